"""Checks an environment, a shipped one or a stranger's, against its protocol, and says what is wrong."""

from collections.abc import Callable, Iterator, Mapping
from typing import cast

from bpns.symbolic.environment_check import attributes, behaviour, plans, tasks
from bpns.symbolic.environment_check.findings import Finding, Remarks, raised
from bpns.symbolic.skills.environment import Environment

__all__ = ["Finding", "check"]

# What each check needs: attributes, and earlier checks, that have no fault.
_TASKS = ("sample_task", "types", "classifiers", "goal_predicates")
_BEHAVIOUR: Mapping[str, tuple[Callable[[Environment, int, int], Remarks], tuple[str, ...]]] = {
    "tasks": (tasks.tasks, _TASKS),
    "object names": (tasks.object_names, ("tasks", "names")),
    "simulate": (behaviour.simulate, ("simulate", "tasks", "action_low", "action_high")),
    "refusals": (behaviour.refusals, ("simulate", "tasks", "action_low", "action_high")),
    "classifiers": (behaviour.classifiers, ("tasks", "symbols")),
    "goals": (tasks.goals, ("tasks", "classifiers")),
    "oracle plans": (
        plans.oracle_plans,
        ("names", "tasks", "simulate", "classifiers", "horizon", "rollout_limit", "budget"),
    ),
    "drawing": (behaviour.drawing, ("draw", "tasks")),
    "workers": (behaviour.workers, ("tasks",)),
}


def check(subject: object, count: int = 5, seed: int = 0) -> Iterator[Finding]:
    """Yield what each check of an environment finds: its faults and warnings, or that it is fine.

    ``subject`` is whatever is meant as an environment; exceptions that it raises become faults. Checks that
    need something faulty are skipped.
    """
    faulty: set[str] = set()
    yield from _run("attributes", (), attributes.attributes(subject), subject, faulty)
    symbols = attributes.symbols(subject, frozenset(faulty))
    yield from _run("symbols", ("types", "classifiers"), symbols, subject, faulty)
    names = attributes.names(subject)
    yield from _run(
        "names", ("name", "types", "classifiers", "oracle_skills", "symbols"), names, subject, faulty
    )
    for name, (function, needs) in _BEHAVIOUR.items():
        remarks = function(cast(Environment, subject), count, seed)
        yield from _run(name, needs, remarks, subject, faulty)


def _run(
    name: str, needs: tuple[str, ...], remarks: Remarks, subject: object, faulty: set[str]
) -> Iterator[Finding]:
    """Run one check to its end or its first exception; note in ``faulty`` what later ones cannot use."""
    if missing := [need for need in needs if need in faulty]:
        faulty.add(name)
        yield Finding(name, "skipped", f"needs {', '.join(missing)} without fault")
        return
    silent = True
    while True:
        try:
            remark = next(remarks)
        except StopIteration as end:
            if silent:
                yield Finding(name, "ok", end.value)
            return
        except Exception as error:
            faulty.add(name)
            yield Finding(name, "fault", raised(error, subject))
            return
        if remark.level == "fault":
            faulty.add(remark.about or name)
        silent = False
        yield Finding(name, remark.level, remark.text)
