"""Carrying a plan out in the environment."""

from dataclasses import dataclass
from time import perf_counter

from bpns.symbolic.bilevel.solve import Plan
from bpns.symbolic.skills.environment import Environment, EnvironmentFailure, holds
from bpns.symbolic.skills.skill import SkillFailure
from bpns.symbolic.state import Array, State, Task, Trajectory


@dataclass(frozen=True, slots=True, eq=False)
class Execution:
    """What happened: ``fault`` is empty where the goal was reached, else it says why not."""

    trajectory: Trajectory
    steps: tuple[int, ...]  # for each action, the number of the plan's step that it belongs to, from 0
    fault: str
    policy_seconds: float

    @property
    def success(self) -> bool:
        """Say whether the goal held in the last state."""
        return not self.fault


def execute(environment: Environment, task: Task, plan: Plan, *, whole: bool = False) -> Execution:
    """Run the plan's skills one after the other until the goal holds, or with ``whole`` to the plan's end.

    Each skill gets as many actions as in the refinement: the simulator is deterministic, so that is where
    the skill is over, or was stuck. Source: spec, common.md section 6 and algorithm.md section 9.
    """
    states: list[State] = [task.init]
    actions: list[Array] = []
    owners: list[int] = []
    seconds = 0.0

    def outcome(fault: str) -> Execution:
        return Execution(Trajectory(tuple(states), tuple(actions)), tuple(owners), fault, seconds)

    def reached() -> bool:
        return all(holds(environment, atom, states[-1]) for atom in task.goal)

    for number, step in enumerate(plan.steps):
        if not step.skill.initiable(environment, states[-1]):
            return outcome(f"step {number + 1} {step.skill.operator} is not initiable")
        start = perf_counter()
        try:
            controller = step.skill.begin(states[-1], step.subgoal)
        except SkillFailure as failure:
            return outcome(f"step {number + 1} {step.skill.operator} failed: {failure}")
        seconds += perf_counter() - start
        for _ in step.trajectory.actions:
            if len(actions) >= environment.horizon:
                return outcome("" if reached() else "horizon")
            if reached() and not whole:
                return outcome("")
            try:
                start = perf_counter()
                action = controller(states[-1])
                seconds += perf_counter() - start
                if action is None:
                    break
                states.append(environment.simulate(states[-1], action))
            except (EnvironmentFailure, SkillFailure) as failure:
                return outcome(f"step {number + 1} {step.skill.operator} failed: {failure}")
            actions.append(action)
            owners.append(number)
    return outcome("" if reached() else "plan exhausted before the goal was reached")
