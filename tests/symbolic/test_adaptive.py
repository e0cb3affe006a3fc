"""The adaptive strategy: what it solves, what it learns, and that it does nothing twice."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from time import monotonic
from typing import Any

import numpy as np
import pytest

from bpns import envs
from bpns.symbolic import planners
from bpns.symbolic.bilevel.adaptive import Adaptive, adaptive
from bpns.symbolic.bilevel.execution import execute
from bpns.symbolic.bilevel.exhaustive import exhaustive
from bpns.symbolic.bilevel.feedback import Sharing
from bpns.symbolic.bilevel.refinement import RefinedStep, carry_out
from bpns.symbolic.bilevel.solve import NoPlan, Plan, solve
from bpns.symbolic.bilevel.strategy import Strategy
from bpns.symbolic.grounding.ground import GroundProblem
from bpns.symbolic.operators import GroundOperator
from bpns.symbolic.planners.protocol import AbstractPlan, CostPlanner, Limit, Planner, SearchRecord
from bpns.symbolic.planners.streams import loopless
from bpns.symbolic.skills.environment import Budget, Environment, sample_tasks
from bpns.symbolic.skills.rollout import GroundSkill
from bpns.symbolic.skills.skill import Controller, NoSampler
from bpns.symbolic.state import Array, State, Task
from bpns.symbolic.structs import Object
from tests.toy import SKILLS, Toy

ANY = Budget(10**6, 10)
TASK = sample_tasks(Toy(), "train", 1, 0)[0]


def run(
    environment: Environment,
    task: Task,
    seed: int,
    strategy: Strategy = adaptive,
    budget: Budget = ANY,
    planner: Planner | None = None,
) -> Plan | NoPlan:
    skills = {skill.operator.name: skill for skill in environment.oracle_skills}
    chosen = planner or planners.load("astar")
    return solve(environment, task, skills, chosen, budget, seed, strategy=strategy)


@pytest.mark.parametrize("name", ["cover", "doors", "stick_button", "coffee"])
def test_what_is_found_reaches_the_goal(name: str) -> None:
    environment = envs.load(name)
    for index, task in enumerate(sample_tasks(environment, "test", 5, 50_100)):
        plan = run(environment, task, index)
        assert isinstance(plan, Plan)
        assert execute(environment, task, plan).success
        ends = [task.init, *(step.trajectory.states[-1] for step in plan.steps)]
        assert all(s.trajectory.states[0] is e for s, e in zip(plan.steps, ends, strict=False))


def test_what_failed_is_not_tried_again_and_again() -> None:
    """With six buttons, five tasks need hundreds of plans where nothing is learned from failures."""
    environment = envs.load("stick_button:test_buttons=6")
    tasks = sample_tasks(environment, "test", 5, 50_100)
    tried = []
    for strategy in (adaptive, Adaptive(Sharing(weight=0.0))):
        found = [run(environment, task, 1, strategy) for task in tasks]
        assert all(isinstance(outcome, Plan) for outcome in found)
        tried.append(sum(outcome.effort.abstract_plans for outcome in found))
    assert tried[0] < 100 < 200 < tried[1]


@dataclass(frozen=True)
class Nowhere:
    """A policy that does nothing."""

    action: Array

    def begin(self, state: State, objects: tuple[Object, ...], subgoal: Array) -> Controller:
        return lambda _: self.action


def test_where_nothing_can_be_sampled_the_search_ends() -> None:
    """There is no end of abstract plans, but all begin with steps that can only fail."""
    environment = envs.load("cover")
    nothing = Nowhere(np.zeros(len(environment.action_low), np.float32))
    skills = {
        skill.operator.name: replace(skill, policy=nothing, sampler=NoSampler())
        for skill in environment.oracle_skills
    }
    task = sample_tasks(environment, "test", 1, 50_100)[0]
    outcome = solve(environment, task, skills, planners.load("astar"), ANY, 1)
    assert isinstance(outcome, NoPlan)
    assert outcome.reason == "not refined"
    assert outcome.effort.abstract_plans <= 10


def test_at_most_so_many_samples_from_one_state() -> None:
    """With one, the plan fails unless its first key fits, and then nothing is left to try."""
    found = [run(Toy(), TASK, seed, Adaptive(samples=1)) for seed in range(20)]
    assert all(outcome.effort.samples <= 2 for outcome in found)
    assert {type(outcome) for outcome in found} == {Plan, NoPlan}


def test_a_plan_gets_as_many_samples_as_it_needs() -> None:
    """One key in thirty opens the door, and there is but one plan: five samples a step are not enough."""
    hard = Toy(fails_below=0.97)
    for seed in range(5):
        assert isinstance(run(hard, TASK, seed), Plan)
    assert not all(isinstance(run(hard, TASK, seed, exhaustive, hard.budget), Plan) for seed in range(5))


def test_nothing_is_simulated_twice(monkeypatch: pytest.MonkeyPatch) -> None:
    """Plans share the states that their common first steps led to."""
    environment = envs.load("stick_button:test_buttons=6")
    seen: Counter[tuple[int, GroundOperator, bytes]] = Counter()
    kept = []  # so that no state's id is given again

    def watched(
        world: Environment, skill: GroundSkill, state: State, actions: int, subgoal: Array, expected: Any
    ) -> RefinedStep | str:
        kept.append(state)
        seen[id(state), skill.operator, subgoal.tobytes()] += 1
        return carry_out(world, skill, state, actions, subgoal, expected)

    monkeypatch.setattr("bpns.symbolic.bilevel.adaptive.carry_out", watched)
    outcome = run(environment, sample_tasks(environment, "test", 1, 50_100)[0], 1)
    assert outcome.effort.abstract_plans > 1
    assert set(seen.values()) == {1}


def test_same_seed_same_outcome() -> None:
    environment = envs.load("stick_button")
    (task,) = sample_tasks(environment, "test", 1, 50_107)

    def told(seed: int) -> tuple[object, ...]:
        outcome = run(environment, task, seed)
        assert isinstance(outcome, Plan)
        return [step.subgoal.tolist() for step in outcome.steps], outcome.effort.samples, outcome.dead_ends

    assert told(3) == told(3)


@dataclass(frozen=True)
class Listed:
    """A planner without costs: astar's first plans in reverse order."""

    name: str = "listed"
    count: int = 5

    def plans(
        self, problem: GroundProblem, rng: np.random.Generator, limit: Limit, record: SearchRecord
    ) -> Iterator[AbstractPlan]:
        found = planners.load("astar").plans(problem, rng, limit, record)
        yield from [plan for plan, _ in zip(found, range(self.count), strict=False)][::-1]
        record.remarks.append("that was all")


def test_planners_without_costs_are_taken_too() -> None:
    assert isinstance(planners.load("astar"), CostPlanner)
    assert not isinstance(Listed(), CostPlanner)
    environment = envs.load("stick_button")
    tasks = sample_tasks(environment, "test", 4, 50_100)
    for index, task in enumerate(tasks):
        plan = run(environment, task, index, planner=Listed(count=100))
        assert isinstance(plan, Plan)
        assert execute(environment, task, plan).success


def test_limits_are_kept_and_told() -> None:
    hopeless = Toy(fails_below=2.0)
    spent = run(hopeless, TASK, 1, budget=replace(ANY, samples=37))
    assert isinstance(spent, NoPlan)
    assert (spent.reason, spent.effort.samples) == ("sample limit", 37)
    assert spent.text == "sample limit of 37 reached after 1 abstract plans"
    assert sum(spent.dead_ends.values()) == 37
    late = solve(Toy(), TASK, SKILLS, planners.load("astar"), ANY, 1, monotonic() - 1)
    assert isinstance(late, NoPlan)
    assert late.reason == "time limit"
    environment = envs.load("stick_button:test_buttons=6")
    (task,) = sample_tasks(environment, "test", 1, 50_100)
    few = run(environment, task, 1, Adaptive(plans=2), Budget(1, 10, samples=500))
    assert isinstance(few, NoPlan)
    assert few.effort.abstract_plans == 2


def test_plans_without_anything_to_sample_are_tried_once() -> None:
    """The only plan's steps can end in one way each, so there is nothing to wait for."""
    fixed = {name: replace(skill, sampler=SKILLS["unlock"].sampler) for name, skill in SKILLS.items()}
    outcome = solve(Toy(), TASK, fixed, planners.load("astar"), ANY, 1)
    assert isinstance(outcome, NoPlan)
    assert (outcome.reason, outcome.effort.samples) == ("not refined", 1)


@dataclass(frozen=True)
class Same:
    """A sampler that proposes one subgoal only, as a learned one does whose data never varied."""

    value: float
    dimension: int = 1

    def sample(self, state: State, objects: tuple[Object, ...], rng: np.random.Generator) -> Array:
        return np.array([self.value], np.float32)


@pytest.mark.parametrize(("key", "solved"), [(0.9, True), (0.5, False)])
def test_a_sampler_without_choice_is_not_asked_again_and_again(key: float, solved: bool) -> None:
    fixed = {**SKILLS, "search": replace(SKILLS["search"], sampler=Same(key))}
    outcome = solve(Toy(), TASK, fixed, planners.load("astar"), ANY, 1)
    assert isinstance(outcome, Plan) == solved
    assert outcome.effort.samples <= 5


@dataclass(frozen=True)
class Few(Same):
    """A sampler that chooses among some subgoals, of which one is rare and the only one that works."""

    def sample(self, state: State, objects: tuple[Object, ...], rng: np.random.Generator) -> Array:
        return np.array([self.value if rng.random() < 0.25 else rng.choice([0.1, 0.2])], np.float32)


@pytest.mark.parametrize("seed", range(10))
def test_a_choice_among_few_is_tried_to_its_end(seed: int) -> None:
    few = {**SKILLS, "search": replace(SKILLS["search"], sampler=Few(0.9))}
    outcome = solve(Toy(), TASK, few, planners.load("astar"), ANY, seed)
    assert isinstance(outcome, Plan)
    assert outcome.effort.samples <= 6  # three keys, each tried on the door


def test_plans_without_loops_take_costs_too() -> None:
    environment = envs.load("stick_button:test_buttons=6")
    (task,) = sample_tasks(environment, "test", 1, 50_100)
    planner = loopless(planners.load("astar"))
    assert isinstance(planner, CostPlanner)
    outcome = run(environment, task, 1, planner=planner)
    assert isinstance(outcome, Plan)
    assert outcome.effort.abstract_plans < 50
    assert not isinstance(loopless(Listed()), CostPlanner)
