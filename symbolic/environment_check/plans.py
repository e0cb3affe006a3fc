"""Plans with an environment's own skills: are there any, and do the skills keep their promises."""

from collections.abc import Iterator
from time import monotonic

import numpy as np

from bpns.symbolic import planners
from bpns.symbolic.bilevel.execution import execute
from bpns.symbolic.bilevel.exhaustive import exhaustive
from bpns.symbolic.bilevel.refinement import RefinedStep
from bpns.symbolic.bilevel.solve import NoPlan, Plan, solve
from bpns.symbolic.environment_check.behaviour import classifier_fault, transition
from bpns.symbolic.environment_check.findings import Remark, Remarks, fault, kind_of
from bpns.symbolic.planners.streams import with_idle_steps
from bpns.symbolic.skills.environment import Environment, sample_tasks
from bpns.symbolic.skills.rollout import Rollout
from bpns.symbolic.state import Array, Task

SECONDS = 20  # for all tasks together


def oracle_plans(environment: Environment, count: int, seed: int) -> Remarks:
    """Solve train tasks with the oracle skills; look at every step of the plans."""
    skills = {skill.operator.name: skill for skill in environment.oracle_skills}
    if not skills:
        yield Remark("warning", "there are no oracle skills: no demonstrations can be made")
        return ""
    planner = with_idle_steps(planners.load("astar"), (skill.operator for skill in skills.values()))
    deadline = monotonic() + SECONDS
    unsolved: list[str] = []
    used: set[str] = set()
    for number, task in enumerate(sample_tasks(environment, "train", count, seed)):
        where = f"train task {number}"
        found = solve(environment, task, skills, planner, environment.budget, seed, deadline, exhaustive)
        if isinstance(found, NoPlan):
            unsolved.append(f"{where}: {_why(found)}")
            continue
        used |= {step.skill.operator.operator.name for step in found.steps}
        wrong = next(_plan_faults(environment, task, found, where), None)
        if wrong is not None:
            yield wrong
            return ""
    if len(unsolved) == count:
        yield Remark("warning", f"they solve none of {count} train tasks; {unsolved[0]}")
    never = ", ".join(sorted(set(skills) - used))
    notes = [f"they solve {count - len(unsolved)} of {count} train tasks", *unsolved[:1]]
    return "; ".join(notes + ([f"never used: {never}"] if never else []))


def _why(found: NoPlan) -> str:
    """Return why there is no plan, with the most frequent dead end."""
    if not found.dead_ends:
        return found.text
    end, times = max(found.dead_ends.items(), key=lambda item: item[1])
    return f"{found.text}, {times} x step {end.step} {end.operator}: {end.reason}"


def _plan_faults(environment: Environment, task: Task, plan: Plan, where: str) -> Iterator[Remark]:
    for number, step in enumerate(plan.steps, 1):
        place = f"{where}, step {number} {step.skill.operator}"
        yield from _step_faults(environment, step, place)
        states, actions = step.trajectory.states, step.trajectory.actions
        for state, action in zip(states, actions, strict=False):
            after = transition(environment, state, action, place)
            if isinstance(after, Remark):
                yield after
        wrong = classifier_fault(environment, states[-1], f"{place}, last state")
        if wrong is not None:
            yield wrong
    execution = execute(environment, task, plan)
    if not execution.success:
        yield fault(
            f"{where}: the plan reached its goal when it was made, but not again ({execution.fault}): "
            "policies must keep nothing from one run to the next"
        )


def _step_faults(environment: Environment, step: RefinedStep, place: str) -> Iterator[Remark]:
    """Look at the subgoal, the actions and the end of a step."""
    dimension = step.skill.skill.sampler.dimension
    if not _is_vector(step.subgoal, dimension):
        yield fault(f"{place}: the subgoal is {_kind(step.subgoal)}: sample float32 of shape ({dimension},)")
    low, high = environment.action_low, environment.action_high
    states, actions = step.trajectory.states, step.trajectory.actions
    for action in actions:
        if not _is_vector(action, len(low)):
            yield fault(f"{place}: the policy sends {_kind(action)}: send float32 of shape ({len(low)},)")
        elif not np.all((low <= action) & (action <= high)):
            yield fault(f"{place}: the policy sends {action.tolist()}, outside the action box: clip it")
    # With one more action than it needed, a skill that ends by itself ends in the same place.
    again = step.skill.roll_out(environment, states[0], step.subgoal, len(actions) + 1)
    if (
        not isinstance(again, Rollout)
        or len(again.trajectory.actions) < len(actions)
        or again.trajectory.states[len(actions)].features != states[-1].features
    ):
        yield fault(f"{place}: the same skill did something else the second time: policies must repeat")
    elif len(again.trajectory.actions) > len(actions):
        yield fault(
            f"{place}: the skill never ended, it was stopped after {len(actions)} actions: "
            "mend its terminal, or let its controller give None"
        )


def _is_vector(value: object, length: int) -> bool:
    return isinstance(value, np.ndarray) and value.dtype == np.float32 and value.shape == (length,)


def _kind(value: Array | object) -> str:
    if isinstance(value, np.ndarray):
        return f"{value.dtype} of shape {value.shape}"
    return f"a {kind_of(value)}"
