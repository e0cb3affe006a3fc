"""Symbolic values: what their constructors check and what applying an operator does."""

import os
import pickle
import subprocess
import sys
from pathlib import Path

import pytest

from bpns.symbolic.operators import Operator, Problem
from bpns.symbolic.structs import (
    OBJECT,
    Object,
    Predicate,
    Type,
    Variable,
    canonical_order,
    either,
    sort_atoms,
)
from tests.symbolic._problems import BLOCK, COVERS, GRIPPER, HAND_EMPTY, HOLDING, PICK, TARGET

ROOT = Path(__file__).parents[2]
BLOCK0, BLOCK1 = Object("block0", BLOCK), Object("block1", BLOCK)
ROBBY = Object("robby", GRIPPER)


def test_type_is_its_ancestors_but_not_its_children() -> None:
    movable = Type("movable")
    cup = Type("cup", (), movable)
    mug = Type("mug", (), cup)
    assert mug.is_a(mug)
    assert mug.is_a(cup)
    assert mug.is_a(movable)
    assert not movable.is_a(mug)
    assert not cup.is_a(Type("jug", (), movable))


def test_every_type_is_an_object() -> None:
    assert Type("cup", (), Type("movable")).is_a(OBJECT)
    assert OBJECT.is_a(OBJECT)
    assert not OBJECT.is_a(BLOCK)


def test_either_is_what_all_its_types_are_and_what_is_any_of_them() -> None:
    movable = Type("movable")
    cup, jug, robot = Type("cup", (), movable), Type("jug", (), movable), Type("robot")
    vessel = either((cup, jug))
    assert vessel.name == "(either cup jug)"
    assert cup.is_a(vessel)
    assert Type("mug", (), cup).is_a(vessel)
    assert not robot.is_a(vessel)
    assert not movable.is_a(vessel)
    assert vessel.is_a(movable)
    assert vessel.is_a(OBJECT)
    assert vessel.is_a(either((robot, jug, cup)))
    assert not vessel.is_a(cup)
    assert not either((cup, robot)).is_a(movable)
    assert not OBJECT.is_a(vessel)
    assert vessel != either((cup, robot))
    assert either((cup, cup)) == cup
    assert either((cup, OBJECT)) == OBJECT


def test_long_lines_of_ancestors_are_compared_without_recursion() -> None:
    def line(name: str) -> Type:
        kind = Type(name)
        for number in range(5000):
            kind = Type(f"t{number}", (), kind)
        return kind

    assert line("a") == line("a")
    assert line("a") != line("b")
    assert line("a").is_a(Type("a"))


def test_types_differ_by_features_and_parent() -> None:
    assert Type("block", ("x",)) != Type("block", ("y",))
    assert Type("block", (), BLOCK) != Type("block")
    assert Type("block", ("x",)) == Type("block", ("x",))


def test_predicate_refuses_wrong_number_of_objects() -> None:
    with pytest.raises(ValueError, match=r"^Covers takes 2 argument\(s\), not 1$"):
        COVERS(BLOCK0)


def test_predicate_refuses_wrong_type_and_says_which_argument() -> None:
    with pytest.raises(ValueError, match=r"^Holding: argument 2 is of type block, not gripper$"):
        HOLDING(BLOCK0, BLOCK1)
    with pytest.raises(ValueError, match=r"^Holding: argument 1 is of type gripper, not block$"):
        HOLDING.lifted(Variable("?r", GRIPPER), Variable("?r", GRIPPER))


def test_predicate_takes_subtypes_but_not_supertypes() -> None:
    movable = Type("movable")
    cup = Type("cup", (), movable)
    clean, full = Predicate("Clean", (movable,)), Predicate("Full", (cup,))
    assert str(clean(Object("cup0", cup))) == "Clean(cup0)"
    with pytest.raises(ValueError, match="argument 1 is of type movable, not cup"):
        full(Object("thing", movable))


def test_grounding_replaces_the_parameters_everywhere() -> None:
    step = PICK.ground((BLOCK0, ROBBY))
    assert str(step) == "Pick(block0, robby)"
    assert step.preconditions == {HAND_EMPTY()}
    assert step.add_effects == {HOLDING(BLOCK0, ROBBY)}
    assert step.delete_effects == {HAND_EMPTY()}


def test_grounding_checks_number_and_types() -> None:
    with pytest.raises(ValueError, match=r"^Pick takes 2 objects, not 1$"):
        PICK.ground((BLOCK0,))
    with pytest.raises(ValueError, match=r"^Pick: block1 is no gripper$"):
        PICK.ground((BLOCK0, BLOCK1))


def test_grounding_takes_a_subtype_and_refuses_a_supertype() -> None:
    small = Type("small-block", (), BLOCK)
    grip = Operator("Grip", (Variable("?b", small),), frozenset(), frozenset(), frozenset())
    assert PICK.ground((Object("pebble", small), ROBBY)).objects[0].name == "pebble"
    with pytest.raises(ValueError, match=r"^Grip: block0 is no small-block$"):
        grip.ground((BLOCK0,))


def test_grounding_keeps_constants_and_allows_one_object_twice() -> None:
    on = Predicate("On", (BLOCK, BLOCK))
    below, above = Variable("?below", BLOCK), Variable("?above", BLOCK)
    stack = Operator(
        "Stack",
        (below, above),
        frozenset({on.lifted(below, BLOCK1)}),
        frozenset({on.lifted(below, above)}),
        frozenset(),
    )
    step = stack.ground((BLOCK0, BLOCK0))
    assert step.preconditions == {on(BLOCK0, BLOCK1)}
    assert step.add_effects == {on(BLOCK0, BLOCK0)}


def test_atom_both_deleted_and_added_holds() -> None:
    swap = Operator(
        "Swap", (), frozenset(), frozenset({HAND_EMPTY.lifted()}), frozenset({HAND_EMPTY.lifted()})
    ).ground(())
    assert swap.apply(frozenset()) == {HAND_EMPTY()}
    assert swap.apply(frozenset({HAND_EMPTY()})) == {HAND_EMPTY()}


def test_apply_deletes_adds_and_leaves_the_rest() -> None:
    other = COVERS(BLOCK1, Object("target0", TARGET))
    after = PICK.ground((BLOCK0, ROBBY)).apply(frozenset({HAND_EMPTY(), other}))
    assert after == {HOLDING(BLOCK0, ROBBY), other}


def test_applicable_needs_what_is_required_and_not_what_is_forbidden() -> None:
    wait = Operator(
        "Wait",
        (),
        frozenset(),
        frozenset(),
        frozenset(),
        negative_preconditions=frozenset({HAND_EMPTY.lifted()}),
    ).ground(())
    pick = PICK.ground((BLOCK0, ROBBY))
    assert pick.applicable(frozenset({HAND_EMPTY()}))
    assert not pick.applicable(frozenset())
    assert wait.applicable(frozenset())
    assert not wait.applicable(frozenset({HAND_EMPTY()}))


def test_ground_operators_are_equal_by_operator_and_objects() -> None:
    assert PICK.ground((BLOCK0, ROBBY)) == PICK.ground((BLOCK0, ROBBY))
    assert PICK.ground((BLOCK0, ROBBY)) != PICK.ground((BLOCK1, ROBBY))


def test_problem_needs_its_goal_and_not_its_negative_goal() -> None:
    problem = Problem("p", (), frozenset(), frozenset({HOLDING(BLOCK0, ROBBY)}), frozenset({HAND_EMPTY()}))
    assert problem.satisfied(frozenset({HOLDING(BLOCK0, ROBBY)}))
    assert not problem.satisfied(frozenset({HOLDING(BLOCK0, ROBBY), HAND_EMPTY()}))
    assert not problem.satisfied(frozenset())


def test_values_survive_pickling() -> None:
    step = PICK.ground((BLOCK0, ROBBY))
    copy = pickle.loads(pickle.dumps(step))
    assert copy == step
    assert hash(copy) == hash(step)
    assert copy.preconditions == step.preconditions


@pytest.mark.parametrize("seed", ["1", "2"])
def test_an_operator_from_another_process_is_found_here(seed: str) -> None:
    """Its hash is that of this process, whatever PYTHONHASHSEED was where it was pickled."""
    there = (
        "import pickle, sys; from tests.symbolic.test_structs import BLOCK0, PICK, ROBBY; "
        "sys.stdout.buffer.write(pickle.dumps(PICK.ground((BLOCK0, ROBBY))))"
    )
    environment = os.environ | {"PYTHONHASHSEED": seed}
    sent = subprocess.run([sys.executable, "-c", there], env=environment, cwd=ROOT, capture_output=True)
    assert pickle.loads(sent.stdout) in {PICK.ground((BLOCK0, ROBBY))}


def test_orders_are_by_name() -> None:
    objects = (ROBBY, BLOCK1, BLOCK0)
    assert [o.name for o in canonical_order(objects)] == ["block0", "block1", "robby"]
    atoms = {HOLDING(BLOCK1, ROBBY), HAND_EMPTY(), HOLDING(BLOCK0, ROBBY)}
    assert list(map(str, sort_atoms(atoms))) == [
        "HandEmpty()",
        "Holding(block0, robby)",
        "Holding(block1, robby)",
    ]
