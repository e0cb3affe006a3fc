"""Plans that come back to no abstract state, where somebody wants only these."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from symbolic.grounding import GroundProblem
from symbolic.planners import AbstractPlan, Limit, Planner, SearchRecord


@dataclass(frozen=True, slots=True)
class Loopless:
    """Another planner's plans without those that visit an abstract state twice.

    Predicates are lossy, so such a plan can be the only one that works: this is for looking at plans.
    """

    planner: Planner

    @property
    def name(self) -> str:
        """The planner's name."""
        return self.planner.name

    def plans(
        self, problem: GroundProblem, rng: np.random.Generator, limit: Limit, record: SearchRecord
    ) -> Iterator[AbstractPlan]:
        """Yield plans; see Planner. With no such plan left, the search may go on to its limit."""
        for plan in self.planner.plans(problem, rng, limit, record):
            if len(set(plan.atoms)) == len(plan.atoms):
                yield plan
