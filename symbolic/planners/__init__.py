"""Planners: one module is one planner and its file name is the planner's name."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib import import_module
from inspect import signature
from pathlib import Path
from time import monotonic
from typing import Protocol

import numpy as np

from symbolic.errors import InputError
from symbolic.grounding import GroundProblem
from symbolic.structs import GroundAtom, GroundOperator


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
    stopped_by: str = ""  # empty, or "node limit", "time limit"


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
        The stream ends when there are no more plans, or at a limit, which ``record`` then names.
        """
        ...


def names() -> list[str]:
    """Return the names of the planners, without importing them."""
    return sorted(file.stem for file in Path(__file__).parent.glob("[!_]*.py"))


def load(name: str) -> Planner:
    """Return a planner by name, with options after colons (``astar:hff``, ``pyperplan:gbf:hff``).

    Each module offers ``create(*options)``. Raises InputError for unknown names and options.
    """
    module, *options = name.split(":")
    if module not in names():
        raise InputError(f"unknown planner '{module}' (have: {', '.join(names())})")
    create = import_module(f"symbolic.planners.{module}").create
    try:
        signature(create).bind(*options)
    except TypeError as error:
        raise InputError(f"planner '{name}' has too many options after '{module}'") from error
    planner: Planner = create(*options)
    return planner
