"""What a planner is: the protocol, and the values that it takes and gives."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from importlib import metadata
from time import monotonic
from typing import Protocol, runtime_checkable

import numpy as np

from bpns.symbolic.errors import MissingPackage
from bpns.symbolic.grounding.ground import GroundProblem
from bpns.symbolic.operators import GroundOperator
from bpns.symbolic.planners.costs import Costs
from bpns.symbolic.structs import GroundAtom


@dataclass(frozen=True, slots=True)
class AbstractPlan:
    """Ground operators and the abstract states before, between and after them."""

    steps: tuple[GroundOperator, ...]
    atoms: tuple[frozenset[GroundAtom], ...]  # one more than steps

    @classmethod
    def follow(cls, problem: GroundProblem, steps: Sequence[GroundOperator]) -> "AbstractPlan":
        """Apply the steps to the initial atoms."""
        atoms = [problem.problem.init]
        for step in steps:
            atoms.append(step.apply(atoms[-1]))
        return cls(tuple(steps), tuple(atoms))

    def __str__(self) -> str:
        return ", ".join(map(str, self.steps)) or "(nothing to do)"


@dataclass(frozen=True, slots=True)
class Limit:
    """When a search gives up: after so many nodes, or at a point of ``time.monotonic``."""

    nodes: int
    deadline: float | None = None

    @property
    def late(self) -> bool:
        """Say whether the deadline has passed."""
        return self.deadline is not None and monotonic() > self.deadline


@dataclass(slots=True)
class SearchRecord:
    """What a search did; it fills this in while its plans are taken."""

    nodes_created: int = 0
    nodes_expanded: int = 0
    stopped_by: str = ""  # empty, or "node limit", "time limit", "planner failed"
    fault: str = ""  # what a planner that failed did
    own: int | None = None  # how many plans are the planner's own, where astar went on for it
    remarks: list[str] = field(default_factory=list)  # what else a user should know, one line each


@dataclass(frozen=True, slots=True)
class About:
    """What a planner can do and where it comes from; ``bpns planners`` prints these.

    A planner is optimal when its plans come in order of length. Whatever it can do itself, every planner's
    stream goes on after its first plan.
    """

    name: str  # how to ask for it
    gives: str  # "one plan", "better plans", "top-k" (many, after a while) or "stream" (many, as they come)
    optimal: bool = False
    proves: bool = False  # says for certain when there is no plan
    negation: bool = False  # takes negative preconditions and goals; they are compiled away for the others
    equality: bool = False  # takes (= ?x ?y); compiled away for the others
    typing: bool = True  # takes types with subtypes; compiled away for the others
    costs: bool = False  # takes costs of ground operators that change between plans
    package: str = ""  # on PyPI; empty for our own
    extra: str = ""  # the extra of bpns that installs it
    licence: str = "MIT"
    note: str = ""

    @property
    def version(self) -> str | None:
        """The installed version; None where the package is missing."""
        try:
            return metadata.version(self.package or "bpns")
        except metadata.PackageNotFoundError:
            return None

    def check_installed(self) -> None:
        """Raise MissingPackage unless the package is there."""
        if self.version is None:
            raise MissingPackage(f"{self.name} needs {self.package}: pip install 'bpns[{self.extra}]'")


class Planner(Protocol):
    """Enumerates abstract plans."""

    @property
    def name(self) -> str: ...

    def plans(
        self, problem: GroundProblem, rng: np.random.Generator, limit: Limit, record: SearchRecord
    ) -> Iterator[AbstractPlan]:
        """Yield abstract plans, lazily, in order of increasing cost, no sequence twice.

        A plan ends at its first goal state. Plans are never dropped because their abstract states were
        seen before: predicates are lossy, and another order can succeed where this one fails.
        No step leaves the abstract state as it is. The stream ends when there are no more plans, or at a
        limit, or when the planner fails: ``record`` then says so. It never raises for a planner's faults.
        Nobody else stops a planner in this process: it has to look at ``limit`` itself.
        """
        ...


@runtime_checkable
class CostPlanner(Planner, Protocol):
    """A planner that takes costs of ground operators, which may change while plans are taken from it."""

    def plans_at(
        self,
        problem: GroundProblem,
        rng: np.random.Generator,
        limit: Limit,
        record: SearchRecord,
        costs: Costs,
    ) -> Iterator[AbstractPlan]:
        """Yield abstract plans as ``plans`` does, the cheapest by the costs of each moment next."""
        ...
