"""Solving evaluation tasks and counting, as in the paper's tables. Source: spec, algorithm.md section 10."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from statistics import fmean, pstdev
from time import monotonic
from types import MappingProxyType
from typing import Any

from bpns.learning.models.solver import Solver, attempt
from bpns.learning.parallel import parallel_unordered
from bpns.symbolic.bilevel.refinement import DeadEnd
from bpns.symbolic.skills.environment import sample_tasks
from bpns.symbolic.state import Task


@dataclass(frozen=True, slots=True)
class Result:
    """How one task went. Times are seconds of wall clock."""

    seed: int
    task: int
    planned: bool | None  # an abstract plan was found; None: the approach does not plan
    refined: bool | None  # one was refined in the simulator; None: likewise
    executed: bool  # carrying it out reached the goal
    fault: str
    dead_ends: tuple[tuple[DeadEnd, int], ...]  # the most frequent ones
    nodes_created: int
    nodes_expanded: int
    abstract_plans: int
    samples: int
    plan_length: int
    planning_seconds: float
    policy_seconds: float
    remarks: tuple[str, ...] = ()  # of the planner

    @property
    def seconds(self) -> float:
        """The paper's test time: planning, and policy calls during execution."""
        return self.planning_seconds + self.policy_seconds


def evaluate_task(solver: Solver, numbered: tuple[int, int, Task]) -> Result:
    """Plan for a task and carry the plan out; the planner's seed is the run's plus the task's number.

    Where a graph network acts in place of a planner, nothing is planned or refined.
    """
    seed, index, task = numbered
    deadline = None if solver.timeout is None else monotonic() + solver.timeout
    outcome = attempt(solver, task, seed + index + 1, deadline)
    effort = outcome.effort
    return Result(
        seed=seed,
        task=index,
        planned=outcome.planned,
        refined=outcome.refined,
        executed=outcome.executed,
        fault=outcome.why,
        dead_ends=tuple(outcome.dead_ends[:5]),
        nodes_created=effort.nodes_created,
        nodes_expanded=effort.nodes_expanded,
        abstract_plans=effort.abstract_plans,
        samples=outcome.samples,
        plan_length=len(outcome.steps),
        planning_seconds=sum(effort.seconds.values()),
        policy_seconds=0.0 if outcome.execution is None else outcome.execution.policy_seconds,
        remarks=effort.remarks,
    )


def evaluate(
    solver: Solver,
    seeds: Iterable[int],
    tasks: int,
    workers: int = 1,
    note: Callable[[Result], None] = lambda result: None,
    known: Mapping[tuple[int, int], Result] = MappingProxyType({}),
) -> list[Result]:
    """Evaluate on the first ``tasks`` evaluation tasks of every seed; times aside, workers change nothing.

    ``known`` are results of earlier, by seed and task, which are not run again; ``note`` gets every other one
    as soon as it is there. Returns all that were asked for, in order.
    """
    asked = {(seed, index): None for seed in seeds for index in range(tasks)}
    missing = {seed: None for seed, index in asked if (seed, index) not in known}
    work = [
        (seed, index, task)
        for seed in missing
        for index, task in enumerate(sample_tasks(solver.environment, "test", tasks, seed))
        if (seed, index) not in known
    ]
    results = {key: known[key] for key in asked if key in known}
    for result in parallel_unordered(partial(evaluate_task, solver), work, workers):
        results[result.seed, result.task] = result
        note(result)
    return [results[key] for key in asked]


@dataclass(frozen=True, slots=True)
class Summary:
    """Means over runs, each with the population standard deviation; shares are in percent.

    Seconds are over solved tasks, nodes over refined ones, as in the paper. Not a number: nothing to average,
    or an approach that does not plan.
    """

    planned: tuple[float, float]
    refined: tuple[float, float]
    solved: tuple[float, float]
    seconds: tuple[float, float]
    nodes_created: tuple[float, float]
    abstract_plans: tuple[float, float]
    samples: tuple[float, float]


def summarize(runs: Mapping[Any, Sequence[Result]]) -> Summary:
    """Return the statistics of an evaluation; each run is the results of one model on one seed."""

    def over_runs(one: Callable[[Sequence[Result]], float | None]) -> tuple[float, float]:
        values = [value for rows in runs.values() if (value := one(rows)) is not None]
        return (fmean(values), pstdev(values)) if values else (float("nan"), float("nan"))

    def share(which: Callable[[Result], bool | None]) -> tuple[float, float]:
        def of_run(rows: Sequence[Result]) -> float | None:
            values = [value for r in rows if (value := which(r)) is not None]
            return 100 * fmean(values) if values else None

        return over_runs(of_run)

    def mean(of: Callable[[Result], float], among: Callable[[Result], bool | None]) -> tuple[float, float]:
        return over_runs(lambda rows: fmean(v) if (v := [of(r) for r in rows if among(r)]) else None)

    return Summary(
        share(lambda r: r.planned),
        share(lambda r: r.refined),
        share(lambda r: r.executed),
        mean(lambda r: r.seconds, lambda r: r.executed),
        mean(lambda r: r.nodes_created, lambda r: r.refined),
        mean(lambda r: r.abstract_plans, lambda r: r.refined),
        mean(lambda r: r.samples, lambda r: r.refined),
    )
