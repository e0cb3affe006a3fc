"""The oracle skills of Coffee. Source: spec, coffee.md section 7."""

from collections.abc import Callable
from dataclasses import dataclass
from math import sqrt
from typing import TypeAlias

import numpy as np

from bpns.envs.coffee.tasks import MAX_START_ROTATION
from bpns.envs.coffee.world import (
    ANGLE_STEP,
    BUTTON,
    BUTTON_PRESSED,
    CUP,
    CUP_FILLED,
    DISPENSE_AREA,
    GRIPPER,
    HAND_EMPTY,
    IS_HOLDING,
    IS_TWISTING,
    MAX_TILT,
    NOT_ABOVE_CUP,
    ON_TABLE,
    PLATE,
    POSITION_STEP,
    POT,
    POT_ABOVE_CUP,
    POT_HEIGHT,
    POT_HOT,
    POT_ON_PLATE,
    PRESSING_BUTTON,
    ROBOT_ABOVE_CUP,
    ROTATION,
    TILT,
    WORLD,
    Point,
    clip,
    distance_across,
    handle_position,
    is_button_pressed,
    is_filled,
    is_hand_empty,
    is_holding,
    is_on_plate,
    is_twisting,
    only,
    position,
    pot_position,
    pour_position,
    squared_distance,
)
from bpns.symbolic.operators import Operator
from bpns.symbolic.skills.skill import Controller, NoSampler, Skill, Terminal
from bpns.symbolic.state import Array, State
from bpns.symbolic.structs import LiftedAtom, Object, Variable

Act: TypeAlias = Callable[[State, tuple[Object, ...], Array], Array]

CLOSE_ENOUGH = 0.1  # squared distance at which the oracle goes on to its next motion


def _move(target: Point, start: Point, dtilt: float = 0.0) -> Array:
    """Return the longest allowed action from start towards target."""
    x, y, z = target[0] - start[0], target[1] - start[1], target[2] - start[2]
    length = sqrt(x * x + y * y + z * z)
    if length > POSITION_STEP:
        x, y, z = (POSITION_STEP * (v / length) for v in (x, y, z))
    tilt = clip(dtilt, -ANGLE_STEP, ANGLE_STEP) / ANGLE_STEP
    return np.array([x / POSITION_STEP, y / POSITION_STEP, z / POSITION_STEP, tilt, 0, 0], np.float32)


def move_to_twist_pot(state: State, objects: tuple[Object, ...], _: Array) -> Array:
    """Go above the pot, then down to its top."""
    robot, pot = position(state[objects[0]]), position(state[objects[1]])
    return _move((pot[0], pot[1], POT_HEIGHT if distance_across(pot, robot) < CLOSE_ENOUGH else WORLD), robot)


def twist_pot(state: State, objects: tuple[Object, ...], subgoal: Array) -> Array:
    """Turn the pot to the subgoal (1: as far as a pot can stand at the start), then go up."""
    robot, pot = position(state[objects[0]]), state[objects[1]]
    left = float(subgoal[0]) * MAX_START_ROTATION - pot[ROTATION]
    turn = clip(left, -ANGLE_STEP, ANGLE_STEP)
    if abs(turn) < 0.1:
        return _move((robot[0], robot[1], WORLD), robot)
    return np.array([0, 0, 0, 0, turn / ANGLE_STEP, 0], np.float32)


def pick_pot(state: State, objects: tuple[Object, ...], _: Array) -> Array:
    """Go up, in front of the handle, down, to the handle, and close the fingers."""
    robot, (x, y, z) = position(state[objects[0]]), handle_position(state[objects[1]])
    if squared_distance((x, y, z), robot) < CLOSE_ENOUGH:
        return np.array([0, 0, 0, 0, 0, -1], np.float32)
    front = y - 1.5
    if y > robot[1] and (x - robot[0]) ** 2 + (z - robot[2]) ** 2 < CLOSE_ENOUGH:
        return _move((x, y, z), robot)
    if distance_across((x, front, z), robot) < CLOSE_ENOUGH:
        return _move((x, front, z), robot)
    if (WORLD - robot[2]) ** 2 < CLOSE_ENOUGH:
        return _move((x, front, WORLD), robot)
    return _move((robot[0], robot[1], WORLD), robot)


def place_pot_on_plate(state: State, objects: tuple[Object, ...], _: Array) -> Array:
    """Carry the pot to the plate and open the fingers."""
    pot = pot_position(state[objects[0]], state[objects[1]])
    if squared_distance(pot, DISPENSE_AREA) < CLOSE_ENOUGH:
        return np.array([0, 0, 0, 0, 0, 1], np.float32)
    if pot[2] > 0:
        return _move(DISPENSE_AREA, pot)
    return _move((pot[0], pot[1], pot[2] + POSITION_STEP), pot)  # lift it off the table first


def press_button(state: State, objects: tuple[Object, ...], _: Array) -> Array:
    """Go to the height of the button, then to the button."""
    robot = position(state[objects[0]])
    if (BUTTON[2] - robot[2]) ** 2 < 0.2**2:
        return _move(BUTTON, robot)
    return _move((robot[0], robot[1], BUTTON[2]), robot)


def pour(state: State, objects: tuple[Object, ...], _: Array) -> Array:
    """Carry the pot upright, high above everything, to the cup; down; tilt it."""
    robot = state[objects[0]]
    pot, goal = pot_position(robot, state[objects[1]]), pour_position(state[objects[2]])
    if squared_distance(pot, goal) < CLOSE_ENOUGH:
        return _move(pot, pot, MAX_TILT - robot[TILT])
    upright = 0.0 - robot[TILT]
    if distance_across(pot, goal) < CLOSE_ENOUGH:
        return _move(goal, pot, upright)
    if (robot[2] - WORLD) ** 2 < CLOSE_ENOUGH:
        return _move((goal[0], goal[1], pot[2]), pot, upright)
    return _move((robot[0], robot[1], WORLD), position(robot), upright)


@dataclass(frozen=True, slots=True)
class OraclePolicy:
    """Acts by a function of the state, the objects and the subgoal."""

    act: Act

    def begin(self, state: State, objects: tuple[Object, ...], subgoal: Array) -> Controller:
        """Fix the objects and the subgoal."""
        return lambda now: self.act(now, objects, subgoal)


@dataclass(frozen=True, slots=True)
class TwistSampler:
    """Any rotation, as a share of the largest at the start, in [-1, 1]."""

    dimension: int = 1

    def sample(self, state: State, objects: tuple[Object, ...], rng: np.random.Generator) -> Array:
        """Return a subgoal, (1,) float32."""
        return np.array([rng.uniform(-1, 1)], np.float32)


_R, _J, _M = Variable("?robot", GRIPPER), Variable("?pot", POT), Variable("?plate", PLATE)
_C, _O, _RJM = Variable("?cup", CUP), Variable("?other-cup", CUP), (_R, _J, _M)
_HOLDS, _TWISTS, _EMPTY = IS_HOLDING.lifted(_R, _J), IS_TWISTING.lifted(_R, _J), HAND_EMPTY.lifted(_R)
_STANDS, _ON_PLATE, _HOT = ON_TABLE.lifted(_J), POT_ON_PLATE.lifted(_J, _M), POT_HOT.lifted(_J)
_PRESSED, _PRESSES = BUTTON_PRESSED.lifted(_M), PRESSING_BUTTON.lifted(_R, _M)
_NOT_ABOVE, _READY = NOT_ABOVE_CUP.lifted(_R, _J), (_EMPTY, _ON_PLATE)
_POURED = (POT_ABOVE_CUP.lifted(_J, _C), ROBOT_ABOVE_CUP.lifted(_R, _C), CUP_FILLED.lifted(_C))
_OTHER = (POT_ABOVE_CUP.lifted(_J, _O), ROBOT_ABOVE_CUP.lifted(_R, _O))


def _placed(state: State, _: tuple[Object, ...]) -> bool:
    return is_on_plate(only(state, POT))


def _filled(state: State, objects: tuple[Object, ...]) -> bool:
    return is_filled(state[objects[2]])


Atoms: TypeAlias = tuple[LiftedAtom, ...]
# name, parameters; preconditions; add effects; delete effects; what to do until when
TABLE: tuple[tuple[str, tuple[Variable, ...], Atoms, Atoms, Atoms, Act, Terminal], ...] = (
    ("MoveToTwistPot", (_R, _J), (_STANDS, _EMPTY), (_TWISTS,), (_EMPTY,), move_to_twist_pot, is_twisting),
    ("TwistPot", (_R, _J), (_STANDS, _TWISTS), (_EMPTY,), (_TWISTS,), twist_pot, is_hand_empty),
    ("PickPotFromTable", (_R, _J), (_STANDS, _EMPTY), (_HOLDS,), (_STANDS, _EMPTY), pick_pot, is_holding),
    ("PlacePotOnPlate", _RJM, (_HOLDS,), (_EMPTY, _ON_PLATE), (_HOLDS,), place_pot_on_plate, _placed),
    ("TurnButtonPressed", _RJM, _READY, (_HOT, _PRESSED, _PRESSES), (), press_button, is_button_pressed),
    ("PickPotFromPlate", _RJM, (*_READY, _PRESSES), (_HOLDS,), (*_READY, _PRESSES), pick_pot, is_holding),
    ("PourFromNowhere", (_R, _J, _C), (_HOLDS, _HOT, _NOT_ABOVE), _POURED, (_NOT_ABOVE,), pour, _filled),
    ("PourFromOtherCup", (_R, _J, _C, _O), (_HOLDS, _HOT, *_OTHER), _POURED, _OTHER, pour, _filled),
)
ORACLE_SKILLS = tuple(
    Skill(
        Operator(name, parameters, frozenset(conditions), frozenset(add), frozenset(delete)),
        OraclePolicy(act),
        TwistSampler() if act is twist_pot else NoSampler(),
        terminal,
    )
    for name, parameters, conditions, add, delete, act, terminal in TABLE
)
