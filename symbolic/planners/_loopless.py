"""Plans that come back to no abstract state, where somebody wants only these."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from symbolic.costs import Costs
from symbolic.grounding import GroundProblem
from symbolic.planners import AbstractPlan, CostPlanner, Limit, Planner, SearchRecord

MOST_IN_VAIN = 1_000  # where loops are possible, plans with more and more of them never end


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
        """Yield plans; see Planner. MOST_IN_VAIN plans with loops in a row end the search."""
        return _without_loops(self.planner.plans(problem, rng, limit, record), record)


@dataclass(frozen=True, slots=True)
class LooplessAtCosts(Loopless):
    """The same of a planner that takes costs."""

    planner: CostPlanner

    def plans_at(
        self,
        problem: GroundProblem,
        rng: np.random.Generator,
        limit: Limit,
        record: SearchRecord,
        costs: Costs,
    ) -> Iterator[AbstractPlan]:
        """Yield plans; see CostPlanner."""
        return _without_loops(self.planner.plans_at(problem, rng, limit, record, costs), record)


def loopless(planner: Planner) -> Loopless:
    """Return a planner that gives another's plans without loops."""
    return LooplessAtCosts(planner) if isinstance(planner, CostPlanner) else Loopless(planner)


def _without_loops(plans: Iterator[AbstractPlan], record: SearchRecord) -> Iterator[AbstractPlan]:
    in_vain = 0
    for plan in plans:
        in_vain += 1
        if len(set(plan.atoms)) == len(plan.atoms):
            in_vain = 0
            yield plan
        elif in_vain == MOST_IN_VAIN:
            record.stopped_by = f"limit of {MOST_IN_VAIN} plans with loops in a row"
            return
