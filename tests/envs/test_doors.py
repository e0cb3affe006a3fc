from math import pi
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bpns.envs.doors import ENVIRONMENT
from bpns.envs.doors.world import (
    DOOR,
    DOOR_IN_ROOM,
    DOOR_IS_OPEN,
    DOORS_SHARE_ROOM,
    IN_DOORWAY,
    IN_MAIN_ROOM,
    IN_ROOM,
    TOUCHING_DOOR,
    opening_rotation,
    simulate,
)
from bpns.symbolic.skills.environment import sample_tasks
from bpns.symbolic.structs import Object
from tests.envs._doors_worlds import (
    AT_UPRIGHT,
    BLOCK,
    EAST,
    FLAT,
    OPENS_AT,
    ROBBY,
    SOUTH,
    UPRIGHT,
    WEST,
    flat,
    step,
    true,
    upright,
    world,
)

# --------------------------------------------------------------------------------------- transition


def test_the_robot_moves_where_nothing_is() -> None:
    assert step(world(0.5, 1.5), 0.05, -0.03, 0.7)[ROBBY] == (0.55, 1.47)
    assert step(world(-7.0, 9.0), -0.05, 0.05)[ROBBY] == (-7.05, 9.05)  # the world has no border


def test_components_are_widened_before_they_are_added() -> None:
    after = simulate(world(0.5, 1.5), np.array([0.03, 0.05, 0], np.float32))
    assert after[ROBBY] == (0.5 + float(np.float32(0.03)), 1.5 + float(np.float32(0.05)))


@pytest.mark.parametrize(("x", "free"), [(1.455, False), (1.4495, True)])
def test_an_obstacle_stops_the_robot_where_it_would_overlap(x: float, free: bool) -> None:
    state = world(x - 0.03, 1.85)
    assert step(state, 0.03, 0)[ROBBY] == (pytest.approx((x, 1.85)) if free else state[ROBBY])


def test_a_turned_obstacle_stops_the_robot_where_it_is_drawn() -> None:
    turned = {BLOCK: (1.5, 1.3, 0.4, 0.02, pi / 2)}  # stands upright, to the left of its corner
    beside, where_it_was = world(1.56, 1.6, more=turned), world(1.7, 1.38, more=turned)
    assert step(beside, -0.04, 0)[ROBBY] == beside[ROBBY]
    assert step(where_it_was, 0, -0.05)[ROBBY] == pytest.approx((1.7, 1.33))
    diagonal = world(1.57, 1.55, more={BLOCK: (1.5, 1.3, 0.4, 0.02, pi / 4)})
    assert step(diagonal, 0.05, 0)[ROBBY] == pytest.approx((1.62, 1.55))
    assert step(diagonal, 0.05, -0.05)[ROBBY] == diagonal[ROBBY]


def test_only_the_place_where_the_robot_would_end_counts() -> None:
    inside = world(1.55, 1.85)  # overlaps the block already
    assert step(inside, 0.05, 0)[ROBBY] == inside[ROBBY]
    thin = world(1.45, 1.5, more={BLOCK: (1.5, 1.45, 0.0001, 0.1, 0)})
    assert step(thin, 0.04, 0)[ROBBY] == thin[ROBBY]
    leaving = world(1.46, 1.5, more={BLOCK: (1.5, 1.45, 0.0001, 0.1, 0)})
    assert step(leaving, -0.02, 0)[ROBBY] == pytest.approx((1.44, 1.5))


def test_a_closed_door_stops_the_robot_and_an_open_one_does_not() -> None:
    for door, start, move in (
        ("upright", (0.94, 1.5), (0.05, 0)),
        ("upright", (1.06, 1.5), (-0.05, 0)),
        ("flat", (0.5, 0.94), (0, 0.05)),
        ("flat", (0.5, 1.06), (0, -0.05)),
    ):
        closed, opened = world(*start), world(*start, **{door: 1.0})
        assert step(closed, *move)[ROBBY] == start
        assert step(opened, *move)[ROBBY] == (start[0] + move[0], start[1] + move[1])


def test_a_touched_handle_turns_though_the_robot_collides() -> None:
    after = step(world(0.94, 1.5), 0.05, 0, 0.123)
    assert after[ROBBY] == (0.94, 1.5)
    assert after[UPRIGHT] == (*upright()[:5], 0.123, 0.6, 0.0)
    assert after[FLAT] == flat()


def test_a_door_that_opens_still_stops_the_robot_in_that_step() -> None:
    after = step(world(0.94, 1.5), 0.05, 0, OPENS_AT)
    assert after[ROBBY] == (0.94, 1.5)
    assert after[UPRIGHT][7] == 1.0
    assert step(after, 0.05, 0)[ROBBY] == (0.99, 1.5)


def test_the_place_before_the_step_decides_which_doors_are_touched() -> None:
    arriving, leaving = world(0.89, 1.5), world(0.9, 1.5)
    assert step(arriving, 0.05, 0, 0.123)[UPRIGHT] == upright()
    left = step(leaving, -0.05, 0, 0.123)
    assert left[ROBBY] == pytest.approx((0.85, 1.5))
    assert left[UPRIGHT][5] == 0.123


def test_every_touched_closed_door_is_turned() -> None:
    second, third = Object("second", DOOR), Object("third", DOOR)
    more = {second: upright(y=1.42), third: upright(y=1.44, is_open=1.0)}
    after = step(world(*AT_UPRIGHT, more=more), 0, 0, OPENS_AT)
    assert [after[door][5:] for door in (UPRIGHT, second)] == [(OPENS_AT, 0.6, 1.0)] * 2
    assert after[third] == more[third]


@pytest.mark.parametrize("away", [-1, 1])
def test_the_tolerance_of_the_handle_is_strict(away: int) -> None:
    no_mass = {UPRIGHT: upright(mass=0.0)}  # opens at 0 exactly
    state = world(*AT_UPRIGHT, more=no_mass)
    for rotation, is_open in ((0.00999, 1.0), (0.01, 0.0), (0.011, 0.0)):
        assert step(state, 0, 0, away * rotation)[UPRIGHT][5:] == (away * rotation, 0.6, is_open)


def test_the_opening_value_follows_mass_friction_and_target() -> None:
    assert opening_rotation(upright()) == pytest.approx(OPENS_AT)
    for rotation, is_open in ((OPENS_AT + 0.0099, 1.0), (OPENS_AT + 0.0101, 0.0), (0.6, 0.0)):
        assert step(world(*AT_UPRIGHT), 0, 0, rotation)[UPRIGHT][7] == is_open


def test_moving_sets_the_handle_and_can_open_a_light_door() -> None:
    assert step(world(*AT_UPRIGHT), 0.01, 0)[UPRIGHT][5:] == (0.0, 0.6, 0.0)
    light = world(*AT_UPRIGHT, more={UPRIGHT: upright(mass=1e-5)})
    assert 0 < opening_rotation(light[UPRIGHT]) < 0.01
    assert step(light, 0.01, 0)[UPRIGHT][7] == 1.0


def test_an_open_door_stays_as_it_is() -> None:
    state = world(*AT_UPRIGHT, upright=1.0)
    for rotation in (0.0, OPENS_AT, 5.0):
        assert step(state, 0, 0, rotation)[UPRIGHT] == upright(is_open=1.0)


def test_a_turned_handle_keeps_its_door_closed_elsewhere() -> None:
    assert step(world(0.5, 1.5), 0, 0, OPENS_AT)[UPRIGHT] == upright()


@pytest.mark.parametrize("action", [[0.0501, 0, 0], [0, -0.06, 0], [0, 0, float("nan")], [0, 0], [[0, 0, 0]]])
def test_an_action_outside_the_box_is_refused(action: Any) -> None:
    with pytest.raises(ValueError, match="not in the box"):
        simulate(world(0.5, 1.5), np.array(action, np.float32))


def test_bounds_belong_to_the_box() -> None:
    high = np.float32(0.05)
    after = simulate(world(0.5, 1.5), np.array([high, -high, 1e9], np.float32))
    assert after[ROBBY] == (0.5 + float(high), 1.5 - float(high))


@settings(max_examples=30)
@given(
    st.integers(0, 10),
    st.lists(
        st.tuples(st.floats(-0.05, 0.05), st.floats(-0.05, 0.05), st.floats(0, 1)),
        min_size=1,
        max_size=20,
    ),
)
def test_invariants(seed: int, actions: list[tuple[float, float, float]]) -> None:
    state = sample_tasks(ENVIRONMENT, "train", 1, seed)[0].init
    for action in actions:
        before = dict(state.features)
        touched = {door.name for _, door in true(state, TOUCHING_DOOR)}
        following = step(state, *action)
        assert dict(state.features) == before  # simulate is pure
        changed = {n for n, values in following.features.items() if values != before[n]}
        assert changed <= touched | {"robby"}
        assert {n: following.features[n][5] for n in touched} == dict.fromkeys(touched, action[2])
        assert true(state, DOOR_IS_OPEN) <= true(following, DOOR_IS_OPEN)
        assert true(following, IN_ROOM)  # closed in by walls
        state = following


# --------------------------------------------------------------------------------------- predicates


def test_a_room_holds_its_border() -> None:
    for x, rooms in ((0.999, {WEST}), (1.0, {WEST, EAST}), (1.001, {EAST}), (2.0, {EAST}), (2.001, set())):
        assert {room for _, room in true(world(x, 1.2), IN_ROOM)} == rooms
    assert {room for _, room in true(world(0.2, 1.0), IN_ROOM)} == {WEST, SOUTH}


def test_a_doorway_reaches_to_both_sides_of_a_door() -> None:
    for x, near in ((0.893, False), (0.895, True), (1.105, True), (1.107, False)):  # 0.944 and 1.056 -+ 0.05
        assert ((ROBBY, UPRIGHT) in true(world(x, 1.5), IN_DOORWAY)) == near
    for y, near in ((1.329, False), (1.331, True), (1.679, True), (1.681, False)):  # 1.38 and 1.63 -+ 0.05
        assert ((ROBBY, UPRIGHT) in true(world(0.96, y), IN_DOORWAY)) == near
    for y, near in ((0.893, False), (0.895, True), (1.105, True), (1.107, False)):
        assert ((ROBBY, FLAT) in true(world(0.5, y), IN_DOORWAY)) == near
    for x, near in ((0.329, False), (0.331, True), (0.679, True), (0.681, False)):
        assert ((ROBBY, FLAT) in true(world(x, 1.04), IN_DOORWAY)) == near


def test_the_main_room_ends_at_the_doorways_of_the_room() -> None:
    assert true(world(0.5, 1.5), IN_MAIN_ROOM) == {(ROBBY, WEST)}
    for place in (AT_UPRIGHT, (0.5, 1.1)):
        for is_open in (0.0, 1.0):
            assert not true(world(*place, upright=is_open, flat=is_open), IN_MAIN_ROOM)
    assert true(world(1.0, 1.2), IN_MAIN_ROOM) == {(ROBBY, WEST), (ROBBY, EAST)}
    of_other_rooms = world(0.95, 1.5, more={UPRIGHT: upright(x=1.03)})  # reaches into a room not its own
    assert true(of_other_rooms, IN_DOORWAY) == {(ROBBY, UPRIGHT)}
    assert true(of_other_rooms, IN_MAIN_ROOM) == {(ROBBY, WEST)}


def test_a_door_is_touched_while_it_is_closed() -> None:
    assert true(world(*AT_UPRIGHT), TOUCHING_DOOR) == {(ROBBY, UPRIGHT)}
    assert true(world(0.5, 0.9), TOUCHING_DOOR) == {(ROBBY, FLAT)}
    opened = world(*AT_UPRIGHT, upright=1.0)
    assert true(opened, TOUCHING_DOOR) == set()
    assert true(opened, IN_DOORWAY) == {(ROBBY, UPRIGHT)}


def test_a_door_is_open_above_a_half() -> None:
    for value, is_open in ((0.0, False), (0.5, False), (0.51, True), (1.0, True)):
        assert true(world(0.5, 1.5, flat=value), DOOR_IS_OPEN) == ({(FLAT,)} if is_open else set())


def test_doors_are_in_the_rooms_that_they_join() -> None:
    assert true(world(0.5, 1.5), DOOR_IN_ROOM) == {
        (UPRIGHT, WEST),
        (UPRIGHT, EAST),
        (FLAT, WEST),
        (FLAT, SOUTH),
    }


def test_different_doors_of_one_room_share_it() -> None:
    far = Object("left-door-0-2", DOOR)
    state = world(0.5, 1.5, more={far: upright(x=2.005)})  # of the east room
    assert true(state, DOORS_SHARE_ROOM) == {
        (UPRIGHT, FLAT),
        (FLAT, UPRIGHT),
        (UPRIGHT, far),
        (far, UPRIGHT),
    }


# ------------------------------------------------------------------------------------------ drawing


def test_drawing_shows_doors_robot_and_caption() -> None:
    start = ENVIRONMENT.draw(world(0.5, 1.5))
    assert start.tobytes() == ENVIRONMENT.draw(world(0.5, 1.5)).tobytes()
    for changed in (world(0.5, 1.5, flat=1.0), world(0.3, 1.5), world(1.5, 1.5)):
        assert ENVIRONMENT.draw(changed).tobytes() != start.tobytes()
    assert ENVIRONMENT.draw(world(0.5, 1.5), "caption").tobytes() != start.tobytes()
