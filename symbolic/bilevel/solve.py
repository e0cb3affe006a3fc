"""Bilevel planning: abstract plans in, a refined plan or the reasons out."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from bpns.symbolic.bilevel.adaptive import adaptive
from bpns.symbolic.bilevel.refinement import DeadEnd, RefinedStep, RefinementRecord
from bpns.symbolic.bilevel.strategy import Stopwatch, Strategy, TaskSearch
from bpns.symbolic.grounding.ground import OutOfTime, Unreachable, ground
from bpns.symbolic.planners.protocol import AbstractPlan, Limit, Planner, SearchRecord
from bpns.symbolic.skills.environment import Budget, Environment, domain_of, problem_of
from bpns.symbolic.skills.skill import Skill
from bpns.symbolic.state import Task

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
    """An abstract plan and its refinement: one step after the other, each with the subgoal that worked.

    >>> import bpns
    >>> world = bpns.load_environment("cover")
    >>> bpns.oracle(world).plan(world.task()).plan
    <plan of 2 steps: Pick(block0, robby); Place(block0, robby, target0)>
    """

    abstract: AbstractPlan
    steps: tuple[RefinedStep, ...]
    effort: Effort
    dead_ends: Mapping[DeadEnd, int]

    def __repr__(self) -> str:
        return f"<plan of {len(self.steps)} steps: {'; '.join(str(s.skill.operator) for s in self.steps)}>"

    def __str__(self) -> str:
        return "\n".join(f"{number}. {step}" for number, step in enumerate(self.steps, 1))


@dataclass(frozen=True, slots=True, eq=False)
class NoPlan:
    """Why there is no plan. ``text`` names the goal atoms or the budget that ran out."""

    reason: Reason
    text: str
    effort: Effort
    dead_ends: Mapping[DeadEnd, int]

    def __repr__(self) -> str:
        return f"<no plan: {self.text}>"


def solve(
    environment: Environment,
    task: Task,
    skills: Mapping[str, Skill],
    planner: Planner,
    budget: Budget,
    seed: int,
    deadline: float | None = None,
    strategy: Strategy = adaptive,
) -> Plan | NoPlan:
    """Plan for a task: find abstract plans and refine one.

    ``skills`` maps operator names to skills; the planner is one that is ready for them, see
    ``with_idle_steps``. ``deadline`` is a point of ``time.monotonic``. The ``strategy``
    decides which plans are refined when, and how hard.
    """
    watch = Stopwatch()
    domain = domain_of(environment, (s.operator for s in skills.values()))
    grounded = ground(domain, problem_of(environment, task), deadline)
    watch.charge("grounding")
    nothing = Effort(0, 0, 0, 0, dict(watch.seconds))
    if isinstance(grounded, Unreachable):
        return NoPlan("unreachable", str(grounded), nothing, Counter())
    if isinstance(grounded, OutOfTime):
        return NoPlan("time limit", "time limit reached while grounding", nothing, Counter())
    limit = Limit(budget.nodes, deadline)
    search = TaskSearch(environment, task, skills, planner, grounded, budget, seed, limit, watch)
    refined = strategy(search)
    effort = Effort(
        search.record.nodes_created,
        search.record.nodes_expanded,
        search.tried,
        search.refining.samples,
        dict(watch.seconds),
        tuple(search.record.remarks),
    )
    if refined is not None:
        return Plan(*refined, effort, search.refining.dead_ends)
    reason, text = _why(search.record, search.refining, limit, budget, search.tried)
    return NoPlan(reason, text, effort, search.refining.dead_ends)


def _why(
    search: SearchRecord, refining: RefinementRecord, limit: Limit, budget: Budget, tried: int
) -> tuple[Reason, str]:
    """Name what ended a search without a plan."""
    if search.stopped_by == "planner failed":
        return "planner failed", f"the planner failed after {tried} abstract plans: {search.fault}"
    if limit.late or search.stopped_by == "time limit":
        return "time limit", f"time limit reached after {tried} abstract plans"
    if refining.samples >= budget.samples:
        return "sample limit", f"sample limit of {budget.samples} reached after {tried} abstract plans"
    if search.stopped_by == "node limit":
        return "node limit", f"node limit of {budget.nodes} reached after {tried} abstract plans"
    if tried == 0 and search.stopped_by:
        return "not refined", f"stopped by the {search.stopped_by}"
    if tried == 0:
        return "no plan", "no plan exists: the whole state space was searched"
    return "not refined", f"none of {tried} abstract plans could be refined"
