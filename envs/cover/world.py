"""Objects, predicates and the simulator of Cover. Source: spec, cover.md sections 2 to 4."""

from collections.abc import Mapping
from math import inf

from bpns.envs.actions import checked
from bpns.envs.shapes2d import Rectangle, rectangles_meet, segment_meets_rectangle
from bpns.symbolic.skills.environment import Classifier
from bpns.symbolic.state import Array, Features, State
from bpns.symbolic.structs import Object, Predicate, Type

BLOCK = Type("block", ("height", "width", "x", "y", "grasp"))  # x: center, y: top, grasp: -1 or 1
TARGET = Type("target", ("width", "x"))
GRIPPER = Type("gripper", ("x", "y", "grip", "holding"))
REGION = Type("allowed-region")
BLOCK_REGION = Type("block-region", ("lower-bound-x", "upper-bound-x"), REGION)  # relative to its block
TARGET_REGION = Type("target-region", ("lower-bound-x", "upper-bound-x"), REGION)  # absolute

HEIGHT, WIDTH, X, Y, GRASP = range(5)  # of a block
GRIPPER_X, GRIPPER_Y, GRIP, HOLDING = range(4)
TARGET_WIDTH, TARGET_X = range(2)

BLOCK_WIDTHS = (0.1, 0.07)
TARGET_WIDTHS = (0.05, 0.03)
BLOCK_HEIGHT = 0.1
FLOOR_Y, TOP_Y = 0.1, 0.4  # lowest and highest y of the gripper
SNAP = 0.01  # vertical distance within which the gripper snaps to a block's top, a block to the floor
REGION_SHARE = 0.4  # length of a hand region over the width of its block or target
MAX_TRIES = 100


COVERS = Predicate("Covers", (BLOCK, TARGET))
HAND_EMPTY = Predicate("HandEmpty", ())
IS_HOLDING = Predicate("Holding", (BLOCK, GRIPPER))
IS_BLOCK = Predicate("IsBlock", (BLOCK,))
IS_TARGET = Predicate("IsTarget", (TARGET,))


def features_of(state: State, type_: Type) -> list[tuple[str, Features]]:
    """Return names and features of the objects of a type, in canonical order."""
    return [(o.name, state.features[o.name]) for o in state.by_type.get(type_.name, ())]


def _block_covers(block: Features, target: Features) -> bool:
    half, target_half = block[WIDTH] / 2, target[TARGET_WIDTH] / 2
    return (
        block[X] - half <= target[TARGET_X] - target_half
        and block[X] + half >= target[TARGET_X] + target_half
        and block[Y] - block[HEIGHT] == 0
    )


def _covers(state: State, objects: tuple[Object, ...]) -> bool:
    block, target = objects
    return _block_covers(state[block], state[target])


def is_hand_empty(state: State, _: tuple[Object, ...]) -> bool:
    """Say whether no block is grasped."""
    return all(state.features[b.name][GRASP] == -1 for b in state.by_type[BLOCK.name])


def is_holding(state: State, objects: tuple[Object, ...]) -> bool:
    """Say whether the gripper (the second object) holds the block."""
    block, gripper = objects
    return state[block][GRASP] != -1 and state[gripper][HOLDING] != -1


def _always(_: State, __: tuple[Object, ...]) -> bool:
    return True


CLASSIFIERS: Mapping[Predicate, Classifier] = {
    COVERS: _covers,
    HAND_EMPTY: is_hand_empty,
    IS_HOLDING: is_holding,
    IS_BLOCK: _always,
    IS_TARGET: _always,
}


def simulate(state: State, action: Array) -> State:
    """Return the next state. Source: spec, cover.md section 4; the comments count its rules."""
    dx, dy, grip = checked(action, (inf, inf, 1), "dx, dy, grip in [-1, 1]")
    ((robot_name, robot),) = features_of(state, GRIPPER)
    blocks = features_of(state, BLOCK)
    x, y = robot[GRIPPER_X], robot[GRIPPER_Y]
    held_name, held = next((b for b in blocks if b[1][GRASP] != -1), ("", None))
    raw_dy = dy
    if y + dy < FLOOR_Y:  # 2
        dy = FLOOR_Y - y
    if y + dy > TOP_Y:  # 3
        dy = TOP_Y - y
    at_floor = False
    candidate_name, candidate = "", None
    if held is not None and dy < 0:  # 4
        bottom = held[Y] - held[HEIGHT]
        if bottom + dy < 0 or abs(bottom + dy - 0) < SNAP:
            dy = 0 - bottom
            at_floor = True
    elif dy < 0:  # 5
        for name, block in blocks:
            half = block[WIDTH] / 2
            if block[X] - half <= x <= block[X] + half and abs(y + dy - block[Y]) < SNAP:
                candidate_name, candidate = name, block
                dy = block[Y] - y
                break
    if held is not None:  # 1 and 6
        others = [block for name, block in blocks if name != held_name]
        if _sweep_collides(held, others, dx, raw_dy):
            return state
    x, y = x + dx, y + dy  # 7
    grip = min(max(grip, -1.0), 1.0)
    changes: dict[str, Features] = {robot_name: (x, y, grip, robot[HOLDING])}
    if held is not None:
        held = (held[HEIGHT], held[WIDTH], held[X] + dx, held[Y] + dy, held[GRASP])
        changes[held_name] = held
    if candidate is not None and grip > 0:  # 8
        regions = zip(blocks, features_of(state, BLOCK_REGION), strict=False)
        if any(b[X] + low <= x <= b[X] + high for (_, b), (_, (low, high)) in regions):
            changes[candidate_name] = (*candidate[:GRASP], 1.0)
            changes[robot_name] = (x, y, grip, 1.0)
    if held is not None and candidate is None and grip < 0 and at_floor:  # 9
        placed = (held[HEIGHT], held[WIDTH], held[X], FLOOR_Y, -1.0)
        if any(_block_covers(placed, target) for _, target in features_of(state, TARGET)) and not any(
            low <= x <= high for _, (low, high) in features_of(state, TARGET_REGION)
        ):
            return state
        changes[held_name] = placed
        changes[robot_name] = (x, y, grip, -1.0)
    return state.changed(changes)


def _sweep_collides(held: Features, others: list[Features], dx: float, dy: float) -> bool:
    """Say whether the held block, moved by the unclamped action, would hit another block."""
    left, bottom = held[X] - held[WIDTH] / 2, held[Y] - held[HEIGHT]
    low_x, high_x = left + min(dx, 0), left + max(dx, 0) + held[WIDTH]
    low_y, high_y = bottom + min(dy, 0), bottom + max(dy, 0) + held[HEIGHT]
    near = [
        other
        for other in others  # the margin keeps this filter from deciding any close case
        if low_x - SNAP <= other[X] + other[WIDTH] / 2
        and other[X] - other[WIDTH] / 2 <= high_x + SNAP
        and low_y - SNAP <= other[Y]
        and other[Y] - other[HEIGHT] <= high_y + SNAP
    ]
    if not near:
        return False
    before = Rectangle(left, bottom, held[WIDTH], held[HEIGHT])
    after = Rectangle(left + dx, bottom + dy, held[WIDTH], held[HEIGHT])
    motions = list(zip(before.vertices(), after.vertices(), strict=True))
    for other in near:
        obstacle = Rectangle(
            other[X] - other[WIDTH] / 2, other[Y] - other[HEIGHT], other[WIDTH], other[HEIGHT]
        )
        if rectangles_meet(obstacle, after) or any(
            segment_meets_rectangle(a, b, obstacle) for a, b in motions
        ):
            return True
    return False
