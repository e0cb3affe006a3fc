"""The oracle skills of Cover. Source: spec, cover.md section 7."""

from dataclasses import dataclass

import numpy as np

from bpns.envs.cover.world import (
    BLOCK,
    COVERS,
    GRIPPER,
    GRIPPER_X,
    GRIPPER_Y,
    HAND_EMPTY,
    HEIGHT,
    IS_BLOCK,
    IS_HOLDING,
    IS_TARGET,
    TARGET,
    TARGET_WIDTH,
    TARGET_X,
    TOP_Y,
    WIDTH,
    X,
    Y,
    is_hand_empty,
    is_holding,
)
from bpns.symbolic.operators import Operator
from bpns.symbolic.skills.skill import Controller, Skill
from bpns.symbolic.state import Array, State
from bpns.symbolic.structs import Object, Variable

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
    Skill(PICK, OraclePolicy(1, picks=True), PickSampler(), is_holding),
    Skill(PLACE, OraclePolicy(2, picks=False), PlaceSampler(), is_hand_empty),
)
