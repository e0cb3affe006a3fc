"""What a strategy works with: one task's search, its limits and its records."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from time import perf_counter
from typing import TypeAlias

from bpns.symbolic.bilevel.refinement import RefinedStep, RefinementRecord
from bpns.symbolic.grounding.ground import GroundProblem
from bpns.symbolic.planners.protocol import AbstractPlan, Limit, Planner, SearchRecord
from bpns.symbolic.skills.environment import Budget, Environment
from bpns.symbolic.skills.rollout import GroundSkill
from bpns.symbolic.skills.skill import Skill
from bpns.symbolic.state import Task


class Stopwatch:
    """Adds up wall-clock seconds by part; time spent is charged when the next part begins."""

    def __init__(self) -> None:
        self.seconds = {"grounding": 0.0, "search": 0.0, "refinement": 0.0}
        self._since = perf_counter()

    def charge(self, part: str) -> None:
        """Charge the time since the last call to a part."""
        now = perf_counter()
        self.seconds[part] += now - self._since
        self._since = now


@dataclass(slots=True, eq=False)
class TaskSearch:
    """A task, the means to solve it, and what was done so far."""

    environment: Environment
    task: Task
    skills: Mapping[str, Skill]  # by operator name
    planner: Planner
    problem: GroundProblem
    budget: Budget
    seed: int
    limit: Limit
    watch: Stopwatch
    record: SearchRecord = field(default_factory=SearchRecord)
    refining: RefinementRecord = field(default_factory=RefinementRecord)
    tried: int = 0  # abstract plans

    @property
    def over(self) -> bool:
        """Whether the samples or the time are spent."""
        return self.refining.samples >= self.budget.samples or self.limit.late

    def ground_skills(self, plan: AbstractPlan) -> list[GroundSkill]:
        """Return the skills of a plan's steps."""
        return [GroundSkill(self.skills[step.operator.name], step) for step in plan.steps]


Refined: TypeAlias = tuple[AbstractPlan, tuple[RefinedStep, ...]]
Strategy: TypeAlias = Callable[[TaskSearch], Refined | None]  # None: the search's records say why
