"""What the adaptive strategy remembers: abstract plans, states that they reached, what came of each try."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from bpns.symbolic.bilevel.refinement import RefinedStep
from bpns.symbolic.operators import GroundOperator
from bpns.symbolic.planners.protocol import AbstractPlan
from bpns.symbolic.skills.rollout import GroundSkill
from bpns.symbolic.state import State

# Which step is tried anew when one fails: relative weights. One whose effects the failed step needs is the
# likeliest to blame; any other may be, so that none is left out for ever.
PROVIDES, SHARES_OBJECTS, ITSELF, ANY = 4.0, 1.0, 1.0, 0.1


@dataclass(slots=True, eq=False)
class Reached:
    """A state to which the first steps of some plans led, and what came of the steps tried from it."""

    state: State
    actions: int  # taken before it
    before: "Reached | None"
    step: RefinedStep | None  # that led here
    failures: int = 0  # here and at the states reached from here
    next: dict[GroundOperator, "Outcomes"] = field(default_factory=dict)

    def path(self) -> list["Reached"]:
        """Return the states on the way here, the first one first."""
        found, now = [self], self.before
        while now is not None:
            found.append(now)
            now = now.before
        return found[::-1]


@dataclass(slots=True, eq=False)
class Outcomes:
    """What came of one ground operator from one state."""

    reached: list[Reached] = field(default_factory=list)
    failures: int = 0
    subgoals: set[bytes] = field(default_factory=set)
    repeats: bool = False  # whether there is nothing new to propose, or no more may be


@dataclass(slots=True, eq=False)
class Candidate:
    """An abstract plan and how often it was tried."""

    plan: AbstractPlan
    number: int  # from 1, in the order in which plans came
    skills: Sequence[GroundSkill]
    visits: int = 0
    spent: bool = False  # whether nothing is left to sample

    def sampled(self, step: int) -> bool:
        """Say whether another try of a step can end otherwise."""
        return self.skills[step].skill.sampler.dimension > 0

    def few_tries(self, state: Reached, step: int, tries: int) -> bool:
        """Say whether a step was tried less often than that from a state, and never with success."""
        outcomes = state.next.get(self.plan.steps[step])
        if outcomes is None:
            return True
        return not outcomes.reached and outcomes.failures < (tries if self.sampled(step) else 1)

    def can_try(self, state: Reached, step: int) -> bool:
        """Say whether one more try of a step from a state may tell something new."""
        outcomes = state.next.get(self.plan.steps[step])
        return outcomes is None or (self.sampled(step) and not outcomes.repeats)

    def weight(self, earlier: int, step: int) -> float:
        """Say how likely a step fails because of how an earlier one, or itself, was done."""
        if earlier == step:
            return ITSELF
        operator, before = self.plan.steps[step], self.plan.steps[earlier]
        later = self.plan.steps[earlier + 1 : step]
        rests = operator.preconditions & before.add_effects
        if any(all(atom not in one.add_effects for one in later) for atom in rests):
            return PROVIDES
        return SHARES_OBJECTS if set(before.objects) & set(operator.objects) else ANY
