"""Skills bound to objects, and running one in the simulator."""

from dataclasses import dataclass

from bpns.symbolic.operators import GroundOperator
from bpns.symbolic.skills.environment import Environment, EnvironmentFailure, holds
from bpns.symbolic.skills.skill import Controller, GivenPolicy, Label, Skill, SkillFailure
from bpns.symbolic.state import Array, State, Trajectory


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

    def __repr__(self) -> str:
        return f"<skill {self.operator}>"

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
        adds = self.operator.add_effects  # what is deleted and added, as of one object in two places, holds
        return all(holds(environment, a, state) for a in adds) and not any(
            holds(environment, a, state) for a in self.operator.delete_effects if a not in adds
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
