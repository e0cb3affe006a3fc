"""The oracle skills of Stick Button. Source: spec, stick_button.md section 7."""

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, pi, sin
from typing import TypeAlias

import numpy as np

from bpns.envs.shapes2d import rectangle_meets_circle
from bpns.envs.stick_button.world import (
    ABOVE_NO_BUTTON,
    BUTTON,
    COS,
    FLAG,
    GRASPED,
    GRIPPER,
    HAND_EMPTY,
    PRESSED,
    ROBOT_ABOVE_BUTTON,
    SIN,
    STEP,
    STICK,
    STICK_ABOVE_BUTTON,
    STICK_LENGTH,
    STICK_THICKNESS,
    UPRIGHT,
    X,
    Y,
    disc_shape,
    is_grasped,
    robot_above,
    tip_shape,
)
from bpns.symbolic.operators import Operator
from bpns.symbolic.skills.skill import Controller, NoSampler, Skill, Terminal
from bpns.symbolic.state import Array, State
from bpns.symbolic.structs import LiftedAtom, Object, Variable

GRASP_TOLERANCE = 0.001  # squared distance at which the oracle closes its hand

_R, _S = Variable("?robot", GRIPPER), Variable("?stick", STICK)
_B, _F = Variable("?button", BUTTON), Variable("?from", BUTTON)

Act: TypeAlias = Callable[[State, tuple[Object, ...], float], Array]  # parameter: where to grasp
PRESS = np.array([0, 0, 1], np.float32)


def _towards(target: tuple[float, float], x: float, y: float) -> Array:
    """Return the action that moves a point at (x, y) towards a target."""
    steps = (min(max(t - p, -STEP), STEP) / STEP for t, p in zip(target, (x, y), strict=True))
    return np.array([*steps, -1], np.float32)


def _press_by_hand(state: State, objects: tuple[Object, ...], _: float) -> Array:
    robot, button = state[objects[0]], state[objects[1]]
    if robot_above(robot, button):
        return PRESS
    return _towards((button[X], button[Y]), *robot)


def _pick(state: State, objects: tuple[Object, ...], share: float) -> Array:
    (x, y), stick = state[objects[0]], state[objects[1]]
    middle, along = STICK_THICKNESS / 2, STICK_LENGTH * share
    grasp_x = stick[X] + middle * cos(UPRIGHT + pi / 2) + along * COS
    grasp_y = stick[Y] + middle * sin(UPRIGHT + pi / 2) + along * SIN
    if (x - grasp_x) ** 2 + (y - grasp_y) ** 2 < GRASP_TOLERANCE:
        return PRESS
    return _towards((grasp_x, grasp_y), x, y)


def _press_by_stick(state: State, objects: tuple[Object, ...], _: float) -> Array:
    stick, button = state[objects[1]], state[objects[2]]
    tip = tip_shape(stick[X], stick[Y])
    if rectangle_meets_circle(tip, disc_shape(button)):
        return PRESS
    return _towards((button[X], button[Y]), tip.x, tip.y)


@dataclass(frozen=True, slots=True)
class OraclePolicy:
    """One rule for every state."""

    act: Act

    def begin(self, state: State, objects: tuple[Object, ...], subgoal: Array) -> Controller:
        """Remember where along the stick to grasp it, if that is a question."""
        share = float(subgoal[0]) if len(subgoal) else 0.0
        return lambda now: self.act(now, objects, share)


@dataclass(frozen=True, slots=True)
class GraspSampler:
    """Anywhere along the stick: 0 is its lower end, 1 its tip."""

    dimension: int = 1

    def sample(self, state: State, objects: tuple[Object, ...], rng: np.random.Generator) -> Array:
        """Return a subgoal, (1,) float32."""
        return np.array([rng.uniform()], np.float32)


def _third_is_pressed(state: State, objects: tuple[Object, ...]) -> bool:
    return state[objects[2]][FLAG] > 0.5


def _second_is_pressed(state: State, objects: tuple[Object, ...]) -> bool:
    return state[objects[1]][FLAG] > 0.5


_EMPTY, _GRASPED, _NOTHING = HAND_EMPTY.lifted(_R), GRASPED.lifted(_R, _S), ABOVE_NO_BUTTON.lifted()
_ABOVE, _ABOVE_OTHER = ROBOT_ABOVE_BUTTON.lifted(_R, _B), ROBOT_ABOVE_BUTTON.lifted(_R, _F)
_STICK, _STICK_OTHER = STICK_ABOVE_BUTTON.lifted(_S, _B), STICK_ABOVE_BUTTON.lifted(_S, _F)
_PRESSED = PRESSED.lifted(_B)

Atoms: TypeAlias = tuple[LiftedAtom, ...]
# name, parameters; preconditions; add effects; delete effects; what to do until when
TABLE: tuple[tuple[str, tuple[Variable, ...], Atoms, Atoms, Atoms, Act, Terminal], ...] = (
    (
        "RobotPressButtonFromNothing",
        (_R, _B),
        (_EMPTY, _NOTHING),
        (_PRESSED, _ABOVE),
        (_NOTHING,),
        _press_by_hand,
        _second_is_pressed,
    ),
    (
        "RobotPressButtonFromButton",
        (_R, _B, _F),
        (_EMPTY, _ABOVE_OTHER),
        (_PRESSED, _ABOVE),
        (_ABOVE_OTHER,),
        _press_by_hand,
        _second_is_pressed,
    ),
    ("PickStickFromNothing", (_R, _S), (_EMPTY, _NOTHING), (_GRASPED,), (_EMPTY,), _pick, is_grasped),
    (
        "PickStickFromButton",
        (_R, _S, _F),
        (_EMPTY, _ABOVE_OTHER),
        (_GRASPED, _NOTHING),
        (_EMPTY, _ABOVE_OTHER),
        _pick,
        is_grasped,
    ),
    (
        "StickPressButtonFromNothing",
        (_R, _S, _B),
        (_GRASPED, _NOTHING),
        (_STICK, _PRESSED),
        (_NOTHING,),
        _press_by_stick,
        _third_is_pressed,
    ),
    (
        "StickPressButtonFromButton",
        (_R, _S, _B, _F),
        (_GRASPED, _STICK_OTHER),
        (_STICK, _PRESSED),
        (_STICK_OTHER,),
        _press_by_stick,
        _third_is_pressed,
    ),
)
ORACLE_SKILLS = tuple(
    Skill(
        Operator(name, parameters, frozenset(needs), frozenset(adds), frozenset(deletes)),
        OraclePolicy(act),
        GraspSampler() if act is _pick else NoSampler(),
        terminal,
    )
    for name, parameters, needs, adds, deletes, act, terminal in TABLE
)
