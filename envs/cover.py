"""Cover: a gripper over a line picks blocks and puts them on targets. Source: spec, cover.md."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from math import inf

import numpy as np
from PIL.Image import Image

from bpns.envs.actions import checked
from bpns.envs.canvas import Canvas, Color
from bpns.envs.shapes2d import Rectangle, rectangles_meet, segment_meets_rectangle
from bpns.symbolic.skills.environment import Budget, Classifier, Split
from bpns.symbolic.skills.skill import Controller, Skill
from bpns.symbolic.state import Array, Features, State, Task
from bpns.symbolic.structs import GroundAtom, Object, Operator, Predicate, Type, Variable

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

# --------------------------------------------------------------------------------------- predicates

COVERS = Predicate("Covers", (BLOCK, TARGET))
HAND_EMPTY = Predicate("HandEmpty", ())
IS_HOLDING = Predicate("Holding", (BLOCK, GRIPPER))
IS_BLOCK = Predicate("IsBlock", (BLOCK,))
IS_TARGET = Predicate("IsTarget", (TARGET,))


def _features(state: State, type_: Type) -> list[tuple[str, Features]]:
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


def _hand_empty(state: State, _: tuple[Object, ...]) -> bool:
    return all(state.features[b.name][GRASP] == -1 for b in state.by_type[BLOCK.name])


def _holding(state: State, objects: tuple[Object, ...]) -> bool:
    block, gripper = objects
    return state[block][GRASP] != -1 and state[gripper][HOLDING] != -1


def _always(_: State, __: tuple[Object, ...]) -> bool:
    return True


CLASSIFIERS: Mapping[Predicate, Classifier] = {
    COVERS: _covers,
    HAND_EMPTY: _hand_empty,
    IS_HOLDING: _holding,
    IS_BLOCK: _always,
    IS_TARGET: _always,
}

# --------------------------------------------------------------------------------------- transition


def simulate(state: State, action: Array) -> State:
    """Return the next state. Source: spec, cover.md section 4; the comments count its rules."""
    dx, dy, grip = checked(action, (inf, inf, 1), "dx, dy, grip in [-1, 1]")
    ((robot_name, robot),) = _features(state, GRIPPER)
    blocks = _features(state, BLOCK)
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
        regions = zip(blocks, _features(state, BLOCK_REGION), strict=False)
        if any(b[X] + low <= x <= b[X] + high for (_, b), (_, (low, high)) in regions):
            changes[candidate_name] = (*candidate[:GRASP], 1.0)
            changes[robot_name] = (x, y, grip, 1.0)
    if held is not None and candidate is None and grip < 0 and at_floor:  # 9
        placed = (held[HEIGHT], held[WIDTH], held[X], FLOOR_Y, -1.0)
        if any(_block_covers(placed, target) for _, target in _features(state, TARGET)) and not any(
            low <= x <= high for _, (low, high) in _features(state, TARGET_REGION)
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


# --------------------------------------------------------------------------------- oracle skills

_B, _R, _T = Variable("?block", BLOCK), Variable("?gripper", GRIPPER), Variable("?target", TARGET)
PICK = Operator(
    "Pick",
    (_B, _R),
    frozenset({IS_BLOCK.lifted(_B), HAND_EMPTY.lifted()}),
    frozenset({IS_HOLDING.lifted(_B, _R)}),
    frozenset({HAND_EMPTY.lifted()}),
)
PLACE = Operator(
    "Place",
    (_B, _R, _T),
    frozenset({IS_BLOCK.lifted(_B), IS_TARGET.lifted(_T), IS_HOLDING.lifted(_B, _R)}),
    frozenset({HAND_EMPTY.lifted(), COVERS.lifted(_B, _T)}),
    frozenset({IS_HOLDING.lifted(_B, _R)}),
)


@dataclass(frozen=True, slots=True)
class PickSampler:
    """Anywhere on the block. The subgoal changes block.grasp and the gripper's x, y, grip, holding."""

    dimension: int = 5

    def sample(self, state: State, objects: tuple[Object, ...], rng: np.random.Generator) -> Array:
        """Return a subgoal, (5,) float32."""
        block, robot = state[objects[0]], state[objects[1]]
        x = rng.uniform(block[X] - block[WIDTH] / 2, block[X] + block[WIDTH] / 2)
        return np.array([2, x - robot[GRIPPER_X], block[Y] - robot[GRIPPER_Y], 2, 2], np.float32)


@dataclass(frozen=True, slots=True)
class PlaceSampler:
    """Anywhere on the target. The subgoal changes block.x, block.grasp and the gripper's x, grip, holding."""

    dimension: int = 5

    def sample(self, state: State, objects: tuple[Object, ...], rng: np.random.Generator) -> Array:
        """Return a subgoal, (5,) float32."""
        robot, target = state[objects[1]], state[objects[2]]
        half = target[TARGET_WIDTH] / 2
        distance = rng.uniform(target[TARGET_X] - half, target[TARGET_X] + half) - robot[GRIPPER_X]
        return np.array([distance, -2, distance, -2, -2], np.float32)


@dataclass(frozen=True, slots=True)
class OraclePolicy:
    """Up, across, down; closes on the block's top (pick) or opens when the block stands (place)."""

    x_entry: int  # entry of the subgoal that moves the gripper in x
    picks: bool

    def begin(self, state: State, objects: tuple[Object, ...], subgoal: Array) -> Controller:
        """Remember the absolute x to go to."""
        block, robot = objects[0], objects[1]
        goal_x = state[robot][GRIPPER_X] + float(subgoal[self.x_entry])

        def act(now: State) -> Array:
            x, y = now[robot][GRIPPER_X], now[robot][GRIPPER_Y]
            if abs(goal_x - x) < 1e-5:
                height = now[block][Y] if self.picks else now[block][HEIGHT]
                return np.array([0, height + 0.001 - y, 1 if self.picks else -1], np.float32)
            if y >= TOP_Y:
                return np.array([goal_x - x, 0, 1], np.float32)
            return np.array([0, TOP_Y + 0.01 - y, 1], np.float32)

        return act


ORACLE_SKILLS = (
    Skill(PICK, OraclePolicy(1, picks=True), PickSampler(), _holding),
    Skill(PLACE, OraclePolicy(2, picks=False), PlaceSampler(), _hand_empty),
)

# -------------------------------------------------------------------------------------------- tasks


def _sample_positions(rng: np.random.Generator) -> tuple[list[float], list[float]]:
    """Draw block and target centers that leave room for every covering placement."""
    for _ in range(MAX_TRIES):
        blocks = [rng.uniform(w / 2, 1 - w / 2) for w in BLOCK_WIDTHS]
        targets = []
        spans = []
        for width, target in zip(BLOCK_WIDTHS, TARGET_WIDTHS, strict=True):
            x = rng.uniform(width - target / 2, 1 - width + target / 2)
            targets.append(x)
            spans.append((x + target / 2 - width, x - target / 2 + width))
        spans += [(x - w / 2, x + w / 2) for x, w in zip(blocks, BLOCK_WIDTHS, strict=True)]
        spans.sort(key=lambda span: span[0])
        if all(right[0] >= left[1] for left, right in pairwise(spans)):
            return blocks, targets
    raise RuntimeError(f"no free places for blocks and targets in {MAX_TRIES} tries")


def _sample_block_region(
    rng: np.random.Generator, block: tuple[float, float], target: tuple[float, float], region: Features
) -> Features:
    """Draw a block's hand region from which its target's region can be reached; arguments are (x, width)."""
    x, width = block
    left_edge, right_edge = x - width / 2, x + width / 2
    length = REGION_SHARE * width
    for _ in range(MAX_TRIES):
        left = rng.uniform(left_edge, right_edge - length)
        right = left + length
        if right_edge - left >= target[0] + target[1] / 2 - region[1] and right - left_edge >= region[0] - (
            target[0] - target[1] / 2
        ):
            return (left - x, right - x)
    raise RuntimeError(f"no hand region for a block in {MAX_TRIES} tries")


@dataclass(frozen=True, slots=True)
class Cover:
    """The environment; the options are those of the paper's supplementary experiments."""

    train_irrelevant_blocks: int = 0  # tiny ones, far away
    test_irrelevant_blocks: int = 0

    name = "cover"
    types = (BLOCK, TARGET, GRIPPER, BLOCK_REGION, TARGET_REGION)
    classifiers = CLASSIFIERS
    goal_predicates = frozenset({COVERS})
    contact_predicates = frozenset({COVERS, HAND_EMPTY, IS_HOLDING})
    oracle_skills = ORACLE_SKILLS
    given_skills = ()
    action_low = np.array([-np.inf, -np.inf, -1], np.float32)
    action_high = np.array([np.inf, np.inf, 1], np.float32)
    horizon = 100
    rollout_limit = 1000
    budget = Budget(abstract_plans=8, samples_per_step=10)

    def simulate(self, state: State, action: Array) -> State:
        """Return the next state; the action is (dx, dy, grip)."""
        return simulate(state, action)

    def sample_task(self, split: Split, index: int, rng: np.random.Generator) -> Task:
        """Draw a task; the goals take turns. Source: spec, cover.md section 6."""
        blocks, targets = _sample_positions(rng)
        features: dict[Object, Features] = {Object("robby", GRIPPER): (0.0, TOP_Y, -1.0, -1.0)}
        regions = []
        for i, (x, width) in enumerate(zip(targets, TARGET_WIDTHS, strict=True)):
            length = REGION_SHARE * width
            left = rng.uniform(x - width / 2, x + width / 2 - length)
            regions.append((left, left + length))
            features[Object(f"target{i}", TARGET)] = (width, x)
            features[Object(f"target{i}-region", TARGET_REGION)] = regions[i]
        for i, (x, width) in enumerate(zip(blocks, BLOCK_WIDTHS, strict=True)):
            target = (targets[i], TARGET_WIDTHS[i])
            features[Object(f"block{i}-region", BLOCK_REGION)] = _sample_block_region(
                rng, (x, width), target, regions[i]
            )
            features[Object(f"block{i}", BLOCK)] = (BLOCK_HEIGHT, width, x, BLOCK_HEIGHT, -1.0)
        for i in range(self.train_irrelevant_blocks if split == "train" else self.test_irrelevant_blocks):
            far = (BLOCK_HEIGHT, 0.001, -100.0, BLOCK_HEIGHT, -1.0)
            features[Object(f"irrelevant-block{i}", BLOCK)] = far
        pairs = [COVERS(Object(f"block{i}", BLOCK), Object(f"target{i}", TARGET)) for i in range(2)]
        goals = ({pairs[0]}, {pairs[1]}, set(pairs))
        return Task(State.of(features), frozenset(goals[index % 3]))

    def draw(self, state: State, caption: str = "", goal: frozenset[GroundAtom] = frozenset()) -> Image:
        """Return a picture of a state; the goal is not marked."""
        return draw(state, caption)


ENVIRONMENT = Cover()

# ------------------------------------------------------------------------------------------ drawing

COLORS: tuple[Color, ...] = ((31, 119, 180), (148, 103, 189), (44, 160, 44), (230, 190, 40))
RED: Color = (214, 39, 40)
GRAY: Color = (110, 110, 110)


def draw(state: State, caption: str = "") -> Image:
    """Return a picture: floor, targets, blocks, hand regions, gripper. Source: spec, cover.md section 10."""
    canvas = Canvas.blank(-0.2, 1.2, -0.25, 1.0, width=640)
    canvas.line((-0.2, -0.003), (1.2, -0.003), (0, 0, 0), 1)
    blocks = _features(state, BLOCK)
    for i, (name, target) in enumerate(_features(state, TARGET)):
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
    for _, target in _features(state, TARGET):  # outlined again, to be seen on the block that covers it
        left = target[TARGET_X] - target[TARGET_WIDTH] / 2
        canvas.rectangle(
            left, 0, target[TARGET_WIDTH], BLOCK_HEIGHT, GRAY, opacity=0.0, edge=GRAY, thickness=1
        )
    region_y = -0.08
    bars = [
        (b[X] + low, b[X] + high)
        for (_, b), (_, (low, high)) in zip(blocks, _features(state, BLOCK_REGION), strict=False)
    ]
    bars += [(low, high) for _, (low, high) in _features(state, TARGET_REGION)]
    for low, high in bars:
        canvas.rectangle(low, region_y, high - low, 0.025, RED, opacity=0.5)
    canvas.rectangle(-0.17, -0.235, 0.06, 0.025, RED, opacity=0.5)
    canvas.text(-0.09, -0.222, "allowed hand region", 11, anchor="lm")
    ((_, robot),) = _features(state, GRIPPER)
    canvas.line((robot[GRIPPER_X], 1.0), (robot[GRIPPER_X], robot[GRIPPER_Y]), RED, 2)
    canvas.disc(robot[GRIPPER_X], robot[GRIPPER_Y], 0.013125, RED)  # 6 pixels
    canvas.text(1.18, 0.96, f"grip {robot[GRIP]:.3f}", 12, anchor="rm")
    canvas.caption(caption.split("\n") if caption else [])
    return canvas.finish()
