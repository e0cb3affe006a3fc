"""Abstract plans with steps that change nothing put in, for operators without effects.

Planners leave such steps out, as they lead nowhere. Source: spec, baselines.md section 5.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement, product

import numpy as np

from symbolic.grounding import GroundProblem
from symbolic.planners import AbstractPlan, Limit, Planner, SearchRecord
from symbolic.structs import GroundOperator


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
