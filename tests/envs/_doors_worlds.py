"""Small states of Doors, made by hand."""

from math import cos, pi, sin, sqrt, tanh

import numpy as np

from bpns.envs.doors import ENVIRONMENT
from bpns.envs.doors.world import DOOR, OBSTACLE, ROBOT, ROOM, simulate
from bpns.symbolic.skills.environment import abstract
from bpns.symbolic.state import State
from bpns.symbolic.structs import Object, Predicate

ROBBY, BLOCK = Object("robby", ROBOT), Object("block", OBSTACLE)
WEST, EAST, SOUTH = Object("room-0-0", ROOM), Object("room-0-1", ROOM), Object("room-1-0", ROOM)
UPRIGHT, FLAT = Object("left-door-0-1", DOOR), Object("bottom-door-0-0", DOOR)  # as on the map
SKILLS = {skill.operator.name: skill for skill in ENVIRONMENT.oracle_skills}
HANDLE = (0.49, 0.3, 0.8, 0.6)  # mass, friction, rotation, target
OPENS_AT = tanh(0.6) * (sin(0.49) + cos(0.3) * sqrt(0.49))
AT_UPRIGHT = (0.9, 1.5)  # in its doorway, far from it
NOTHING = np.zeros(0, np.float32)


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
