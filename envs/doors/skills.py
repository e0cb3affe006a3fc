"""The given and the oracle skills of Doors. Source: spec, doors.md sections 7 and 8."""

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from math import hypot

import numpy as np

from bpns.envs.doors.motion import plan_motion
from bpns.envs.doors.world import (
    DOOR,
    DOOR_IN_ROOM,
    DOOR_IS_OPEN,
    DOORS_SHARE_ROOM,
    IN_DOORWAY,
    IN_MAIN_ROOM,
    IN_ROOM,
    RADIUS,
    ROBOT,
    ROOM,
    ROOM_SIZE,
    ROTATION,
    STEP,
    TOUCHING_DOOR,
    door_is_open,
    doorway_of,
    in_doorway,
    opening_rotation,
    reaches,
    room_holds,
    rooms_of,
    solid_shapes,
)
from bpns.envs.shapes2d import Circle, Point, Rectangle, rectangle_meets_circle
from bpns.symbolic.operators import Operator
from bpns.symbolic.skills.skill import Controller, GivenSkill, Skill, SkillFailure
from bpns.symbolic.state import Array, Features, State
from bpns.symbolic.structs import LiftedAtom, Object, Variable


def _position_in_doorway(room: Features, door: Features) -> Point:
    """Return the middle of the doorway's edge that lies in a room."""
    inside = [v for v in doorway_of(door).vertices() if room_holds(room, *v)]
    if len(inside) != 2:
        raise SkillFailure("the doorway does not lie across the room's border")
    return (inside[0][0] + inside[1][0]) / 2, (inside[0][1] + inside[1][1]) / 2


@lru_cache(maxsize=4096)  # once per start and target, however often a search comes back to it
def _motion(
    start: Point, target: Point, corner: Point, solid: tuple[Rectangle, ...], seed: int
) -> tuple[Point, ...] | None:
    """Return the points of a motion plan within a room, from the start on."""
    rng = np.random.default_rng(seed)

    def free(point: Point) -> bool:
        x, y = point
        return not any(
            reaches(shape, x, y, RADIUS) and rectangle_meets_circle(shape, Circle(x, y, RADIUS))
            for shape in solid
        )

    def sample() -> Point:
        x, y = (float(np.float32(rng.uniform(c + RADIUS, c + ROOM_SIZE - RADIUS))) for c in corner)
        return x, y

    path = plan_motion(start, target, free, sample, STEP, rng)
    return None if path is None else tuple(path)


@dataclass(frozen=True, slots=True)
class MoveToDoor:
    """Follow a motion plan through the room to a door. Objects: robot, door."""

    seed: int = (
        0  # of the motion planner: the same plan for the same state, whatever the run (spec: its seed)
    )

    def begin(self, state: State, objects: tuple[Object, ...], subgoal: Array) -> Controller:
        """Plan the motion; raise SkillFailure where there is none."""
        robot, door = objects
        x, y = state[robot]
        room = next((r for r in rooms_of(state, state[door]) if room_holds(r, x, y)), None)
        if room is None:
            raise SkillFailure("the robot is in no room of the door")
        target = _position_in_doorway(room, state[door])
        corner = room[0], room[1]
        center = corner[0] + ROOM_SIZE / 2, corner[1] + ROOM_SIZE / 2
        near = max(ROOM_SIZE / 2, abs(x - center[0]), abs(y - center[1])) + RADIUS  # holds the whole plan
        solid = tuple(shape for shape in solid_shapes(state) if reaches(shape, *center, near))
        path = _motion((x, y), target, corner, solid, self.seed)
        if path is None:
            raise SkillFailure("no motion plan")
        steps = pairwise(path)

        def act(now: State) -> Array | None:
            if in_doorway(now, objects):
                return None
            here, there = next(steps, (None, None))
            if here is None or there is None:
                raise SkillFailure("the motion plan ended before the door")
            return np.array([there[0] - here[0], there[1] - here[1], 0], np.float32)

        return act


@dataclass(frozen=True, slots=True)
class MoveThroughDoor:
    """Go straight through an open door into the other room. Objects: robot, door."""

    def begin(self, state: State, objects: tuple[Object, ...], subgoal: Array) -> Controller:
        """Remember the room behind the door."""
        robot, door = objects
        rooms = rooms_of(state, state[door])
        if len(rooms) != 2 or not in_doorway(state, objects) or not door_is_open(state, objects[1:]):
            raise SkillFailure("the robot is not at an open door between two rooms")
        other = rooms[1] if room_holds(rooms[0], *state[robot]) else rooms[0]
        target = _position_in_doorway(other, state[door])

        def act(now: State) -> Array | None:
            x, y = now[robot]
            if room_holds(other, x, y):
                return None
            dx, dy = target[0] - x, target[1] - y
            length = hypot(dx, dy)
            share = min(1.0, STEP / length) if length > 0 else 0.0
            return np.array([dx * share, dy * share, 0], np.float32)

        return act


MOVE_TO_DOOR = GivenSkill("MoveToDoor", (ROBOT, DOOR), MoveToDoor())
MOVE_THROUGH_DOOR = GivenSkill("MoveThroughDoor", (ROBOT, DOOR), MoveThroughDoor())


@dataclass(frozen=True, slots=True)
class OpenSampler:
    """The one change of rotation and is-open that opens the door."""

    dimension: int = 2

    def sample(self, state: State, objects: tuple[Object, ...], rng: np.random.Generator) -> Array:
        """Return a subgoal, (2,) float32."""
        door = state[objects[0]]
        return np.array([opening_rotation(door) - door[ROTATION], 1], np.float32)


@dataclass(frozen=True, slots=True)
class OpenPolicy:
    """Turn the handle by the subgoal's first entry."""

    def begin(self, state: State, objects: tuple[Object, ...], subgoal: Array) -> Controller:
        """Remember the absolute rotation."""
        action = np.array([0, 0, state[objects[0]][ROTATION] + float(subgoal[0])], np.float32)
        return lambda now: action


def _oracle_skills() -> tuple[Skill, ...]:
    """Return the oracle's skills. Source: spec, doors.md section 8."""
    robot, door, other = Variable("?robot", ROBOT), Variable("?door", DOOR), Variable("?door2", DOOR)
    room, other_room = Variable("?room", ROOM), Variable("?room2", ROOM)
    at, touching = IN_DOORWAY.lifted(robot, door), TOUCHING_DOOR.lifted(robot, door)
    inside, main = IN_ROOM.lifted(robot, room), IN_MAIN_ROOM.lifted(robot, room)
    at_other, touching_other = IN_DOORWAY.lifted(robot, other), TOUCHING_DOOR.lifted(robot, other)
    is_open, in_room = DOOR_IS_OPEN.lifted(door), DOOR_IN_ROOM.lifted(door, room)

    def operator(
        name: str,
        parameters: tuple[Variable, ...],
        preconditions: set[LiftedAtom],
        adds: set[LiftedAtom],
        deletes: set[LiftedAtom],
    ) -> Operator:
        return Operator(name, parameters, frozenset(preconditions), frozenset(adds), frozenset(deletes))

    from_room = operator(
        "MoveToDoorFromMainRoom", (robot, room, door), {inside, main, in_room}, {touching, at}, {main}
    )
    from_door = operator(
        "MoveToDoorFromDoorWay",
        (robot, door, other),
        {at, DOORS_SHARE_ROOM.lifted(door, other)},
        {touching_other, at_other},
        {at},
    )
    opening = operator("OpenDoor", (door, robot), {touching, at}, {is_open}, {touching})
    through = operator(
        "MoveThroughDoor",
        (robot, room, door, other_room),
        {inside, at, is_open, in_room, DOOR_IN_ROOM.lifted(door, other_room)},
        {IN_ROOM.lifted(robot, other_room)},
        {inside},
    )
    return (
        Skill.of_given(from_room, MOVE_TO_DOOR, (robot, door)),
        Skill.of_given(from_door, MOVE_TO_DOOR, (robot, other)),
        Skill(opening, OpenPolicy(), OpenSampler(), door_is_open),
        Skill.of_given(through, MOVE_THROUGH_DOOR, (robot, door)),
    )


ORACLE_SKILLS = _oracle_skills()
