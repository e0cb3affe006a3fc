"""Skills, how they run, and what they leave behind."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, TypeAlias

import numpy as np

from symbolic.environment import Environment, EnvironmentFailure, holds
from symbolic.state import Array, State, Trajectory
from symbolic.structs import GroundOperator, Object, Operator, Type, Variable

Controller: TypeAlias = Callable[[State], Array | None]  # None: done, as far as the policy knows
Terminal: TypeAlias = Callable[[State, tuple[Object, ...]], bool]


class SkillFailure(Exception):
    """A policy that cannot act. Its text says why."""


class Policy(Protocol):
    """Turns a subgoal into actions."""

    def begin(self, state: State, objects: tuple[Object, ...], subgoal: Array) -> Controller:
        """Fix the target at the skill's first state; the result maps each following state to an action.

        ``subgoal`` is (D,) float32; actions are (A,) float32 inside the environment's box.
        """
        ...


class Sampler(Protocol):
    """Proposes subgoals."""

    @property
    def dimension(self) -> int:
        """The length D of a subgoal; 0 where there is nothing to choose."""
        ...

    def sample(self, state: State, objects: tuple[Object, ...], rng: np.random.Generator) -> Array:
        """Return a subgoal, (D,) float32."""
        ...


def never(_: State, __: tuple[Object, ...]) -> bool:
    """Say that a skill is not over: for those whose controller says so itself."""
    return False


@dataclass(frozen=True, slots=True)
class NoSampler:
    """For skills without anything to choose."""

    dimension: int = 0

    def sample(self, state: State, objects: tuple[Object, ...], rng: np.random.Generator) -> Array:
        """Return the empty subgoal, (0,) float32."""
        return np.zeros(0, np.float32)


@dataclass(frozen=True, slots=True)
class GivenSkill:
    """A policy that comes with an environment: operators are learned around it, the policy is not.

    ``types`` are those of its own objects. It gets an empty subgoal, and is over when its controller gives
    None. Demonstrations label the actions that it produced. Source: spec, doors.md section 7.
    """

    name: str
    types: tuple[Type, ...]
    policy: Policy


@dataclass(frozen=True, slots=True)
class Label:
    """Which given skill produced an action, and with which objects."""

    skill: str
    objects: tuple[Object, ...]


@dataclass(frozen=True, slots=True)
class GivenPolicy:
    """A given skill as an operator's policy; ``places`` says which of the operator's objects it gets."""

    given: GivenSkill
    places: tuple[int, ...]

    def label(self, objects: tuple[Object, ...]) -> Label:
        """Return how demonstrations call the skill, from the operator's objects."""
        return Label(self.given.name, tuple(objects[place] for place in self.places))

    def begin(self, state: State, objects: tuple[Object, ...], subgoal: Array) -> Controller:
        """Start the given skill; see Policy."""
        return self.given.policy.begin(state, self.label(objects).objects, subgoal)


@dataclass(frozen=True, slots=True)
class Skill:
    """An operator and how to make it happen.

    ``terminal`` says when the skill is over; without it, that is when all effects have happened. Either way
    it is over, too, when its controller gives None.
    ``max_actions`` bounds a roll-out, beside the environment's limit.
    """

    operator: Operator
    policy: Policy
    sampler: Sampler
    terminal: Terminal | None = None
    max_actions: int | None = None

    @classmethod
    def of_given(cls, operator: Operator, given: GivenSkill, arguments: tuple[Variable, ...]) -> "Skill":
        """Make a given skill happen as an operator; ``arguments`` are the parameters that it gets."""
        policy = GivenPolicy(given, tuple(operator.parameters.index(v) for v in arguments))
        return cls(operator, policy, NoSampler(), never)


@dataclass(frozen=True, slots=True)
class NotInitiable:
    """A precondition does not hold."""


@dataclass(frozen=True, slots=True)
class Failed:
    """The environment or the policy failed during the roll-out."""

    reason: str


@dataclass(frozen=True, slots=True, eq=False)
class Rollout:
    """What running a skill did; ``stuck`` says that it ended because nothing moved any more."""

    trajectory: Trajectory
    stuck: bool


@dataclass(frozen=True, slots=True)
class GroundSkill:
    """A skill whose operator is bound to objects."""

    skill: Skill
    operator: GroundOperator

    def initiable(self, environment: Environment, state: State) -> bool:
        """Say whether all preconditions hold in the state."""
        return all(holds(environment, a, state) for a in self.operator.preconditions) and not any(
            holds(environment, a, state) for a in self.operator.negative_preconditions
        )

    @property
    def label(self) -> Label | None:
        """How demonstrations label its actions: with the given skill, if it is one."""
        policy = self.skill.policy
        return policy.label(self.operator.objects) if isinstance(policy, GivenPolicy) else None

    def terminal(self, environment: Environment, state: State) -> bool:
        """Say whether the skill is over in this state."""
        if self.skill.terminal is not None:
            return self.skill.terminal(state, self.operator.objects)
        return all(holds(environment, a, state) for a in self.operator.add_effects) and not any(
            holds(environment, a, state) for a in self.operator.delete_effects
        )

    def begin(self, state: State, subgoal: Array) -> Controller:
        """Start the policy in a state."""
        return self.skill.policy.begin(state, self.operator.objects, subgoal)

    def roll_out(
        self, environment: Environment, state: State, subgoal: Array, most: int
    ) -> Rollout | NotInitiable | Failed:
        """Run the skill in the simulator until it is over, stuck, or has taken ``most`` actions.

        Source: spec, common.md section 6.
        """
        if not self.initiable(environment, state):
            return NotInitiable()
        if self.skill.max_actions is not None:
            most = min(most, self.skill.max_actions)
        states = [state]
        actions: list[Array] = []
        stuck = False
        try:
            controller = self.begin(state, subgoal)
        except SkillFailure as failure:
            return Failed(str(failure))
        while len(actions) < most and not self.terminal(environment, state):
            if len(states) > 1 and state.close(states[-2]):
                stuck = True
                break
            try:
                action = controller(state)
                if action is None:
                    break
                state = environment.simulate(state, action)
            except (EnvironmentFailure, SkillFailure) as failure:
                return Failed(str(failure))
            states.append(state)
            actions.append(action)
        return Rollout(Trajectory(tuple(states), tuple(actions)), stuck)
