"""Planners: against all plans found by brute force, against other validators, and their contract."""

from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings

from bpns.symbolic.grounding.ground import Unreachable, ground
from bpns.symbolic.grounding.heuristics import LmCut, hadd
from bpns.symbolic.grounding.masks import compile_problem
from bpns.symbolic.operators import Domain, Problem
from bpns.symbolic.pddl.write import write_domain, write_problem
from bpns.symbolic.planners.astar.best_first import enumerate_plans
from bpns.symbolic.planners.protocol import AbstractPlan, Limit, SearchRecord
from tests.symbolic._planning import AMPLE, check_plan, grounded, key, plans
from tests.symbolic._problems import (
    COVER,
    Graph,
    competition_task,
    cover_problem,
    distances,
    plans_by_length,
    searchable_tasks,
    steps_as_time,
    switches,
)

# ------------------------------------------------------------------------------ against brute force


@settings(deadline=None, max_examples=150)
@given(searchable_tasks())
def test_astar_gives_all_plans_in_order_of_length_and_then_ends(task: tuple[Domain, Problem, Graph]) -> None:
    domain, problem, graph = task
    expected = plans_by_length(problem, graph)
    found = ground(domain, problem)
    if isinstance(found, Unreachable):
        assert not any(expected)
        return
    with steps_as_time():
        stream, record = plans(found, limit=Limit(20_000, deadline=50_000))
        got: list[AbstractPlan] = []
        for plan in stream:
            if len(plan.steps) >= len(expected):
                break
            check_plan(problem, plan)
            got.append(plan)
        else:
            assert record.stopped_by == ""
    lengths = [len(plan.steps) for plan in got]
    assert lengths == sorted(lengths)
    assert len({key(plan) for plan in got}) == len(got)
    assert [{key(p) for p in got if len(p.steps) == n} for n in range(len(expected))] == expected


@pytest.mark.parametrize("planner", ["astar", "astar:hadd", "astar:hff"])
@settings(deadline=None, max_examples=60)
@given(searchable_tasks())
def test_every_heuristic_finds_distinct_valid_plans_exactly_where_there_are_plans(
    planner: str, task: tuple[Domain, Problem, Graph]
) -> None:
    domain, problem, graph = task
    found = ground(domain, problem)
    if isinstance(found, Unreachable):
        assert problem.init not in distances(problem, graph)
        return
    with steps_as_time():
        stream, _ = plans(found, planner, Limit(5_000, deadline=50_000))
        got = list(islice(stream, 10))
    assert bool(got) == (problem.init in distances(problem, graph))
    assert len({key(plan) for plan in got}) == len(got)
    for plan in got:
        check_plan(problem, plan)


OPTIMA = {
    "blocks": (6, 10, 6),
    "gripper": (11,),
    "movie": (7, 7),
    "psr-small": (8, 11, 11),
    "rovers": (10,),
    "satellite": (9,),
    "tpp": (5, 8, 11),
}


@pytest.mark.parametrize("folder", OPTIMA)
def test_first_plans_of_competition_tasks_are_as_short_as_known(data: Path, folder: str) -> None:
    for number, length in enumerate(OPTIMA[folder], 1):
        domain, problem = competition_task(data, folder, number)
        plan = next(plans(grounded(domain, problem))[0])
        check_plan(problem, plan)
        assert len(plan.steps) == length


# ------------------------------------------------------------------------------- other validators


def written_plan(plan: AbstractPlan) -> str:
    """Write a plan as the planning competitions do."""
    return "".join(
        f"({' '.join([step.operator.name, *map(str, step.objects)]).lower()})\n" for step in plan.steps
    )


@settings(deadline=None, max_examples=60)
@given(searchable_tasks())
def test_kairos_finds_the_plans_valid(task: tuple[Domain, Problem, Graph]) -> None:
    kairos = pytest.importorskip("kairos")
    domain, problem, _ = task
    found = ground(domain, problem)
    if isinstance(found, Unreachable):
        return
    with steps_as_time():
        got = list(islice(plans(found, limit=Limit(5_000, deadline=50_000))[0], 5))
    for plan in got:
        texts = write_domain(domain), write_problem(problem, domain)
        report = kairos.validate_plan(*texts, kairos.parse_plan(written_plan(plan)))
        assert report.status == kairos.ValidationStatus.VALID, str(report.diagnostics)


def test_unified_planning_finds_the_plans_valid() -> None:
    io = pytest.importorskip("unified_planning.io")
    from unified_planning.engines import SequentialPlanValidator

    problem = cover_problem(2)
    read = io.PDDLReader().parse_problem_string(write_domain(COVER), write_problem(problem, COVER))
    for plan in islice(plans(grounded(COVER, problem))[0], 5):
        theirs = io.PDDLReader().parse_plan_string(read, written_plan(plan))
        with SequentialPlanValidator() as validator:
            assert validator.validate(read, theirs)
            assert not validator.validate(
                read, io.PDDLReader().parse_plan_string(read, "(pick block0 robby)")
            )


# --------------------------------------------------------------------- what a search must not forget


def test_ways_through_the_same_abstract_states_are_all_given() -> None:
    moves = {
        "left": ("home", "shop home-"),
        "right": ("home", "shop home-"),
        "buy": ("shop", "bread"),
        "steal": ("shop", "bread"),
    }
    stream, record = plans(grounded(*switches(moves, init="home", goal="bread")))
    got = {key(plan) for plan in stream}
    assert got == {(way, end) for way in ("left()", "right()") for end in ("buy()", "steal()")}
    assert record.stopped_by == ""


def test_steps_that_change_nothing_are_not_taken() -> None:
    moves = {
        "walk": ("home", "away home-"),
        "stay": ("", "home"),
        "hum": ("home", ""),
        "rest": ("", "rested"),
    }
    got = [key(plan) for plan in islice(plans(grounded(*switches(moves, init="home", goal="away")))[0], 4)]
    assert got[:2] == [("walk()",), ("rest()", "walk()")]
    assert not [step for plan in got for step in plan if step == "hum()"]


def test_plans_that_return_to_a_state_are_given() -> None:
    moves = {"go": ("here", "there here-"), "come": ("there", "here there-"), "win": ("here", "won")}
    got = [key(plan) for plan in islice(plans(grounded(*switches(moves, init="here", goal="won")))[0], 3)]
    assert got == [("win()",), ("go()", "come()", "win()"), ("go()", "come()", "go()", "come()", "win()")]


def test_of_equal_plans_those_least_like_the_others_come_first() -> None:
    got = [plan.steps for plan in islice(plans(grounded(COVER, cover_problem(5)))[0], 120)]
    assert {len(steps) for steps in got} == {10}
    assert len({steps[0] for steps in got[:5]}) == 5
    assert len({steps[:4] for steps in got[:20]}) == 20


def test_plan_of_nothing_where_the_goal_holds() -> None:
    moves = {"walk": ("home", "away home-")}
    got = list(plans(grounded(*switches(moves, init="home", goal="home")))[0])
    assert [key(plan) for plan in got] == [()]
    assert str(got[0]) == "(nothing to do)"


DEAD_ENDS = {
    "no way out": {"buy": ("money", "bread money-"), "ride": ("money", "home money-")},
    "a step that changes nothing": {
        "buy": ("money", "bread money-"),
        "ride": ("money", "home money-"),
        "wait": ("", "waited"),
    },
    "a circle": {
        "buy": ("money", "bread money-"),
        "ride": ("money", "home money-"),
        "go": ("here", "there here-"),
        "come": ("there", "here there-"),
    },
}


@pytest.mark.parametrize("name", DEAD_ENDS)
@pytest.mark.parametrize("heuristic", ["lmcut", "hadd", "hff"])
def test_search_without_any_plan_ends(name: str, heuristic: str) -> None:
    with steps_as_time():
        problem = grounded(*switches(DEAD_ENDS[name], init="money here", goal="bread home"))
        stream, record = plans(problem, f"astar:{heuristic}", Limit(10_000, deadline=50_000))
        assert list(stream) == []
    assert record.stopped_by == ""


@pytest.mark.parametrize("name", DEAD_ENDS)
def test_search_ends_after_the_last_plan(name: str) -> None:
    """Dead ends that the heuristic does not see must not keep it going."""
    moves = {"win": ("start", "bread home start-"), "lose": ("start", "money here start-"), **DEAD_ENDS[name]}
    if name == "a step that changes nothing":
        moves["wait"] = ("money", "waited")  # not at the start
    with steps_as_time():
        problem = grounded(*switches(moves, init="start", goal="bread home"))
        stream, record = plans(problem, limit=Limit(10_000, deadline=50_000))
        assert [key(plan) for plan in stream] == [("win()",)]
    assert record.stopped_by == ""


def test_first_plan_needs_no_more_evaluations_where_landmarks_are_exact() -> None:
    masks = compile_problem(grounded(COVER, cover_problem(6)))
    evaluate = LmCut(masks)
    evaluated: list[int] = []
    call = LmCut.__call__

    def counted(heuristic: LmCut, state: int) -> float:
        evaluated.append(state)
        return call(heuristic, state)

    record = SearchRecord()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(LmCut, "__call__", counted)
        assert len(next(enumerate_plans(masks, evaluate, np.random.default_rng(0), AMPLE, record))) == 12
    assert evaluated == [masks.init]  # its landmarks lead all the way
    assert record.nodes_created > 50


def test_limits_hold_in_large_dead_ends_too() -> None:
    switchboard = {f"on{i}": ("here", f"lamp{i}") for i in range(12)}
    switchboard |= {f"off{i}": (f"lamp{i}", f"lamp{i}-") for i in range(12)}
    moves = {
        "win": ("start", "bread home start-"),
        "lose": ("start", "money here start-"),
        **DEAD_ENDS["no way out"],
        **switchboard,
    }
    masks = compile_problem(grounded(*switches(moves, init="start", goal="bread home")))
    evaluate = hadd(masks)
    evaluated: list[int] = []

    def counted(state: int) -> float:
        evaluated.append(state)
        return evaluate(state)

    record = SearchRecord()
    with steps_as_time():
        limit = Limit(10_000, deadline=50)
        assert len(list(enumerate_plans(masks, counted, np.random.default_rng(0), limit, record))) == 1
    assert record.stopped_by == "time limit"
    assert len(evaluated) < 50 * len(moves)  # of 4096 states
