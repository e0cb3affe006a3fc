"""Coffee: a gripper heats a pot on a plate and pours into cups. Source: spec, coffee.md."""

from collections.abc import Callable
from dataclasses import dataclass
from math import pi, sqrt
from typing import TypeAlias

import numpy as np
from PIL.Image import Image

from bpns.envs.coffee.drawing import draw
from bpns.envs.coffee.world import (
    ANGLE_STEP,
    BUTTON,
    BUTTON_PRESSED,
    CLASSIFIERS,
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
    OPEN,
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
    X,
    Y,
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
    simulate,
    squared_distance,
)
from bpns.symbolic.skills.environment import Budget, Split
from bpns.symbolic.skills.skill import Controller, NoSampler, Skill, Terminal
from bpns.symbolic.state import Array, Features, State, Task
from bpns.symbolic.structs import GroundAtom, LiftedAtom, Object, Operator, Variable

Act: TypeAlias = Callable[[State, tuple[Object, ...], Array], Array]


START: Features = (5.0, 5.0, WORLD, 0.0, 0.0, OPEN)  # of the gripper
MAX_START_ROTATION = 2 * pi / 3
POT_BOX, CUP_BOX = ((8.0, 9.0), (2.4, 4.6)), ((0.74, 6.76), (2.4, 4.6))  # bounds of x, of y
CUP_SPACING = 2 * 0.74
CAPACITIES, TARGET_SHARE = (0.75, 1.5), 0.75
TRIES_PER_CUP = 10
SETS_PER_SPACING, SHRINKING = 100, 0.95

# ---------------------------------------------------------------------------------- oracle policies

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

# -------------------------------------------------------------------------------------------- tasks


def _sample_set(count: int, spacing: float, rng: np.random.Generator) -> list[Features]:
    """Draw places and capacities; the list ends early where a cup finds no place."""
    cups: list[Features] = []
    for _ in range(count):
        for _ in range(TRIES_PER_CUP):
            x, y = (rng.uniform(low, high) for low, high in CUP_BOX)
            if all((x - c[X]) ** 2 + (y - c[Y]) ** 2 >= spacing**2 for c in cups):
                capacity = rng.uniform(*CAPACITIES)
                cups.append((x, y, capacity, TARGET_SHARE * capacity, 0.0))
                break
        else:
            break
    return cups


def _sample_cups(count: int, rng: np.random.Generator) -> list[Features]:
    """Draw sets of cups until one is complete, with less spacing whenever many sets were not.

    The paper has one spacing and up to 3 cups; of more than 6 hardly any set would ever be complete.
    """
    spacing = CUP_SPACING
    while True:
        for _ in range(SETS_PER_SPACING):
            if len(cups := _sample_set(count, spacing, rng)) == count:
                return cups
        spacing *= SHRINKING


@dataclass(frozen=True, slots=True)
class Coffee:
    """The environment; the options are how many cups there can be, each number as likely as the others."""

    train_cups: tuple[int, ...] = (1, 2)
    test_cups: tuple[int, ...] = (2, 3)

    name = "coffee"
    types = (GRIPPER, POT, PLATE, CUP)
    classifiers = CLASSIFIERS
    goal_predicates = frozenset({CUP_FILLED})
    contact_predicates = frozenset({IS_HOLDING, HAND_EMPTY, BUTTON_PRESSED, CUP_FILLED})
    oracle_skills = ORACLE_SKILLS
    given_skills = ()
    action_low = np.full(6, -1, np.float32)
    action_high = np.full(6, 1, np.float32)
    horizon = 1000
    rollout_limit = 1000
    budget = Budget(abstract_plans=1000, samples_per_step=10, samples_per_plan=100)

    def __post_init__(self) -> None:
        if not all(counts and min(counts) >= 1 for counts in (self.train_cups, self.test_cups)):
            raise ValueError("train_cups and test_cups are one or more numbers above 0")

    def simulate(self, state: State, action: Array) -> State:
        """Return the next state; the action is (dx, dy, dz, dtilt, dwrist, dfingers), each in [-1, 1]."""
        return simulate(state, action)

    def sample_task(self, split: Split, index: int, rng: np.random.Generator) -> Task:
        """Draw a task: fill all cups. Source: spec, coffee.md section 6."""
        count = int(rng.choice(self.train_cups if split == "train" else self.test_cups))
        cups = {Object(f"cup{i}", CUP): cup for i, cup in enumerate(_sample_cups(count, rng))}
        x, y = (rng.uniform(low, high) for low, high in POT_BOX)
        rotation = rng.uniform(-MAX_START_ROTATION, MAX_START_ROTATION)
        features: dict[Object, Features] = {
            **cups,
            Object("robby", GRIPPER): START,
            Object("pot", POT): (x, y, rotation, 0.0, 0.0),
            Object("plate", PLATE): (0.0,),
        }
        return Task(State.of(features), frozenset(CUP_FILLED(cup) for cup in cups))

    def draw(self, state: State, caption: str = "", goal: frozenset[GroundAtom] = frozenset()) -> Image:
        """Return a picture of a state; the goal is not marked."""
        return draw(state, caption)


ENVIRONMENT = Coffee()
