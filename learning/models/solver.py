"""Solving one task with what was learned: by planning, or with a graph network that acts in its place."""

from collections.abc import Mapping
from dataclasses import dataclass

from bpns.learning.graphs.reactive import Acted, GraphModel, react
from bpns.symbolic.bilevel.adaptive import adaptive
from bpns.symbolic.bilevel.execution import Execution, execute
from bpns.symbolic.bilevel.refinement import DeadEnd
from bpns.symbolic.bilevel.solve import Effort, NoPlan, Plan, solve
from bpns.symbolic.bilevel.strategy import Strategy
from bpns.symbolic.planners.protocol import Planner
from bpns.symbolic.planners.streams import with_idle_steps
from bpns.symbolic.skills.environment import Budget, Environment
from bpns.symbolic.skills.skill import Skill
from bpns.symbolic.state import Array, State, Task

NO_EFFORT = Effort(0, 0, 0, 0, {})


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


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """What came of a task: planned, refined and executed, each by itself.

    ``found`` is the plan, or why there is none, or what a graph network did in place of a plan.
    Source: spec, algorithm.md section 9.

    >>> import bpns
    >>> world = bpns.load_environment("cover")
    >>> bpns.oracle(world).plan(world.task())
    <solved: 2 steps, 5 actions>
    """

    task: Task
    found: Plan | NoPlan | Acted
    execution: Execution | None  # None where there was nothing to carry out

    @property
    def plan(self) -> Plan | None:
        """The refined plan: its ``steps`` and the ``abstract`` plan that it refines; None without one."""
        return self.found if isinstance(self.found, Plan) else None

    @property
    def planned(self) -> bool | None:
        """Whether there was an abstract plan; None where nothing plans."""
        return None if isinstance(self.found, Acted) else self.found.effort.abstract_plans > 0

    @property
    def refined(self) -> bool | None:
        """Whether one was refined in the simulator; None where nothing plans."""
        return None if isinstance(self.found, Acted) else isinstance(self.found, Plan)

    @property
    def executed(self) -> bool:
        """Whether carrying it out reached the goal: only then is a task solved."""
        return self.execution is not None and self.execution.success

    @property
    def why(self) -> str:
        """Why the task was not solved; empty where it was."""
        if isinstance(self.found, NoPlan):
            return self.found.text
        return self.execution.fault if self.execution is not None else ""

    @property
    def states(self) -> tuple[State, ...]:
        """The states of the execution, from the initial one on."""
        return (self.task.init,) if self.execution is None else self.execution.trajectory.states

    @property
    def actions(self) -> tuple[Array, ...]:
        """The actions that were carried out, each (A,) float32; one fewer than states."""
        return () if self.execution is None else self.execution.trajectory.actions

    @property
    def effort(self) -> Effort:
        """What planning cost: nodes, abstract plans, samples, seconds."""
        return NO_EFFORT if isinstance(self.found, Acted) else self.found.effort

    @property
    def dead_ends(self) -> list[tuple[DeadEnd, int]]:
        """Where refinements failed, with how often, the most frequent first."""
        ends = {} if isinstance(self.found, Acted) else self.found.dead_ends
        return sorted(ends.items(), key=lambda item: (-item[1], item[0]))

    @property
    def samples(self) -> int:
        """How many subgoals were tried."""
        return self.found.samples if isinstance(self.found, Acted) else self.found.effort.samples

    @property
    def steps(self) -> tuple[str, ...]:
        """The skills with their objects, as text; none without a plan, or where a network gives actions."""
        if isinstance(self.found, Acted):
            return tuple(self.found.steps)
        return tuple(str(s.skill.operator) for s in self.found.steps) if isinstance(self.found, Plan) else ()

    def __repr__(self) -> str:
        steps = f"{len(self.steps)} steps, {len(self.actions)} actions" if self.execution else "no plan"
        return f"<{'solved' if self.executed else 'not solved'}: {steps}{self.why and f'; {self.why}'}>"


def attempt(solver: Solver, task: Task, seed: int, deadline: float | None = None) -> Outcome:
    """Plan for a task and carry the plan out, or act; ``deadline`` is a point of ``time.monotonic``."""
    world = solver.environment
    if solver.graph is not None:
        execution, acted = react(world, task, solver.graph, solver.skills, seed, deadline)
        return Outcome(task, acted, execution)
    planner = with_idle_steps(solver.planner, (skill.operator for skill in solver.skills.values()))
    found = solve(world, task, solver.skills, planner, solver.budget, seed, deadline, solver.strategy)
    return Outcome(task, found, execute(world, task, found) if isinstance(found, Plan) else None)
