"""Grounding against the cross product of all objects, filtered by plain delete relaxation."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from random import Random
from time import monotonic

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bpns.symbolic.grounding.ground import GroundProblem, OutOfTime, Unreachable, ground
from bpns.symbolic.operators import Domain, Operator, Problem
from bpns.symbolic.structs import GroundAtom, Object, Predicate, Type, Variable
from tests.symbolic._problems import (
    COVER,
    Graph,
    Item,
    all_ground_operators,
    competition_task,
    cover_problem,
    distances,
    relaxed_fixpoint,
    searchable_tasks,
    switches,
    tasks,
)

CROSS_PRODUCTS_OF_THOUSANDS = (
    "airport blocks elevators gripper logistics miconic movie openstacks parcprinter psr-small rovers "
    "tpp transport"
)


def grounded(domain: Domain, problem: Problem) -> GroundProblem:
    found = ground(domain, problem)
    assert isinstance(found, GroundProblem), str(found)
    return found


def check_against_cross_product(domain: Domain, problem: Problem) -> None:
    """Compare; exact only where no operator has negative preconditions."""
    reached, usable = relaxed_fixpoint(problem.init, all_ground_operators(domain, problem))
    found = ground(domain, problem)
    if isinstance(found, GroundProblem):
        assert problem.goal <= reached
        assert set(found.operators) == usable
        assert len(found.operators) == len(usable)
    else:
        assert set(found.never_true) == problem.goal - reached
        permanent = problem.init.difference(*(o.delete_effects for o in usable))
        assert set(found.never_false) == problem.negative_goal & permanent
        assert found.never_true or found.never_false


def without_negative_preconditions(domain: Domain) -> Domain:
    operators = (replace(o, negative_preconditions=frozenset()) for o in domain.operators)
    return replace(domain, operators=tuple(operators))


@settings(deadline=None, max_examples=100)
@given(tasks())
def test_grounding_equals_the_filtered_cross_product(task: tuple[Domain, Problem]) -> None:
    domain, problem = task
    check_against_cross_product(without_negative_preconditions(domain), problem)


@settings(deadline=None, max_examples=100)
@given(searchable_tasks(negative=False))
def test_grounding_equals_the_filtered_cross_product_on_solvable_tasks(
    task: tuple[Domain, Problem, Graph],
) -> None:
    check_against_cross_product(*task[:2])


@pytest.mark.filterwarnings("ignore::bpns.symbolic.pddl.read.PddlWarning")  # miconic forgot :typing
@pytest.mark.parametrize("folder", CROSS_PRODUCTS_OF_THOUSANDS.split())
def test_grounding_equals_the_filtered_cross_product_on_competition_tasks(data: Path, folder: str) -> None:
    domain, problem = competition_task(data, folder, 1)
    assert grounded(domain, problem).operators
    check_against_cross_product(domain, problem)


@settings(deadline=None, max_examples=150)
@given(searchable_tasks())
def test_every_operator_that_can_ever_be_used_is_kept(task: tuple[Domain, Problem, Graph]) -> None:
    domain, problem, graph = task
    found = ground(domain, problem)
    if isinstance(found, Unreachable):
        assert not distances(problem, graph)
    else:
        used = {operator for moves in graph.values() for operator, _ in moves}
        relaxed = relaxed_fixpoint(problem.init, all_ground_operators(domain, problem))[1]
        assert used <= set(found.operators) <= relaxed


def test_operator_that_is_forbidden_for_ever_is_dropped() -> None:
    moves = {"never": ("locked-", "open"), "sometimes": ("dark-", "open"), "light": ("", "dark-")}
    found = grounded(*switches(moves, init="locked dark", goal="open"))
    assert [str(o) for o in found.operators] == ["light()", "sometimes()"]


def test_static_preconditions_keep_large_products_away() -> None:
    node = Type("node")
    road, at = Predicate("road", (node, node)), Predicate("at", (node,))
    stops = tuple(Variable(f"?n{i}", node) for i in range(7))
    roads = frozenset(road.lifted(a, b) for a, b in pairwise(stops))
    travel = Operator(
        "travel",
        stops,
        roads | {at.lifted(stops[0])},
        frozenset({at.lifted(stops[-1])}),
        frozenset({at.lifted(stops[0])}),
    )
    domain = Domain("roads", (node,), (road, at), (travel,))
    nodes = tuple(Object(f"n{i:02}", node) for i in range(61))  # 61 ** 7 ways to fill the parameters
    line = frozenset(road(a, b) for a, b in pairwise(nodes))
    problem = Problem("far", nodes, line | {at(nodes[0])}, frozenset({at(nodes[60])}))
    assert [str(o.objects[-1]) for o in grounded(domain, problem).operators] == [
        f"n{i:02}" for i in range(6, 61, 6)
    ]


def test_constants_and_one_object_twice() -> None:
    cup = Type("cup")
    clean, near = Predicate("clean", (cup,)), Predicate("near", (cup, cup))
    left, right = Variable("?l", cup), Variable("?r", cup)
    sink = Object("sink", cup)
    wash = Operator(
        "wash",
        (left, right),
        frozenset({near.lifted(left, right), near.lifted(right, sink)}),
        frozenset({clean.lifted(left), clean.lifted(sink)}),
        frozenset(),
    )
    domain = Domain("kitchen", (cup,), (clean, near), (wash,), (sink,))
    mug, jug = Object("mug", cup), Object("jug", cup)
    init = frozenset({near(mug, mug), near(mug, sink), near(jug, mug), near(jug, jug)})
    found = grounded(domain, Problem("p", (mug, jug), init, frozenset({clean(sink)})))
    assert [str(o) for o in found.operators] == ["wash(jug, mug)", "wash(mug, mug)"]


def test_parameter_without_precondition_takes_every_object_of_its_type_and_subtypes() -> None:
    movable = Type("movable")
    cup = Type("cup", (), movable)
    seen = Predicate("seen", (movable,))
    thing = Variable("?x", movable)
    look = Operator("look", (thing,), frozenset(), frozenset({seen.lifted(thing)}), frozenset())
    objects = (Object("mug", cup), Object("box", movable), Object("moon", Type("place")))
    domain = Domain("d", (movable, cup), (seen,), (look,))
    found = grounded(domain, Problem("p", objects, frozenset(), frozenset()))
    assert [str(o) for o in found.operators] == ["look(box)", "look(mug)"]


def test_subtype_in_a_precondition_is_checked() -> None:
    movable = Type("movable")
    cup = Type("cup", (), movable)
    near, full = Predicate("near", (movable,)), Predicate("full", (cup,))
    mug, box = Object("mug", cup), Object("box", movable)
    thing = Variable("?x", cup)
    near_thing, full_thing = frozenset({near.lifted(thing)}), frozenset({full.lifted(thing)})
    pour = Operator("pour", (thing,), near_thing, full_thing, frozenset())
    domain = Domain("d", (movable, cup), (near, full), (pour,))
    problem = Problem("p", (mug, box), frozenset({near(mug), near(box)}), frozenset({full(mug)}))
    assert [str(o) for o in grounded(domain, problem).operators] == ["pour(mug)"]


def test_unreachable_names_the_atoms_that_nothing_makes_true() -> None:
    moves = {"walk": ("home", "away home-"), "fly": ("wings", "moon")}
    found = ground(*switches(moves, init="home", goal="away moon sun"))
    assert isinstance(found, Unreachable)
    assert [str(a) for a in found.never_true] == ["moon()", "sun()"]
    assert str(found) == (
        "no plan exists: the goal needs moon(), which nothing makes true; sun(), which nothing makes true"
    )


def test_unreachable_names_the_atoms_that_nothing_makes_false() -> None:
    moves = {"walk": ("home", "away home-")}
    found = ground(*switches(moves, init="home tired", goal="away home- tired-"))
    assert isinstance(found, Unreachable)
    assert not found.never_true
    assert [str(a) for a in found.never_false] == ["tired()"]
    assert str(found) == "no plan exists: the goal needs not tired(), which nothing makes false"


def test_negative_goal_that_holds_already_is_no_obstacle() -> None:
    assert isinstance(ground(*switches({}, init="home", goal="home tired-")), GroundProblem)


@settings(deadline=None, max_examples=50)
@given(tasks(), st.integers(0, 999))
def test_order_of_the_input_does_not_matter(task: tuple[Domain, Problem], seed: int) -> None:
    domain, problem = task
    rng = Random(seed)

    def shuffled(items: tuple[Item, ...]) -> tuple[Item, ...]:
        return tuple(rng.sample(items, len(items)))

    declared = (domain.types, domain.predicates, domain.operators, domain.constants)
    other_domain = Domain(domain.name, *map(shuffled, declared))
    other_problem = replace(problem, objects=shuffled(problem.objects))
    one, other = ground(domain, problem), ground(other_domain, other_problem)
    if isinstance(one, GroundProblem):
        assert isinstance(other, GroundProblem)
        assert one.operators == other.operators
    else:
        assert one == other


def test_deadline_ends_grounding() -> None:
    thing = Type("thing")
    marks = tuple(Variable(f"?x{i}", thing) for i in range(9))
    seen = Predicate("seen", (thing,))
    look = Operator("look", marks, frozenset(), frozenset({seen.lifted(marks[0])}), frozenset())
    objects = tuple(Object(f"o{i}", thing) for i in range(50))  # 50 ** 9 ground operators
    domain, problem = Domain("d", (thing,), (seen,), (look,)), Problem("p", objects, frozenset(), frozenset())
    assert ground(domain, problem, monotonic() + 0.05) == OutOfTime()
    assert ground(domain, problem, monotonic() - 1) == OutOfTime()


def test_deadline_that_does_not_pass_changes_nothing() -> None:
    domain, problem = COVER, cover_problem(3)
    assert ground(domain, problem, monotonic() + 1e6) == ground(domain, problem)


def test_operators_are_ordered_by_name_then_objects() -> None:
    names = [str(o) for o in grounded(COVER, cover_problem(2)).operators]
    assert names == sorted(names)
    assert names[0] == "Pick(block0, robby)"
    assert len(names) == 6


def test_ground_operators_have_the_atoms_of_their_objects() -> None:
    found = grounded(COVER, cover_problem(1))
    place = found.operators[1]
    holding = next(iter(place.delete_effects))
    assert isinstance(holding, GroundAtom)
    assert str(holding) == "Holding(block0, robby)"
    assert {str(a) for a in place.add_effects} == {"HandEmpty()", "Covers(block0, target0)"}
