import re
from itertools import pairwise
from math import hypot
from typing import Any

import numpy as np
import pytest

from bpns.envs.doors import ENVIRONMENT
from bpns.envs.doors.skills import MOVE_THROUGH_DOOR, MOVE_TO_DOOR, MoveToDoor, _motion
from bpns.envs.doors.world import DOOR, DOOR_IN_ROOM, DOOR_IS_OPEN, IN_DOORWAY, IN_ROOM, ROBOT, TOUCHING_DOOR
from bpns.symbolic import planners
from bpns.symbolic.bilevel.execution import execute
from bpns.symbolic.bilevel.solve import Plan, solve
from bpns.symbolic.skills.environment import abstract, sample_tasks
from bpns.symbolic.skills.rollout import GroundSkill, Rollout
from bpns.symbolic.skills.skill import GivenSkill, Label, SkillFailure
from bpns.symbolic.state import State
from bpns.symbolic.structs import GroundAtom, Object
from tests.envs._doors_worlds import (
    AT_UPRIGHT,
    BLOCK,
    EAST,
    FLAT,
    HANDLE,
    NOTHING,
    OPENS_AT,
    ROBBY,
    SKILLS,
    SOUTH,
    UPRIGHT,
    WEST,
    true,
    world,
)
from tests.envs._operators import assert_operator

# ------------------------------------------------------------------------------------ given skills


def run(given: GivenSkill, state: State, door: Object) -> list[State]:
    """Run a given skill until it says that it is done; return all states."""
    controller = given.policy.begin(state, (ROBBY, door), NOTHING)
    states = [state]
    while (action := controller(states[-1])) is not None:
        assert action.dtype == np.float32
        assert action[2] == 0
        assert len(states) < 500
        states.append(ENVIRONMENT.simulate(states[-1], action))
    return states


def collided(states: list[State]) -> bool:
    return any(a[ROBBY] == b[ROBBY] for a, b in pairwise(states))


@pytest.mark.parametrize("door", [UPRIGHT, FLAT])
@pytest.mark.parametrize("x", [0.3, 0.7])
def test_moving_to_a_door_ends_as_soon_as_it_is_touched(door: Object, x: float) -> None:
    in_the_way = {BLOCK: (0.35, 1.45, 0.15, 0.15, 0.3)}
    states = run(MOVE_TO_DOOR, world(x, 1.75, more=in_the_way), door)
    assert (ROBBY, door) in true(states[-1], TOUCHING_DOOR)
    assert not any((ROBBY, door) in true(state, IN_DOORWAY) for state in states[:-1])
    assert not collided(states)
    assert true(states[-1], IN_ROOM) == {(ROBBY, WEST)}


def test_moving_to_a_door_from_the_other_side_and_from_another_door() -> None:
    states = run(MOVE_TO_DOOR, world(1.3, 1.3), UPRIGHT)
    assert true(states[-1], IN_ROOM) == {(ROBBY, EAST)}
    assert true(states[-1], IN_DOORWAY) == {(ROBBY, UPRIGHT)}
    states = run(MOVE_TO_DOOR, world(0.5, 1.1, flat=1.0), UPRIGHT)
    assert true(states[-1], IN_DOORWAY) == {(ROBBY, UPRIGHT)}


def test_moving_to_doors_in_sampled_rooms_meets_no_obstacle() -> None:
    runs = 0
    for task in sample_tasks(ENVIRONMENT, "test", 5, 8):
        ((_, room),) = true(task.init, IN_ROOM)
        for door, other in true(task.init, DOOR_IN_ROOM):
            if other == room:
                states = run(MOVE_TO_DOOR, task.init, door)
                assert true(states[-1], TOUCHING_DOOR) == {(ROBBY, door)}
                assert not collided(states)
                runs += 1
    assert runs >= 5


def test_the_same_state_and_seed_give_the_same_motion() -> None:
    state = world(0.3, 1.75, more={BLOCK: (0.4, 1.4, 0.3, 0.3, 0.5)})
    paths = []
    for seed in (0, 0, 1):
        _motion.cache_clear()
        given = GivenSkill("MoveToDoor", (ROBOT, DOOR), MoveToDoor(seed))
        paths.append([s[ROBBY] for s in run(given, state, FLAT)])
    assert paths[0] == paths[1] != paths[2]


def test_moving_to_a_door_at_which_the_robot_is_takes_no_action() -> None:
    assert len(run(MOVE_TO_DOOR, world(*AT_UPRIGHT), UPRIGHT)) == 1


def test_moving_to_a_door_of_another_room_fails() -> None:
    with pytest.raises(SkillFailure, match="in no room of the door"):
        run(MOVE_TO_DOOR, world(1.5, 1.5), FLAT)


def test_moving_to_a_door_that_cannot_be_reached_fails() -> None:
    bar = {BLOCK: (0.0, 1.3, 1.0, 0.05, 0.0)}
    with pytest.raises(SkillFailure, match="no motion plan"):
        run(MOVE_TO_DOOR, world(0.5, 1.7, more=bar), FLAT)
    run(MOVE_TO_DOOR, world(0.5, 1.7, more=bar), UPRIGHT)


@pytest.mark.parametrize(
    ("door", "start", "end"),
    [
        (UPRIGHT, (0.9, 1.45), EAST),
        (UPRIGHT, (1.1, 1.55), WEST),
        (FLAT, (0.45, 1.1), SOUTH),
        (FLAT, (0.6, 0.9), WEST),
    ],
)
def test_moving_through_a_door_ends_in_the_other_room(
    door: Object, start: tuple[float, float], end: Object
) -> None:
    states = run(MOVE_THROUGH_DOOR, world(*start, upright=1.0, flat=1.0), door)
    assert true(states[-1], IN_ROOM) == {(ROBBY, end)}
    assert not any((ROBBY, end) in true(state, IN_ROOM) for state in states[:-1])
    assert all((ROBBY, door) in true(state, IN_DOORWAY) for state in states)
    lengths = [hypot(b[ROBBY][0] - a[ROBBY][0], b[ROBBY][1] - a[ROBBY][1]) for a, b in pairwise(states)]
    assert lengths == pytest.approx([0.05] * len(lengths), abs=1e-6)


def test_moving_through_a_door_aims_at_its_middle() -> None:
    after = run(MOVE_THROUGH_DOOR, world(0.9, 1.45, upright=1.0), UPRIGHT)[1]
    dx, dy = 1.056 - 0.9, 1.505 - 1.45  # the far end of the doorway; a door is 0.25 wide
    moved = after[ROBBY][0] - 0.9, after[ROBBY][1] - 1.45
    assert moved == pytest.approx((0.05 * dx / hypot(dx, dy), 0.05 * dy / hypot(dx, dy)), abs=1e-6)


@pytest.mark.parametrize(
    "state",
    [
        world(*AT_UPRIGHT),  # closed
        world(*AT_UPRIGHT, flat=1.0),  # another one is open
        world(0.5, 1.5, upright=1.0),  # not there
    ],
)
def test_moving_through_a_door_needs_an_open_one_here(state: State) -> None:
    with pytest.raises(SkillFailure, match="not at an open door"):
        run(MOVE_THROUGH_DOOR, state, UPRIGHT)


def test_skills_that_are_given_label_what_they_do() -> None:
    objects = {"MoveToDoorFromMainRoom": (ROBBY, WEST, UPRIGHT), "OpenDoor": (UPRIGHT, ROBBY)}
    objects |= {"MoveToDoorFromDoorWay": (ROBBY, FLAT, UPRIGHT)}
    objects |= {"MoveThroughDoor": (ROBBY, WEST, UPRIGHT, EAST)}
    labels = {
        name: GroundSkill(SKILLS[name], SKILLS[name].operator.ground(them)).label
        for name, them in objects.items()
    }
    assert labels == {
        "MoveToDoorFromMainRoom": Label("MoveToDoor", (ROBBY, UPRIGHT)),
        "MoveToDoorFromDoorWay": Label("MoveToDoor", (ROBBY, UPRIGHT)),
        "MoveThroughDoor": Label("MoveThroughDoor", (ROBBY, UPRIGHT)),
        "OpenDoor": None,
    }


# ------------------------------------------------------------------------------------------- oracle

OPERATORS = """
MoveToDoorFromMainRoom r,m,d: InRoom(r,m) InMainRoom(r,m) DoorInRoom(d,m) -> TouchingDoor(r,d) \
InDoorway(r,d) / InMainRoom(r,m) : MoveToDoor(r,d)
MoveToDoorFromDoorWay r,d,e: InDoorway(r,d) DoorsShareRoom(d,e) -> TouchingDoor(r,e) InDoorway(r,e) / \
InDoorway(r,d) : MoveToDoor(r,e)
OpenDoor d,r: TouchingDoor(r,d) InDoorway(r,d) -> DoorIsOpen(d) / TouchingDoor(r,d) :
MoveThroughDoor r,m,d,n: InRoom(r,m) InDoorway(r,d) DoorIsOpen(d) DoorInRoom(d,m) DoorInRoom(d,n) -> \
InRoom(r,n) / InRoom(r,m) : MoveThroughDoor(r,d)
"""


def test_operators_are_those_of_the_specification() -> None:
    short = {"?robot": "r", "?room": "m", "?room2": "n", "?door": "d", "?door2": "e"}
    lines = OPERATORS.strip().split("\n")
    for skill, line in zip(ENVIRONMENT.oracle_skills, lines, strict=True):
        operator = skill.operator
        head, conditions, add, delete, given = (
            part.strip() for part in re.split(r": | -> | / | :", line, maxsplit=4)
        )
        assert_operator(operator, short, head, conditions, add, delete)
        letters = tuple(Object(short[v.name], v.type) for v in operator.parameters)
        label = GroundSkill(skill, operator.ground(letters)).label
        assert (f"{label.skill}({','.join(o.name for o in label.objects)})" if label else "") == given
        assert skill.sampler.dimension == (2 if operator.name == "OpenDoor" else 0)


def test_the_oracle_opens_a_door_in_one_step() -> None:
    skill, state = SKILLS["OpenDoor"], world(*AT_UPRIGHT)
    subgoal = skill.sampler.sample(state, (UPRIGHT, ROBBY), np.random.default_rng(0))
    assert subgoal == pytest.approx([OPENS_AT - HANDLE[2], 1.0])
    rollout = GroundSkill(skill, skill.operator.ground((UPRIGHT, ROBBY))).roll_out(
        ENVIRONMENT, state, subgoal, 100
    )
    assert isinstance(rollout, Rollout)
    assert len(rollout.trajectory.actions) == 1
    assert true(rollout.trajectory.states[-1], DOOR_IS_OPEN) == {(UPRIGHT,)}


@pytest.mark.parametrize("split", ["train", "test"])
def test_the_oracle_solves_tasks(split: Any) -> None:
    for task in sample_tasks(ENVIRONMENT, split, 4, 7):
        plan = solve(ENVIRONMENT, task, SKILLS, planners.load("astar"), ENVIRONMENT.budget, seed=0)
        assert isinstance(plan, Plan)
        execution = execute(ENVIRONMENT, task, plan)
        assert execution.success
        final: frozenset[GroundAtom] = abstract(ENVIRONMENT, execution.trajectory.states[-1])
        assert task.goal <= final
