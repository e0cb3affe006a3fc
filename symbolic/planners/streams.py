"""Streams of abstract plans, changed or measured: without loops, with idle steps, and the first of each."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement, islice, product
from time import monotonic

import numpy as np

from bpns.symbolic.grounding.ground import GroundProblem
from bpns.symbolic.operators import GroundOperator, Operator
from bpns.symbolic.planners.costs import Costs
from bpns.symbolic.planners.protocol import AbstractPlan, CostPlanner, Limit, Planner, SearchRecord

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


@dataclass(frozen=True, slots=True)
class WithIdleSteps:
    """Puts idle steps into another planner's plans, in all ways, shorter plans first."""

    planner: Planner

    @property
    def name(self) -> str:
        """The name of the planner behind it."""
        return self.planner.name

    def plans(
        self, problem: GroundProblem, rng: np.random.Generator, limit: Limit, record: SearchRecord
    ) -> Iterator[AbstractPlan]:
        """Yield abstract plans; see Planner. No step follows the first goal state."""
        idle = [o for o in problem.operators if not o.add_effects and not o.delete_effects]
        stream = self.planner.plans(problem, rng, limit, record)
        known: list[AbstractPlan] = []
        following = next(stream, None)
        length = 0
        while following is not None or (idle and any(plan.steps for plan in known)):
            fresh = len(known)
            while following is not None and len(following.steps) <= length:
                known.append(following)
                yield following
                following = next(stream, None)
            for plan in known[:fresh] if idle else ():
                for steps in _filled(plan.steps, idle, length - len(plan.steps)):
                    record.nodes_created += 1
                    if limit.late or record.nodes_created >= limit.nodes:
                        record.stopped_by = "time limit" if limit.late else "node limit"
                        return
                    found = AbstractPlan.follow(problem, steps)
                    if all(
                        step.preconditions <= atoms and not step.negative_preconditions & atoms
                        for step, atoms in zip(found.steps, found.atoms, strict=False)
                    ):
                        yield found
            length += 1


def with_idle_steps(planner: Planner, operators: Iterable[Operator]) -> Planner:
    """Return a planner that also puts in operators which change nothing, where there are such.

    One that leaves loops out stays as it is: an idle step is a loop.
    """
    idle = any(not operator.add_effects and not operator.delete_effects for operator in operators)
    return WithIdleSteps(planner) if idle and not isinstance(planner, Loopless) else planner


def _filled(
    steps: Sequence[GroundOperator], idle: Sequence[GroundOperator], count: int
) -> Iterator[list[GroundOperator]]:
    """Yield all ways to put ``count`` idle steps before steps of a plan; none into one without steps."""
    for places in combinations_with_replacement(range(len(steps)), count):
        for chosen in product(idle, repeat=count):
            found: list[GroundOperator] = []
            for place, step in enumerate(steps):
                found += [one for one, at in zip(chosen, places, strict=True) if at == place]
                found.append(step)
            yield found


@dataclass(frozen=True, slots=True)
class Enumeration:
    """The first plans of a planner for a problem."""

    plans: tuple[AbstractPlan, ...]
    first_seconds: float | None  # None without a plan
    seconds: float  # until the last plan, or the end
    record: SearchRecord

    @property
    def ended(self) -> str:
        """Why there are no more plans, where somebody asked for more; empty where nothing went wrong."""
        return self.record.fault or self.record.stopped_by


def first_plans(planner: Planner, problem: GroundProblem, count: int, seed: int, limit: Limit) -> Enumeration:
    """Take a planner's first plans."""
    start, record = monotonic(), SearchRecord()
    stream = planner.plans(problem, np.random.default_rng(seed), limit, record)
    found, first = [], None
    for plan in islice(stream, count):
        first = first or monotonic() - start
        found.append(plan)
    return Enumeration(tuple(found), first, monotonic() - start, record)
