"""Context objects: parameters that no effect names, but that a contact ties to those of the effects."""

import numpy as np

from bpns.envs.stick_button import ENVIRONMENT as STICK_BUTTON
from bpns.learning.data.demonstrations import collect
from bpns.learning.data.segmentation import Segment, segment
from bpns.learning.networks.policies import changing_features, policy_examples
from bpns.learning.operators.learn import OperatorData, learn_operators
from bpns.symbolic.state import State, Trajectory
from bpns.symbolic.structs import GroundAtom, Object, Predicate, Type

HAND, TOOL, NAIL = Type("hand", ("x",)), Type("tool", ("x",)), Type("nail", ("x",))
LEFT, RIGHT = Object("left", HAND), Object("right", HAND)
HAMMER, STONE = Object("hammer", TOOL), Object("stone", TOOL)
FIRST, SECOND = Object("first", NAIL), Object("second", NAIL)
HOLDS, NEAR = Predicate("Holds", (HAND, TOOL)), Predicate("Near", (HAND, NAIL))
HIT = Predicate("Hit", (TOOL, NAIL))
CONTACTS = frozenset({HOLDS, HIT})
OBJECTS = (LEFT, RIGHT, HAMMER, STONE, FIRST, SECOND)


def hit(tool: Object, nail: Object, *before: GroundAtom) -> Segment:
    """A step of all objects to the right, after which the tool has hit the nail."""
    states = (State.of(dict.fromkeys(OBJECTS, (0.0,))), State.of(dict.fromkeys(OBJECTS, (1.0,))))
    init = frozenset(before)
    return Segment(Trajectory(states, (np.zeros(1, np.float32),)), init, init | {HIT(tool, nail)})


def parameters(operator: OperatorData) -> list[str]:
    return [str(v) for v in operator.operator.parameters]


def preconditions(operator: OperatorData) -> set[str]:
    return {str(a) for a in operator.operator.preconditions}


def test_who_holds_the_tool_is_a_parameter() -> None:
    segments = [hit(HAMMER, FIRST, HOLDS(LEFT, HAMMER)), hit(STONE, SECOND, HOLDS(RIGHT, STONE))]
    (plain,) = learn_operators(segments)
    assert parameters(plain) == ["?x0:nail", "?x1:tool"]
    assert preconditions(plain) == set()
    (operator,) = learn_operators(segments, contacts=CONTACTS)
    assert parameters(operator) == ["?x0:nail", "?x1:tool", "?x2:hand"]
    assert preconditions(operator) == {"Holds(?x2:hand, ?x1:tool)"}
    assert operator.context == 1
    assert [m.objects for m in operator.members] == [(FIRST, HAMMER, LEFT), (SECOND, STONE, RIGHT)]
    assert operator.operator.add_effects == plain.operator.add_effects


def test_subgoals_are_about_the_effects_objects_only() -> None:
    (operator,) = learn_operators([hit(HAMMER, FIRST, HOLDS(LEFT, HAMMER))], contacts=CONTACTS)
    changing = changing_features(operator)
    assert changing == ((0, 0), (1, 0))
    inputs, _ = policy_examples(operator, changing)
    assert inputs.shape == (1, 1 + 3 + 2)  # but policies see where the hand is


def test_an_object_must_be_unique_in_every_segment() -> None:
    held = hit(HAMMER, FIRST, HOLDS(LEFT, HAMMER))
    for other in (
        hit(HAMMER, SECOND),  # nobody holds it
        hit(HAMMER, SECOND, HOLDS(LEFT, HAMMER), HOLDS(RIGHT, HAMMER)),  # both do
        hit(HAMMER, SECOND, HOLDS(LEFT, STONE)),  # another tool is held
    ):
        (operator,) = learn_operators([held, other], contacts=CONTACTS)
        assert parameters(operator) == ["?x0:nail", "?x1:tool"]
        assert operator.context == 0


def test_only_contacts_tie() -> None:
    segments = [hit(HAMMER, FIRST, NEAR(LEFT, FIRST)), hit(STONE, SECOND, NEAR(RIGHT, SECOND))]
    (operator,) = learn_operators(segments, contacts=CONTACTS)
    assert operator.context == 0


def test_one_object_that_several_atoms_tie_comes_once() -> None:
    grips = Predicate("Grips", (TOOL, HAND))
    segments = [
        hit(HAMMER, FIRST, HOLDS(LEFT, HAMMER), grips(HAMMER, LEFT)),
        hit(STONE, SECOND, HOLDS(RIGHT, STONE), grips(STONE, RIGHT)),
    ]
    (operator,) = learn_operators(segments, contacts=CONTACTS | {grips})
    assert parameters(operator) == ["?x0:nail", "?x1:tool", "?x2:hand"]
    assert preconditions(operator) == {"Grips(?x1:tool, ?x2:hand)", "Holds(?x2:hand, ?x1:tool)"}


def test_pressing_with_the_stick_takes_the_hand_that_holds_it() -> None:
    data = collect(STICK_BUTTON, 12, seed=50_200)
    segments = [s for d in data.demonstrations for s in segment(STICK_BUTTON, d.trajectory, d.labels)]
    found = learn_operators(segments, contacts=STICK_BUTTON.contact_predicates)
    pressing = [o for o in found if "StickAboveButton" in {a.predicate.name for a in o.operator.add_effects}]
    assert pressing
    for operator in pressing:
        assert "Grasped" in {a.predicate.name for a in operator.operator.preconditions}
        assert operator.operator.parameters[-1].type.name == "gripper"


def test_context_objects_are_different_ones_in_every_segment() -> None:
    """Whoever holds the tool also guards the nail in one segment, and in the other does not."""
    guards = Predicate("Guards", (HAND, NAIL))
    one = hit(HAMMER, FIRST, HOLDS(LEFT, HAMMER), guards(LEFT, FIRST))
    two = hit(HAMMER, FIRST, HOLDS(LEFT, HAMMER), guards(RIGHT, FIRST))
    for segments in ([one, two], [two, one]):
        (operator,) = learn_operators(segments, contacts=CONTACTS | {guards})
        assert parameters(operator) == ["?x0:nail", "?x1:tool", "?x2:hand"]
        assert len(preconditions(operator)) == 1
