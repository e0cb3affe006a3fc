"""Stick Button: a robot presses buttons by hand, or with a stick where its hand cannot go.

Source: spec, stick_button.md.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from math import cos, pi, sin
from typing import TypeAlias

import numpy as np
from PIL.Image import Image

from bpns.envs.canvas import Canvas, Color
from bpns.envs.shapes2d import Circle, Rectangle, circles_meet, rectangle_meets_circle
from bpns.envs.stick_button.world import (
    ABOVE_NO_BUTTON,
    BUTTON,
    CLASSIFIERS,
    COS,
    FLAG,
    GRASPED,
    GRIPPER,
    HAND_EMPTY,
    HOLDER,
    HOLDER_LENGTH,
    HOLDER_THICKNESS,
    PRESSED,
    RADIUS,
    ROBOT_ABOVE_BUTTON,
    SIN,
    STEP,
    STICK,
    STICK_ABOVE_BUTTON,
    STICK_LENGTH,
    STICK_THICKNESS,
    UPRIGHT,
    WORLD_X,
    WORLD_Y,
    ZONE_Y,
    X,
    Y,
    disc_shape,
    is_grasped,
    only,
    robot_above,
    simulate,
    stick_shape,
    tip_shape,
)
from bpns.symbolic.errors import InputError
from bpns.symbolic.skills.environment import Budget, Split
from bpns.symbolic.skills.skill import Controller, NoSampler, Skill
from bpns.symbolic.state import Array, Features, State, Task
from bpns.symbolic.structs import GroundAtom, Object, Operator, Variable

SPACING = 0.5  # around everything at the start
STICK_START_Y = 1.6  # highest
MAX_TRIES = 10_000  # to find a place; with the paper's numbers of buttons a few are enough
GRASP_TOLERANCE = 0.001  # squared distance at which the oracle closes its hand

# --------------------------------------------------------------------------------- oracle skills

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


def _oracle_skills() -> tuple[Skill, ...]:
    """Return the oracle's skills. Source: spec, stick_button.md section 7."""
    empty, grasped, nothing = HAND_EMPTY.lifted(_R), GRASPED.lifted(_R, _S), ABOVE_NO_BUTTON.lifted()
    above, above_other = ROBOT_ABOVE_BUTTON.lifted(_R, _B), ROBOT_ABOVE_BUTTON.lifted(_R, _F)
    stick, stick_other = STICK_ABOVE_BUTTON.lifted(_S, _B), STICK_ABOVE_BUTTON.lifted(_S, _F)
    pressed = PRESSED.lifted(_B)
    by_hand, by_stick, pick = (OraclePolicy(a) for a in (_press_by_hand, _press_by_stick, _pick))
    rows = (
        ("RobotPressButtonFromNothing", (_R, _B), {empty, nothing}, {pressed, above}, {nothing}, by_hand),
        (
            "RobotPressButtonFromButton",
            (_R, _B, _F),
            {empty, above_other},
            {pressed, above},
            {above_other},
            by_hand,
        ),
        ("PickStickFromNothing", (_R, _S), {empty, nothing}, {grasped}, {empty}, pick),
        (
            "PickStickFromButton",
            (_R, _S, _F),
            {empty, above_other},
            {grasped, nothing},
            {empty, above_other},
            pick,
        ),
        (
            "StickPressButtonFromNothing",
            (_R, _S, _B),
            {grasped, nothing},
            {stick, pressed},
            {nothing},
            by_stick,
        ),
        (
            "StickPressButtonFromButton",
            (_R, _S, _B, _F),
            {grasped, stick_other},
            {stick, pressed},
            {stick_other},
            by_stick,
        ),
    )
    terminals = {by_hand: _second_is_pressed, by_stick: _third_is_pressed, pick: is_grasped}
    return tuple(
        Skill(
            Operator(name, parameters, frozenset(needs), frozenset(adds), frozenset(deletes)),
            policy,
            GraspSampler() if policy is pick else NoSampler(),
            terminals[policy],
        )
        for name, parameters, needs, adds, deletes, policy in rows
    )


# -------------------------------------------------------------------------------------------- tasks


def _place(
    rng: np.random.Generator, most_x: float, most_y: float, taken: Iterable[Circle]
) -> tuple[float, float]:
    """Draw a position whose surroundings are free."""
    least = RADIUS + SPACING
    for _ in range(MAX_TRIES):
        x, y = rng.uniform(least, most_x), rng.uniform(least, most_y)
        if not any(circles_meet(Circle(x, y, least), other) for other in taken):
            return x, y
    raise InputError("stick_button: no room for so many buttons: ask for fewer")


def _sample_state(rng: np.random.Generator, count: int) -> State:
    """Draw a state with so many buttons. Source: spec, stick_button.md section 6."""
    least = RADIUS + SPACING
    taken: list[Circle] = []
    features: dict[Object, Features] = {}
    for number in range(count):
        x, y = _place(rng, WORLD_X - least, WORLD_Y - least, taken)
        taken.append(Circle(x, y, least))
        features[Object(f"button{number}", BUTTON)] = (x, y, 0.0)
    highest = max(circle.y for circle in taken)
    robot = _place(rng, WORLD_X - least, ZONE_Y - least, taken)
    features[Object("robby", GRIPPER)] = robot
    taken.append(Circle(*robot, least))
    for _ in range(MAX_TRIES):
        x, y = rng.uniform(least, WORLD_X - least), rng.uniform(least, STICK_START_Y)
        if not any(rectangle_meets_circle(stick_shape(x, y), circle) for circle in taken):
            break
    else:
        raise InputError("stick_button: no room for the stick among so many buttons: ask for fewer")
    features[Object("stick", STICK)] = (x, y, 0.0)
    reach = highest - ZONE_Y
    while True:
        offset = rng.uniform(-HOLDER_LENGTH, STICK_LENGTH / 2)
        room_above = STICK_LENGTH - (offset + HOLDER_LENGTH)
        if reach < 0 or offset > 2 * RADIUS or room_above > reach:  # the stick can be held low enough
            break
    middle = y - (HOLDER_THICKNESS - STICK_THICKNESS) / 2
    holder = Rectangle(x + offset, middle, HOLDER_LENGTH, HOLDER_THICKNESS).rotated((x, y), UPRIGHT)
    features[Object("holder", HOLDER)] = (holder.x, holder.y)
    return State.of(features)


@dataclass(frozen=True, slots=True)
class StickButton:
    """The environment; the counts of buttons are drawn from these."""

    train_buttons: tuple[int, ...] = (1, 2)
    test_buttons: tuple[int, ...] = (3, 4)

    name = "stick_button"
    types = (GRIPPER, BUTTON, STICK, HOLDER)
    classifiers = CLASSIFIERS
    goal_predicates = frozenset({PRESSED})
    contact_predicates = frozenset({GRASPED, PRESSED})
    oracle_skills = _oracle_skills()
    given_skills = ()
    action_low = np.array([-1, -1, -1], np.float32)
    action_high = np.array([1, 1, 1], np.float32)
    horizon = 100
    rollout_limit = 50
    budget = Budget(abstract_plans=1000, samples_per_step=10, samples_per_plan=100)

    def __post_init__(self) -> None:
        if not all(counts and min(counts) >= 1 for counts in (self.train_buttons, self.test_buttons)):
            raise ValueError("train_buttons and test_buttons are one or more numbers above 0")

    def simulate(self, state: State, action: Array) -> State:
        """Return the next state; the action is (dx, dy, force)."""
        return simulate(state, action)

    def sample_task(self, split: Split, index: int, rng: np.random.Generator) -> Task:
        """Draw a task: press all buttons. Source: spec, stick_button.md section 6."""
        counts = self.train_buttons if split == "train" else self.test_buttons
        state = _sample_state(rng, int(rng.choice(counts)))
        goal: frozenset[GroundAtom] = frozenset(PRESSED(b) for b in state.by_type[BUTTON.name])
        return Task(state, goal)

    def draw(self, state: State, caption: str = "", goal: frozenset[GroundAtom] = frozenset()) -> Image:
        """Return a picture of a state; the goal is not marked."""
        return draw(state, caption)


ENVIRONMENT = StickButton()

# ------------------------------------------------------------------------------------------ drawing

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
