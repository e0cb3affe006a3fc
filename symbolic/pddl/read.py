"""Read PDDL: ``:strips :typing :negative-preconditions :equality``, constants, ``either``, in any case.

Everything else in the language is refused as unsupported, by name and with its place. Names are lower-cased
as PDDL demands; ``names`` gives their spelling in our model (``handempty`` -> ``HandEmpty``).
"""

from collections.abc import Mapping
from pathlib import Path

from bpns.symbolic.files import read_text
from bpns.symbolic.operators import Domain, Problem
from bpns.symbolic.pddl.domains import build_domain
from bpns.symbolic.pddl.lists import parse_lists
from bpns.symbolic.pddl.problems import build_problem
from bpns.symbolic.pddl.scope import MissingRequirement, PddlWarning, Scope

__all__ = [
    "MissingRequirement",
    "PddlWarning",
    "parse_domain",
    "parse_problem",
    "read_domain",
    "read_problem",
]


def read_domain(path: Path, names: Mapping[str, str] | None = None) -> Domain:
    """Read a domain file; raise PddlError, UnsupportedPddl or InputError."""
    return parse_domain(_text(path), str(path), names)


def read_problem(path: Path, domain: Domain, names: Mapping[str, str] | None = None) -> Problem:
    """Read a problem file of a domain; raise PddlError, UnsupportedPddl or InputError."""
    return parse_problem(_text(path), domain, str(path), names)


def _text(path: Path) -> str:
    # Old files have comments in other encodings; elsewhere such bytes are refused with their place.
    return read_text(path, errors="surrogateescape")


def parse_domain(text: str, path: str = "<text>", names: Mapping[str, str] | None = None) -> Domain:
    """Return the domain that a text describes; see the module's docstring."""
    return build_domain(Scope(text, path, names or {}), parse_lists(text, path))


def parse_problem(
    text: str, domain: Domain, path: str = "<text>", names: Mapping[str, str] | None = None
) -> Problem:
    """Return the problem that a text describes; see the module's docstring."""
    scope = Scope(text, path, names or {})
    scope.types |= {t.name.lower(): t for t in domain.types}
    scope.objects |= {o.name.lower(): o for o in domain.constants}
    scope.predicates |= {p.name.lower(): p for p in domain.predicates}
    scope.requirements = frozenset({":adl"})  # the domain's own reading has warned already
    return build_problem(scope, parse_lists(text, path), domain)
