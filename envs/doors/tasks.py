"""Tasks of Doors: maps of rooms, walls, doors and obstacles. Source: spec, doors.md section 6."""

from math import pi
from typing import TypeAlias

import numpy as np

from bpns.envs.doors.world import (
    DOOR,
    GAP,
    HANDLE_TOLERANCE,
    IN_ROOM,
    OBSTACLE,
    ROBOT,
    ROOM,
    ROOM_SIZE,
    THICKNESS,
    collides,
    room_holds,
)
from bpns.envs.shapes2d import Rectangle, rectangles_meet
from bpns.symbolic.state import Features, State, Task
from bpns.symbolic.structs import Object

Cell: TypeAlias = tuple[int, int]  # row from the top, column

OBSTACLE_SIZES = (0.05, 0.15)
OFF_CENTER = 0.1  # of obstacles and the robot's start, per axis


def _sample_cells(
    rng: np.random.Generator, rows: int, columns: int, share: tuple[float, float]
) -> frozenset[Cell]:
    """Draw which cells of the grid are rooms; all of them hang together."""
    least, most = (int(s * rows * columns) for s in share)
    wanted = int(rng.integers(least, most, endpoint=True))
    start = int(rng.integers(rows)), int(rng.integers(columns))
    cells, queue = {start}, [start]
    while len(cells) < wanted:
        row, column = queue.pop(int(rng.integers(len(queue))))
        for cell in ((row - 1, column), (row + 1, column), (row, column - 1), (row, column + 1)):
            if 0 <= cell[0] < rows and 0 <= cell[1] < columns and cell not in cells:
                cells.add(cell)
                queue.append(cell)
    return frozenset(cells)


def _walls(x: float, y: float, row: int, column: int, cells: frozenset[Cell]) -> list[Features]:
    """Return the walls of a room, with gaps towards its neighbours."""
    half, long = THICKNESS / 2, (ROOM_SIZE + THICKNESS - GAP) / 2
    walls: list[Features] = []
    for neighbour, wall_y in (((row - 1, column), y + ROOM_SIZE - half), ((row + 1, column), y - half)):
        if neighbour in cells:
            walls += [(wx, wall_y, long, THICKNESS, 0.0) for wx in (x - half, long + GAP + x - half)]
        else:
            walls.append((x - half, wall_y, ROOM_SIZE + THICKNESS, THICKNESS, 0.0))
    for neighbour, wall_x in (((row, column - 1), x - half), ((row, column + 1), x + ROOM_SIZE - half)):
        if neighbour in cells:
            walls += [(wall_x, wy, THICKNESS, long, 0.0) for wy in (y - half, y + long + GAP - half)]
        else:
            walls.append((wall_x, y - half, THICKNESS, ROOM_SIZE + THICKNESS, 0.0))
    return walls


def _sample_door(rng: np.random.Generator, x: float, y: float, theta: float) -> Features:
    """Draw the handle of a closed door."""
    mass, friction, target = (rng.uniform() for _ in range(3))
    rotation = rng.uniform()
    while not abs(rotation - target) > HANDLE_TOLERANCE:
        rotation = rng.uniform()
    return (x, y, theta, mass, friction, rotation, target, 0.0)


def _sample_obstacles(
    rng: np.random.Generator, x: float, y: float, counts: tuple[int, int]
) -> list[Features]:
    """Draw obstacles around a room's center (x, y) that do not overlap each other."""
    found: list[Features] = []
    for _ in range(int(rng.integers(*counts, endpoint=True))):
        while True:
            left, bottom = (rng.uniform(c - OFF_CENTER, c + OFF_CENTER) for c in (x, y))
            width, height = (rng.uniform(*OBSTACLE_SIZES) for _ in range(2))
            shape = Rectangle(left, bottom, width, height, rng.uniform(-pi, pi))
            if not any(rectangles_meet(shape, Rectangle(*other)) for other in found):
                break
        found.append((shape.x, shape.y, shape.width, shape.height, shape.theta))
    return found


def _sample_state(
    rng: np.random.Generator, cells: frozenset[Cell], rows: int, obstacles: tuple[int, int]
) -> State:
    """Draw doors, obstacles and the robot's start, which may collide."""
    features: dict[Object, Features] = {}
    corners = {cell: (cell[1] * ROOM_SIZE, (rows - 1 - cell[0]) * ROOM_SIZE) for cell in sorted(cells)}
    shift = (ROOM_SIZE + THICKNESS - GAP) / 2
    half = THICKNESS / 2
    for (row, column), (x, y) in corners.items():
        name = f"{row}-{column}"
        features[Object(f"room-{name}", ROOM)] = (x, y)
        for number, wall in enumerate(_walls(x, y, row, column, cells)):
            features[Object(f"wall-{name}-{number}", OBSTACLE)] = wall
        if (row + 1, column) in cells:
            door = _sample_door(rng, x + shift, y - half, 0.0)
            features[Object(f"bottom-door-{name}", DOOR)] = door
        if (row, column - 1) in cells:
            door = _sample_door(rng, x + half, y + shift, pi / 2)
            features[Object(f"left-door-{name}", DOOR)] = door
    centers = {cell: (x + ROOM_SIZE / 2, y + ROOM_SIZE / 2) for cell, (x, y) in corners.items()}
    for (row, column), center in centers.items():
        for number, obstacle in enumerate(_sample_obstacles(rng, *center, obstacles)):
            features[Object(f"room-{row}-{column}-obstacle-{number}", OBSTACLE)] = obstacle
    center = list(centers.values())[int(rng.integers(len(centers)))]
    features[Object("robby", ROBOT)] = tuple(rng.uniform(c - OFF_CENTER, c + OFF_CENTER) for c in center)
    return State.of(features)


def sample_task(
    rng: np.random.Generator, rows: int, columns: int, share: tuple[float, float], obstacles: tuple[int, int]
) -> Task:
    """Draw a map, a start that is free, and a goal room."""
    cells = _sample_cells(rng, rows, columns, share)
    while True:
        state = _sample_state(rng, cells, rows, obstacles)
        (robot,) = state.by_type[ROBOT.name]
        if not collides(state, *state[robot]):
            break
    rooms = [room for room in state.by_type[ROOM.name] if not room_holds(state[room], *state[robot])]
    goal = rooms[int(rng.integers(len(rooms)))]
    return Task(state, frozenset({IN_ROOM(robot, goal)}))
