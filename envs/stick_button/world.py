"""The world of Stick Button: shapes, predicates and the transition.

Source: spec, stick_button.md sections 1 to 5.
"""

from collections.abc import Mapping
from math import cos, pi, sin

from bpns.envs.actions import checked
from bpns.envs.shapes2d import Circle, Rectangle, circles_meet, rectangle_meets_circle
from bpns.symbolic.skills.environment import Classifier, EnvironmentFailure
from bpns.symbolic.state import Array, Features, State
from bpns.symbolic.structs import Object, Predicate, Type

GRIPPER = Type("gripper", ("x", "y"))
BUTTON = Type("button", ("x", "y", "pressed"))
STICK = Type("stick", ("x", "y", "held"))  # its corner; it always stands upright
HOLDER = Type("holder", ("x", "y"))  # its corner; upright too

X, Y, FLAG = range(3)

WORLD_X, WORLD_Y, ZONE_Y = 10.0, 6.0, 3.0  # the hand stays within x 0..10, y 0..3
STEP = 0.5  # most per action and axis
RADIUS = 0.1  # of robot and buttons
STICK_LENGTH, STICK_THICKNESS, TIP_LENGTH = 3.0, 0.05, 0.05
HOLDER_LENGTH, HOLDER_THICKNESS = STICK_LENGTH * 0.1, 0.125
UPRIGHT = pi / 2
COS, SIN = cos(UPRIGHT), sin(UPRIGHT)

# --------------------------------------------------------------------------------------- predicates

ABOVE_NO_BUTTON = Predicate("AboveNoButton", ())
GRASPED = Predicate("Grasped", (GRIPPER, STICK))
HAND_EMPTY = Predicate("HandEmpty", (GRIPPER,))
PRESSED = Predicate("Pressed", (BUTTON,))
ROBOT_ABOVE_BUTTON = Predicate("RobotAboveButton", (GRIPPER, BUTTON))
STICK_ABOVE_BUTTON = Predicate("StickAboveButton", (STICK, BUTTON))


def only(state: State, type_: Type) -> tuple[str, Features]:
    """Return name and features of the one object of a type."""
    (obj,) = state.by_type[type_.name]
    return obj.name, state.features[obj.name]


def disc_shape(features: Features) -> Circle:
    """Return the shape of a robot or button."""
    return Circle(features[X], features[Y], RADIUS)


def stick_shape(x: float, y: float) -> Rectangle:
    """Return the rectangle of a stick at a place."""
    return Rectangle(x, y, STICK_LENGTH, STICK_THICKNESS, UPRIGHT)


def tip_shape(x: float, y: float) -> Rectangle:
    """Return the rectangle of a stick's tip."""
    far = STICK_LENGTH - TIP_LENGTH
    return Rectangle(x + far * COS, y + far * SIN, TIP_LENGTH, STICK_THICKNESS, UPRIGHT)


def robot_above(robot: Features, button: Features) -> bool:
    """Say whether the hand is above a button."""
    return circles_meet(disc_shape(robot), disc_shape(button))


def _stick_above(stick: Features, button: Features) -> bool:
    if abs(stick[X] - button[X]) > 1:  # far from any close case
        return False
    return rectangle_meets_circle(stick_shape(stick[X], stick[Y]), disc_shape(button))


def _above_no_button(state: State, _: tuple[Object, ...]) -> bool:
    robot, stick = only(state, GRIPPER)[1], only(state, STICK)[1]
    return not any(
        robot_above(robot, state.features[b.name]) or _stick_above(stick, state.features[b.name])
        for b in state.by_type.get(BUTTON.name, ())
    )


def is_grasped(state: State, objects: tuple[Object, ...]) -> bool:
    """Say whether the stick is held."""
    return state[objects[1]][FLAG] > 0.5


def _hand_empty(state: State, _: tuple[Object, ...]) -> bool:
    return not only(state, STICK)[1][FLAG] > 0.5


def _pressed(state: State, objects: tuple[Object, ...]) -> bool:
    return state[objects[-1]][FLAG] > 0.5


def _robot_above_button(state: State, objects: tuple[Object, ...]) -> bool:
    return robot_above(state[objects[0]], state[objects[1]])


def _stick_above_button(state: State, objects: tuple[Object, ...]) -> bool:
    return _stick_above(state[objects[0]], state[objects[1]])


CLASSIFIERS: Mapping[Predicate, Classifier] = {
    ABOVE_NO_BUTTON: _above_no_button,
    GRASPED: is_grasped,
    HAND_EMPTY: _hand_empty,
    PRESSED: _pressed,
    ROBOT_ABOVE_BUTTON: _robot_above_button,
    STICK_ABOVE_BUTTON: _stick_above_button,
}

# --------------------------------------------------------------------------------------- transition


def simulate(state: State, action: Array) -> State:
    """Return the next state. Source: spec, stick_button.md section 4; the comments count its rules."""
    dx, dy, force = checked(action, (1, 1, 1), "dx, dy, force, all in [-1, 1]")
    dx, dy = STEP * dx, STEP * dy  # 1
    robot_name, (x, y) = only(state, GRIPPER)
    x, y = x + dx, y + dy
    if not (0.0 + RADIUS <= x <= WORLD_X - RADIUS and 0.0 + RADIUS <= y <= ZONE_Y - RADIUS):  # 2
        raise EnvironmentFailure("the robot left its zone")
    changes: dict[str, Features] = {robot_name: (x, y)}  # 3
    stick_name, (stick_x, stick_y, held) = only(state, STICK)
    if held > 0.5:  # 4
        stick_x, stick_y = stick_x + dx, stick_y + dy
        changes[stick_name] = (stick_x, stick_y, held)
    if force > 0:  # 5
        robot = Circle(x, y, RADIUS)
        if held <= 0.5 and rectangle_meets_circle(stick_shape(stick_x, stick_y), robot):
            _, (holder_x, holder_y) = only(state, HOLDER)
            holder = Rectangle(holder_x, holder_y, HOLDER_LENGTH, HOLDER_THICKNESS, UPRIGHT)
            if rectangle_meets_circle(holder, robot):
                raise EnvironmentFailure("the robot collided with the holder")
            changes[stick_name] = (stick_x, stick_y, 1.0)
        tip = tip_shape(stick_x, stick_y)
        for obj in state.by_type.get(BUTTON.name, ()):
            button = state.features[obj.name]
            disc = disc_shape(button)
            if rectangle_meets_circle(tip, disc) if held > 0.5 else circles_meet(robot, disc):
                changes[obj.name] = (button[X], button[Y], 1.0)
    return state.changed(changes)
