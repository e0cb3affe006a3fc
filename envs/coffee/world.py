"""The world of Coffee: what is where, predicates, the transition. Source: spec, coffee.md sections 1 to 5."""

from collections.abc import Mapping
from math import cos, pi, sin
from typing import TypeAlias

from bpns.envs.actions import checked
from bpns.symbolic.skills.environment import Classifier, EnvironmentFailure
from bpns.symbolic.state import Array, Features, State
from bpns.symbolic.structs import Object, Predicate, Type

Point: TypeAlias = tuple[float, float, float]

GRIPPER = Type("gripper", ("x", "y", "z", "tilt-angle", "wrist-angle", "fingers"))
POT = Type("pot", ("x", "y", "rotation", "is-held", "is-hot"))  # no z: it hangs from the gripper or stands
PLATE = Type("plate", ("is-on",))
CUP = Type("cup", ("x", "y", "liquid-capacity", "liquid-target", "current-liquid"))

X, Y, Z, TILT, WRIST, FINGERS = range(6)  # of the gripper; X and Y of pot and cups too
ROTATION, IS_HELD, IS_HOT = 2, 3, 4  # of the pot
CAPACITY, TARGET, LEVEL = 2, 3, 4  # of a cup

WORLD = 10.0  # x, y and z are in 0..WORLD
BUTTON: Point = (9.0, 7.5, 3.0)
BUTTON_RADIUS = 0.2
PLATE_CORNER, PLATE_SIZE = (8.5, 7.5), (1.0, 2.0, 4.0)
POT_RADIUS, POT_HEIGHT = 0.4, 1.5
CUP_RADIUS = 0.24
HANDLE_DISTANCE, HANDLE_HEIGHT = 1.05 * POT_RADIUS, 1.125  # from the middle of the pot's bottom
DISPENSE_AREA: Point = (BUTTON[X], BUTTON[Y] - 1.1 * POT_RADIUS, 0.0)  # where a pot is on the plate
POUR_OFFSET: Point = (1.5 * (CUP_RADIUS + POT_RADIUS), CUP_RADIUS, 1.1 * (1.5 + POT_HEIGHT - HANDLE_HEIGHT))
NEAR_TOP, NEAR_AREA, NEAR_POUR = 0.5, 1.0, 1.0  # squared distances
MAX_TILT, MAX_WRIST = pi / 4, pi
OPEN, CLOSED, FINGER_TOLERANCE = 0.4, 0.1, 0.01
POSITION_STEP, ANGLE_STEP, FINGER_STEP = 2.5, pi / 4, 1.0  # what an action component of 1 does
POUR_ANGLE_TOLERANCE, POUR_AMOUNT = 0.1, 1.5 / 10
MAX_PICK_ROTATION = pi / 3  # beyond it the handle cannot be grasped
NEAR_BUTTON, NEAR_HANDLE = 0.2, 0.5  # squared; the paper compares the button's with its plain radius
SINGLE = (GRIPPER, POT, PLATE)  # types that have one object


def squared_distance(a: Point, b: Point) -> float:
    """Return the squared distance."""
    x, y, z = a[0] - b[0], a[1] - b[1], a[2] - b[2]
    return x * x + y * y + z * z


def distance_across(a: Point, b: Point) -> float:
    """Return the squared distance in x and y."""
    return (a[X] - b[X]) ** 2 + (a[Y] - b[Y]) ** 2


def clip(value: float, low: float, high: float) -> float:
    """Return the nearest number in low..high."""
    return low if value < low else high if value > high else value


def only(state: State, type_: Type) -> Features:
    """Return the features of the one object of a type."""
    return state.features[state.by_type[type_.name][0].name]


def position(robot: Features) -> Point:
    """Return where the gripper is."""
    return (robot[X], robot[Y], robot[Z])


def pot_position(robot: Features, pot: Features) -> Point:
    """Return the middle of the bottom of a held pot; one that stands is at height 0."""
    return (pot[X], pot[Y], robot[Z] - HANDLE_HEIGHT)


def handle_position(pot: Features) -> Point:
    """Return where a pot that stands is grasped."""
    angle = pot[ROTATION] - pi / 2
    return (pot[X] + cos(angle) * HANDLE_DISTANCE, pot[Y] + sin(angle) * HANDLE_DISTANCE, HANDLE_HEIGHT)


def pour_position(cup: Features) -> Point:
    """Return where a pot pours into a cup."""
    return (cup[X] + POUR_OFFSET[X], cup[Y] + POUR_OFFSET[Y], POUR_OFFSET[Z])


def is_on_plate(pot: Features) -> bool:
    """Say whether the pot stands on the plate."""
    at = (pot[X], pot[Y], 0.0)
    return not pot[IS_HELD] > 0.5 and squared_distance(DISPENSE_AREA, at) < NEAR_AREA


def is_at_top(robot: Features, pot: Features) -> bool:
    """Say whether the gripper is at the top of the pot, and not nearer to the handle."""
    at = position(robot)
    top = squared_distance((pot[X], pot[Y], POT_HEIGHT), at)
    return top < NEAR_TOP and not squared_distance(handle_position(pot), at) < top


def is_above(robot: Features, pot: Features, cup: Features) -> bool:
    """Say whether the pot is held where it can pour into the cup."""
    at = pot_position(robot, pot)
    return pot[IS_HELD] > 0.5 and squared_distance(at, pour_position(cup)) < NEAR_POUR


def cup_below(state: State, spout: Point) -> str:
    """Return the name of the cup that a tilted pot pours into; empty where there is none."""
    nearest, best = "", NEAR_POUR
    for obj in state.by_type[CUP.name]:
        distance = squared_distance(spout, pour_position(state[obj]))
        if distance < best:  # strictly: the first in canonical order on ties
            nearest, best = obj.name, distance
    return nearest


def is_filled(cup: Features) -> bool:
    """Say whether there is more in a cup than wanted."""
    return cup[LEVEL] > cup[TARGET]


# --------------------------------------------------------------------------------------- predicates

CUP_FILLED = Predicate("CupFilled", (CUP,))
IS_HOLDING = Predicate("Holding", (GRIPPER, POT))
POT_ON_PLATE = Predicate("PotOnPlate", (POT, PLATE))
BUTTON_PRESSED = Predicate("ButtonPressed", (PLATE,))
ON_TABLE = Predicate("OnTable", (POT,))
IS_TWISTING = Predicate("Twisting", (GRIPPER, POT))
HAND_EMPTY = Predicate("HandEmpty", (GRIPPER,))
POT_HOT = Predicate("PotHot", (POT,))
ROBOT_ABOVE_CUP = Predicate("RobotAboveCup", (GRIPPER, CUP))
POT_ABOVE_CUP = Predicate("PotAboveCup", (POT, CUP))
NOT_ABOVE_CUP = Predicate("NotAboveCup", (GRIPPER, POT))
PRESSING_BUTTON = Predicate("PressingButton", (GRIPPER, PLATE))


def is_holding(state: State, _: tuple[Object, ...]) -> bool:
    """Say whether the gripper holds the pot."""
    return only(state, POT)[IS_HELD] > 0.5


def is_button_pressed(state: State, _: tuple[Object, ...]) -> bool:
    """Say whether the machine's button is pressed."""
    return only(state, PLATE)[0] > 0.5


def is_twisting(state: State, _: tuple[Object, ...]) -> bool:
    """Say whether the gripper is at the pot's top, where it turns it."""
    return is_at_top(only(state, GRIPPER), only(state, POT))


def is_hand_empty(state: State, _: tuple[Object, ...]) -> bool:
    """Say whether the gripper neither holds the pot nor turns it."""
    robot, pot = only(state, GRIPPER), only(state, POT)
    return not pot[IS_HELD] > 0.5 and not is_at_top(robot, pot)


CLASSIFIERS: Mapping[Predicate, Classifier] = {
    CUP_FILLED: lambda state, objects: is_filled(state[objects[0]]),
    IS_HOLDING: is_holding,
    POT_ON_PLATE: lambda state, objects: is_on_plate(state[objects[0]]),
    BUTTON_PRESSED: is_button_pressed,
    ON_TABLE: lambda s, objects: not s[objects[0]][IS_HELD] > 0.5 and not is_on_plate(s[objects[0]]),
    IS_TWISTING: is_twisting,
    HAND_EMPTY: is_hand_empty,
    POT_HOT: lambda state, objects: state[objects[0]][IS_HOT] > 0.5,
    ROBOT_ABOVE_CUP: lambda state, objects: is_above(state[objects[0]], only(state, POT), state[objects[1]]),
    POT_ABOVE_CUP: lambda state, objects: is_above(only(state, GRIPPER), *map(state.__getitem__, objects)),
    NOT_ABOVE_CUP: lambda s, o: not any(is_above(s[o[0]], s[o[1]], s[cup]) for cup in s.by_type[CUP.name]),
    PRESSING_BUTTON: lambda s, objects: squared_distance(BUTTON, position(s[objects[0]])) < NEAR_BUTTON,
}

# --------------------------------------------------------------------------------------- transition


def simulate(state: State, action: Array) -> State:
    """Return the next state. Source: spec, coffee.md section 4; the comments count its rules."""
    dx, dy, dz, dtilt, dwrist, dfingers = checked(action, (1, 1, 1, 1, 1, 1), "six numbers in [-1, 1]")
    robot_name, pot_name, plate_name = (state.by_type[t.name][0].name for t in SINGLE)
    old, pot = state.features[robot_name], state.features[pot_name]
    on = state.features[plate_name][0] > 0.5
    x = clip(old[X] + POSITION_STEP * dx, 0.0, WORLD)  # 1
    y = clip(old[Y] + POSITION_STEP * dy, 0.0, WORLD)
    z = clip(old[Z] + POSITION_STEP * dz, 0.0, WORLD)
    tilt = clip(old[TILT] + ANGLE_STEP * dtilt, 0.0, MAX_TILT)
    wrist = clip(old[WRIST] + ANGLE_STEP * dwrist, -MAX_WRIST, MAX_WRIST)
    fingers = clip(old[FINGERS] + FINGER_STEP * dfingers, CLOSED, OPEN)
    at = (x, y, z)
    robot: Features = (x, y, z, tilt, wrist, fingers)  # 3
    changes: dict[str, Features] = {}
    if not on and squared_distance(BUTTON, at) < NEAR_BUTTON:  # 5 and 6A
        changes[plate_name] = (1.0,)
        on = True
        robot = (*BUTTON, 0.0, 0.0, fingers)
    elif pot[IS_HELD] > 0.5:
        if abs(fingers - OPEN) < FINGER_TOLERANCE:  # 6B1
            pot = (*pot[:3], 0.0, pot[4])
        elif abs(tilt - MAX_TILT) < POUR_ANGLE_TOLERANCE:  # 6B2
            cup_name, cup = _poured(state, pot_position(robot, pot))
            changes[cup_name] = cup
            robot = (old[X], old[Y], old[Z], tilt, wrist, CLOSED)
        else:  # 6B3, with the motion of rule 2
            pot = (pot[X] + (x - old[X]), pot[Y] + (y - old[Y]), *pot[2:])
            robot = (x, y, z, 0.0, 0.0, CLOSED)
    elif (  # 4 and 6C
        abs(fingers - CLOSED) < FINGER_TOLERANCE
        and abs(pot[ROTATION]) < MAX_PICK_ROTATION
        and squared_distance(handle := handle_position(pot), at) < NEAR_HANDLE
    ):
        robot = (*handle, 0.0, 0.0, fingers)
        pot = (*pot[:3], 1.0, pot[4])
    elif is_at_top(old, pot):  # 6D, with the turn of rule 2
        pot = (pot[X], pot[Y], pot[ROTATION] + (wrist - old[WRIST]), *pot[3:])
    if on and not pot[IS_HOT] > 0.5 and is_on_plate(pot):  # 7
        pot = (*pot[:4], 1.0)
    changes[robot_name] = robot
    changes[pot_name] = pot
    return state.changed(changes)


def _poured(state: State, spout: Point) -> tuple[str, Features]:
    """Return the cup below the spout with more in it; raise EnvironmentFailure on a mess."""
    name = cup_below(state, spout)
    if not name:
        raise EnvironmentFailure("spilled: no cup is below the tilted pot")
    *fixed, level = state.features[name]
    level += POUR_AMOUNT
    if level > fixed[CAPACITY]:
        raise EnvironmentFailure(f"overfilled: {name} cannot hold what is poured")
    return name, (*fixed, level)
