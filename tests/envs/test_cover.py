import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bpns.envs.cover import ENVIRONMENT, Cover
from bpns.envs.cover.world import BLOCK, COVERS, GRIPPER, HAND_EMPTY, IS_HOLDING, TARGET, simulate
from bpns.symbolic.skills.environment import abstract, sample_tasks
from bpns.symbolic.state import State
from bpns.symbolic.structs import Object

BLOCK0, BLOCK1 = Object("block0", BLOCK), Object("block1", BLOCK)
ROBBY = Object("robby", GRIPPER)
TARGET0 = Object("target0", TARGET)


def world(**changes: tuple[float, ...]) -> State:
    """A task with block0 at 0.3, its region the middle; block1 at 0.8; target0 at 0.5."""
    state = sample_tasks(ENVIRONMENT, "train", 1, 0)[0].init
    fixed: dict[str, tuple[float, ...]] = {
        "block0": (0.1, 0.1, 0.3, 0.1, -1.0),
        "block0-region": (-0.02, 0.02),
        "block1": (0.1, 0.07, 0.8, 0.1, -1.0),
        "block1-region": (-0.014, 0.014),
        "target0": (0.05, 0.5),
        "target0-region": (0.49, 0.51),
        "target1": (0.03, 0.95),
        "target1-region": (0.944, 0.956),
    }
    return state.changed({**fixed, **changes})


def step(state: State, dx: float, dy: float, grip: float) -> State:
    return simulate(state, np.array([dx, dy, grip], np.float32))


HELD = {"block0": (0.1, 0.1, 0.3, 0.4, 1.0), "robby": (0.3, 0.4, 1.0, 1.0)}


def test_grasp_needs_the_hand_region() -> None:
    above = world(robby=(0.31, 0.4, 1.0, -1.0))
    assert step(above, 0, -0.299, 1)[BLOCK0][4] == 1
    outside = world(robby=(0.33, 0.4, 1.0, -1.0))
    after = step(outside, 0, -0.299, 1)
    assert after[BLOCK0][4] == -1
    assert after[ROBBY][1] == pytest.approx(0.1)  # ends on top of the block without grasping


def test_grasp_needs_a_closed_grip() -> None:
    assert step(world(robby=(0.3, 0.4, 1.0, -1.0)), 0, -0.299, -1)[ROBBY][3] == -1


def test_placement_over_a_target_needs_its_hand_region() -> None:
    over = world(block0=(0.1, 0.1, 0.5, 0.4, 1.0), robby=(0.52, 0.4, 1.0, 1.0))
    assert step(over, 0, -0.299, -1) is over  # a no-op: even the motion is undone
    inside = world(block0=(0.1, 0.1, 0.5, 0.4, 1.0), robby=(0.5, 0.4, 1.0, 1.0))
    assert COVERS(BLOCK0, TARGET0) in abstract(ENVIRONMENT, step(inside, 0, -0.299, -1))


def test_placement_that_covers_nothing_is_allowed_anywhere() -> None:
    after = step(world(**HELD), 0, -0.299, -1)
    assert HAND_EMPTY() in abstract(ENVIRONMENT, after)
    assert after[BLOCK0][3] == 0.1


def test_collision_uses_the_unclamped_motion() -> None:
    below = {"block1": (0.1, 0.07, 0.26, 0.1, -1.0)}  # a corner of the held block comes down on it
    start = world(**HELD, **below)
    assert step(start, 0, -5.0, 1) is start  # the gripper would stop, but the sweep counts
    between = world(**HELD, block1=(0.1, 0.07, 0.3, 0.1, -1.0))  # no corner meets it, nor the far end
    assert step(between, 0, -5.0, 1)[ROBBY][1] < 0.4
    assert step(start, 0, 0.1, 1)[ROBBY][1] == 0.4  # clamped at the top, nothing above


def test_a_held_block_on_the_floor_covers() -> None:
    state = world(block0=(0.1, 0.1, 0.5, 0.1, 1.0), robby=(0.5, 0.1, 1.0, 1.0))
    atoms = abstract(ENVIRONMENT, state)
    assert {COVERS(BLOCK0, TARGET0), IS_HOLDING(BLOCK0, ROBBY)} <= atoms


@pytest.mark.parametrize("action", [[0, 0, 1.5], [0, float("nan"), 0], [0, 0]])
def test_an_action_outside_the_box_is_refused(action: list[float]) -> None:
    with pytest.raises(ValueError, match="not in the box"):
        simulate(world(), np.array(action, np.float32))


@settings(deadline=None, max_examples=50)
@given(
    st.integers(0, 20),
    st.lists(
        st.tuples(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(-1, 1)), min_size=1, max_size=20
    ),
)
def test_invariants(seed: int, actions: list[tuple[float, float, float]]) -> None:
    state = sample_tasks(ENVIRONMENT, "train", 1, seed)[0].init
    for action in actions:
        before = dict(state.features)
        following = step(state, *action)
        assert dict(state.features) == before  # simulate is pure
        state = following
        held = [
            name for name, block in state.features.items() if name in ("block0", "block1") and block[4] != -1
        ]
        assert len(held) == (state[ROBBY][3] == 1)
        assert 0.1 - 1e-12 <= state[ROBBY][1] <= 0.4 + 1e-12
        assert (HAND_EMPTY() in abstract(ENVIRONMENT, state)) == (not held)


def test_irrelevant_blocks_are_there_in_their_split_only() -> None:
    environment = Cover(test_irrelevant_blocks=3)
    train, test = (sample_tasks(environment, split, 1, 5)[0].init for split in ("train", "test"))  # type: ignore[arg-type]
    assert len(train.objects) == 9
    assert [o.name for o in test.objects if o.name.startswith("irr")] == [
        f"irrelevant-block{i}" for i in range(3)
    ]
    assert step(test, 0.1, 0, 1)[ROBBY][0] == pytest.approx(0.1)


def test_drawing_shows_what_is_held() -> None:
    free, held = ENVIRONMENT.draw(world()), ENVIRONMENT.draw(world(**HELD), "caption")
    assert free.size == held.size == (640, 635)
    assert free.tobytes() != held.tobytes()
