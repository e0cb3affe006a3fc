"""Solving evaluation tasks and counting, as in the paper's tables. Source: spec, algorithm.md section 10."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from statistics import fmean, pstdev
from time import monotonic
from types import MappingProxyType
from typing import Any

from bpns.learning.graphs.reactive import GraphModel, react
from bpns.learning.parallel import parallel_unordered
from bpns.symbolic.bilevel.adaptive import adaptive
from bpns.symbolic.bilevel.execution import execute
from bpns.symbolic.bilevel.refinement import DeadEnd
from bpns.symbolic.bilevel.solve import Plan, solve
from bpns.symbolic.bilevel.strategy import Strategy
from bpns.symbolic.planners.protocol import Planner
from bpns.symbolic.skills.environment import Budget, Environment, sample_tasks
from bpns.symbolic.skills.skill import Skill
from bpns.symbolic.state import Task


@dataclass(frozen=True, slots=True)
class Solver:
    """All that is needed to solve tasks."""

    environment: Environment
    skills: Mapping[str, Skill]
    planner: Planner
    budget: Budget
    timeout: float | None = None  # seconds per task
    strategy: Strategy = adaptive
    graph: GraphModel | None = None  # acts in place of the planner


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
    if solver.graph is not None:
        execution, episode = react(
            solver.environment, task, solver.graph, solver.skills, seed + index + 1, deadline
        )
        return Result(
            seed=seed,
            task=index,
            planned=None,
            refined=None,
            executed=execution.success,
            fault=execution.fault,
            dead_ends=(),
            nodes_created=0,
            nodes_expanded=0,
            abstract_plans=0,
            samples=episode.samples,
            plan_length=len(episode.steps),
            planning_seconds=0.0,
            policy_seconds=execution.policy_seconds,
        )
    outcome = solve(
        solver.environment,
        task,
        solver.skills,
        solver.planner,
        solver.budget,
        seed + index + 1,
        deadline,
        solver.strategy,
    )
    refined = isinstance(outcome, Plan)
    if isinstance(outcome, Plan):
        execution = execute(solver.environment, task, outcome)
        executed, fault, policy_seconds = execution.success, execution.fault, execution.policy_seconds
        length = len(outcome.steps)
    else:
        executed, fault, policy_seconds, length = False, outcome.text, 0.0, 0
    effort = outcome.effort
    ends = sorted(outcome.dead_ends.items(), key=lambda item: (-item[1], item[0]))
    return Result(
        seed,
        index,
        effort.abstract_plans > 0,
        refined,
        executed,
        fault,
        tuple(ends[:5]),
        effort.nodes_created,
        effort.nodes_expanded,
        effort.abstract_plans,
        effort.samples,
        length,
        sum(effort.seconds.values()),
        policy_seconds,
        effort.remarks,
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
