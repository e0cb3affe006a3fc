"""Pictures of Cover. Source: spec, cover.md section 10."""

from PIL.Image import Image

from bpns.envs.canvas import Canvas, Color
from bpns.envs.cover.world import (
    BLOCK,
    BLOCK_HEIGHT,
    BLOCK_REGION,
    GRASP,
    GRIP,
    GRIPPER,
    GRIPPER_X,
    GRIPPER_Y,
    HEIGHT,
    TARGET,
    TARGET_REGION,
    TARGET_WIDTH,
    TARGET_X,
    WIDTH,
    X,
    Y,
    features_of,
)
from bpns.symbolic.state import State

COLORS: tuple[Color, ...] = ((31, 119, 180), (148, 103, 189), (44, 160, 44), (230, 190, 40))
RED: Color = (214, 39, 40)
GRAY: Color = (110, 110, 110)


def draw(state: State, caption: str = "") -> Image:
    """Return a picture: floor, targets, blocks, hand regions, gripper. Source: spec, cover.md section 10."""
    canvas = Canvas.blank(-0.2, 1.2, -0.25, 1.0, width=640)
    canvas.line((-0.2, -0.003), (1.2, -0.003), (0, 0, 0), 1)
    blocks = features_of(state, BLOCK)
    for i, (name, target) in enumerate(features_of(state, TARGET)):
        left = target[TARGET_X] - target[TARGET_WIDTH] / 2
        canvas.rectangle(left, 0, target[TARGET_WIDTH], BLOCK_HEIGHT, COLORS[i % 4], opacity=0.25)
        canvas.text(target[TARGET_X], -0.17, name, 11)
    for i, (name, block) in enumerate(blocks):
        held = block[GRASP] != -1
        left, bottom = block[X] - block[WIDTH] / 2, block[Y] - block[HEIGHT]
        edge = RED if held else GRAY
        canvas.rectangle(left, bottom, block[WIDTH], block[HEIGHT], COLORS[i % 4], 0.75, edge)
        label = f"{name} (grasped)" if held else name
        if held:
            canvas.text(left + block[WIDTH] + 0.015, bottom + block[HEIGHT] / 2, label, 11, anchor="lm")
        else:
            canvas.text(block[X], -0.12, label, 11)
    for _, target in features_of(state, TARGET):  # outlined again, to be seen on the block that covers it
        left = target[TARGET_X] - target[TARGET_WIDTH] / 2
        canvas.rectangle(
            left, 0, target[TARGET_WIDTH], BLOCK_HEIGHT, GRAY, opacity=0.0, edge=GRAY, thickness=1
        )
    region_y = -0.08
    bars = [
        (b[X] + low, b[X] + high)
        for (_, b), (_, (low, high)) in zip(blocks, features_of(state, BLOCK_REGION), strict=False)
    ]
    bars += [(low, high) for _, (low, high) in features_of(state, TARGET_REGION)]
    for low, high in bars:
        canvas.rectangle(low, region_y, high - low, 0.025, RED, opacity=0.5)
    canvas.rectangle(-0.17, -0.235, 0.06, 0.025, RED, opacity=0.5)
    canvas.text(-0.09, -0.222, "allowed hand region", 11, anchor="lm")
    ((_, robot),) = features_of(state, GRIPPER)
    canvas.line((robot[GRIPPER_X], 1.0), (robot[GRIPPER_X], robot[GRIPPER_Y]), RED, 2)
    canvas.disc(robot[GRIPPER_X], robot[GRIPPER_Y], 0.013125, RED)  # 6 pixels
    canvas.text(1.18, 0.96, f"grip {robot[GRIP]:.3f}", 12, anchor="rm")
    canvas.caption(caption.split("\n") if caption else [])
    return canvas.finish()
