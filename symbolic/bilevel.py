"""Bilevel planning: abstract plans in, a refined plan or the reasons out."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from time import perf_counter
from typing import Literal

import numpy as np

from symbolic.environment import Budget, Environment, domain_of, problem_of
from symbolic.grounding import OutOfTime, Unreachable, ground
from symbolic.planners import AbstractPlan, Limit, Planner, SearchRecord
from symbolic.refinement import DeadEnd, RefinedStep, RefinementRecord, Refiner
from symbolic.skills import GroundSkill, Skill
from symbolic.state import Task

Reason = Literal[
    "unreachable", "no plan", "not refined", "node limit", "time limit", "sample limit", "planner failed"
]


@dataclass(frozen=True, slots=True)
class Effort:
    """What planning cost."""

    nodes_created: int
    nodes_expanded: int
    abstract_plans: int
    samples: int
    seconds: Mapping[str, float]  # by part: grounding, search, refinement
    remarks: tuple[str, ...] = ()  # of the planner, for the user


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """An abstract plan and its refinement."""

    abstract: AbstractPlan
    steps: tuple[RefinedStep, ...]
    effort: Effort
    dead_ends: Mapping[DeadEnd, int]


@dataclass(frozen=True, slots=True, eq=False)
class NoPlan:
    """Why there is no plan. ``text`` names the goal atoms or the budget that ran out."""

    reason: Reason
    text: str
    effort: Effort
    dead_ends: Mapping[DeadEnd, int]


class _Stopwatch:
    """Adds up wall-clock seconds by part; time spent is charged when the next part begins."""

    def __init__(self) -> None:
        self.seconds = {"grounding": 0.0, "search": 0.0, "refinement": 0.0}
        self._since = perf_counter()

    def charge(self, part: str) -> None:
        now = perf_counter()
        self.seconds[part] += now - self._since
        self._since = now


def solve(
    environment: Environment,
    task: Task,
    skills: Mapping[str, Skill],
    planner: Planner,
    budget: Budget,
    seed: int,
    deadline: float | None = None,
) -> Plan | NoPlan:
    """Plan for a task: refine one abstract plan after the other.

    ``skills`` maps operator names to skills; ``deadline`` is a point of ``time.monotonic``.
    Source: Silver et al. 2022, section 4; spec, algorithm.md section 8.
    """
    watch = _Stopwatch()
    limit = Limit(budget.nodes, deadline)
    search, refining = SearchRecord(), RefinementRecord()
    tried = 0

    def effort() -> Effort:
        return Effort(
            search.nodes_created,
            search.nodes_expanded,
            tried,
            refining.samples,
            dict(watch.seconds),
            tuple(search.remarks),
        )

    domain = domain_of(environment, (s.operator for s in skills.values()))
    grounded = ground(domain, problem_of(environment, task), deadline)
    watch.charge("grounding")
    if isinstance(grounded, Unreachable):
        return NoPlan("unreachable", str(grounded), effort(), Counter())
    if isinstance(grounded, OutOfTime):
        return NoPlan("time limit", "time limit reached while grounding", effort(), Counter())
    plans = planner.plans(grounded, np.random.default_rng(seed), limit, search)
    while tried < budget.abstract_plans and refining.samples < budget.samples and not limit.late:
        abstract = next(plans, None)
        watch.charge("search")
        if abstract is None:
            break
        tried += 1
        refiner = Refiner(
            environment,
            tried,
            [GroundSkill(skills[step.operator.name], step) for step in abstract.steps],
            abstract.atoms,
            budget.samples_per_step,
            min(budget.samples, refining.samples + budget.samples_per_plan),
            limit,
            np.random.default_rng(seed),
            refining,
        )
        steps = next(refiner.refine(task.init), None)
        watch.charge("refinement")
        if steps is not None:
            return Plan(abstract, steps, effort(), refining.dead_ends)
    reason, text = _why(search, refining, limit, budget, tried)
    return NoPlan(reason, text, effort(), refining.dead_ends)


def _why(
    search: SearchRecord, refining: RefinementRecord, limit: Limit, budget: Budget, tried: int
) -> tuple[Reason, str]:
    """Name what ended a search without a plan."""
    if search.stopped_by == "planner failed":
        return "planner failed", f"the planner failed after {tried} abstract plans: {search.fault}"
    if limit.late or search.stopped_by == "time limit":
        return "time limit", f"time limit reached after {tried} abstract plans"
    if search.stopped_by == "node limit":
        return "node limit", f"node limit of {budget.nodes} reached after {tried} abstract plans"
    if refining.samples >= budget.samples:
        return "sample limit", f"sample limit of {budget.samples} reached after {tried} abstract plans"
    if tried == 0 and search.stopped_by:
        return "not refined", f"stopped by the {search.stopped_by}"
    if tried == 0:
        return "no plan", "no plan exists: the whole state space was searched"
    return "not refined", f"none of {tried} abstract plans could be refined"
