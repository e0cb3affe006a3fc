"""What is checked, and what checkers say of it."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypeAlias

from bpns.symbolic.errors import InputError, PddlError
from bpns.symbolic.files import read_text
from bpns.symbolic.pddl.plan_file import Step, parse_plans

Level: TypeAlias = Literal["ok", "fault", "unsupported", "failed", "skipped"]
Outcome: TypeAlias = Literal["valid", "invalid", "failed", "unsupported"]


@dataclass(frozen=True, slots=True)
class Verdict:
    """What a checker says of one item; the text is one line with the place."""

    level: Level
    text: str = ""


@dataclass(frozen=True, slots=True)
class Source:
    """A file's path, for messages, and its text."""

    path: str
    text: str


@dataclass(frozen=True, slots=True)
class PlanSource:
    """A plan of a file; ``fault`` says why its steps could not be read."""

    name: str
    steps: tuple[Step, ...]
    fault: str = ""

    @property
    def text(self) -> str:
        """The steps as every checker reads them: one a line, nothing else."""
        return "".join(f"{step}\n" for step in self.steps)

    def place(self, number: int) -> str:
        """Say where step ``number`` (from 1) stands."""
        return f"{self.name}: line {self.steps[number - 1].line}, step {number} {self.steps[number - 1]}"


@dataclass(frozen=True, slots=True)
class Inputs:
    """What is to be checked; plans need a problem."""

    domain: Source
    problem: Source | None = None
    plans: tuple[PlanSource, ...] = ()

    @property
    def items(self) -> tuple[str, ...]:
        """The names of what gets a verdict."""
        return ("domain", *(("problem",) if self.problem else ()), *(plan.name for plan in self.plans))


@dataclass(frozen=True, slots=True)
class Report:
    """A checker's verdicts, in the order of ``Inputs.items``; ``missing`` says how to install it."""

    checker: str
    version: str = ""
    verdicts: tuple[Verdict, ...] = ()
    missing: str = ""


def read_inputs(domain: Path, problem: Path | None = None, plans: Sequence[Path] = ()) -> Inputs:
    """Read the files; raise InputError where one is missing or no text, not for faults in them."""
    found: list[PlanSource] = []
    for path in plans:
        text = read_text(path)
        try:
            parsed = parse_plans(text, str(path))
        except PddlError as error:
            found.append(PlanSource(str(path), (), str(error)))
            continue
        for number, steps in enumerate(parsed, 1):
            name = str(path) if len(parsed) == 1 else f"{path}, plan {number}"
            found.append(PlanSource(name, tuple(steps)))
    if found and problem is None:
        raise InputError("a plan can only be checked with its problem: give the problem too")
    problem_source = None if problem is None else Source(str(problem), read_text(problem, "replace"))
    return Inputs(Source(str(domain), read_text(domain, "replace")), problem_source, tuple(found))


def disagreements(items: Sequence[str], reports: Sequence[Report]) -> list[str]:
    """Say for which items some checkers find a fault where others find none."""
    found = []
    for number, item in enumerate(items):
        accept = [r.checker for r in reports if r.verdicts and r.verdicts[number].level == "ok"]
        refuse = [r.checker for r in reports if r.verdicts and r.verdicts[number].level == "fault"]
        if accept and refuse:
            found.append(f"{item}: valid says {', '.join(accept)}; invalid says {', '.join(refuse)}")
    return found


def outcome(items: Sequence[str], reports: Sequence[Report]) -> Outcome:
    """Sum the verdicts up: a fault outweighs a check that failed, and that an item that nobody checked."""
    levels = [{r.verdicts[number].level for r in reports if r.verdicts} for number in range(len(items))]
    if any("fault" in found for found in levels):
        return "invalid"
    if any("failed" in found for found in levels):
        return "failed"
    return "valid" if all("ok" in found for found in levels) else "unsupported"
