"""Pictures of Doors. Source: spec, doors.md section 9."""

from PIL.Image import Image

from bpns.envs.canvas import Canvas, Color
from bpns.envs.doors.world import (
    DOOR,
    IS_OPEN,
    OBSTACLE,
    RADIUS,
    ROBOT,
    ROOM,
    ROOM_SIZE,
    door_shape,
    room_holds,
    room_shape,
)
from bpns.envs.shapes2d import Rectangle
from bpns.symbolic.state import State
from bpns.symbolic.structs import GroundAtom

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
