"""Heuristics against true distances, plain fixpoints and pyperplan, on every state of small random tasks."""

from collections.abc import Sequence
from itertools import combinations, permutations, product
from math import inf
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bpns.symbolic.grounding.ground import GroundProblem, ground
from bpns.symbolic.grounding.heuristics import HEURISTICS, LmCut, hadd, hff
from bpns.symbolic.grounding.masks import CompiledProblem, compile_problem
from bpns.symbolic.operators import Domain, GroundOperator, Problem
from bpns.symbolic.structs import GroundAtom
from tests.symbolic._problems import (
    COVER,
    AbstractState,
    Graph,
    cover_problem,
    distances,
    encode,
    relaxed_fixpoint,
    searchable_tasks,
    switches,
)


def compiled(domain: Domain, problem: Problem) -> CompiledProblem | None:
    """Return a compiled problem, or nothing where the goal is out of reach."""
    found = ground(domain, problem)
    return compile_problem(found) if isinstance(found, GroundProblem) else None


def plain_hmax(state: AbstractState, operators: Sequence[GroundOperator], goal: AbstractState) -> float:
    """Cost of the goal's most expensive atom when nothing is deleted; by repetition until nothing changes."""
    cost: dict[GroundAtom, float] = dict.fromkeys(state, 0)
    while True:
        before = dict(cost)
        for operator in operators:
            after = 1 + max((cost.get(a, inf) for a in operator.preconditions), default=0)
            for atom in operator.add_effects:
                cost[atom] = min(cost.get(atom, inf), after)
        if cost == before:
            return max((cost.get(a, inf) for a in goal), default=0)


@settings(deadline=None, max_examples=200)
@given(searchable_tasks())
def test_lmcut_never_overestimates(task: tuple[Domain, Problem, Graph]) -> None:
    domain, problem, graph = task
    if masks := compiled(domain, problem):
        evaluate = LmCut(masks)
        steps = distances(problem, graph)
        for state in graph:
            assert evaluate(encode(masks, state)) <= steps.get(state, inf)


@settings(deadline=None, max_examples=200)
@given(searchable_tasks(), st.randoms(use_true_random=False))
def test_lmcut_on_random_walks_keeps_only_landmarks(task: tuple[Domain, Problem, Graph], rng: Random) -> None:
    domain, problem, graph = task
    masks = compiled(domain, problem)
    if masks is None:
        return
    evaluate = LmCut(masks)
    steps = distances(problem, graph)
    operators = [o.ground for o in masks.operators]
    numbers = {operator: number for number, operator in enumerate(operators)}
    state, mask = problem.init, masks.init
    evaluate(mask)
    for _ in range(12):
        moves = [(numbers[o], after) for o, after in graph[state] if o in numbers]
        if not moves:
            return
        number, after = rng.choice(moves)
        total, covered = evaluate.known(mask)
        at_first = total - (number in covered)
        state, mask, before = after, encode(masks, after), mask
        evaluate.inherit(mask, before, number)
        assert at_first <= evaluate.known(mask)[0]
        value = evaluate(mask)
        assert at_first <= value <= steps.get(state, inf)
        reached, _ = relaxed_fixpoint(state, operators)
        assert (value == 0) == (problem.goal <= state)
        assert (value == inf) == (not problem.goal <= reached)
        assert value == evaluate(mask)
        if value == inf:
            return


@settings(deadline=None, max_examples=100)
@given(searchable_tasks())
def test_landmarks_share_no_operators_and_every_plan_uses_one_of_each(
    task: tuple[Domain, Problem, Graph],
) -> None:
    domain, problem, graph = task
    if masks := compiled(domain, problem):
        evaluate = LmCut(masks)
        operators = [o.ground for o in masks.operators]
        for state in graph:
            mask = encode(masks, state)
            if evaluate(mask) == inf:
                continue
            for one, other in combinations(evaluate.landmarks[mask], 2):
                assert one.isdisjoint(other)
            for landmark in evaluate.landmarks[mask]:
                others = [o for number, o in enumerate(operators) if number not in landmark]
                assert not problem.goal <= relaxed_fixpoint(state, others)[0]


@settings(deadline=None, max_examples=100)
@given(searchable_tasks())
def test_values_are_in_the_order_that_theory_demands(task: tuple[Domain, Problem, Graph]) -> None:
    domain, problem, graph = task
    if masks := compiled(domain, problem):
        operators = [o.ground for o in masks.operators]
        sums, plans, cuts = hadd(masks), hff(masks), LmCut(masks)
        for state in graph:
            mask = encode(masks, state)
            hmax = plain_hmax(state, operators, problem.goal)
            assert hmax <= cuts(mask)
            assert hmax <= plans(mask) <= sums(mask)


@pytest.mark.parametrize("name", HEURISTICS)
@settings(deadline=None, max_examples=100)
@given(searchable_tasks())
def test_zero_at_goals_and_infinite_where_relaxation_finds_no_way(
    name: str, task: tuple[Domain, Problem, Graph]
) -> None:
    domain, problem, graph = task
    if masks := compiled(domain, problem):
        evaluate = HEURISTICS[name](masks)
        operators = [o.ground for o in masks.operators]
        for state in graph:
            value = evaluate(encode(masks, state))
            reached, _ = relaxed_fixpoint(state, operators)
            assert (value == 0) == (problem.goal <= state)
            assert (value == inf) == (not problem.goal <= reached)


def cover_values(size: int) -> dict[str, float]:
    masks = compiled(COVER, cover_problem(size))
    assert masks is not None
    return {name: make(masks)(masks.init) for name, make in HEURISTICS.items()}


def test_values_on_cover_are_those_found_by_hand() -> None:
    # each block costs a pick and a place
    assert cover_values(1) == {"lmcut": 2, "hadd": 2, "hff": 2}
    assert cover_values(3) == {"lmcut": 6, "hadd": 6, "hff": 6}


def test_shared_preconditions_count_twice_for_hadd_only() -> None:
    moves = {"open": ("", "door"), "left": ("door", "lamp"), "right": ("door", "radio")}
    masks = compiled(*switches(moves, init="", goal="lamp radio"))
    assert masks is not None
    assert {name: make(masks)(masks.init) for name, make in HEURISTICS.items()} == {
        "lmcut": 3,
        "hadd": 4,
        "hff": 3,
    }


def doors_moves(cells: list[str]) -> dict[str, tuple[str, str]]:
    """Return moves as in Doors: go to a door from inside a room or from another of its doors, open, pass."""
    near = [(a, b) for a, b in combinations(cells, 2) if abs(int(a) - int(b)) in (1, 10)]
    moves = {}
    for a, b in near:
        moves[f"open{a}{b}"] = (f"at{a}{b}", f"open{a}{b}")
        for here, there in ((a, b), (b, a)):
            moves[f"to{a}{b}from{here}"] = (f"in{here} main", f"at{a}{b} main-")
            moves[f"pass{here}{there}"] = (f"in{here} at{a}{b} open{a}{b}", f"in{there} in{here}-")
    for (a, b), (c, d) in permutations(near, 2):
        if {a, b} & {c, d}:
            moves[f"to{c}{d}from{a}{b}"] = (f"at{a}{b}", f"at{c}{d} at{a}{b}-")
    return moves


def test_lmcut_is_exact_where_operators_choose_their_most_expensive_precondition_alike() -> None:
    """With a choice by the order in which they are reached, it was 20."""
    cells = [f"{x}{y}" for x, y in product(range(4), range(4)) if (x, y) not in ((0, 2), (1, 1))]
    masks = compiled(*switches(doors_moves(cells), init="in00 main", goal="in03"))
    assert masks is not None
    assert LmCut(masks)(masks.init) == 3 * 7  # rooms 10 20 21 22 12 13 03


def test_atom_that_holds_is_free_even_if_the_way_deletes_it() -> None:
    masks = compiled(*switches({"turn": ("key", "open key-")}, init="key", goal="open key"))
    assert masks is not None
    assert {make(masks)(masks.init) for make in HEURISTICS.values()} == {1}


@settings(deadline=None, max_examples=50)
@given(searchable_tasks(negative=False))
def test_hadd_equals_that_of_pyperplan(task: tuple[Domain, Problem, Graph]) -> None:
    hadd_of_pyperplan = pytest.importorskip("pyperplan.planner").HEURISTICS["hadd"]
    from pyperplan.search.searchspace import make_root_node
    from pyperplan.task import Operator, Task

    domain, problem, graph = task
    if masks := compiled(domain, problem):

        def texts(atoms: AbstractState) -> frozenset[str]:
            return frozenset(map(str, atoms))

        steps = [o.ground for o in masks.operators]
        facts = texts(problem.init | problem.goal).union(
            *(texts(o.preconditions | o.add_effects | o.delete_effects) for o in steps)
        )
        theirs = hadd_of_pyperplan(
            Task(
                "task",
                facts,
                texts(problem.init),
                texts(problem.goal),
                [
                    Operator(str(o), texts(o.preconditions), texts(o.add_effects), texts(o.delete_effects))
                    for o in steps
                ],
            )
        )
        ours = hadd(masks)
        for state in graph:
            assert ours(encode(masks, state)) == theirs(make_root_node(texts(state)))
