"""Our own planner: A* over paths on bit masks; exact order with lmcut."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from symbolic.compile import compile_problem
from symbolic.errors import InputError
from symbolic.grounding import GroundProblem
from symbolic.heuristics import HEURISTICS
from symbolic.planners import AbstractPlan, Limit, SearchRecord
from symbolic.planners._best_first import enumerate_plans


@dataclass(frozen=True, slots=True)
class AStar:
    """A* with one of our heuristics: lmcut (exact cost order), hadd or hff."""

    heuristic: str = "lmcut"

    @property
    def name(self) -> str:
        """How to ask for this planner."""
        return f"astar:{self.heuristic}"

    def plans(
        self, problem: GroundProblem, rng: np.random.Generator, limit: Limit, record: SearchRecord
    ) -> Iterator[AbstractPlan]:
        """Yield abstract plans; see Planner. Ties are broken by ``rng``."""
        compiled = compile_problem(problem)
        heuristic = HEURISTICS[self.heuristic](compiled)
        for steps in enumerate_plans(compiled, heuristic, rng, limit, record):
            yield AbstractPlan.follow(problem, [compiled.operators[i].ground for i in steps])


def create(heuristic: str = "lmcut") -> AStar:
    """Return the planner; raise InputError for an unknown heuristic."""
    if heuristic not in HEURISTICS:
        raise InputError(f"unknown heuristic 'astar:{heuristic}' (have: {', '.join(HEURISTICS)})")
    return AStar(heuristic)
