"""Pictures of Stick Button. Source: spec, stick_button.md section 9."""

from PIL.Image import Image

from bpns.envs.canvas import Canvas, Color
from bpns.envs.shapes2d import Rectangle
from bpns.envs.stick_button.world import (
    BUTTON,
    GRIPPER,
    HOLDER,
    HOLDER_LENGTH,
    HOLDER_THICKNESS,
    RADIUS,
    STICK,
    UPRIGHT,
    WORLD_X,
    WORLD_Y,
    ZONE_Y,
    only,
    stick_shape,
    tip_shape,
)
from bpns.symbolic.state import State

BLACK: Color = (0, 0, 0)
WHITE: Color = (255, 255, 255)
GREEN: Color = (144, 238, 144)
YELLOW: Color = (255, 225, 40)
BLUE: Color = (40, 70, 220)
GRAY: Color = (128, 128, 128)
FIREBRICK: Color = (178, 34, 34)
BROWN: Color = (139, 69, 19)
RED: Color = (230, 20, 20)


def draw(state: State, caption: str = "") -> Image:
    """Return a picture from above. Source: spec, stick_button.md section 9."""
    canvas = Canvas.blank(0, WORLD_X, 0, WORLD_Y, width=720)
    canvas.rectangle(0, 0, WORLD_X, ZONE_Y, GREEN, opacity=0.25)
    canvas.rectangle(0, 0, WORLD_X, WORLD_Y, WHITE, opacity=0.0, edge=GRAY, thickness=1)
    canvas.text(0.08, ZONE_Y - 0.02, "the hand can reach below this line", 11, anchor="lt")
    for obj in state.by_type.get(BUTTON.name, ()):
        x, y, pressed = state[obj]
        canvas.disc(x, y, RADIUS, BLUE if pressed > 0.5 else YELLOW, opacity=0.75, edge=BLACK, thickness=1)
        canvas.text(x, y + 0.22, obj.name, 11)
    _, (x, y) = only(state, HOLDER)
    holder = Rectangle(x, y, HOLDER_LENGTH, HOLDER_THICKNESS, UPRIGHT)
    canvas.polygon(list(holder.vertices()), GRAY)
    _, (x, y, held) = only(state, STICK)
    edge = BLACK if held > 0.5 else WHITE
    canvas.polygon(list(stick_shape(x, y).vertices()), FIREBRICK, edge=edge, thickness=1)
    canvas.polygon(list(tip_shape(x, y).vertices()), BROWN)
    _, (x, y) = only(state, GRIPPER)
    canvas.disc(x, y, RADIUS, RED, edge=BLACK, thickness=1)
    canvas.caption(caption.split("\n") if caption else [])
    return canvas.finish()
