"""Planners: against all plans found by brute force, against other validators, and their contract."""

import os
import subprocess
import sys
from collections.abc import Iterator
from itertools import islice, pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings

from symbolic.compile import compile_problem
from symbolic.errors import InputError, MissingPackage, Unsupported
from symbolic.grounding import GroundProblem, Unreachable, ground
from symbolic.heuristics import hadd
from symbolic.pddl.read import parse_domain, parse_problem
from symbolic.pddl.write import write_domain, write_problem
from symbolic.planners import AbstractPlan, Limit, Planner, SearchRecord, load, names
from symbolic.planners._best_first import enumerate_plans
from symbolic.structs import Domain, Problem
from symbolic.validate import first_fault
from tests.symbolic._problems import (
    COVER,
    Graph,
    PlanKey,
    competition_task,
    cover_problem,
    distances,
    plans_by_length,
    searchable_tasks,
    steps_as_time,
    switches,
)

AMPLE = Limit(1_000_000)


def grounded(domain: Domain, problem: Problem) -> GroundProblem:
    found = ground(domain, problem)
    assert isinstance(found, GroundProblem), str(found)
    return found


def load_or_skip(name: str) -> Planner:
    try:
        return load(name)
    except MissingPackage as error:
        pytest.skip(str(error))


def plans(
    problem: GroundProblem, planner: str = "astar", limit: Limit = AMPLE, seed: int = 0
) -> tuple[Iterator[AbstractPlan], SearchRecord]:
    record = SearchRecord()
    return load_or_skip(planner).plans(problem, np.random.default_rng(seed), limit, record), record


def key(plan: AbstractPlan) -> PlanKey:
    return tuple(map(str, plan.steps))


def check_plan(problem: Problem, plan: AbstractPlan) -> None:
    """Check that a plan is valid, ends at its first goal state and comes with the right abstract states."""
    assert first_fault(problem, plan.steps) == ""
    assert plan.atoms[0] == problem.init
    for step, (before, after) in zip(plan.steps, pairwise(plan.atoms), strict=True):
        assert step.apply(before) == after
    assert not any(problem.satisfied(atoms) for atoms in plan.atoms[:-1])


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
def test_first_plans_of_competition_tasks_are_as_short_as_known(shared: Path, folder: str) -> None:
    for number, length in enumerate(OPTIMA[folder], 1):
        domain, problem = competition_task(shared, folder, number)
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


# ---------------------------------------------------------------------------------------- contract


def test_names_are_the_modules_without_underscore() -> None:
    assert {"astar", "pyperplan"} <= set(names())
    assert not [name for name in names() if name.startswith("_")]


@pytest.mark.parametrize("planner", names())
def test_name_of_a_planner_loads_it_again(planner: str) -> None:
    loaded = load_or_skip(planner)
    assert loaded.name.startswith(planner)
    assert load(loaded.name) == loaded


@pytest.mark.parametrize("planner", names())
def test_shortest_plan_comes_first_and_others_follow(planner: str) -> None:
    problem = cover_problem(2)
    stream, _ = plans(grounded(COVER, problem), planner)
    got = list(islice(stream, 30))
    assert len({key(plan) for plan in got}) == 30
    for plan in got:
        check_plan(problem, plan)
    lengths = [len(plan.steps) for plan in got]
    assert lengths == sorted(lengths)
    assert lengths[:3] == [4, 4, 6]


@pytest.mark.parametrize("planner", names())
def test_planners_agree_on_the_number_of_plans_of_each_length(planner: str) -> None:
    problem = cover_problem(2)
    found = grounded(COVER, problem)
    got, expected = (
        sorted(key(plan) for plan in islice(plans(found, name)[0], 60) if len(plan.steps) <= 6)
        for name in (planner, "astar")
    )
    assert got == expected


@pytest.mark.parametrize("planner", names())
def test_same_seed_gives_the_same_plans_and_another_seed_other_ones(planner: str) -> None:
    found = grounded(COVER, cover_problem(3))
    first, again, other = (
        [key(plan) for plan in islice(plans(found, planner, seed=seed)[0], 20)] for seed in (5, 5, 6)
    )
    assert first == again
    assert first != other


TRUCKS = parse_domain("""
(define (domain trucks) (:requirements :strips :typing)
  (:types place thing - object truck parcel - thing)
  (:predicates (road ?a ?b - place) (at ?x - thing ?p - place) (in ?x - parcel ?t - truck))
  (:action drive :parameters (?t - truck ?a ?b - place)
    :precondition (and (road ?a ?b) (at ?t ?a)) :effect (and (at ?t ?b) (not (at ?t ?a))))
  (:action load :parameters (?x - parcel ?t - truck ?a - place)
    :precondition (and (at ?x ?a) (at ?t ?a)) :effect (and (in ?x ?t) (not (at ?x ?a))))
  (:action unload :parameters (?x - parcel ?t - truck ?a - place)
    :precondition (and (in ?x ?t) (at ?t ?a)) :effect (and (at ?x ?a) (not (in ?x ?t)))))
""")
RING = parse_problem(
    """
(define (problem ring) (:domain trucks)
  (:objects p0 p1 p2 p3 p4 - place t0 t1 - truck x0 x1 x2 - parcel)
  (:init (road p0 p1) (road p1 p2) (road p2 p3) (road p3 p4) (road p4 p0)
    (road p1 p0) (road p2 p1) (road p3 p2) (road p4 p3) (road p0 p4)
    (at t0 p0) (at t1 p2) (at x0 p0) (at x1 p1) (at x2 p2))
  (:goal (and (at x0 p2) (at x1 p3) (at x2 p4))))
""",
    TRUCKS,
)


@pytest.mark.parametrize("planner", [*names(), "pyperplan:gbf:lmcut"])
def test_plans_do_not_depend_on_the_hash_seed(planner: str) -> None:
    """The last one's would, if its facts were not numbered."""
    load_or_skip(planner)
    script = (
        "from itertools import islice\n"
        "from tests.symbolic.test_planners import *\n"
        f"stream, record = plans(grounded(TRUCKS, RING), {planner!r})\n"
        "for plan in islice(stream, 5): print(plan)\n"
        "print(record)\n"
    )
    outputs = [
        subprocess.run(
            [sys.executable, "-c", script],
            env={**os.environ, "PYTHONHASHSEED": hash_seed},
            cwd=Path(__file__).parents[2],
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for hash_seed in ("1", "2")
    ]
    assert outputs[0].count("unload(") >= 15
    assert outputs[0] == outputs[1]


@pytest.mark.parametrize("planner", names())
def test_node_limit_is_kept_and_named(planner: str) -> None:
    stream, record = plans(grounded(COVER, cover_problem(3)), planner, Limit(nodes=40))
    assert all(len(plan.steps) >= 6 for plan in stream)
    assert record.stopped_by == "node limit"
    assert 40 <= record.nodes_created <= 50
    assert 0 < record.nodes_expanded <= 40


@pytest.mark.parametrize("planner", names())
def test_deadline_is_kept_and_named(planner: str) -> None:
    with steps_as_time():
        stream, record = plans(grounded(COVER, cover_problem(3)), planner, Limit(100_000, deadline=10))
        assert len(list(stream)) <= 1
    assert record.stopped_by == "time limit"
    assert 0 < record.nodes_expanded <= 10


@pytest.mark.parametrize("planner", names())
def test_plans_are_made_only_as_they_are_taken(planner: str) -> None:
    stream, record = plans(grounded(COVER, cover_problem(3)), planner)
    assert record.nodes_created == 0
    next(stream)
    after_one = record.nodes_created
    list(islice(stream, 50))
    assert 0 < after_one < record.nodes_created
    assert record.stopped_by == ""


def test_limit_without_deadline_is_never_late() -> None:
    assert not Limit(1).late
    assert Limit(1, deadline=-1.0).late


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("fast-downward", r"^unknown planner 'fast-downward' \(have: .*astar, .*pyperplan"),
        ("", "^unknown planner ''"),
        ("_best_first", "^unknown planner '_best_first'"),
        ("__init__", "^unknown planner '__init__'"),
        ("astar:hmax", r"^unknown heuristic 'astar:hmax' \(have: lmcut, hadd, hff\)$"),
        ("astar:", "^unknown heuristic 'astar:'"),
        ("astar:hff:fast", "astar:hff:fast"),
    ],
)
def test_unknown_planner_or_option_is_refused_with_what_there_is(name: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        load(name)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("pyperplan:dfs", r"^unknown search 'dfs' in 'pyperplan:dfs:lmcut' \(have: astar, bfs, "),
        ("pyperplan:gbf:h2", r"^unknown heuristic 'h2' in 'pyperplan:gbf:h2' \(have: blind, hadd, "),
        ("pyperplan:gbf:hff:fast", "pyperplan:gbf:hff:fast"),
    ],
)
def test_unknown_option_of_pyperplan_is_refused_with_what_there_is(name: str, message: str) -> None:
    pytest.importorskip("pyperplan")
    with pytest.raises(InputError, match=message):
        load(name)


def test_pyperplan_refuses_what_it_does_not_have() -> None:
    pytest.importorskip("pyperplan")
    moves = {"walk": ("tired-", "away")}
    for task in (switches(moves, "", "away"), switches({"walk": ("", "away home-")}, "home", "away home-")):
        with pytest.raises(Unsupported, match=r"no negative preconditions or goals: use --planner astar$"):
            next(plans(grounded(*task), "pyperplan")[0])


@pytest.mark.parametrize("planner", ["pyperplan:bfs", "pyperplan:gbf:hff", "pyperplan:wastar:hadd"])
def test_other_searches_of_pyperplan_give_distinct_valid_plans_too(planner: str) -> None:
    problem = cover_problem(2)
    got = list(islice(plans(grounded(COVER, problem), planner)[0], 20))
    assert len({key(plan) for plan in got}) == 20
    for plan in got:
        check_plan(problem, plan)


@settings(deadline=None, max_examples=25)
@given(searchable_tasks(negative=False))
def test_pyperplan_agrees_with_astar_on_the_length_of_the_first_plan(
    task: tuple[Domain, Problem, Graph],
) -> None:
    pytest.importorskip("pyperplan")
    domain, problem, graph = task
    found = ground(domain, problem)
    if isinstance(found, Unreachable):
        return
    first = next(plans(found, "pyperplan", Limit(5_000))[0], None)
    if first is None:
        assert problem.init not in distances(problem, graph)
    else:
        check_plan(problem, first)
        assert len(first.steps) == distances(problem, graph)[problem.init]
