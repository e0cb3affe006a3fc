"""What is where in Coffee, and its picture. Source: spec, coffee.md sections 1, 2 and 9."""

from collections.abc import Callable
from math import cos, pi, sin
from typing import TypeAlias

from PIL.Image import Image

from envs._draw import Canvas, Color
from symbolic.state import Features, State
from symbolic.structs import Type

Point: TypeAlias = tuple[float, float, float]

GRIPPER = Type("gripper", ("x", "y", "z", "tilt-angle", "wrist-angle", "fingers"))
POT = Type("pot", ("x", "y", "rotation", "is-held", "is-hot"))  # no z: it hangs from the gripper or stands
PLATE = Type("plate", ("is-on",))
CUP = Type("cup", ("x", "y", "liquid-capacity", "liquid-target", "current-liquid"))

X, Y, Z, TILT, WRIST, FINGERS = range(6)  # of the gripper; X and Y of pot and cups too
ROTATION, IS_HELD, IS_HOT = 2, 3, 4  # of the pot
LIMIT, TARGET, LEVEL = 2, 3, 4  # of a cup

WORLD = 10.0  # x, y and z are in 0..WORLD
BUTTON: Point = (9.0, 7.5, 3.0)
BUTTON_RADIUS = 0.2
PLATE_CORNER, PLATE_SIZE = (8.5, 7.5), (1.0, 2.0, 4.0)
POT_RADIUS, POT_HEIGHT = 0.4, 1.5
CUP_RADIUS = 0.24
HANDLE_DISTANCE, HANDLE_HEIGHT = 1.05 * POT_RADIUS, 1.125  # from the middle of the pot's bottom
DISPENSE_AREA: Point = (BUTTON[X], BUTTON[Y] - 1.1 * POT_RADIUS, 0.0)  # where a pot is on the plate
POUR_OFFSET: Point = (1.5 * (CUP_RADIUS + POT_RADIUS), CUP_RADIUS, 1.1 * (1.5 + POT_HEIGHT - HANDLE_HEIGHT))
NEAR_TOP, NEAR_AREA, NEAR_POUR = 0.5, 1.0, 1.0  # squared distances


def squared_distance(a: Point, b: Point) -> float:
    """Return the squared distance."""
    x, y, z = a[0] - b[0], a[1] - b[1], a[2] - b[2]
    return x * x + y * y + z * z


def distance_across(a: Point, b: Point) -> float:
    """Return the squared distance in x and y."""
    return (a[X] - b[X]) ** 2 + (a[Y] - b[Y]) ** 2


def clip(value: float, low: float, high: float) -> float:
    """Return the nearest number in low..high."""
    return low if value < low else high if value > high else value


def only(state: State, type_: Type) -> Features:
    """Return the features of the one object of a type."""
    return state.features[state.by_type[type_.name][0].name]


def position(robot: Features) -> Point:
    """Return where the gripper is."""
    return (robot[X], robot[Y], robot[Z])


def pot_position(robot: Features, pot: Features) -> Point:
    """Return the middle of the bottom of a held pot; one that stands is at height 0."""
    return (pot[X], pot[Y], robot[Z] - HANDLE_HEIGHT)


def handle_position(pot: Features) -> Point:
    """Return where a pot that stands is grasped."""
    angle = pot[ROTATION] - pi / 2
    return (pot[X] + cos(angle) * HANDLE_DISTANCE, pot[Y] + sin(angle) * HANDLE_DISTANCE, HANDLE_HEIGHT)


def pour_position(cup: Features) -> Point:
    """Return where a pot pours into a cup."""
    return (cup[X] + POUR_OFFSET[X], cup[Y] + POUR_OFFSET[Y], POUR_OFFSET[Z])


def is_on_plate(pot: Features) -> bool:
    """Say whether the pot stands on the plate."""
    at = (pot[X], pot[Y], 0.0)
    return not pot[IS_HELD] > 0.5 and squared_distance(DISPENSE_AREA, at) < NEAR_AREA


def is_at_top(robot: Features, pot: Features) -> bool:
    """Say whether the gripper is at the top of the pot, and not nearer to the handle."""
    at = position(robot)
    top = squared_distance((pot[X], pot[Y], POT_HEIGHT), at)
    return top < NEAR_TOP and not squared_distance(handle_position(pot), at) < top


def is_above(robot: Features, pot: Features, cup: Features) -> bool:
    """Say whether the pot is held where it can pour into the cup."""
    at = pot_position(robot, pot)
    return pot[IS_HELD] > 0.5 and squared_distance(at, pour_position(cup)) < NEAR_POUR


def cup_below(state: State, spout: Point) -> str:
    """Return the name of the cup that a tilted pot pours into; empty where there is none."""
    nearest, best = "", NEAR_POUR
    for obj in state.by_type[CUP.name]:
        distance = squared_distance(spout, pour_position(state[obj]))
        if distance < best:  # strictly: the first in canonical order on ties
            nearest, best = obj.name, distance
    return nearest


def is_filled(cup: Features) -> bool:
    """Say whether there is more in a cup than wanted."""
    return cup[LEVEL] > cup[TARGET]


# ------------------------------------------------------------------------------------------ drawing

BLACK: Color = (30, 30, 30)
GRAY: Color = (170, 170, 170)
DARK_GRAY: Color = (90, 90, 90)
LIQUID: Color = (135, 206, 250)
BROWN: Color = (139, 69, 19)
RED: Color = (220, 30, 30)
GOLD: Color = (255, 200, 0)
POT_COLORS: dict[tuple[bool, bool], Color] = {  # held, hot
    (False, False): (144, 238, 144),
    (True, False): (20, 120, 20),
    (False, True): (150, 195, 240),
    (True, True): (30, 50, 170),
}
HANDLE_RADIUS = 0.1
ACROSS = 12.0  # from the origin of the view from above to that of the view from the front


def _axes(canvas: Canvas, left: float, across: str, up: str, title: str) -> None:
    """Draw a frame with half a unit of padding, ticks and labels."""
    canvas.rectangle(left - 0.5, -0.5, WORLD + 1, WORLD + 1, (255, 255, 255), edge=GRAY, thickness=1)
    for tick in range(0, 11, 2):
        canvas.line((left + tick, -0.5), (left + tick, -0.6), GRAY, 1)
        canvas.line((left - 0.5, tick), (left - 0.6, tick), GRAY, 1)
        canvas.text(left + tick, -0.8, str(tick), 11)
        canvas.text(left - 0.8, tick, str(tick), 11)
    canvas.text(left + 5, -1.2, across, 13)
    canvas.text(left - 1.2, 5, up, 13)
    canvas.text(left + 5, 10.8, title, 13)


def _turned(center: tuple[float, float], angle: float) -> Callable[[float, float], tuple[float, float]]:
    """Return the rotation about a point, counter-clockwise."""

    def turn(x: float, y: float) -> tuple[float, float]:
        dx, dy = x - center[0], y - center[1]
        return (
            center[0] + dx * cos(angle) - dy * sin(angle),
            center[1] + dx * sin(angle) + dy * cos(angle),
        )

    return turn


def _draw_above(canvas: Canvas, state: State) -> None:
    """Draw x and y: plate, cups with what is in them, pot, handle, gripper."""
    robot, pot = only(state, GRIPPER), only(state, POT)
    canvas.rectangle(*PLATE_CORNER, PLATE_SIZE[X], PLATE_SIZE[Y], GRAY, edge=BLACK, thickness=1)
    for obj in state.by_type[CUP.name]:
        cup = state[obj]
        canvas.disc(cup[X], cup[Y], CUP_RADIUS, LIQUID, float(cup[LEVEL] > 0), BLACK, 1.5)
        canvas.text(cup[X], cup[Y] - 0.5, obj.name, 11)
    color = POT_COLORS[pot[IS_HELD] > 0.5, pot[IS_HOT] > 0.5]
    canvas.disc(pot[X], pot[Y], POT_RADIUS, color, edge=BLACK, thickness=1.5)
    canvas.disc(robot[X], robot[Y], CUP_RADIUS, GOLD, 0.9, BLACK, 1)
    canvas.disc(*handle_position(pot)[:2], HANDLE_RADIUS, DARK_GRAY)


def _draw_front(canvas: Canvas, state: State) -> None:
    """Draw x and z: plate, button, cups with their levels and targets, tilted pot, handle, gripper."""
    robot, pot = only(state, GRIPPER), only(state, POT)
    held = pot[IS_HELD] > 0.5
    canvas.line((ACROSS - 0.5, 0), (ACROSS + WORLD + 0.5, 0), GRAY, 1)
    left = ACROSS + PLATE_CORNER[X]
    canvas.rectangle(left, 0, PLATE_SIZE[X], PLATE_SIZE[Z], GRAY, edge=BLACK, thickness=1)
    color = RED if only(state, PLATE)[0] > 0.5 else BROWN
    canvas.disc(ACROSS + BUTTON[X], BUTTON[Z], BUTTON_RADIUS, color, edge=BLACK, thickness=1)
    # The paper draws a cup from its middle to the right and a radius above the table; here it stands there.
    for obj in sorted(state.by_type[CUP.name], key=lambda o: -state[o][Y]):  # the nearest last
        cup = state[obj]
        left, width = ACROSS + cup[X] - CUP_RADIUS, 2 * CUP_RADIUS
        canvas.rectangle(left, 0, width, cup[LEVEL], LIQUID)
        canvas.rectangle(left, 0, width, cup[LIMIT], LIQUID, 0.0, BLACK, 1.5)
        canvas.line((left - 0.1, cup[TARGET]), (left + width + 0.1, cup[TARGET]), RED, 1)
    angle = robot[TILT] if held else 0.0  # the spout goes down to the left, where the cup is
    turn = _turned((ACROSS + robot[X], robot[Z]), angle)
    bottom = pot_position(robot, pot)[Z] if held else 0.0
    left, right, top = ACROSS + pot[X] - POT_RADIUS, ACROSS + pot[X] + POT_RADIUS, bottom + POT_HEIGHT
    corners = [turn(*p) for p in ((left, bottom), (left, top), (right, top), (right, bottom))]
    canvas.polygon(corners, POT_COLORS[held, pot[IS_HOT] > 0.5], edge=BLACK, thickness=1.5)
    canvas.disc(ACROSS + robot[X], robot[Z], CUP_RADIUS, GOLD, 0.9, BLACK, 1)
    handle = turn(ACROSS + handle_position(pot)[X], bottom + HANDLE_HEIGHT)
    canvas.disc(*handle, HANDLE_RADIUS, DARK_GRAY)


def draw(state: State, caption: str = "") -> Image:
    """Return a picture: the view from above and the one from the front, side by side."""
    canvas = Canvas.blank(-1.6, ACROSS + WORLD + 0.8, -1.5, 11.2, width=1040)
    _axes(canvas, 0.0, "x", "y", "from above")
    _axes(canvas, ACROSS, "x", "z", "from the front (red: target levels)")
    _draw_above(canvas, state)
    _draw_front(canvas, state)
    canvas.caption(caption.split("\n") if caption else [])
    return canvas.finish()
