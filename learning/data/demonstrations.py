"""Demonstrations: trajectories that solve tasks, and how oracle skills make them."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from bpns.learning.parallel import parallel_map
from bpns.symbolic import planners
from bpns.symbolic.bilevel.execution import execute
from bpns.symbolic.bilevel.exhaustive import exhaustive
from bpns.symbolic.bilevel.solve import NoPlan, solve
from bpns.symbolic.planners.streams import with_idle_steps
from bpns.symbolic.skills.environment import Environment, sample_tasks
from bpns.symbolic.skills.skill import Label
from bpns.symbolic.state import Task, Trajectory


@dataclass(frozen=True, slots=True, eq=False)
class Demonstration:
    """A trajectory that solves a task; ``labels`` has one entry per action, None where no skill is given.

    >>> import bpns
    >>> bpns.collect(bpns.load_environment("cover"), count=1).demonstrations[0]
    <demonstration of 5 actions, <task: Covers(block0, target0); 9 objects>>
    """

    task_index: int
    task: Task
    trajectory: Trajectory
    labels: tuple[Label | None, ...]

    def __repr__(self) -> str:
        return f"<demonstration of {len(self.trajectory.actions)} actions, {self.task!r}>"


@dataclass(frozen=True, slots=True, eq=False)
class Demonstrations:
    """Demonstrations of one environment; ``failures`` says for each task without one why.

    >>> import bpns
    >>> len(bpns.collect(bpns.load_environment("cover"), count=3).demonstrations)
    3
    """

    environment: str  # its name
    seed: int
    asked: int
    demonstrations: tuple[Demonstration, ...]
    failures: tuple[tuple[int, str], ...]

    def __repr__(self) -> str:
        return f"<{len(self.demonstrations)} demonstrations of {self.asked} tasks in {self.environment}>"


def demonstrate(environment: Environment, seed: int, numbered: tuple[int, Task]) -> Demonstration | str:
    """Solve a train task with the oracle skills and carry the whole plan out; or say why that failed.

    Source: spec, algorithm.md section 1.
    """
    index, task = numbered
    skills = {skill.operator.name: skill for skill in environment.oracle_skills}
    plan = solve(
        environment,
        task,
        skills,
        with_idle_steps(planners.load("astar"), (skill.operator for skill in environment.oracle_skills)),
        environment.budget,
        seed + index + 1,
        strategy=exhaustive,
    )
    if isinstance(plan, NoPlan):
        return plan.text
    execution = execute(environment, task, plan, whole=True)
    if execution.fault:
        return execution.fault
    labels = tuple(plan.steps[step].skill.label for step in execution.steps)
    return Demonstration(index, task, execution.trajectory, labels)


def collect(
    environment: Environment,
    count: int,
    seed: int,
    workers: int = 1,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Demonstrations:
    """Demonstrate the first ``count`` train tasks; the result does not depend on ``workers``."""
    tasks = list(enumerate(sample_tasks(environment, "train", count, seed)))
    work = partial(demonstrate, environment, seed)
    found, failures = [], []
    for index, result in enumerate(parallel_map(work, tasks, workers, chunk=10)):
        if isinstance(result, str):
            failures.append((index, result))
        else:
            found.append(result)
        progress(index + 1, count)
    return Demonstrations(environment.name, seed, count, tuple(found), tuple(failures))
