import gzip
import json
import re
from collections.abc import Iterable
from itertools import pairwise
from math import cos, hypot, pi, sin, sqrt, tanh
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import affinity

import envs
import envs._doors_tasks
from envs._doors_world import (
    DOOR,
    DOOR_IN_ROOM,
    DOOR_IS_OPEN,
    DOORS_SHARE_ROOM,
    IN_DOORWAY,
    IN_MAIN_ROOM,
    IN_ROOM,
    OBSTACLE,
    ROBOT,
    ROOM,
    TOUCHING_DOOR,
    opening_rotation,
    simulate,
)
from envs._shapes2d import Rectangle, segments_cross
from envs.doors import ENVIRONMENT, MOVE_THROUGH_DOOR, MOVE_TO_DOOR, MoveToDoor, _motion
from symbolic import planners
from symbolic.bilevel import Plan, solve
from symbolic.environment import abstract, sample_tasks
from symbolic.errors import InputError
from symbolic.execution import execute
from symbolic.skills import GivenSkill, GroundSkill, Label, Rollout, SkillFailure
from symbolic.state import State, Task
from symbolic.structs import GroundAtom, Object, Predicate
from tests.envs._operators import assert_operator

ROBBY, BLOCK = Object("robby", ROBOT), Object("block", OBSTACLE)
WEST, EAST, SOUTH = Object("room-0-0", ROOM), Object("room-0-1", ROOM), Object("room-1-0", ROOM)
UPRIGHT, FLAT = Object("left-door-0-1", DOOR), Object("bottom-door-0-0", DOOR)  # as on the map
SKILLS = {skill.operator.name: skill for skill in ENVIRONMENT.oracle_skills}
HANDLE = (0.49, 0.3, 0.8, 0.6)  # mass, friction, rotation, target
OPENS_AT = tanh(0.6) * (sin(0.49) + cos(0.3) * sqrt(0.49))
AT_UPRIGHT = (0.9, 1.5)  # in its doorway, far from it
NOTHING = np.zeros(0, np.float32)


@pytest.fixture(scope="module")
def recording(shared: Path) -> Any:
    return json.loads(gzip.decompress((shared / "reference" / "doors.json.gz").read_bytes()))


def upright(x: float = 1.005, y: float = 1.38, is_open: float = 0.0, mass: float = 0.49) -> tuple[float, ...]:
    return (x, y, pi / 2, mass, *HANDLE[1:], is_open)


def flat(is_open: float = 0.0) -> tuple[float, ...]:
    return (0.38, 0.995, 0.0, *HANDLE, is_open)


def world(*robot: float, more: dict[Object, tuple[float, ...]] | None = None, **doors: float) -> State:
    """Rooms west (0, 1), east (1, 1) and south (0, 0); doors between west and each other one; a far block."""
    return State.of(
        {
            ROBBY: robot,
            WEST: (0, 1),
            EAST: (1, 1),
            SOUTH: (0, 0),
            UPRIGHT: upright(is_open=doors.get("upright", 0.0)),
            FLAT: flat(is_open=doors.get("flat", 0.0)),
            BLOCK: (1.5, 1.8, 0.1, 0.1, 0),
            **(more or {}),
        }
    )


def step(state: State, dx: float, dy: float, rotation: float = 0.0) -> State:
    return simulate(state, np.array([dx, dy, rotation], np.float64))


def true(state: State, predicate: Predicate) -> set[tuple[Object, ...]]:
    return {atom.objects for atom in abstract(ENVIRONMENT, state, {predicate})}


# --------------------------------------------------------------------------------------- recording


def ours(name: str) -> str:
    """Return a recorded name without the authors' running number."""
    return re.sub(r"^(room|wall|bottom-door|left-door)\d+-", r"\1-", name)


def check_recorded(task: Task, recorded: Any) -> None:
    assert {n: list(v) for n, v in task.init.features.items()} == {
        ours(n): v for n, v in recorded["init"].items()
    }
    assert {(a.predicate.name, *(o.name for o in a.objects)) for a in task.goal} == {
        (name, *map(ours, objects)) for name, *objects in recorded["goal"]
    }


def test_the_first_evaluation_tasks_are_those_recorded_with_seed_0(recording: Any) -> None:
    for task, recorded in zip(sample_tasks(ENVIRONMENT, "test", 4, 0), recording["test_tasks"], strict=False):
        check_recorded(task, recorded)


def meet_by_edges(one: Rectangle, two: Rectangle) -> bool:
    """As the recorded tasks were drawn, up to test task 11: where no edges cross, one may be in the other."""
    (x1, y1), (x2, y2) = one.center(), two.center()
    first, second = one.vertices(), two.vertices()
    return hypot(x1 - x2, y1 - y2) < one.reach() + two.reach() and any(
        segments_cross(first[i - 1], first[i], second[j - 1], second[j]) for i in range(4) for j in range(4)
    )


@pytest.mark.parametrize(("split", "count"), [("train", 20), ("test", 11)])
def test_tasks_are_those_recorded_once_obstacles_may_lie_within_others(
    recording: Any, split: Any, count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(envs._doors_tasks, "rectangles_meet", meet_by_edges)
    tasks = sample_tasks(ENVIRONMENT, split, count, 0)
    for task, recorded in zip(tasks, recording[f"{split}_tasks"], strict=False):
        check_recorded(task, recorded)


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


# -------------------------------------------------------------------------------------------- tasks


def names_of(task: Task, kind: str) -> list[str]:
    """Names of objects that are a kind and a cell, such as room-0-1."""
    return [n for n in task.init.features if re.fullmatch(rf"{kind}-\d+-\d+", n)]


def cells_of(names: Iterable[str]) -> set[tuple[int, int]]:
    found = (name.split("-")[-2:] for name in names)
    return {(int(row), int(column)) for row, column in found}


def neighbours(cell: tuple[int, int]) -> set[tuple[int, int]]:
    row, column = cell
    return {(row - 1, column), (row + 1, column), (row, column - 1), (row, column + 1)}


def polygon(shape: tuple[float, ...]) -> shapely.Polygon:
    x, y, width, height, theta = shape
    upright = shapely.box(x, y, x + width, y + height)
    return affinity.rotate(upright, theta, origin=(x, y), use_radians=True)


def check_map(task: Task, rows: int, columns: int, most: int, least: int) -> None:
    cells = cells_of(names_of(task, "room"))
    assert least <= len(cells) <= most + 3
    assert all(0 <= row < rows and 0 <= column < columns for row, column in cells)
    for row, column in cells:
        room = task.init.features[f"room-{row}-{column}"]
        assert room == (column, rows - 1 - row)
    reached, queue = set(), [min(cells)]
    while queue:
        cell = queue.pop()
        reached.add(cell)
        queue += neighbours(cell) & cells - reached
    assert reached == cells
    assert cells_of(names_of(task, "bottom-door")) == {(r, c) for r, c in cells if (r + 1, c) in cells}
    assert cells_of(names_of(task, "left-door")) == {(r, c) for r, c in cells if (r, c - 1) in cells}


def check_walls(task: Task) -> None:
    """Every side of a room is closed, but for a gap of 0.25 in the middle where there is a neighbour."""
    cells = cells_of(names_of(task, "room"))
    walls = shapely.union_all(
        [polygon(values) for name, values in task.init.features.items() if name.startswith("wall-")]
    )
    for row, column in cells:
        x, y = task.init.features[f"room-{row}-{column}"]
        sides = {
            (row - 1, column): ((x, y + 1), (x + 1, y + 1)),
            (row + 1, column): ((x, y), (x + 1, y)),
            (row, column - 1): ((x, y), (x, y + 1)),
            (row, column + 1): ((x + 1, y), (x + 1, y + 1)),
        }
        for cell, ends in sides.items():
            side = shapely.LineString(ends)
            gap = side.difference(walls)
            assert gap.length == pytest.approx(0.25 if cell in cells else 0.0)
            if cell in cells:
                assert gap.centroid.distance(side.centroid) == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("split", ["train", "test"])
def test_maps_hang_together_and_have_doors_between_neighbours(split: Any) -> None:
    for task in sample_tasks(ENVIRONMENT, split, 8, 3):
        check_map(task, 5, 5, 18, 6)
        check_walls(task)


def test_doors_join_two_rooms_and_start_closed() -> None:
    for task in sample_tasks(ENVIRONMENT, "train", 10, 4):
        state = task.init
        rooms_of: dict[Object, int] = dict.fromkeys(state.by_type["door"], 0)
        doors_of: dict[Object, int] = dict.fromkeys(state.by_type["room"], 0)
        for door, room in true(state, DOOR_IN_ROOM):
            rooms_of[door] += 1
            doors_of[room] += 1
        assert set(rooms_of.values()) == {2}
        assert set(doors_of.values()) <= {1, 2, 3, 4}
        for door in rooms_of:
            assert all(0 <= v <= 1 for v in state[door][3:])
            assert abs(state[door][5] - state[door][6]) > 0.01
            assert state[door][7] == 0.0


def test_the_start_is_free_and_the_goal_is_elsewhere() -> None:
    for task in sample_tasks(ENVIRONMENT, "test", 20, 5):
        state = task.init
        robot = shapely.Point(state[ROBBY])
        doors = [
            (x, y, 0.25, 0.01, theta) for x, y, theta, *_ in map(state.__getitem__, state.by_type["door"])
        ]
        shapes = doors + [state[o] for o in state.by_type["obstacle"]]
        assert min(robot.distance(polygon(shape)) for shape in shapes) > 0.05 - 1e-6
        (goal,) = task.goal
        assert goal.predicate == IN_ROOM
        assert goal.objects[0] == ROBBY
        assert goal not in abstract(ENVIRONMENT, state)
        start = [(x, y) for x, y in map(state.__getitem__, state.by_type["room"]) if 0 <= robot.x - x <= 1]
        assert any(abs(robot.x - x - 0.5) <= 0.1 and abs(robot.y - y - 0.5) <= 0.1 for x, y in start)


def test_obstacles_stand_apart_in_the_middle_of_their_rooms() -> None:
    counts = set()
    for task in sample_tasks(ENVIRONMENT, "train", 10, 6):
        for room in task.init.by_type["room"]:
            x, y = task.init[room]
            found = [v for n, v in task.init.features.items() if n.startswith(f"{room.name}-obstacle-")]
            counts.add(len(found))
            assert all(abs(o[0] - x - 0.5) <= 0.1 and abs(o[1] - y - 0.5) <= 0.1 for o in found)
            assert all(0.05 <= side <= 0.15 for o in found for side in o[2:4])
            assert all(-pi <= o[4] <= pi for o in found)
            shapes = [polygon(o) for o in found]
            overlaps = (a.intersection(b).area for i, a in enumerate(shapes) for b in shapes[:i])
            assert not any(area > 1e-9 for area in overlaps)
    assert counts == {0, 1, 2, 3}


def test_bigger_maps_and_other_shares() -> None:
    big = envs.load("doors:rows=10:columns=10")
    for task in sample_tasks(big, "test", 3, 0):
        check_map(task, 10, 10, 75, 25)
    narrow = envs.load("doors:rows=2:columns=8:room_share=0.5,0.5:obstacles=0,0")
    for task in sample_tasks(narrow, "train", 5, 0):
        check_map(task, 2, 8, 8, 8)
        assert not [n for n in task.init.features if "obstacle" in n]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ("rows=1:columns=1", "must be two rooms"),
        ("rows=2:columns=2", "must be two rooms"),
        ("room_share=0.7,0.5", "room_share is two numbers"),
        ("room_share=0.5,1.5", "room_share is two numbers"),
        ("room_share=0.5", "room_share is two numbers"),
        ("rows=-5:columns=-5", "rows and columns are numbers above 0"),
        ("rows=3:rows=4", "rows is given twice"),
        ("obstacles=0,20", "obstacles is two numbers"),
        ("obstacles=3", "obstacles is two numbers"),
        ("obstacles=2,1", "obstacles is two numbers"),
        ("obstacles=-1,1", "obstacles is two numbers"),
        ("colour=red", r"no option 'colour' \(have: rows, columns, room_share, obstacles\)"),
        ("rows=many", "cannot read 'many' as rows"),
        ("rows=2.5", "cannot read '2.5' as rows"),
        ("obstacles=0;3", "cannot read '0;3' as obstacles"),
    ],
)
def test_bad_options_are_one_clear_message(options: str, message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        envs.load(f"doors:{options}")
    assert "\n" not in str(caught.value)


# ------------------------------------------------------------------------------------ given skills


def run(given: GivenSkill, state: State, door: Object) -> list[State]:
    """Run a given skill until it says that it is done; return all states."""
    controller = given.policy.begin(state, (ROBBY, door), NOTHING)
    states = [state]
    while (action := controller(states[-1])) is not None:
        assert action.dtype == np.float32
        assert action[2] == 0
        assert len(states) < 500
        states.append(ENVIRONMENT.simulate(states[-1], action))
    return states


def collided(states: list[State]) -> bool:
    return any(a[ROBBY] == b[ROBBY] for a, b in pairwise(states))


@pytest.mark.parametrize("door", [UPRIGHT, FLAT])
@pytest.mark.parametrize("x", [0.3, 0.7])
def test_moving_to_a_door_ends_as_soon_as_it_is_touched(door: Object, x: float) -> None:
    in_the_way = {BLOCK: (0.35, 1.45, 0.15, 0.15, 0.3)}
    states = run(MOVE_TO_DOOR, world(x, 1.75, more=in_the_way), door)
    assert (ROBBY, door) in true(states[-1], TOUCHING_DOOR)
    assert not any((ROBBY, door) in true(state, IN_DOORWAY) for state in states[:-1])
    assert not collided(states)
    assert true(states[-1], IN_ROOM) == {(ROBBY, WEST)}


def test_moving_to_a_door_from_the_other_side_and_from_another_door() -> None:
    states = run(MOVE_TO_DOOR, world(1.3, 1.3), UPRIGHT)
    assert true(states[-1], IN_ROOM) == {(ROBBY, EAST)}
    assert true(states[-1], IN_DOORWAY) == {(ROBBY, UPRIGHT)}
    states = run(MOVE_TO_DOOR, world(0.5, 1.1, flat=1.0), UPRIGHT)
    assert true(states[-1], IN_DOORWAY) == {(ROBBY, UPRIGHT)}


def test_moving_to_doors_in_sampled_rooms_meets_no_obstacle() -> None:
    runs = 0
    for task in sample_tasks(ENVIRONMENT, "test", 5, 8):
        ((_, room),) = true(task.init, IN_ROOM)
        for door, other in true(task.init, DOOR_IN_ROOM):
            if other == room:
                states = run(MOVE_TO_DOOR, task.init, door)
                assert true(states[-1], TOUCHING_DOOR) == {(ROBBY, door)}
                assert not collided(states)
                runs += 1
    assert runs >= 5


def test_the_same_state_and_seed_give_the_same_motion() -> None:
    state = world(0.3, 1.75, more={BLOCK: (0.4, 1.4, 0.3, 0.3, 0.5)})
    paths = []
    for seed in (0, 0, 1):
        _motion.cache_clear()
        given = GivenSkill("MoveToDoor", (ROBOT, DOOR), MoveToDoor(seed))
        paths.append([s[ROBBY] for s in run(given, state, FLAT)])
    assert paths[0] == paths[1] != paths[2]


def test_moving_to_a_door_at_which_the_robot_is_takes_no_action() -> None:
    assert len(run(MOVE_TO_DOOR, world(*AT_UPRIGHT), UPRIGHT)) == 1


def test_moving_to_a_door_of_another_room_fails() -> None:
    with pytest.raises(SkillFailure, match="in no room of the door"):
        run(MOVE_TO_DOOR, world(1.5, 1.5), FLAT)


def test_moving_to_a_door_that_cannot_be_reached_fails() -> None:
    bar = {BLOCK: (0.0, 1.3, 1.0, 0.05, 0.0)}
    with pytest.raises(SkillFailure, match="no motion plan"):
        run(MOVE_TO_DOOR, world(0.5, 1.7, more=bar), FLAT)
    run(MOVE_TO_DOOR, world(0.5, 1.7, more=bar), UPRIGHT)


@pytest.mark.parametrize(
    ("door", "start", "end"),
    [
        (UPRIGHT, (0.9, 1.45), EAST),
        (UPRIGHT, (1.1, 1.55), WEST),
        (FLAT, (0.45, 1.1), SOUTH),
        (FLAT, (0.6, 0.9), WEST),
    ],
)
def test_moving_through_a_door_ends_in_the_other_room(
    door: Object, start: tuple[float, float], end: Object
) -> None:
    states = run(MOVE_THROUGH_DOOR, world(*start, upright=1.0, flat=1.0), door)
    assert true(states[-1], IN_ROOM) == {(ROBBY, end)}
    assert not any((ROBBY, end) in true(state, IN_ROOM) for state in states[:-1])
    assert all((ROBBY, door) in true(state, IN_DOORWAY) for state in states)
    lengths = [hypot(b[ROBBY][0] - a[ROBBY][0], b[ROBBY][1] - a[ROBBY][1]) for a, b in pairwise(states)]
    assert lengths == pytest.approx([0.05] * len(lengths), abs=1e-6)


def test_moving_through_a_door_aims_at_its_middle() -> None:
    after = run(MOVE_THROUGH_DOOR, world(0.9, 1.45, upright=1.0), UPRIGHT)[1]
    dx, dy = 1.056 - 0.9, 1.505 - 1.45  # the far end of the doorway; a door is 0.25 wide
    moved = after[ROBBY][0] - 0.9, after[ROBBY][1] - 1.45
    assert moved == pytest.approx((0.05 * dx / hypot(dx, dy), 0.05 * dy / hypot(dx, dy)), abs=1e-6)


@pytest.mark.parametrize(
    "state",
    [
        world(*AT_UPRIGHT),  # closed
        world(*AT_UPRIGHT, flat=1.0),  # another one is open
        world(0.5, 1.5, upright=1.0),  # not there
    ],
)
def test_moving_through_a_door_needs_an_open_one_here(state: State) -> None:
    with pytest.raises(SkillFailure, match="not at an open door"):
        run(MOVE_THROUGH_DOOR, state, UPRIGHT)


def test_skills_that_are_given_label_what_they_do() -> None:
    objects = {"MoveToDoorFromMainRoom": (ROBBY, WEST, UPRIGHT), "OpenDoor": (UPRIGHT, ROBBY)}
    objects |= {"MoveToDoorFromDoorWay": (ROBBY, FLAT, UPRIGHT)}
    objects |= {"MoveThroughDoor": (ROBBY, WEST, UPRIGHT, EAST)}
    labels = {
        name: GroundSkill(SKILLS[name], SKILLS[name].operator.ground(them)).label
        for name, them in objects.items()
    }
    assert labels == {
        "MoveToDoorFromMainRoom": Label("MoveToDoor", (ROBBY, UPRIGHT)),
        "MoveToDoorFromDoorWay": Label("MoveToDoor", (ROBBY, UPRIGHT)),
        "MoveThroughDoor": Label("MoveThroughDoor", (ROBBY, UPRIGHT)),
        "OpenDoor": None,
    }


# ------------------------------------------------------------------------------------------- oracle

OPERATORS = """
MoveToDoorFromMainRoom r,m,d: InRoom(r,m) InMainRoom(r,m) DoorInRoom(d,m) -> TouchingDoor(r,d) \
InDoorway(r,d) / InMainRoom(r,m) : MoveToDoor(r,d)
MoveToDoorFromDoorWay r,d,e: InDoorway(r,d) DoorsShareRoom(d,e) -> TouchingDoor(r,e) InDoorway(r,e) / \
InDoorway(r,d) : MoveToDoor(r,e)
OpenDoor d,r: TouchingDoor(r,d) InDoorway(r,d) -> DoorIsOpen(d) / TouchingDoor(r,d) :
MoveThroughDoor r,m,d,n: InRoom(r,m) InDoorway(r,d) DoorIsOpen(d) DoorInRoom(d,m) DoorInRoom(d,n) -> \
InRoom(r,n) / InRoom(r,m) : MoveThroughDoor(r,d)
"""


def test_operators_are_those_of_the_specification() -> None:
    short = {"?robot": "r", "?room": "m", "?room2": "n", "?door": "d", "?door2": "e"}
    lines = OPERATORS.strip().split("\n")
    for skill, line in zip(ENVIRONMENT.oracle_skills, lines, strict=True):
        operator = skill.operator
        head, conditions, add, delete, given = (
            part.strip() for part in re.split(r": | -> | / | :", line, maxsplit=4)
        )
        assert_operator(operator, short, head, conditions, add, delete)
        letters = tuple(Object(short[v.name], v.type) for v in operator.parameters)
        label = GroundSkill(skill, operator.ground(letters)).label
        assert (f"{label.skill}({','.join(o.name for o in label.objects)})" if label else "") == given
        assert skill.sampler.dimension == (2 if operator.name == "OpenDoor" else 0)


def test_the_oracle_opens_a_door_in_one_step() -> None:
    skill, state = SKILLS["OpenDoor"], world(*AT_UPRIGHT)
    subgoal = skill.sampler.sample(state, (UPRIGHT, ROBBY), np.random.default_rng(0))
    assert subgoal == pytest.approx([OPENS_AT - HANDLE[2], 1.0])
    rollout = GroundSkill(skill, skill.operator.ground((UPRIGHT, ROBBY))).roll_out(
        ENVIRONMENT, state, subgoal, 100
    )
    assert isinstance(rollout, Rollout)
    assert len(rollout.trajectory.actions) == 1
    assert true(rollout.trajectory.states[-1], DOOR_IS_OPEN) == {(UPRIGHT,)}


@pytest.mark.parametrize("split", ["train", "test"])
def test_the_oracle_solves_tasks(split: Any) -> None:
    for task in sample_tasks(ENVIRONMENT, split, 4, 7):
        plan = solve(ENVIRONMENT, task, SKILLS, planners.load("astar"), ENVIRONMENT.budget, seed=0)
        assert isinstance(plan, Plan)
        execution = execute(ENVIRONMENT, task, plan)
        assert execution.success
        final: frozenset[GroundAtom] = abstract(ENVIRONMENT, execution.trajectory.states[-1])
        assert task.goal <= final


# ------------------------------------------------------------------------------------------ drawing


def test_drawing_shows_doors_robot_and_caption() -> None:
    start = ENVIRONMENT.draw(world(0.5, 1.5))
    assert start.tobytes() == ENVIRONMENT.draw(world(0.5, 1.5)).tobytes()
    for changed in (world(0.5, 1.5, flat=1.0), world(0.3, 1.5), world(1.5, 1.5)):
        assert ENVIRONMENT.draw(changed).tobytes() != start.tobytes()
    assert ENVIRONMENT.draw(world(0.5, 1.5), "caption").tobytes() != start.tobytes()
