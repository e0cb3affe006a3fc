"""The picture of Coffee: from above and from the front. Source: spec, coffee.md section 9."""

from collections.abc import Callable
from math import cos, sin

from PIL.Image import Image

from bpns.envs.canvas import Canvas, Color
from bpns.envs.coffee.world import (
    BUTTON,
    BUTTON_RADIUS,
    CAPACITY,
    CUP,
    CUP_RADIUS,
    GRIPPER,
    HANDLE_HEIGHT,
    IS_HELD,
    IS_HOT,
    LEVEL,
    PLATE,
    PLATE_CORNER,
    PLATE_SIZE,
    POT,
    POT_HEIGHT,
    POT_RADIUS,
    TARGET,
    TILT,
    WORLD,
    X,
    Y,
    Z,
    handle_position,
    only,
    pot_position,
)
from bpns.symbolic.state import State

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
        canvas.rectangle(left, 0, width, cup[CAPACITY], LIQUID, 0.0, BLACK, 1.5)
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
