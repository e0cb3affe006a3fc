"""Checkers of PDDL files and plans, ours and others': one module is one checker.

Each offers ``version()``, which raises MissingPackage where the checker is not installed, and
``verdicts(inputs)``, a generator of one verdict for each of ``inputs.items``, in order. It may end early:
what comes after a domain that it cannot read is skipped.
"""

from bpns.symbolic.plugins import PlugIns

CHECKERS = PlugIns("checker", "bpns.symbolic.checkers", "verdicts")


def names() -> list[str]:
    """Return the names of the checkers, ours first, without importing them."""
    return sorted(CHECKERS.names(), key=lambda name: (name != "bpns", name))
