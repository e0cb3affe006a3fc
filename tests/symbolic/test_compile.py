"""Compiled problems: bit masks must behave as the sets of atoms that they stand for."""

from hypothesis import given, settings

from bpns.symbolic.grounding.ground import GroundProblem, Unreachable, ground
from bpns.symbolic.grounding.masks import applicable_operators, bits, compile_problem
from bpns.symbolic.operators import Domain, Problem
from tests.symbolic._problems import COVER, Graph, cover_problem, encode, searchable_tasks, switches


@settings(deadline=None, max_examples=300)
@given(searchable_tasks())
def test_masks_behave_as_the_atoms_that_they_stand_for(task: tuple[Domain, Problem, Graph]) -> None:
    domain, problem, graph = task
    found = ground(domain, problem)
    if isinstance(found, Unreachable):
        return
    compiled = compile_problem(found)
    assert compiled.init == encode(compiled, problem.init)
    for state, moves in graph.items():
        mask = encode(compiled, state)
        assert compiled.decode(mask) == state
        assert compiled.is_goal(mask) == problem.satisfied(state)
        applicable = [o for o in compiled.operators if o.applicable(mask)]
        assert {(o.ground, compiled.decode(o.apply(mask))) for o in applicable} == set(moves)


def compiled_moves(moves: dict[str, tuple[str, str]], init: str, goal: str) -> list[str]:
    """Return what is applicable at the start, and whether the goal is said to hold there."""
    found = ground(*switches(moves, init, goal))
    if isinstance(found, Unreachable):
        return ["unreachable"]
    compiled = compile_problem(found)
    applicable = [str(o.ground) for o in compiled.operators if o.applicable(compiled.init)]
    return [*applicable, "goal"] if compiled.is_goal(compiled.init) else applicable


def test_goal_that_only_a_forbidden_operator_achieves_does_not_hold() -> None:
    moves = {"never": ("locked-", "open")}
    assert compiled_moves(moves, init="locked", goal="open") in ([], ["unreachable"])


def test_precondition_that_only_a_forbidden_operator_achieves_is_not_forgotten() -> None:
    moves = {"never": ("locked-", "open"), "enter": ("open", "inside"), "climb": ("", "inside")}
    assert compiled_moves(moves, init="locked", goal="inside") == ["climb()"]


def test_forbidden_atom_that_only_a_forbidden_operator_deletes_is_not_forgotten() -> None:
    moves = {"never": ("locked-", "dark-"), "read": ("dark-", "wise"), "think": ("", "wise")}
    assert compiled_moves(moves, init="locked dark", goal="wise") == ["think()"]


def test_forbidden_goal_that_only_a_forbidden_operator_deletes_is_not_forgotten() -> None:
    moves = {"never": ("locked-", "dark-")}
    assert compiled_moves(moves, init="locked dark", goal="dark-") in ([], ["unreachable"])


def test_atoms_that_never_change_are_left_out_of_the_numbers() -> None:
    found = ground(*switches({"walk": ("home floor", "away home-")}, init="home floor", goal="away"))
    assert isinstance(found, GroundProblem)
    compiled = compile_problem(found)
    assert [str(a) for a in compiled.atoms] == ["away()", "home()"]
    assert {str(a) for a in compiled.constant} == {"floor()"}


def test_same_problem_gives_the_same_numbers() -> None:
    first, second = (ground(COVER, cover_problem(3)) for _ in range(2))
    assert isinstance(first, GroundProblem)
    assert isinstance(second, GroundProblem)
    assert compile_problem(first) == compile_problem(second)
    assert [str(a) for a in compile_problem(first).atoms] == sorted(map(str, compile_problem(first).atoms))


def test_bits_are_the_positions_of_the_ones() -> None:
    assert bits(0) == []
    assert bits(0b1) == [0]
    assert bits(0b101001) == [0, 3, 5]
    assert bits(1 << 200 | 2) == [1, 200]


@settings(deadline=None, max_examples=100)
@given(searchable_tasks())
def test_applicable_operators_are_all_those_that_are_applicable(task: tuple[Domain, Problem, Graph]) -> None:
    domain, problem, graph = task
    found = ground(domain, problem)
    if isinstance(found, GroundProblem):
        compiled = compile_problem(found)
        applicable = applicable_operators(compiled)
        for state in graph:
            mask = encode(compiled, state)
            assert applicable(mask) == [i for i, o in enumerate(compiled.operators) if o.applicable(mask)]
