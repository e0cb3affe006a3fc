"""Segmentation and clustering on made-up trajectories."""

from dataclasses import replace

import numpy as np

from bpns.learning.data.segmentation import Segment, segment
from bpns.learning.operators.learn import learn_operators
from bpns.symbolic.state import State, Trajectory
from bpns.symbolic.structs import GroundAtom, Object, Predicate, Type
from tests.toy import DOOR_0, HAND_0, HAS_KEY, IS_OPEN, Toy

BLOCK, HAND = Type("block", ("x",)), Type("hand", ("x",))
ON = Predicate("On", (BLOCK, BLOCK))
HELD = Predicate("Held", (BLOCK, HAND))
FREE = Predicate("Free", ())
RED = Predicate("Red", (BLOCK,))
A, B, C = (Object(name, BLOCK) for name in "abc")
ROBOT = Object("robot", HAND)
STILL = Trajectory((State.of({A: [0]}),), ())


def made(init: set[GroundAtom], final: set[GroundAtom]) -> Segment:
    return Segment(STILL, frozenset(init), frozenset(final))


def toy_trajectory() -> Trajectory:
    environment = Toy()
    states = [State.of({HAND_0: (0, 0), DOOR_0: (0,)})]
    actions = [np.array(a, np.float32) for a in ([1, 0], [0, 0.9], [1, 0], [1, 0])]
    for action in actions:
        states.append(environment.simulate(states[-1], action))
    return Trajectory(tuple(states), tuple(actions))


def test_segments_end_where_contacts_change_and_the_tail_is_dropped() -> None:
    trajectory = toy_trajectory()
    first, second = segment(Toy(), trajectory, [None] * len(trajectory.actions))
    assert [len(s.trajectory.actions) for s in (first, second)] == [2, 1]
    assert first.trajectory.states[-1] is second.trajectory.states[0]
    assert first.add_effects == {HAS_KEY(HAND_0)}
    assert (second.add_effects, second.delete_effects) == ({IS_OPEN(DOOR_0)}, {HAS_KEY(HAND_0)})


def test_only_contact_predicates_cut() -> None:
    class Blind(Toy):
        contact_predicates = frozenset({IS_OPEN})

    trajectory = toy_trajectory()
    (only,) = segment(Blind(), trajectory, [None] * len(trajectory.actions))
    assert len(only.trajectory.actions) == 3
    assert only.add_effects == {IS_OPEN(DOOR_0)}


def test_preconditions_are_what_all_members_share() -> None:
    first = made({FREE(), RED(A), ON(A, B)}, {HELD(A, ROBOT), RED(A), ON(A, B)})
    second = made({FREE(), RED(C), RED(B)}, {HELD(C, ROBOT), RED(C), RED(B)})
    (operator,) = learn_operators([first, second])
    assert operator.operator.name == "Op0"
    assert [str(v) for v in operator.operator.parameters] == ["?x0:block", "?x1:hand"]
    assert {str(a) for a in operator.operator.preconditions} == {"Free()", "Red(?x0:block)"}
    assert [m.objects for m in operator.members] == [(A, ROBOT), (C, ROBOT)]


def test_maps_are_one_to_one() -> None:
    """On(a, b) and On(a, a) differ, whichever comes first."""
    different, same = made(set(), {ON(A, B)}), made(set(), {ON(A, A)})
    for order in ([different, same], [same, different]):
        assert len(learn_operators(order)) == 2


def test_maps_are_found_by_backtracking() -> None:
    """The first pairing of atoms in order of names is wrong here: a chain against a reversed chain."""
    chain, reversed_chain = made(set(), {ON(A, B), ON(B, C)}), made(set(), {ON(C, B), ON(B, A)})
    (operator,) = learn_operators([chain, reversed_chain])
    assert [m.objects for m in operator.members] == [(A, B, C), (C, B, A)]


def test_delete_effects_count() -> None:
    adds = made({RED(A)}, {RED(A), HELD(A, ROBOT)})
    moves = made({RED(A)}, {HELD(A, ROBOT)})
    assert [o.operator.name for o in learn_operators([adds, moves, adds])] == ["Op0", "Op1"]


def test_rare_operators_are_dropped_and_names_keep_their_number() -> None:
    rare, common = made(set(), {ON(A, A)}), made(set(), {ON(A, B)})
    found = learn_operators([rare, *[common] * 100], min_share=0.01)
    assert [o.operator.name for o in found] == ["Op1"]
    exactly = learn_operators([rare, *[common] * 99], min_share=0.01)
    assert [o.operator.name for o in exactly] == ["Op0", "Op1"]
    assert len(learn_operators([rare, *[common] * 100], min_share=0)) == 2


def test_operators_do_not_depend_on_the_order_of_atoms() -> None:
    one = made({FREE()}, {HELD(B, ROBOT), ON(A, B)})
    two = replace(one, final_atoms=frozenset(sorted(one.final_atoms, key=str, reverse=True)))
    assert learn_operators([one])[0].operator == learn_operators([two])[0].operator
