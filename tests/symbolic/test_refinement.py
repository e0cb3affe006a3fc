"""Refinement and bilevel search in the toy world, where only backtracking solves the task."""

from collections import Counter
from dataclasses import replace
from functools import partial
from time import monotonic
from typing import Any

import numpy as np
import pytest

from bpns.symbolic import planners
from bpns.symbolic.bilevel import solve as bilevel
from bpns.symbolic.bilevel.execution import execute
from bpns.symbolic.bilevel.exhaustive import exhaustive
from bpns.symbolic.bilevel.refinement import DeadEnd, RefinementRecord, Refiner
from bpns.symbolic.bilevel.solve import NoPlan, Plan, solve
from bpns.symbolic.bilevel.strategy import TaskSearch
from bpns.symbolic.grounding.ground import GroundProblem, ground
from bpns.symbolic.planners.protocol import AbstractPlan, Limit
from bpns.symbolic.skills.environment import Budget, problem_of, sample_tasks
from bpns.symbolic.skills.rollout import GroundSkill
from bpns.symbolic.state import State
from bpns.symbolic.structs import GroundAtom
from tests.toy import DOOR_0, HAND_0, HAS_KEY, IS_OPEN, SEARCH, SKILLS, UNLOCK, Toy

TASK = sample_tasks(Toy(), "train", 1, 0)[0]
PLAN = (SEARCH.ground((HAND_0,)), UNLOCK.ground((DOOR_0, HAND_0)))
EXPECTED: list[frozenset[GroundAtom]] = [
    frozenset(),
    frozenset({HAS_KEY(HAND_0)}),
    frozenset({IS_OPEN(DOOR_0)}),
]


def refiner(seed: int, environment: Toy | None = None, samples: int = 10, total: int = 1000) -> Refiner:
    steps = [GroundSkill(SKILLS[step.operator.name], step) for step in PLAN]
    return Refiner(
        environment or Toy(),
        1,
        steps,
        EXPECTED,
        samples,
        total,
        Limit(100),
        np.random.default_rng(seed),
        RefinementRecord(),
    )


def keys(seed: int, count: int) -> list[float]:
    rng = np.random.default_rng(seed)
    return [float(np.float32(rng.uniform())) for _ in range(count)]


@pytest.mark.parametrize("seed", range(20))
def test_backtracking_draws_keys_until_one_fits(seed: int) -> None:
    attempt = refiner(seed)
    steps = next(attempt.refine(TASK.init), None)
    drawn = keys(seed, 10)
    fitting = [number for number, key in enumerate(drawn, 1) if key > 0.7]
    if not fitting:
        assert steps is None
        assert attempt.record.samples == 20  # each of the ten keys is tried on the door once
        return
    assert steps is not None
    assert [str(s.skill.operator) for s in steps] == ["search(hand0)", "unlock(door0, hand0)"]
    assert steps[0].subgoal[0] == np.float32(drawn[fitting[0] - 1])
    assert attempt.record.samples == 2 * fitting[0]
    missing = DeadEnd(1, 2, "unlock(door0, hand0)", "missing IsOpen(door0) (stuck)")
    assert attempt.record.dead_ends == ({missing: fitting[0] - 1} if fitting[0] > 1 else Counter())


def test_refinements_go_on_after_the_first() -> None:
    attempt = refiner(0, samples=50)
    found = list(attempt.refine(TASK.init))
    assert [s[0].subgoal[0] for s in found] == [k for k in map(np.float32, keys(0, 50)) if k > 0.7]


def test_totals_end_a_refinement() -> None:
    attempt = refiner(0, samples=50, total=7)
    list(attempt.refine(TASK.init))
    assert attempt.record.samples == 7


def test_environment_failures_and_the_horizon_are_dead_ends() -> None:
    broken = refiner(0, Toy(fails_below=2.0))
    assert next(broken.refine(TASK.init), None) is None
    assert broken.record.dead_ends == {DeadEnd(1, 1, "search(hand0)", "failure: the key broke"): 10}
    short = refiner(0, Toy(horizon=1), samples=100)
    assert next(short.refine(TASK.init), None) is None
    assert {end.reason for end in short.record.dead_ends} >= {"horizon"}


def test_a_skill_whose_precondition_fails_is_not_initiable() -> None:
    attempt = replace(refiner(0), steps=refiner(0).steps[1:], expected=EXPECTED[1:])
    assert next(attempt.refine(TASK.init), None) is None
    assert {end.reason for end in attempt.record.dead_ends} == {"not initiable"}


def test_a_skill_that_is_over_at_once_is_a_dead_end() -> None:
    state: State = TASK.init.changed({"hand0": (0.5, 0.0)})  # has a key already
    attempt = refiner(0)
    assert next(attempt.refine(state), None) is None
    assert {end.reason for end in attempt.record.dead_ends} == {"over before it began"}


def run(environment: Toy, budget: Budget, seed: int = 1, **options: float) -> Plan | NoPlan:
    planner = planners.load("astar")
    return solve(environment, TASK, SKILLS, planner, budget, seed, strategy=exhaustive, **options)


def test_a_refined_plan_is_executed() -> None:
    environment = Toy()
    plan = run(environment, Budget(3, 20))
    assert isinstance(plan, Plan)
    execution = execute(environment, TASK, plan)
    assert execution.success
    assert execution.steps == (0, 1)
    assert plan.abstract.steps == PLAN


def test_execution_says_what_went_wrong() -> None:
    plan = run(Toy(), Budget(3, 20))
    assert isinstance(plan, Plan)
    assert "the key broke" in execute(Toy(fails_below=2.0), TASK, plan).fault
    assert execute(Toy(horizon=1), TASK, plan).fault == "horizon"
    shortened = replace(plan, steps=plan.steps[:1])
    assert execute(Toy(), TASK, shortened).fault == "plan exhausted before the goal was reached"


def test_reasons_for_no_plan() -> None:
    failed = run(Toy(fails_below=2.0), Budget(3, 4))
    assert isinstance(failed, NoPlan)
    assert failed.reason == "not refined"
    assert failed.effort.abstract_plans == 1  # searching again changes nothing, so there is no other plan
    assert {end.plan for end in failed.dead_ends} == {1}
    few = run(Toy(fails_below=2.0), Budget(3, 4, samples=3))
    assert isinstance(few, NoPlan)
    assert (few.reason, few.effort.samples) == ("sample limit", 3)
    late = run(Toy(), Budget(3, 4), deadline=monotonic() - 1)
    assert isinstance(late, NoPlan)
    assert late.reason == "time limit"
    crowded = run(Toy(), Budget(3, 4, nodes=1))
    assert isinstance(crowded, NoPlan)
    assert crowded.reason == "node limit"


def test_an_unreachable_goal_is_named_without_search() -> None:
    only_search = {"search": SKILLS["search"]}
    outcome = solve(Toy(), TASK, only_search, planners.load("astar"), Budget(3, 4), 1)
    assert isinstance(outcome, NoPlan)
    assert outcome.reason == "unreachable"
    assert "IsOpen(door0)" in outcome.text
    assert outcome.effort.nodes_created == 0


def test_expected_atoms_come_from_the_operators() -> None:
    problem = ground_toy()
    plan = AbstractPlan.follow(problem, PLAN)
    assert list(plan.atoms) == EXPECTED


def ground_toy() -> GroundProblem:
    from bpns.symbolic.skills.environment import domain_of

    found = ground(domain_of(Toy(), (SEARCH, UNLOCK)), problem_of(Toy(), TASK))
    assert isinstance(found, GroundProblem)
    return found


class Forgetful(dict[Any, Any]):
    def __setitem__(self, key: Any, value: Any) -> None:
        pass


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("horizon", [2, 3, 20])
def test_what_is_kept_of_attempts_changes_no_outcome(
    seed: int, horizon: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    toy = Toy(horizon=horizon, fails_below=0.2)
    task = toy.sample_task("train", 0, np.random.default_rng(0))
    outcomes = []
    for known in (dict, Forgetful):
        record = partial(RefinementRecord, known=known())
        monkeypatch.setattr(bilevel, "TaskSearch", partial(TaskSearch, refining=record()))
        planner = planners.load("astar")
        outcome = bilevel.solve(toy, task, SKILLS, planner, toy.budget, seed, strategy=exhaustive)
        steps = [(str(s.skill.operator), s.subgoal.tolist()) for s in getattr(outcome, "steps", ())]
        outcomes.append((type(outcome), steps, outcome.effort.samples, outcome.dead_ends))
    assert outcomes[0] == outcomes[1]
