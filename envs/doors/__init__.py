"""Doors: a robot opens doors to get from room to room. Source: spec, doors.md.

Moving is given, by motion planning; opening doors is to be learned.
"""

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from math import hypot

import numpy as np
from PIL.Image import Image

from bpns.envs.canvas import Canvas, Color
from bpns.envs.doors.motion import plan_motion
from bpns.envs.doors.tasks import sample_task
from bpns.envs.doors.world import (
    CLASSIFIERS,
    DOOR,
    DOOR_IN_ROOM,
    DOOR_IS_OPEN,
    DOORS_SHARE_ROOM,
    IN_DOORWAY,
    IN_MAIN_ROOM,
    IN_ROOM,
    IS_OPEN,
    OBSTACLE,
    RADIUS,
    ROBOT,
    ROOM,
    ROOM_SIZE,
    ROTATION,
    STEP,
    TOUCHING_DOOR,
    door_is_open,
    door_shape,
    doorway_of,
    in_doorway,
    opening_rotation,
    reaches,
    room_holds,
    room_shape,
    rooms_of,
    simulate,
    solid_shapes,
)
from bpns.envs.shapes2d import Circle, Point, Rectangle, rectangle_meets_circle
from bpns.symbolic.skills.environment import Budget, Split
from bpns.symbolic.skills.skill import Controller, GivenSkill, Skill, SkillFailure
from bpns.symbolic.state import Array, Features, State, Task
from bpns.symbolic.structs import GroundAtom, LiftedAtom, Object, Operator, Variable

# ------------------------------------------------------------------------------------ given skills


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

# ----------------------------------------------------------------------------------- oracle skills


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


# -------------------------------------------------------------------------------------- environment

MOST_OBSTACLES = 4  # that surely fit around a room's center


@dataclass(frozen=True, slots=True)
class Doors:
    """The environment; the options are the size of the map and how full it is."""

    rows: int = 5
    columns: int = 5
    room_share: tuple[float, float] = (0.25, 0.75)  # of the cells of the grid: least and most
    obstacles: tuple[int, int] = (0, 3)  # in a room: least and most

    name = "doors"
    types = (ROBOT, DOOR, ROOM, OBSTACLE)
    classifiers = CLASSIFIERS
    goal_predicates = frozenset({IN_ROOM})
    contact_predicates = frozenset({TOUCHING_DOOR, IN_ROOM})
    oracle_skills = _oracle_skills()
    given_skills = (MOVE_TO_DOOR, MOVE_THROUGH_DOOR)
    action_low = np.array([-STEP, -STEP, -np.inf], np.float32)
    action_high = np.array([STEP, STEP, np.inf], np.float32)
    horizon = 1000
    rollout_limit = 1000
    budget = Budget(abstract_plans=8, samples_per_step=10)

    def __post_init__(self) -> None:
        if min(self.rows, self.columns) < 1:
            raise ValueError("rows and columns are numbers above 0")
        if len(self.room_share) != 2 or not 0 <= self.room_share[0] <= self.room_share[1] <= 1:
            raise ValueError("room_share is two numbers in 0..1: least,most")
        if int(self.room_share[0] * self.rows * self.columns) < 2:
            raise ValueError("there must be two rooms at least: more rows, columns or room_share")
        if len(self.obstacles) != 2 or not 0 <= self.obstacles[0] <= self.obstacles[1] <= MOST_OBSTACLES:
            raise ValueError(f"obstacles is two numbers in 0..{MOST_OBSTACLES}: least,most in a room")

    def simulate(self, state: State, action: Array) -> State:
        """Return the next state; the action is (dx, dy, rotation), the last one absolute."""
        return simulate(state, action)

    def sample_task(self, split: Split, index: int, rng: np.random.Generator) -> Task:
        """Draw a task; both splits are alike. Source: spec, doors.md section 6."""
        return sample_task(rng, self.rows, self.columns, self.room_share, self.obstacles)

    def draw(self, state: State, caption: str = "", goal: frozenset[GroundAtom] = frozenset()) -> Image:
        """Return a picture of a state; rooms that the goal names have a color of their own."""
        return draw(state, caption, goal)


ENVIRONMENT = Doors()

# ------------------------------------------------------------------------------------------ drawing

BLACK: Color = (0, 0, 0)
LIGHT_GRAY: Color = (224, 224, 224)
STEEL_BLUE: Color = (176, 196, 222)
KHAKI: Color = (240, 230, 140)
ORANGE_RED: Color = (255, 69, 0)
LIGHT_GREEN: Color = (100, 220, 100)
BLUE: Color = (30, 60, 220)


def draw(state: State, caption: str, goal: frozenset[GroundAtom]) -> Image:
    """Return a picture from above. Source: spec, doors.md section 9."""
    rooms = [state[room] for room in state.by_type[ROOM.name]]
    margin = 0.02
    canvas = Canvas.blank(
        min(x for x, _ in rooms) - margin,
        max(x for x, _ in rooms) + ROOM_SIZE + margin,
        min(y for _, y in rooms) - margin,
        max(y for _, y in rooms) + ROOM_SIZE + margin,
        width=640,
    )
    (robot,) = state.by_type[ROBOT.name]
    x, y = state[robot]
    for obj in state.by_type[ROOM.name]:
        color = STEEL_BLUE if room_holds(state[obj], x, y) else LIGHT_GRAY
        color = KHAKI if any(obj in atom.objects for atom in goal) else color
        canvas.polygon(list(room_shape(state[obj]).vertices()), color)
        canvas.text(state[obj][0] + 0.06, state[obj][1] + 0.94, obj.name, 10, anchor="lt")
    for obj in state.by_type.get(OBSTACLE.name, ()):
        canvas.polygon(list(Rectangle(*state[obj]).vertices()), BLACK)
    for obj in state.by_type.get(DOOR.name, ()):
        door = state[obj]
        color = LIGHT_GREEN if door[IS_OPEN] > 0.5 else ORANGE_RED
        canvas.polygon(list(door_shape(door).vertices()), color, edge=color, thickness=3)
    canvas.disc(x, y, RADIUS, BLUE)
    canvas.caption(caption.split("\n") if caption else [])
    return canvas.finish()
