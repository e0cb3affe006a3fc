"""Where things are at the start of a task of Stick Button. Source: spec, stick_button.md section 6."""

from collections.abc import Iterable

import numpy as np

from bpns.envs.shapes2d import Circle, Rectangle, circles_meet, rectangle_meets_circle
from bpns.envs.stick_button.world import (
    BUTTON,
    GRIPPER,
    HOLDER,
    HOLDER_LENGTH,
    HOLDER_THICKNESS,
    PRESSED,
    RADIUS,
    STICK,
    STICK_LENGTH,
    STICK_THICKNESS,
    UPRIGHT,
    WORLD_X,
    WORLD_Y,
    ZONE_Y,
    stick_shape,
)
from bpns.symbolic.errors import InputError
from bpns.symbolic.state import Features, State, Task
from bpns.symbolic.structs import GroundAtom, Object

SPACING = 0.5  # around everything at the start
STICK_START_Y = 1.6  # highest
MAX_TRIES = 10_000  # to find a place; with the paper's numbers of buttons a few are enough


def _place(
    rng: np.random.Generator, most_x: float, most_y: float, taken: Iterable[Circle]
) -> tuple[float, float]:
    """Draw a position whose surroundings are free."""
    least = RADIUS + SPACING
    for _ in range(MAX_TRIES):
        x, y = rng.uniform(least, most_x), rng.uniform(least, most_y)
        if not any(circles_meet(Circle(x, y, least), other) for other in taken):
            return x, y
    raise InputError("stick_button: no room for so many buttons: ask for fewer")


def _sample_state(rng: np.random.Generator, count: int) -> State:
    """Draw a state with so many buttons. Source: spec, stick_button.md section 6."""
    least = RADIUS + SPACING
    taken: list[Circle] = []
    features: dict[Object, Features] = {}
    for number in range(count):
        x, y = _place(rng, WORLD_X - least, WORLD_Y - least, taken)
        taken.append(Circle(x, y, least))
        features[Object(f"button{number}", BUTTON)] = (x, y, 0.0)
    highest = max(circle.y for circle in taken)
    robot = _place(rng, WORLD_X - least, ZONE_Y - least, taken)
    features[Object("robby", GRIPPER)] = robot
    taken.append(Circle(*robot, least))
    for _ in range(MAX_TRIES):
        x, y = rng.uniform(least, WORLD_X - least), rng.uniform(least, STICK_START_Y)
        if not any(rectangle_meets_circle(stick_shape(x, y), circle) for circle in taken):
            break
    else:
        raise InputError("stick_button: no room for the stick among so many buttons: ask for fewer")
    features[Object("stick", STICK)] = (x, y, 0.0)
    reach = highest - ZONE_Y
    while True:
        offset = rng.uniform(-HOLDER_LENGTH, STICK_LENGTH / 2)
        room_above = STICK_LENGTH - (offset + HOLDER_LENGTH)
        if reach < 0 or offset > 2 * RADIUS or room_above > reach:  # the stick can be held low enough
            break
    middle = y - (HOLDER_THICKNESS - STICK_THICKNESS) / 2
    holder = Rectangle(x + offset, middle, HOLDER_LENGTH, HOLDER_THICKNESS).rotated((x, y), UPRIGHT)
    features[Object("holder", HOLDER)] = (holder.x, holder.y)
    return State.of(features)


def sample_task(rng: np.random.Generator, counts: tuple[int, ...]) -> Task:
    """Draw a task with one of these numbers of buttons: press all. Source: spec, section 6."""
    state = _sample_state(rng, int(rng.choice(counts)))
    goal: frozenset[GroundAtom] = frozenset(PRESSED(b) for b in state.by_type[BUTTON.name])
    return Task(state, goal)
