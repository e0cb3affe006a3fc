"""What every planner promises, and what is said of planners that there are not."""

import os
import subprocess
import sys
from itertools import islice
from pathlib import Path

import pytest
from hypothesis import given, settings

from bpns.symbolic.errors import InputError
from bpns.symbolic.grounding.ground import Unreachable, ground
from bpns.symbolic.operators import Domain, Problem
from bpns.symbolic.pddl.read import parse_domain, parse_problem
from bpns.symbolic.planners.protocol import Limit
from bpns.symbolic.planners.registry import about, load, names
from tests.symbolic._planning import check_plan, grounded, key, load_or_skip, plans
from tests.symbolic._problems import (
    COVER,
    Graph,
    cover_problem,
    distances,
    searchable_tasks,
    steps_as_time,
    switches,
)

# ---------------------------------------------------------------------------------------- contract
# Here are those that search with our path search, and what all modules share; test_backends.py has the rest.

OURS = ("astar", "pyperplan")


def test_names_are_the_modules_without_underscore() -> None:
    assert {"astar", "pyperplan", "kairos", "kstar", "symk", "up", "command"} <= set(names())
    assert not [name for name in names() if name.startswith("_")]


@pytest.mark.parametrize(
    "planner",
    [about.name for about in about() if about.name != "command"] + ["command:cat {domain} {problem} -n"],
)
def test_name_of_a_planner_loads_it_again(planner: str) -> None:
    loaded = load_or_skip(planner)
    assert loaded.name.startswith(planner.split(" ")[0].replace("command:cat", "command:"))
    assert load(loaded.name) == loaded


def test_every_module_says_what_its_planners_can_do() -> None:
    assert {one.name.split(":")[0] for one in about()} == set(names())
    assert len({one.name for one in about()}) == len(about())


@pytest.mark.parametrize("planner", OURS)
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


@pytest.mark.parametrize("planner", OURS)
def test_planners_agree_on_the_number_of_plans_of_each_length(planner: str) -> None:
    problem = cover_problem(2)
    found = grounded(COVER, problem)
    got, expected = (
        sorted(key(plan) for plan in islice(plans(found, name)[0], 60) if len(plan.steps) <= 6)
        for name in (planner, "astar")
    )
    assert got == expected


@pytest.mark.parametrize("planner", OURS)
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


@pytest.mark.parametrize(
    "planner",
    [
        "astar",
        "pyperplan:gbf:lmcut",
        *(
            pytest.param(name, marks=pytest.mark.slow)
            for name in ("pyperplan", "kairos", "kstar", "symk", "up:fast-downward")
        ),
    ],
)
def test_plans_do_not_depend_on_the_hash_seed(planner: str) -> None:
    """pyperplan's with gbf would, if its facts were not numbered."""
    load_or_skip(planner)
    script = (
        "from itertools import islice\n"
        "from tests.symbolic._planning import grounded, plans\n"
        "from tests.symbolic.test_planner_contract import RING, TRUCKS\n"
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


@pytest.mark.parametrize("planner", OURS)
def test_node_limit_is_kept_and_named(planner: str) -> None:
    stream, record = plans(grounded(COVER, cover_problem(3)), planner, Limit(nodes=40))
    assert all(len(plan.steps) >= 6 for plan in stream)
    assert record.stopped_by == "node limit"
    assert 40 <= record.nodes_created <= 50
    assert 0 < record.nodes_expanded <= 40


def test_deadline_is_kept_and_named() -> None:
    with steps_as_time():
        stream, record = plans(grounded(COVER, cover_problem(3)), "astar", Limit(100_000, deadline=10))
        assert len(list(stream)) <= 1
    assert record.stopped_by == "time limit"
    assert 0 < record.nodes_expanded <= 10


@pytest.mark.parametrize("planner", OURS)
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


def test_pyperplan_gets_what_it_does_not_read_in_other_words() -> None:
    moves = {"walk": ("tired-", "away")}
    for task in (switches(moves, "", "away"), switches({"walk": ("", "away home-")}, "home", "away home-")):
        first = next(plans(grounded(*task), "pyperplan")[0])
        check_plan(task[1], first)
        assert [step.operator.name for step in first.steps] == ["walk"]


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
