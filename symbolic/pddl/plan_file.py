"""Plan files: one step a line, ``(pick block0 robby)``, as planners write them.

Read as well: comments (``; cost = 3``), blank lines, any case, times and durations as in
``0.000: (pick block0 robby) [1.000]``.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from bpns.symbolic.errors import PddlError
from bpns.symbolic.operators import Domain, GroundOperator, Problem

_STEP = re.compile(r"(?:(\d+(?:\.\d*)?|\.\d+)\s*:\s*)?\(([^()]*)\)\s*(?:\[[^\[\]()]*\])?\Z")
_NEXT_PLAN = re.compile(r"\s*;\s*plan\s+\d+\b", re.IGNORECASE)  # how 'bpns plan' introduces each of its plans
_SHOWN = 10  # names in a message


@dataclass(frozen=True, slots=True)
class Step:
    """A step as it is written, in lower case: the operator's name and the objects' names; its line from 1."""

    words: tuple[str, ...]
    line: int

    def __str__(self) -> str:
        return f"({' '.join(self.words)})"


def parse_plan(text: str, path: str = "<text>") -> list[Step]:
    """Return a plan file's steps, in the order of their times where all have one; raise PddlError."""
    return _in_order(_lines(text), path)


def parse_plans(text: str, path: str = "<text>") -> list[list[Step]]:
    """Return the plans of a file, at least one; a comment such as ``; plan 2`` begins the next one.

    Raises PddlError for a line that is no step.
    """
    groups: list[list[tuple[int, str]]] = [[]]
    named = False
    for number, line in _lines(text):
        if _NEXT_PLAN.match(line):
            if named or any(rest.partition(";")[0].strip() for _, rest in groups[-1]):
                groups.append([])
            named = True
        groups[-1].append((number, line))
    return [_in_order(group, path) for group in groups]


def ground_steps(
    steps: Sequence[Step], domain: Domain, problem: Problem, path: str = "<text>"
) -> list[GroundOperator]:
    """Return the ground operators that steps name; raise PddlError for a wrong name, number or type."""
    operators = {operator.name.lower(): operator for operator in domain.operators}
    objects = {obj.name.lower(): obj for obj in (*domain.constants, *problem.objects)}
    found = []
    for step in steps:
        name, *arguments = step.words
        if name not in operators:
            raise PddlError(path, step.line, 1, f"unknown operator '{name}' {_have(operators)}")
        for argument in arguments:
            if argument not in objects:
                raise PddlError(path, step.line, 1, f"{step}: unknown object '{argument}' {_have(objects)}")
        try:
            found.append(operators[name].ground(tuple(objects[argument] for argument in arguments)))
        except ValueError as error:
            raise PddlError(path, step.line, 1, f"{step}: {error}") from error
    return found


def _have(names: Mapping[str, object]) -> str:
    shown = ", ".join(sorted(names)[:_SHOWN]) or "none"
    more = len(names) - _SHOWN
    return f"(have: {shown}, and {more} more)" if more > 0 else f"(have: {shown})"


def _lines(text: str) -> Iterable[tuple[int, str]]:
    # Not splitlines: it breaks lines where editors do not, and the numbers would be others.
    return enumerate(text.split("\n"), 1)


def _in_order(lines: Iterable[tuple[int, str]], path: str) -> list[Step]:
    timed: list[tuple[float | None, Step]] = []
    for number, line in lines:
        code = line.partition(";")[0]
        if not code.strip():
            continue
        match = _STEP.match(code.strip())
        words = match.group(2).lower().split() if match else []
        if match is None or not words:
            column = len(code) - len(code.lstrip()) + 1
            shown = "".join(c for c in code.strip() if c.isprintable())
            shown = shown if len(shown) <= 60 else f"{shown[:57]}..."
            raise PddlError(path, number, column, f"expected one step such as (pick block0), found '{shown}'")
        timed.append((float(match.group(1)) if match.group(1) else None, Step(tuple(words), number)))
    times = [time for time, _ in timed if time is not None]
    if len(times) < len(timed):
        return [step for _, step in timed]
    return [step for _, step in sorted(timed, key=lambda item: item[0] or 0.0)]
