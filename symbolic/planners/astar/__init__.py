"""Our own planner: all abstract plans on bit masks, in exact order of cost with lmcut."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from bpns.symbolic.errors import InputError
from bpns.symbolic.grounding.ground import GroundProblem
from bpns.symbolic.grounding.heuristics import HEURISTICS
from bpns.symbolic.grounding.masks import compile_problem
from bpns.symbolic.planners.astar.best_first import enumerate_plans
from bpns.symbolic.planners.costs import Costs
from bpns.symbolic.planners.protocol import About, AbstractPlan, Limit, SearchRecord

ABOUT = (
    About(
        "astar",
        "stream",
        optimal=True,
        proves=True,
        negation=True,
        equality=True,
        costs=True,
        note="astar:HEURISTIC; only with lmcut, which it takes unless told otherwise, optimal",
    ),
)


@dataclass(frozen=True, slots=True)
class AStar:
    """A* with one of our heuristics: lmcut (exact cost order), hadd or hff."""

    heuristic: str = "lmcut"

    @property
    def name(self) -> str:
        """How to ask for this planner."""
        return f"astar:{self.heuristic}"

    def plans(
        self,
        problem: GroundProblem,
        rng: np.random.Generator,
        limit: Limit,
        record: SearchRecord,
    ) -> Iterator[AbstractPlan]:
        """Yield abstract plans; see Planner. Of equally cheap ones, those least like the given go first."""
        return self._plans(problem, rng, limit, record, None)

    def plans_at(
        self,
        problem: GroundProblem,
        rng: np.random.Generator,
        limit: Limit,
        record: SearchRecord,
        costs: Costs,
    ) -> Iterator[AbstractPlan]:
        """Yield abstract plans; see CostPlanner."""
        return self._plans(problem, rng, limit, record, costs)

    def _plans(
        self,
        problem: GroundProblem,
        rng: np.random.Generator,
        limit: Limit,
        record: SearchRecord,
        costs: Costs | None,
    ) -> Iterator[AbstractPlan]:
        compiled = compile_problem(problem)
        heuristic = HEURISTICS[self.heuristic](compiled)
        known = {compiled.init: problem.problem.init}  # plans share the abstract states on their ways
        for numbers in enumerate_plans(compiled, heuristic, rng, limit, record, costs):
            mask = compiled.init
            steps, atoms = [], [known[mask]]
            for number in numbers:
                step = compiled.operators[number]
                mask = step.apply(mask)
                if mask not in known:
                    known[mask] = step.ground.apply(atoms[-1])
                steps.append(step.ground)
                atoms.append(known[mask])
            yield AbstractPlan(tuple(steps), tuple(atoms))


def create(heuristic: str = "lmcut") -> AStar:
    """Return the planner; raise InputError for an unknown heuristic."""
    if heuristic not in HEURISTICS:
        raise InputError(f"unknown heuristic 'astar:{heuristic}' (have: {', '.join(HEURISTICS)})")
    return AStar(heuristic)
