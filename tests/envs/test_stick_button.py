import re
from math import hypot
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bpns import envs
from bpns.envs.stick_button import ENVIRONMENT
from bpns.envs.stick_button.world import (
    ABOVE_NO_BUTTON,
    BUTTON,
    GRASPED,
    GRIPPER,
    HAND_EMPTY,
    HOLDER,
    PRESSED,
    ROBOT_ABOVE_BUTTON,
    STICK,
    STICK_ABOVE_BUTTON,
    simulate,
)
from bpns.symbolic import planners
from bpns.symbolic.bilevel.execution import execute
from bpns.symbolic.bilevel.solve import Plan, solve
from bpns.symbolic.errors import InputError
from bpns.symbolic.skills.environment import EnvironmentFailure, abstract, sample_tasks
from bpns.symbolic.skills.rollout import Failed, GroundSkill, Rollout
from bpns.symbolic.state import State
from bpns.symbolic.structs import Object, Predicate
from tests.envs._operators import assert_operator

ROBBY, THE_STICK, THE_HOLDER = Object("robby", GRIPPER), Object("stick", STICK), Object("holder", HOLDER)
LOW, HIGH = Object("button0", BUTTON), Object("button1", BUTTON)  # within the hand's reach, and above it
SKILLS = {skill.operator.name: skill for skill in ENVIRONMENT.oracle_skills}
STAY, PRESS = (0.0, 0.0, -1.0), (0.0, 0.0, 1.0)


def world(**changes: tuple[float, ...]) -> State:
    """Buttons at (2, 2) and (5, 5); the stick covers x 7.95..8 and y 1..4, its holder y 2..2.3 of it."""
    fixed: dict[Object, tuple[float, ...]] = {
        ROBBY: (4.0, 1.0),
        LOW: (2.0, 2.0, 0.0),
        HIGH: (5.0, 5.0, 0.0),
        THE_STICK: (8.0, 1.0, 0.0),
        THE_HOLDER: (8.0375, 2.0),
    }
    return State.of(fixed).changed(changes)


def held(x: float, y: float, **changes: tuple[float, ...]) -> State:
    """The stick is in the hand, with its corner at (x, y)."""
    return world(**{"robby": (x - 0.025, 1.5), "stick": (x, y, 1.0), **changes})


def step(state: State, *action: float) -> State:
    return simulate(state, np.array(action, np.float64))


def true(state: State, predicate: Predicate) -> set[tuple[Object, ...]]:
    return {atom.objects for atom in abstract(ENVIRONMENT, state, {predicate})}


def pressed(state: State) -> set[Object]:
    return {button for (button,) in true(state, PRESSED)}


# --------------------------------------------------------------------------------------- transition


def test_the_hand_moves_half_a_unit_at_most() -> None:
    after = step(world(), 1, -0.5, 0)
    assert after[ROBBY] == (4.5, 0.75)
    assert {n for n, v in after.features.items() if v != world().features[n]} == {"robby"}


def test_components_are_widened_before_they_are_multiplied() -> None:
    after = simulate(world(), np.array([0.1, 0.3, -1], np.float32))
    assert after[ROBBY] == (4.0 + 0.5 * float(np.float32(0.1)), 1.0 + 0.5 * float(np.float32(0.3)))


@pytest.mark.parametrize(
    ("start", "border", "direction"),
    [
        ((0.5, 1.5), (0.1, 1.5), (-1, 0)),
        ((9.5, 1.5), (9.9, 1.5), (1, 0)),
        ((4.0, 0.5), (4.0, 0.1), (0, -1)),
        ((4.0, 2.5), (4.0, 2.9), (0, 1)),
    ],
)
def test_leaving_the_zone_fails(
    start: tuple[float, float], border: tuple[float, float], direction: tuple[int, int]
) -> None:
    state = world(robby=start)
    assert step(state, *(0.79 * d for d in direction), -1)[ROBBY] == pytest.approx(
        [a + 0.395 * d for a, d in zip(start, direction, strict=True)]
    )
    for force in (-1, 1):
        with pytest.raises(EnvironmentFailure, match="left its zone"):
            step(state, *(0.81 * d for d in direction), force)
    assert step(world(robby=border), *STAY)[ROBBY] == border  # the zone is closed


def test_the_stick_may_leave_the_zone_and_the_world() -> None:
    after = step(held(9.5, 2.9, robby=(5.0, 1.5)), 1, 1, -1)
    assert after[THE_STICK] == (10.0, 3.4, 1.0)


@pytest.mark.parametrize("force", [-1.0, -0.1, 0.0])
def test_without_force_nothing_is_pressed_or_picked(force: float) -> None:
    over_both = world(robby=(8.0, 1.5), button0=(8.0, 1.5, 0.0))
    assert step(over_both, 0, 0, force).features == over_both.features
    tip_above = held(5.0, 2.05)
    assert step(tip_above, 0, 0, force).features == tip_above.features
    in_holder = world(robby=(8.0, 2.1))
    assert step(in_holder, 0, 0, force).features == in_holder.features


def test_any_force_above_zero_is_enough() -> None:
    assert step(world(robby=(8.0, 1.5)), 0, 0, 1e-6)[THE_STICK][2] == 1.0
    assert pressed(step(world(robby=(2.0, 2.0)), 0, 0, 1e-6)) == {LOW}


@pytest.mark.parametrize(
    ("robot", "picks"),
    [
        ((8.095, 1.5), True),
        ((8.105, 1.5), False),
        ((7.855, 1.5), True),  # the stick is to the left of its corner
        ((7.845, 1.5), False),
        ((7.975, 0.905), True),
        ((7.975, 0.895), False),
        ((7.975, 2.895), True),
    ],
)
def test_the_stick_is_picked_where_the_hand_overlaps_it(robot: tuple[float, float], picks: bool) -> None:
    after = step(world(robby=robot), *PRESS)
    assert after[THE_STICK] == (8.0, 1.0, float(picks))
    assert after[ROBBY] == robot


def test_the_place_after_the_motion_decides_what_is_picked() -> None:
    arriving, leaving = world(robby=(7.6, 1.5)), world(robby=(7.9, 1.5))
    assert step(arriving, 0.6, 0, 1)[THE_STICK] == (8.0, 1.0, 1.0)  # stays where it was in this step
    assert step(leaving, -0.6, 0, 1)[THE_STICK] == (8.0, 1.0, 0.0)


@pytest.mark.parametrize(("y", "fails"), [(1.895, False), (1.905, True), (2.395, True), (2.405, False)])
def test_picking_within_the_holder_fails(y: float, fails: bool) -> None:
    state = world(robby=(8.0, y))
    if fails:
        with pytest.raises(EnvironmentFailure, match="collided with the holder"):
            step(state, *PRESS)
    else:
        assert step(state, *PRESS)[THE_STICK][2] == 1.0


def test_the_holder_alone_is_no_obstacle() -> None:
    beside = world(robby=(8.12, 2.1))  # over the holder, not over the stick
    assert step(beside, *PRESS).features == beside.features
    in_hand = held(5.0, 2.05, robby=(8.0, 2.1))  # the stick is out already
    assert pressed(step(in_hand, *PRESS)) == {HIGH}


@pytest.mark.parametrize(("distance", "presses"), [(0.195, True), (0.205, False)])
def test_the_hand_presses_what_it_overlaps(distance: float, presses: bool) -> None:
    state = world(robby=(2.0 + distance, 2.0))
    assert pressed(step(state, *PRESS)) == ({LOW} if presses else set())
    assert step(state, *PRESS)[LOW][:2] == (2.0, 2.0)


def test_all_buttons_under_the_hand_are_pressed() -> None:
    assert pressed(step(world(robby=(2.0, 2.1), button1=(2.0, 2.2, 0.0)), *PRESS)) == {LOW, HIGH}


def test_the_hand_presses_where_it_arrives() -> None:
    assert pressed(step(world(robby=(1.5, 2.0)), 1, 0, 1)) == {LOW}
    assert pressed(step(world(robby=(2.0, 2.0)), 1, 0, 1)) == set()


def test_in_the_step_of_picking_the_hand_presses_and_the_tip_does_not() -> None:
    state = world(robby=(8.0, 1.5), button0=(8.0, 1.45, 0.0), button1=(7.975, 3.975, 0.0))
    picked = step(state, *PRESS)
    assert picked[THE_STICK][2] == 1.0
    assert pressed(picked) == {LOW}
    assert pressed(step(picked, *PRESS)) == {LOW, HIGH}


def test_the_holder_fails_before_anything_is_pressed() -> None:
    with pytest.raises(EnvironmentFailure, match="holder"):
        step(world(robby=(8.0, 2.1), button0=(8.0, 2.1, 0.0)), *PRESS)


def test_a_held_stick_moves_along() -> None:
    after = step(held(5.0, 1.0), -1, 0.5, -1)
    assert after[THE_STICK] == (4.5, 1.25, 1.0)
    assert after[ROBBY] == (4.475, 1.75)
    assert step(world(robby=(8.0, 1.5)), 1, 0, -1)[THE_STICK] == (8.0, 1.0, 0.0)  # not held: stays


def test_a_held_stick_presses_with_its_tip_only() -> None:
    middle, hand = held(5.0, 3.0), held(2.025, 1.0, robby=(2.0, 2.0))
    assert (THE_STICK, HIGH) in true(middle, STICK_ABOVE_BUTTON)
    assert pressed(step(middle, *PRESS)) == set()
    assert (ROBBY, LOW) in true(hand, ROBOT_ABOVE_BUTTON)
    assert pressed(step(hand, *PRESS)) == set()
    assert pressed(step(held(5.0, 2.05), *PRESS)) == {HIGH}


@pytest.mark.parametrize(
    ("corner", "presses"),
    [
        ((4.905, 2.0), True),  # the tip is x 4.855..4.905
        ((4.895, 2.0), False),
        ((5.145, 2.0), True),
        ((5.155, 2.0), False),
        ((5.0, 1.905), True),  # y 4.855..4.905
        ((5.0, 1.895), False),
        ((5.0, 2.145), True),  # y 5.095..5.145
        ((5.0, 2.155), False),
    ],
)
def test_the_tip_is_the_upper_end_of_the_stick(corner: tuple[float, float], presses: bool) -> None:
    assert pressed(step(held(*corner), *PRESS)) == ({HIGH} if presses else set())


def test_the_tip_presses_where_it_arrives() -> None:
    assert pressed(step(held(4.6, 2.05), 0.8, 0, 1)) == {HIGH}
    assert pressed(step(held(5.0, 2.05), 0.8, 0, 1)) == set()


def test_the_stick_is_never_released_and_buttons_stay_pressed() -> None:
    state = held(5.0, 2.05, button0=(2.0, 2.0, 1.0))
    for action in (PRESS, STAY, (-1, 0, 1), (1, 0, 1), (0, -1, 0), PRESS):
        state = step(state, *action)
        assert state[THE_STICK][2] == 1.0
        assert pressed(state) == {LOW, HIGH}


@pytest.mark.parametrize("action", [[0, 0, 1.01], [-1.5, 0, 0], [0, float("nan"), 0], [0, 0], [[0, 0, 0]]])
def test_an_action_outside_the_box_is_refused(action: Any) -> None:
    with pytest.raises(ValueError, match="not in the box"):
        simulate(world(), np.array(action, np.float32))


@settings(max_examples=50)
@given(st.integers(0, 20), st.lists(st.tuples(*[st.floats(-1, 1, width=32)] * 3), min_size=1, max_size=30))
def test_invariants(seed: int, actions: list[tuple[float, float, float]]) -> None:
    state = sample_tasks(ENVIRONMENT, "train", 1, seed)[0].init
    for action in actions:
        before = dict(state.features)
        try:
            following = step(state, *action)
        except EnvironmentFailure:
            return
        assert dict(state.features) == before  # simulate is pure
        x, y = following[ROBBY]
        assert 0.1 <= x <= 9.9
        assert 0.1 <= y <= 2.9
        assert following[THE_HOLDER] == state[THE_HOLDER]
        moved = x - state[ROBBY][0], y - state[ROBBY][1]
        grasped = bool(true(state, GRASPED))
        expected = [a + (d if grasped else 0) for a, d in zip(state[THE_STICK][:2], moved, strict=True)]
        assert following[THE_STICK][:2] == pytest.approx(expected)
        assert true(state, GRASPED) <= true(following, GRASPED)
        assert pressed(state) <= pressed(following)
        if action[2] <= 0:
            assert pressed(state) == pressed(following)
            assert true(state, GRASPED) == true(following, GRASPED)
        assert bool(true(following, HAND_EMPTY)) == (not true(following, GRASPED))
        above = true(following, ROBOT_ABOVE_BUTTON) | true(following, STICK_ABOVE_BUTTON)
        assert bool(true(following, ABOVE_NO_BUTTON)) == (not above)
        state = following


# --------------------------------------------------------------------------------------- predicates


@pytest.mark.parametrize(("value", "is_so"), [(0.0, False), (0.5, False), (0.51, True), (1.0, True)])
def test_flags_count_above_a_half(value: float, is_so: bool) -> None:
    state = world(button0=(2.0, 2.0, value), stick=(8.0, 1.0, value))
    assert pressed(state) == ({LOW} if is_so else set())
    assert true(state, GRASPED) == ({(ROBBY, THE_STICK)} if is_so else set())
    assert true(state, HAND_EMPTY) == (set() if is_so else {(ROBBY,)})


def test_the_robot_is_above_the_buttons_that_it_overlaps() -> None:
    assert true(world(robby=(2.195, 2.0)), ROBOT_ABOVE_BUTTON) == {(ROBBY, LOW)}
    assert true(world(robby=(2.205, 2.0)), ROBOT_ABOVE_BUTTON) == set()
    both = held(2.0, 1.0, robby=(2.0, 2.0))
    assert true(both, ROBOT_ABOVE_BUTTON) == {(ROBBY, LOW)}  # whatever the hand holds


@pytest.mark.parametrize("is_held", [0.0, 1.0])
@pytest.mark.parametrize(
    ("button", "above"),
    [
        ((7.975, 3.9), True),  # the tip
        ((7.975, 2.5), True),
        ((7.975, 1.0), True),
        ((7.975, 0.905), True),
        ((7.975, 0.895), False),
        ((8.095, 2.5), True),
        ((8.105, 2.5), False),
        ((7.855, 2.5), True),
        ((7.845, 2.5), False),
        ((7.975, 4.095), True),
        ((7.975, 4.105), False),
    ],
)
def test_all_of_the_stick_counts_in_the_holder_too(
    button: tuple[float, float], above: bool, is_held: float
) -> None:
    state = world(stick=(8.0, 1.0, is_held), button0=(*button, 0.0))
    assert true(state, STICK_ABOVE_BUTTON) == ({(THE_STICK, LOW)} if above else set())
    assert true(state, ABOVE_NO_BUTTON) == (set() if above else {()})


def test_above_no_button_means_neither_hand_nor_stick() -> None:
    assert true(world(), ABOVE_NO_BUTTON) == {()}
    assert true(world(robby=(2.0, 2.0)), ABOVE_NO_BUTTON) == set()
    assert true(world(robby=(2.0, 2.0), button0=(2.0, 2.0, 1.0)), ABOVE_NO_BUTTON) == set()
    assert true(held(5.0, 2.05), ABOVE_NO_BUTTON) == set()


# -------------------------------------------------------------------------------------------- tasks


@pytest.mark.parametrize(("split", "numbers"), [("train", {1, 2}), ("test", {3, 4})])
def test_starts_have_room_around_everything(split: Any, numbers: set[int]) -> None:
    tasks = sample_tasks(ENVIRONMENT, split, 20, 1)
    assert {len(task.goal) for task in tasks} == numbers
    for task in tasks:
        state = task.init
        buttons = [state[o] for o in state.by_type["button"]]
        assert task.goal == {PRESSED(o) for o in state.by_type["button"]}
        discs = [(x, y) for x, y, _ in buttons] + [state[ROBBY]]
        assert min(hypot(a[0] - b[0], a[1] - b[1]) for i, a in enumerate(discs) for b in discs[:i]) >= 1.2
        assert all(0.6 <= x <= 9.4 and 0.6 <= y <= 5.4 and not flag for x, y, flag in buttons)
        assert 0.6 <= state[ROBBY][0] <= 9.4
        assert 0.6 <= state[ROBBY][1] <= 2.4
        x, y, flag = state[THE_STICK]
        assert 0.6 <= x <= 9.4
        assert 0.6 <= y <= 1.6
        assert flag == 0.0
        for disc in discs:
            dx = max(x - 0.05 - disc[0], 0, disc[0] - x)
            dy = max(y - disc[1], 0, disc[1] - y - 3)
            assert hypot(dx, dy) >= 0.6 - 1e-9


def test_the_holder_is_across_the_stick_and_leaves_room_to_grasp() -> None:
    offsets = []
    for task in sample_tasks(ENVIRONMENT, "test", 30, 2):
        x, y, _ = task.init[THE_STICK]
        holder_x, holder_y = task.init[THE_HOLDER]
        assert holder_x - 0.125 / 2 == pytest.approx(x - 0.05 / 2)  # both upright: centred on each other
        offset = holder_y - y
        assert -0.3 <= offset <= 1.5
        reach = max(task.init[button][1] for button in task.init.by_type["button"]) - 3
        assert reach < 0 or offset > 0.2 or 3 - (offset + 0.3) > reach
        offsets.append(offset)
    assert min(offsets) < 0.2 < 1.0 < max(offsets)


def test_other_numbers_of_buttons() -> None:
    environment = envs.load("stick_button:test_buttons=10:train_buttons=3,5")
    assert {len(task.goal) for task in sample_tasks(environment, "test", 3, 0)} == {10}
    assert {len(task.goal) for task in sample_tasks(environment, "train", 10, 0)} == {3, 5}


def test_too_many_buttons_are_one_clear_message() -> None:
    with pytest.raises(InputError, match="no room for so many buttons") as caught:
        sample_tasks(envs.load("stick_button:test_buttons=100"), "test", 1, 0)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ("test_buttons=0", "one or more numbers above 0"),
        ("train_buttons=2,-1", "one or more numbers above 0"),
        ("test_buttons=", "cannot read '' as test_buttons"),
        ("test_buttons=3.5", "cannot read '3.5' as test_buttons"),
        ("buttons=3", r"no option 'buttons' \(have: train_buttons, test_buttons\)"),
    ],
)
def test_bad_options_are_one_clear_message(options: str, message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        envs.load(f"stick_button:{options}")
    assert "\n" not in str(caught.value)


# ------------------------------------------------------------------------------------------- oracle

OPERATORS = """
RobotPressButtonFromNothing r,b: HandEmpty(r) AboveNoButton() -> Pressed(b) RobotAboveButton(r,b) / \
AboveNoButton()
RobotPressButtonFromButton r,b,f: HandEmpty(r) RobotAboveButton(r,f) -> Pressed(b) RobotAboveButton(r,b) / \
RobotAboveButton(r,f)
PickStickFromNothing r,s: HandEmpty(r) AboveNoButton() -> Grasped(r,s) / HandEmpty(r)
PickStickFromButton r,s,f: HandEmpty(r) RobotAboveButton(r,f) -> Grasped(r,s) AboveNoButton() / \
HandEmpty(r) RobotAboveButton(r,f)
StickPressButtonFromNothing r,s,b: Grasped(r,s) AboveNoButton() -> StickAboveButton(s,b) Pressed(b) / \
AboveNoButton()
StickPressButtonFromButton r,s,b,f: Grasped(r,s) StickAboveButton(s,f) -> StickAboveButton(s,b) \
Pressed(b) / StickAboveButton(s,f)
"""


def test_operators_are_those_of_the_specification() -> None:
    short = {"?robot": "r", "?stick": "s", "?button": "b", "?from": "f"}
    lines = OPERATORS.strip().split("\n")
    for skill, line in zip(ENVIRONMENT.oracle_skills, lines, strict=True):
        operator = skill.operator
        head, conditions, add, delete = (part.strip() for part in re.split(r": | -> | / ", line))
        assert_operator(operator, short, head, conditions, add, delete)
        assert skill.sampler.dimension == operator.name.startswith("PickStick")


def roll_out(name: str, state: State, *objects: Object, subgoal: tuple[float, ...] = ()) -> Rollout:
    ground = GroundSkill(SKILLS[name], SKILLS[name].operator.ground(objects))
    result = ground.roll_out(ENVIRONMENT, state, np.array(subgoal, np.float32), 50)
    assert isinstance(result, Rollout)
    return result


def test_pressing_by_hand_moves_each_axis_by_itself_then_presses() -> None:
    rollout = roll_out("RobotPressButtonFromNothing", world(), ROBBY, LOW)
    actions = [a.tolist() for a in rollout.trajectory.actions]
    assert actions[:2] == [[-1, 1, -1], [-1, 1, -1]]
    assert actions[2] == [-1, 0, -1]
    assert actions[-1] == [0, 0, 1]
    assert all(force == -1 for *_, force in actions[:-1])
    assert pressed(rollout.trajectory.states[-1]) == {LOW}


@pytest.mark.parametrize("share", [0.1, 0.6])
def test_picking_grasps_the_middle_of_the_stick_where_asked(share: float) -> None:
    rollout = roll_out("PickStickFromNothing", world(), ROBBY, THE_STICK, subgoal=(share,))
    last = rollout.trajectory.states[-1]
    place = 8.0 - 0.025, 1.0 + 3 * share
    assert true(last, GRASPED) == {(ROBBY, THE_STICK)}
    assert hypot(last[ROBBY][0] - place[0], last[ROBBY][1] - place[1]) ** 2 < 0.001


def test_picking_where_the_hand_cannot_reach_fails() -> None:
    skill = SKILLS["PickStickFromNothing"]
    ground = GroundSkill(skill, skill.operator.ground((ROBBY, THE_STICK)))
    result = ground.roll_out(ENVIRONMENT, world(), np.array([0.9], np.float32), 50)
    assert isinstance(result, Failed)
    assert "left its zone" in result.reason


def test_pressing_by_stick_brings_the_tip_to_the_button() -> None:
    state = held(4.0, 1.0, button0=(3.0, 4.5, 0.0))
    rollout = roll_out("StickPressButtonFromNothing", state, ROBBY, THE_STICK, HIGH)
    last = rollout.trajectory.states[-1]
    assert pressed(last) == {HIGH}
    assert rollout.trajectory.actions[-1].tolist() == [0, 0, 1]
    again = roll_out("StickPressButtonFromButton", last, ROBBY, THE_STICK, LOW, HIGH)
    assert pressed(again.trajectory.states[-1]) == {LOW, HIGH}


def test_the_grasp_is_uniform_along_the_stick() -> None:
    rng = np.random.default_rng(0)
    sampler = SKILLS["PickStickFromNothing"].sampler
    values = [float(sampler.sample(world(), (ROBBY, THE_STICK), rng)[0]) for _ in range(500)]
    assert np.histogram(values, 5, (0, 1))[0].min() > 70
    assert all(0 <= v <= 1 for v in values)


@pytest.mark.parametrize(("split", "least"), [("train", 8), ("test", 6)])
def test_the_oracle_solves_most_tasks(split: Any, least: int) -> None:
    solved = 0
    for index, task in enumerate(sample_tasks(ENVIRONMENT, split, 8, 7)):
        plan = solve(ENVIRONMENT, task, SKILLS, planners.load("astar"), ENVIRONMENT.budget, seed=index)
        if isinstance(plan, Plan):
            solved += 1
            assert execute(ENVIRONMENT, task, plan).success
            picks = any("PickStick" in step.skill.operator.operator.name for step in plan.steps)
            assert picks or all(task.init[b][1] < 3.1 for b in task.init.by_type["button"])
    assert solved >= least


# ------------------------------------------------------------------------------------------ drawing


def test_drawing_shows_what_is_pressed_and_held() -> None:
    start = ENVIRONMENT.draw(world())
    assert start.tobytes() == ENVIRONMENT.draw(world()).tobytes()
    for changed in (
        world(button1=(5.0, 5.0, 1.0)),
        world(stick=(8.0, 1.0, 1.0)),
        world(robby=(4.0, 2.0)),
        world(holder=(8.0375, 1.0)),
    ):
        assert ENVIRONMENT.draw(changed).tobytes() != start.tobytes()
    assert ENVIRONMENT.draw(world(), "caption").tobytes() != start.tobytes()
