"""One abstract plan -> trajectories, by backtracking over subgoals."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from bpns.symbolic.operators import GroundOperator
from bpns.symbolic.planners.protocol import Limit
from bpns.symbolic.skills.environment import Environment, holds
from bpns.symbolic.skills.rollout import Failed, GroundSkill, NotInitiable
from bpns.symbolic.state import Array, State, Trajectory
from bpns.symbolic.structs import GroundAtom, sort_atoms


@dataclass(frozen=True, slots=True, eq=False)
class RefinedStep:
    """A skill with the subgoal that worked and what it did."""

    skill: GroundSkill
    subgoal: Array
    trajectory: Trajectory

    def __repr__(self) -> str:
        return f"<{self}>"

    def __str__(self) -> str:
        return f"{self.skill.operator}  ({len(self.trajectory.actions)} actions)"


@dataclass(frozen=True, slots=True, order=True)
class DeadEnd:
    """Where a refinement failed: which plan (counting from 1), which of its steps (from 1), and why."""

    plan: int
    step: int
    operator: str
    reason: str


MOST_KEPT_STATES = 20_000  # of known attempts: a limit on memory, beyond which nothing new is kept


class _Attempt(NamedTuple):
    """All that the outcome of an attempt depends on, given the environment. States count as objects."""

    state: State
    actions: int  # before it
    operator: GroundOperator
    subgoal: bytes
    expected: frozenset[GroundAtom]


@dataclass(slots=True)
class RefinementRecord:
    """What refining has cost so far and where it failed.

    ``known`` keeps what came of each attempt. Plans often begin with the same steps, and as each plan is
    refined with the same random numbers, these lead to the same states, objects in memory and all.
    """

    samples: int = 0
    dead_ends: Counter[DeadEnd] = field(default_factory=Counter)
    known: dict[_Attempt, RefinedStep | str] = field(default_factory=dict)
    kept_states: int = 0


@dataclass(frozen=True, slots=True)
class Refiner:
    """Everything that stays the same while one abstract plan is refined."""

    environment: Environment
    plan_number: int
    steps: Sequence[GroundSkill]
    expected: Sequence[frozenset[GroundAtom]]  # the atoms that must hold after 0, 1, ... steps
    samples_per_step: int
    max_samples: int  # by the record's count, which is over all plans of the task
    limit: Limit
    rng: np.random.Generator
    record: RefinementRecord

    def refine(self, state: State, step: int = 0, actions: int = 0) -> Iterator[tuple[RefinedStep, ...]]:
        """Yield the ways to carry out the plan from ``step`` on; each is found by fresh samples.

        Source: spec, algorithm.md section 8. A step without anything to sample is tried once.
        """
        if step == len(self.steps):
            yield ()
            return
        tries = self.samples_per_step if self.steps[step].skill.sampler.dimension else 1
        for _ in range(tries):
            if self.record.samples >= self.max_samples or self.limit.late:
                return
            attempt = self.attempt(state, step, actions)
            if isinstance(attempt, RefinedStep):
                trajectory = attempt.trajectory
                used = actions + len(trajectory.actions)
                for rest in self.refine(trajectory.states[-1], step + 1, used):
                    yield (attempt, *rest)
            else:
                operator = str(self.steps[step].operator)
                self.record.dead_ends[DeadEnd(self.plan_number, step + 1, operator, attempt)] += 1

    def attempt(self, state: State, step: int, actions: int) -> RefinedStep | str:
        """Sample a subgoal and pursue it; return the step, or why it is a dead end."""
        skill = self.steps[step]
        self.record.samples += 1
        subgoal = skill.skill.sampler.sample(state, skill.operator.objects, self.rng)
        numbers = np.asarray(subgoal).tobytes()
        key = _Attempt(state, actions, skill.operator, numbers, self.expected[step + 1])
        found = self.record.known.get(key)
        if found is None:
            expected = self.expected[step + 1]
            found = carry_out(self.environment, skill, state, actions, subgoal, expected)
            if self.record.kept_states < MOST_KEPT_STATES:
                self.record.known[key] = found
                self.record.kept_states += 0 if isinstance(found, str) else len(found.trajectory.states)
        return found


def carry_out(
    environment: Environment,
    skill: GroundSkill,
    state: State,
    actions: int,
    subgoal: Array,
    expected: frozenset[GroundAtom],
) -> RefinedStep | str:
    """Roll a skill out after so many actions; return the step, or why it is a dead end.

    It is one unless the ``expected`` atoms hold afterwards. Source: spec, algorithm.md section 8.
    """
    left = environment.horizon - actions
    most = min(environment.rollout_limit, left + 1)  # one more than fits shows that it does not fit
    rollout = skill.roll_out(environment, state, subgoal, most)
    if isinstance(rollout, NotInitiable):
        return "not initiable"
    if isinstance(rollout, Failed):
        return f"failure: {rollout.reason}"
    trajectory = rollout.trajectory
    if not trajectory.actions:
        return "over before it began"
    if len(trajectory.actions) > left:
        return "horizon"
    last = trajectory.states[-1]
    missing = [a for a in expected if not holds(environment, a, last)]
    if missing:
        return f"missing {', '.join(map(str, sort_atoms(missing)))}{' (stuck)' if rollout.stuck else ''}"
    return RefinedStep(skill, subgoal, trajectory)
