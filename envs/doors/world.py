"""The world of Doors: shapes, predicates and the transition. Source: spec, doors.md sections 1 to 5.

Shapes other than the robot never change. What is far away is dismissed by comparing coordinates, so that only
close cases cost geometry.
"""

from collections.abc import Mapping
from functools import lru_cache
from math import cos, inf, sin, sqrt, tanh

import numpy as np

from bpns.envs.actions import checked
from bpns.envs.shapes2d import Circle, Rectangle, rectangle_meets_circle, rectangles_meet
from bpns.symbolic.skills.environment import Classifier
from bpns.symbolic.state import Array, Features, State
from bpns.symbolic.structs import Object, Predicate, Type

ROBOT = Type("robot", ("x", "y"))
DOOR = Type("door", ("x", "y", "theta", "mass", "friction", "rotation", "target", "is-open"))  # a corner
ROOM = Type("room", ("x", "y"))  # lower left corner
OBSTACLE = Type("obstacle", ("x", "y", "width", "height", "theta"))  # walls too

X, Y, THETA, MASS, FRICTION, ROTATION, TARGET, IS_OPEN = range(8)  # of a door

ROOM_SIZE, GAP, THICKNESS = 1.0, 0.25, 0.01  # THICKNESS: of walls and doors
RADIUS = 0.05  # of the robot
STEP = 0.05  # most per action and axis
_BOUND = float(np.float32(STEP))
PADDING = RADIUS + 0.001  # of a doorway, to both sides of its door
HANDLE_TOLERANCE = 0.01
MARGIN = 1e-6  # keeps the comparisons of coordinates from deciding any close case

# ----------------------------------------------------------------------------------------- geometry


def door_shape(door: Features) -> Rectangle:
    """Return the rectangle that a door fills."""
    return Rectangle(door[X], door[Y], GAP, THICKNESS, door[THETA])


def doorway_of(door: Features) -> Rectangle:
    """Return the area in which the robot counts as being at a door."""
    if abs(door[THETA]) < 1e-6:
        return Rectangle(door[X], door[Y] - PADDING, GAP, THICKNESS + 2 * PADDING)
    return Rectangle(door[X] - THICKNESS - PADDING, door[Y], THICKNESS + 2 * PADDING, GAP)


def room_shape(room: Features) -> Rectangle:
    """Return a room's square."""
    return Rectangle(room[X], room[Y], ROOM_SIZE, ROOM_SIZE)


def reaches(shape: Rectangle, x: float, y: float, distance: float) -> bool:
    """Say whether a point is within a distance of a rectangle's bounding box, or nearly so."""
    far = distance + MARGIN
    if shape.theta == 0:
        return -far <= x - shape.x <= shape.width + far and -far <= y - shape.y <= shape.height + far
    far += shape.width + shape.height
    return -far <= x - shape.x <= far and -far <= y - shape.y <= far


def room_holds(room: Features, x: float, y: float) -> bool:
    """Say whether a point lies in a room."""
    return 0 <= x - room[X] <= ROOM_SIZE and 0 <= y - room[Y] <= ROOM_SIZE


def _is_at(x: float, y: float, door: Features) -> bool:
    """Say whether a robot at (x, y) is in the doorway."""
    if abs(x - door[X]) > 2 * GAP or abs(y - door[Y]) > 2 * GAP:
        return False
    return rectangle_meets_circle(doorway_of(door), Circle(x, y, RADIUS))


FAR = ROOM_SIZE + GAP + MARGIN  # a door's corner is at most so far right of or above its room's, ...
LOW = -GAP - MARGIN  # ... and at least so far


def joins(door: Features, room: Features) -> bool:
    """Say whether a door is one of a room's."""
    if not LOW <= door[X] - room[X] <= FAR or not LOW <= door[Y] - room[Y] <= FAR:
        return False
    return _joins(door[X], door[Y], door[THETA], room[X], room[Y])


@lru_cache(maxsize=65_536)  # on a grid, the same few places come back all the time
def _joins(x: float, y: float, theta: float, room_x: float, room_y: float) -> bool:
    door = Rectangle(x, y, GAP, THICKNESS, theta)
    return rectangles_meet(Rectangle(room_x, room_y, ROOM_SIZE, ROOM_SIZE), door)


def rooms_of(state: State, door: Features) -> list[Features]:
    """Return the rooms that a door joins, in canonical order."""
    features = state.features
    return [room for o in state.by_type.get(ROOM.name, ()) if joins(door, room := features[o.name])]


def solid_shapes(state: State) -> list[Rectangle]:
    """Return walls, obstacles and closed doors."""
    features = state.features
    shapes = [Rectangle(*features[o.name]) for o in state.by_type.get(OBSTACLE.name, ())]
    doors = (features[d.name] for d in state.by_type.get(DOOR.name, ()))
    return shapes + [door_shape(door) for door in doors if not door[IS_OPEN] > 0.5]


def collides(state: State, x: float, y: float) -> bool:
    """Say whether a robot at (x, y) would overlap an obstacle or a closed door."""
    features = state.features
    near = RADIUS + MARGIN
    for obj in state.by_type.get(OBSTACLE.name, ()):
        left, bottom, width, height, theta = features[obj.name]
        if theta == 0:
            if not -near <= x - left <= width + near or not -near <= y - bottom <= height + near:
                continue
        elif abs(x - left) + abs(y - bottom) > 2 * (width + height + near):
            continue
        if rectangle_meets_circle(Rectangle(left, bottom, width, height, theta), Circle(x, y, RADIUS)):
            return True
    for obj in state.by_type.get(DOOR.name, ()):
        door = features[obj.name]
        if (
            abs(x - door[X]) <= 2 * GAP
            and abs(y - door[Y]) <= 2 * GAP
            and not door[IS_OPEN] > 0.5
            and rectangle_meets_circle(door_shape(door), Circle(x, y, RADIUS))
        ):
            return True
    return False


# --------------------------------------------------------------------------------------- predicates

DOOR_IN_ROOM = Predicate("DoorInRoom", (DOOR, ROOM))
DOOR_IS_OPEN = Predicate("DoorIsOpen", (DOOR,))
DOORS_SHARE_ROOM = Predicate("DoorsShareRoom", (DOOR, DOOR))
IN_DOORWAY = Predicate("InDoorway", (ROBOT, DOOR))
IN_MAIN_ROOM = Predicate("InMainRoom", (ROBOT, ROOM))
IN_ROOM = Predicate("InRoom", (ROBOT, ROOM))
TOUCHING_DOOR = Predicate("TouchingDoor", (ROBOT, DOOR))


def _door_in_room(state: State, objects: tuple[Object, ...]) -> bool:
    return joins(state[objects[0]], state[objects[1]])


def door_is_open(state: State, objects: tuple[Object, ...]) -> bool:
    """Say whether a door is open."""
    return state[objects[0]][IS_OPEN] > 0.5


def _doors_share_room(state: State, objects: tuple[Object, ...]) -> bool:
    one, two = state[objects[0]], state[objects[1]]
    x, y, other_x, other_y = one[X], one[Y], two[X], two[Y]
    most = FAR - LOW
    if objects[0] == objects[1] or abs(x - other_x) > most or abs(y - other_y) > most:
        return False
    features = state.features
    for obj in state.by_type.get(ROOM.name, ()):
        left, bottom = room = features[obj.name]
        if (
            LOW <= x - left <= FAR
            and LOW <= y - bottom <= FAR
            and LOW <= other_x - left <= FAR
            and LOW <= other_y - bottom <= FAR
            and joins(one, room)
            and joins(two, room)
        ):
            return True
    return False


def in_doorway(state: State, objects: tuple[Object, ...]) -> bool:
    """Say whether the robot stands in a door's way."""
    x, y = state[objects[0]]
    return _is_at(x, y, state[objects[1]])


def _in_room(state: State, objects: tuple[Object, ...]) -> bool:
    return room_holds(state[objects[1]], *state[objects[0]])


def _in_main_room(state: State, objects: tuple[Object, ...]) -> bool:
    (x, y), room = state[objects[0]], state[objects[1]]
    if not room_holds(room, x, y):
        return False
    doors = (state.features[door.name] for door in state.by_type.get(DOOR.name, ()))
    return not any(_is_at(x, y, door) and joins(door, room) for door in doors)


def _touching_door(state: State, objects: tuple[Object, ...]) -> bool:
    door = state[objects[1]]
    return not door[IS_OPEN] > 0.5 and in_doorway(state, objects)


CLASSIFIERS: Mapping[Predicate, Classifier] = {
    DOOR_IN_ROOM: _door_in_room,
    DOOR_IS_OPEN: door_is_open,
    DOORS_SHARE_ROOM: _doors_share_room,
    IN_DOORWAY: in_doorway,
    IN_MAIN_ROOM: _in_main_room,
    IN_ROOM: _in_room,
    TOUCHING_DOOR: _touching_door,
}

# --------------------------------------------------------------------------------------- transition


def opening_rotation(door: Features) -> float:
    """Return the handle value that opens a door."""
    return tanh(door[TARGET]) * (sin(door[MASS]) + cos(door[FRICTION]) * sqrt(door[MASS]))


def simulate(state: State, action: Array) -> State:
    """Return the next state. Source: spec, doors.md section 4."""
    dx, dy, rotation = checked(action, (_BOUND, _BOUND, inf), f"dx, dy in +-{STEP}, any rotation")
    (robot,) = state.by_type[ROBOT.name]
    x, y = state.features[robot.name]
    changes: dict[str, Features] = {}
    if not collides(state, x + dx, y + dy):
        changes[robot.name] = (x + dx, y + dy)
    for obj in state.by_type.get(DOOR.name, ()):  # at the old place of the robot
        door = state.features[obj.name]
        if not door[IS_OPEN] > 0.5 and _is_at(x, y, door):
            opened = abs(rotation - opening_rotation(door)) < HANDLE_TOLERANCE
            changes[obj.name] = (*door[:ROTATION], rotation, door[TARGET], 1.0 if opened else door[IS_OPEN])
    return state.changed(changes)
