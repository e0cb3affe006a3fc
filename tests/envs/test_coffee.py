from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bpns.envs.coffee import ENVIRONMENT, Coffee
from bpns.envs.coffee.world import (
    BUTTON,
    CUP,
    CUP_FILLED,
    GRIPPER,
    HAND_EMPTY,
    IS_TWISTING,
    NOT_ABOVE_CUP,
    ON_TABLE,
    PLATE,
    POT,
    POT_ABOVE_CUP,
    POT_ON_PLATE,
    PRESSING_BUTTON,
    ROBOT_ABOVE_CUP,
    simulate,
)
from bpns.symbolic import planners
from bpns.symbolic.bilevel.execution import execute
from bpns.symbolic.bilevel.solve import Plan, solve
from bpns.symbolic.skills.environment import EnvironmentFailure, Split, abstract, sample_tasks
from bpns.symbolic.skills.rollout import GroundSkill, Rollout
from bpns.symbolic.state import State, Task
from bpns.symbolic.structs import Object
from tests.envs._operators import assert_operator

ROBBY, THE_POT, THE_PLATE = Object("robby", GRIPPER), Object("pot", POT), Object("plate", PLATE)
CUP0, CUP1 = Object("cup0", CUP), Object("cup1", CUP)
SKILLS = {skill.operator.name: skill for skill in ENVIRONMENT.oracle_skills}
POUR = (0.96, 0.24, 2.0625)  # from a cup to the bottom of a pot that pours into it


def world(**changes: tuple[float, ...]) -> State:
    """A cold pot at (8.5, 3) with its handle in front (y 2.58), cups at (2, 3) and (5, 3), no hand near."""
    fixed: dict[Object, tuple[float, ...]] = {
        ROBBY: (5.0, 5.0, 10.0, 0.0, 0.0, 0.4),
        THE_POT: (8.5, 3.0, 0.0, 0.0, 0.0),
        THE_PLATE: (0.0,),
        CUP0: (2.0, 3.0, 1.0, 0.75, 0.0),
        CUP1: (5.0, 3.0, 1.0, 0.75, 0.0),
    }
    return State.of(fixed).changed(changes)


def step(state: State, *action: float) -> State:
    return simulate(state, np.array(action, np.float32))


def pouring(
    z: float = 2.0625 + 1.125, x: float = 2.96, y: float = 3.24, **changes: tuple[float, ...]
) -> State:
    """The pot is held at the pour position of cup0; the next full tilt pours."""
    return world(**{"robby": (x, y - 0.42, z, 0.0, 0.0, 0.1), "pot": (x, y, 0.0, 1.0, 1.0), **changes})


TILT = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0)


def with_rotation(task: Task, rotation: float) -> Task:
    pot = task.init[THE_POT]
    return Task(task.init.changed({"pot": (pot[0], pot[1], rotation, 0.0, 0.0)}), task.goal)


def oracle_plan(environment: Coffee, task: Task) -> Plan:
    plan = solve(environment, task, SKILLS, planners.load("astar"), environment.budget, seed=0)
    assert isinstance(plan, Plan)
    assert execute(environment, task, plan).success
    return plan


# --------------------------------------------------------------------------------------- transition


def test_everything_stops_at_its_bounds() -> None:
    state = world(robby=(9.0, 1.0, 9.0, 0.5, 3.0, 0.3))
    assert step(state, 1, -1, 1, 1, 1, 1)[ROBBY] == (10.0, 0.0, 10.0, pi / 4, pi, 0.4)
    state = world(robby=(9.0, 1.0, 9.0, 0.5, -3.0, 0.3))
    assert step(state, -0.5, 0.5, -0.5, -1, -1, -1)[ROBBY] == (7.75, 2.25, 7.75, 0.0, -pi, 0.1)


def test_pressing_comes_before_holding() -> None:
    state = world(robby=(9.0, 7.5, 3.1, 0.0, 0.5, 0.1), pot=(9.0, 7.06, 0.0, 1.0, 0.0))
    after = step(state, 0, 0, 0, 1, 0, 1)  # would release the pot
    assert after[THE_PLATE] == (1.0,)
    assert after[THE_POT] == state[THE_POT]
    assert after[ROBBY] == (*BUTTON, 0.0, 0.0, 0.4)
    again = step(after, 0, 0, 0, 0, 0, 0)  # pressed already: now the open fingers release
    assert again[THE_POT] == (9.0, 7.06, 0.0, 0.0, 1.0)


def test_the_button_reaches_farther_than_it_is_wide() -> None:
    for distance, on in ((0.44, 1.0), (0.45, 0.0)):  # squared: 0.19 and 0.20 against 0.2
        state = world(robby=(9.0, 7.5 - distance, 3.0, 0.0, 0.0, 0.4))
        assert (PRESSING_BUTTON(ROBBY, THE_PLATE) in abstract(ENVIRONMENT, state)) == bool(on)
        assert step(state, 0, 0, 0, 0, 0, 0)[THE_PLATE] == (on,)


def test_a_pot_is_released_where_it_was() -> None:
    after = step(pouring(), 1, 0, 0, 1, 0, 1)
    assert after[THE_POT] == (2.96, 3.24, 0.0, 0.0, 1.0)
    assert after[ROBBY] == (2.96 + 2.5, 3.24 - 0.42, 2.0625 + 1.125, pi / 4, 0.0, 0.4)


def test_a_held_pot_moves_as_far_as_the_hand() -> None:
    state = world(robby=(9.0, 2.58, 5.0, 0.4, 0.3, 0.1), pot=(9.0, 3.0, 0.2, 1.0, 0.0))
    after = step(state, 1, 0.5, 0.5, 0, 0.5, 0.25)
    assert after[THE_POT] == (10.0, 4.25, 0.2, 1.0, 0.0)  # the hand stopped at 10
    assert after[ROBBY] == (10.0, 2.58 + 1.25, 6.25, 0.0, 0.0, 0.1)


def test_pouring_fills_and_moves_nothing_else() -> None:
    state = pouring()
    after = step(state, 0.1, 0.2, 0.0, 0.9, 0.5, 0.1)  # 0.9: within the tolerance of the pour angle
    assert after[CUP0] == (2.0, 3.0, 1.0, 0.75, 0.15)
    assert after[CUP1] == state[CUP1]
    assert after[THE_POT] == state[THE_POT]
    assert after[ROBBY][:3] == state[ROBBY][:3]
    assert after[ROBBY][3:] == pytest.approx((0.9 * pi / 4, pi / 8, 0.1))


def test_pouring_looks_at_the_new_height_and_the_old_place() -> None:
    high = pouring(z=2.0625 + 1.125 + 2.0)  # 2 too high for a cup
    after = step(high, 1, 0, -0.8, 1, 0, 0)  # 2 down, 2.5 to the side
    assert after[CUP0][4] == 0.15
    assert after[ROBBY][2] == high[ROBBY][2]
    with pytest.raises(EnvironmentFailure, match="spilled"):
        step(high, *TILT)


def test_the_nearest_cup_is_filled_and_the_first_of_equals() -> None:
    near = pouring(cup1=(2.1, 3.0, 1.0, 0.75, 0.0), x=3.02)
    assert (step(near, *TILT)[CUP0][4], step(near, *TILT)[CUP1][4]) == (0.0, 0.15)
    equal = pouring(cup1=(2.0, 3.0, 1.0, 0.75, 0.0))
    assert (step(equal, *TILT)[CUP0][4], step(equal, *TILT)[CUP1][4]) == (0.15, 0.0)


def test_a_cup_can_be_filled_to_the_brim_only() -> None:
    assert step(pouring(cup0=(2.0, 3.0, 0.85, 0.6, 0.70)), *TILT)[CUP0][4] == 0.85
    with pytest.raises(EnvironmentFailure, match="overfilled: cup0"):
        step(pouring(cup0=(2.0, 3.0, 0.84, 0.6, 0.70)), *TILT)


def test_a_cold_pot_pours_too() -> None:
    assert step(pouring(pot=(2.96, 3.24, 0.0, 1.0, 0.0)), *TILT)[CUP0][4] == 0.15


@pytest.mark.parametrize(
    ("rotation", "away", "fingers", "grasped"),
    [
        (0.0, 0.7, -1.0, True),
        (0.0, 0.71, -1.0, False),  # squared: 0.504
        (0.0, 0.0, -0.2, False),  # half closed
        (pi / 3 - 1e-9, 0.0, -1.0, True),
        (pi / 3, 0.0, -1.0, False),
        (-pi / 3, 0.0, -1.0, False),
    ],
)
def test_a_grasp_needs_the_handle_and_its_direction(
    rotation: float, away: float, fingers: float, grasped: bool
) -> None:
    handle = (8.5 + cos(rotation - pi / 2) * 0.42, 3.0 + sin(rotation - pi / 2) * 0.42, 1.125)
    state = world(
        pot=(8.5, 3.0, rotation, 0.0, 0.0), robby=(handle[0], handle[1] - away, 1.125, 0.3, 0.3, 0.4)
    )
    after = step(state, 0, 0, 0, 0, 0, fingers)
    assert after[THE_POT] == (8.5, 3.0, rotation, float(grasped), 0.0)
    if grasped:
        assert after[ROBBY] == pytest.approx((*handle, 0.0, 0.0, 0.1))
    else:
        assert after[ROBBY][:5] == state[ROBBY][:5]


def test_a_grasp_comes_before_twisting() -> None:
    state = world(robby=(8.5, 3.0, 1.5, 0.0, 0.0, 0.1), pot=(8.5, 3.0, 0.5, 0.0, 0.0))
    assert IS_TWISTING(ROBBY, THE_POT) in abstract(ENVIRONMENT, state)
    after = step(state, 0, 0, 0, 0, 0.5, 0)
    assert (after[THE_POT][3], after[THE_POT][2]) == (1.0, 0.5)


def test_twisting_turns_the_pot_with_the_wrist() -> None:
    at_top = world(robby=(8.5, 3.0, 1.5, 0.0, 3.0, 0.4))
    assert step(at_top, 0, 0, 0, 0, -1, 0)[THE_POT][2] == pytest.approx(-pi / 4)
    assert step(at_top, 0, 0, 0, 0, 1, 0)[THE_POT][2] == pytest.approx(pi - 3)  # the wrist stopped at pi
    leaving = step(at_top, 0, 0, 1, 0, -1, 0)  # what was true before the step counts
    assert leaving[THE_POT][2] == pytest.approx(-pi / 4)
    arriving = world(robby=(8.5, 3.0, 4.0, 0.0, 0.0, 0.4))
    assert step(arriving, 0, 0, -1, 0, -1, 0)[THE_POT][2] == 0.0


def test_the_top_must_not_be_farther_than_the_handle() -> None:
    top, handle = (8.5, 2.9, 1.5, 0.0, 0.0, 0.4), (8.5, 2.6, 1.2, 0.0, 0.0, 0.4)
    twisting, grasping = (abstract(ENVIRONMENT, world(robby=r)) for r in (top, handle))
    assert IS_TWISTING(ROBBY, THE_POT) in twisting
    assert HAND_EMPTY(ROBBY) not in twisting
    assert IS_TWISTING(ROBBY, THE_POT) not in grasping
    assert HAND_EMPTY(ROBBY) in grasping


def test_a_pot_gets_hot_on_the_plate_only() -> None:
    at_button = (9.0, 7.5, 3.0, 0.0, 0.0, 0.4)
    stay = (0.0,) * 6
    assert step(world(robby=at_button), *stay)[THE_POT][4] == 0.0  # still on the table
    assert step(world(robby=at_button, pot=(9.0, 7.0, 0.0, 0.0, 0.0)), *stay)[THE_POT][4] == 1.0
    assert step(world(pot=(9.0, 7.0, 0.0, 0.0, 0.0)), *stay)[THE_POT][4] == 0.0  # the button is off
    held = {"robby": (9.0, 6.6, 1.125, 0.0, 0.0, 0.1), "pot": (9.0, 7.0, 0.0, 1.0, 0.0), "plate": (1.0,)}
    assert step(world(**held), *stay)[THE_POT] == (9.0, 7.0, 0.0, 1.0, 0.0)
    assert step(world(**held), 0, 0, 0, 0, 0, 1)[THE_POT] == (9.0, 7.0, 0.0, 0.0, 1.0)  # put down: hot
    hot = world(pot=(9.0, 3.0, 0.0, 0.0, 1.0))
    assert step(hot, *stay)[THE_POT][4] == 1.0  # and stays so


@pytest.mark.parametrize("action", [[0, 0, 0, 0, 0, 1.01], [0, float("nan"), 0, 0, 0, 0], [0] * 5, [[0] * 6]])
def test_an_action_outside_the_box_is_refused(action: list[float]) -> None:
    with pytest.raises(ValueError, match="not in the box"):
        simulate(world(), np.array(action, np.float32))


@given(st.integers(0, 20), st.lists(st.tuples(*[st.floats(-1, 1, width=32)] * 6), min_size=1, max_size=20))
def test_invariants(seed: int, actions: list[tuple[float, ...]]) -> None:
    state = sample_tasks(ENVIRONMENT, "train", 1, seed)[0].init
    for action in actions:
        try:
            following = step(state, *action)
        except EnvironmentFailure:
            assert state[THE_POT][3] == 1.0
            return
        low, high = (0, 0, 0, 0, -pi, 0.1), (10, 10, 10, pi / 4, pi, 0.4)
        assert all(a <= v <= b for a, v, b in zip(low, following[ROBBY], high, strict=True))
        atoms = {a.predicate.name for a in abstract(ENVIRONMENT, following)}
        assert len(atoms & {"Holding", "PotOnPlate", "OnTable"}) == 1
        assert ("HandEmpty" in atoms) == (not atoms & {"Holding", "Twisting"})
        assert ("NotAboveCup" in atoms) == ("PotAboveCup" not in atoms)
        state = following


# --------------------------------------------------------------------------------------- predicates


def test_above_a_cup_means_with_the_pot_in_hand() -> None:
    above = {POT_ABOVE_CUP(THE_POT, CUP0), ROBOT_ABOVE_CUP(ROBBY, CUP0)}
    held = abstract(ENVIRONMENT, pouring())
    assert above <= held
    assert not {NOT_ABOVE_CUP(ROBBY, THE_POT), POT_ABOVE_CUP(THE_POT, CUP1)} & held
    standing = abstract(ENVIRONMENT, pouring(pot=(2.96, 3.24, 0.0, 0.0, 1.0)))
    assert not above & standing
    assert NOT_ABOVE_CUP(ROBBY, THE_POT) in standing


def test_a_cup_is_filled_above_its_target_only() -> None:
    for level, filled in ((0.75, False), (0.7501, True)):
        state = world(cup0=(2.0, 3.0, 1.0, 0.75, level))
        assert (CUP_FILLED(CUP0) in abstract(ENVIRONMENT, state)) == filled


def test_the_plate_is_where_the_dispense_area_is() -> None:
    for y, on_plate in ((6.07, True), (6.05, False)):  # the area is at y 7.06, within a distance of 1
        atoms = abstract(ENVIRONMENT, world(pot=(9.0, y, 0.0, 0.0, 0.0)))
        assert (POT_ON_PLATE(THE_POT, THE_PLATE) in atoms) == on_plate
        assert (ON_TABLE(THE_POT) in atoms) == (not on_plate)


# ------------------------------------------------------------------------------------------- oracle

OPERATORS = """
MoveToTwistPot r,j: OnTable(j) HandEmpty(r) -> Twisting(r,j) / HandEmpty(r)
TwistPot r,j: OnTable(j) Twisting(r,j) -> HandEmpty(r) / Twisting(r,j)
PickPotFromTable r,j: OnTable(j) HandEmpty(r) -> Holding(r,j) / OnTable(j) HandEmpty(r)
PlacePotOnPlate r,j,m: Holding(r,j) -> HandEmpty(r) PotOnPlate(j,m) / Holding(r,j)
TurnButtonPressed r,j,m: HandEmpty(r) PotOnPlate(j,m) -> PotHot(j) ButtonPressed(m) PressingButton(r,m) /
PickPotFromPlate r,j,m: HandEmpty(r) PotOnPlate(j,m) PressingButton(r,m) -> Holding(r,j) / \
HandEmpty(r) PotOnPlate(j,m) PressingButton(r,m)
PourFromNowhere r,j,c: Holding(r,j) PotHot(j) NotAboveCup(r,j) -> PotAboveCup(j,c) RobotAboveCup(r,c) \
CupFilled(c) / NotAboveCup(r,j)
PourFromOtherCup r,j,c,o: Holding(r,j) PotHot(j) PotAboveCup(j,o) RobotAboveCup(r,o) -> PotAboveCup(j,c) \
RobotAboveCup(r,c) CupFilled(c) / PotAboveCup(j,o) RobotAboveCup(r,o)
"""


def test_operators_are_those_of_the_specification() -> None:
    short = {"?robot": "r", "?pot": "j", "?plate": "m", "?cup": "c", "?other-cup": "o"}
    lines = OPERATORS.strip().split("\n")
    for skill, line in zip(ENVIRONMENT.oracle_skills, lines, strict=True):
        operator = skill.operator
        head, _, rest = line.partition(": ")
        conditions, _, effects = rest.partition(" -> ")
        add, _, delete = effects.partition("/")
        assert_operator(operator, short, head, conditions, add, delete)
        assert skill.sampler.dimension == (operator.name == "TwistPot")


@pytest.mark.parametrize("split", ["train", "test"])
def test_the_oracle_solves_tasks_and_twists_where_it_must(split: Split) -> None:
    for task in sample_tasks(ENVIRONMENT, split, 10, 7):
        names = [step.skill.operator.operator.name for step in oracle_plan(ENVIRONMENT, task).steps]
        assert ("TwistPot" in names) == (abs(task.init[THE_POT][2]) >= pi / 3)


def test_a_handle_at_the_back_leaves_the_pick_stuck() -> None:
    state = world(pot=(8.5, 3.0, 2.0, 0.0, 0.0))
    skill = SKILLS["PickPotFromTable"]
    ground = GroundSkill(skill, skill.operator.ground((ROBBY, THE_POT)))
    rollout = ground.roll_out(ENVIRONMENT, state, np.zeros(0, np.float32), 100)
    assert isinstance(rollout, Rollout)
    assert rollout.stuck
    assert len(rollout.trajectory.actions) < 20


@pytest.mark.parametrize("share", [-0.4, 0.0, 0.4])
def test_twisting_reaches_the_subgoal_and_lets_go(share: float) -> None:
    state = world(robby=(8.5, 3.0, 1.5, 0.0, 0.0, 0.4), pot=(8.5, 3.0, 1.5, 0.0, 0.0))
    skill = SKILLS["TwistPot"]
    ground = GroundSkill(skill, skill.operator.ground((ROBBY, THE_POT)))
    rollout = ground.roll_out(ENVIRONMENT, state, np.array([share], np.float32), 100)
    assert isinstance(rollout, Rollout)
    last = rollout.trajectory.states[-1]
    assert last[THE_POT][2] == pytest.approx(share * 2 * pi / 3, abs=0.1)
    assert HAND_EMPTY(ROBBY) in abstract(ENVIRONMENT, last)


# -------------------------------------------------------------------------------------------- tasks


@pytest.mark.parametrize("count", [4, 10])
def test_more_cups_than_the_paper_has(count: int) -> None:
    environment = Coffee(test_cups=(count,))
    task = sample_tasks(environment, "test", 1, 0)[0]
    cups = [task.init[o] for o in task.init.by_type["cup"]]
    assert len(task.goal) == len(cups) == count
    distances = [((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2) ** 0.5 for a in cups for b in cups if a is not b]
    assert min(distances) >= (1.48 if count == 4 else 0.9)
    assert all(0.74 <= c[0] <= 6.76 and 2.4 <= c[1] <= 4.6 for c in cups)
    plan = oracle_plan(environment, with_rotation(task, 0.5))
    assert len(plan.steps) == 4 + count


def test_numbers_of_cups_depend_on_the_split() -> None:
    for split, numbers in (("train", {1, 2}), ("test", {2, 3})):
        tasks = sample_tasks(ENVIRONMENT, split, 20, 1)  # type: ignore[arg-type]
        assert {len(task.goal) for task in tasks} == numbers


# ------------------------------------------------------------------------------------------ drawing


def test_drawing_shows_levels_button_and_the_tilt_of_a_held_pot() -> None:
    start = ENVIRONMENT.draw(world())
    assert start.size[0] == 1040
    for changed in (
        world(cup0=(2.0, 3.0, 1.0, 0.75, 0.3)),
        world(plate=(1.0,)),
        world(pot=(8.5, 3.0, 0.0, 0.0, 1.0)),
    ):
        assert ENVIRONMENT.draw(changed).tobytes() != start.tobytes()
    tilted = world(robby=(5.0, 5.0, 10.0, 0.7, 0.0, 0.4))
    assert ENVIRONMENT.draw(tilted).tobytes() == start.tobytes()  # the hand itself is a disc
    held, tilted = pouring(), pouring(robby=(2.96, 2.82, 3.1875, 0.7, 0.0, 0.1))
    assert ENVIRONMENT.draw(held).tobytes() != ENVIRONMENT.draw(tilted).tobytes()
