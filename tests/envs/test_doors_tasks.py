import gzip
import json
import re
from collections.abc import Iterable
from math import hypot, pi
from pathlib import Path
from typing import Any

import pytest
import shapely
from shapely import affinity

from bpns import envs
from bpns.envs.doors import ENVIRONMENT
from bpns.envs.doors import tasks as doors_tasks
from bpns.envs.doors.world import DOOR_IN_ROOM, IN_ROOM
from bpns.envs.shapes2d import Rectangle, segments_cross
from bpns.symbolic.errors import InputError
from bpns.symbolic.skills.environment import abstract, sample_tasks
from bpns.symbolic.state import Task
from bpns.symbolic.structs import Object
from tests.envs._doors_worlds import (
    ROBBY,
    true,
)


@pytest.fixture(scope="module")
def recording(data: Path) -> Any:
    return json.loads(gzip.decompress((data / "reference" / "doors.json.gz").read_bytes()))


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
    monkeypatch.setattr(doors_tasks, "rectangles_meet", meet_by_edges)
    tasks = sample_tasks(ENVIRONMENT, split, count, 0)
    for task, recorded in zip(tasks, recording[f"{split}_tasks"], strict=False):
        check_recorded(task, recorded)


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
