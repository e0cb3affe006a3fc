"""Skills that come with an environment: labels in demonstrations, learned operators around them, models."""

import json
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import h5py
import pytest

from bpns import envs
from bpns.envs.doors.skills import OpenPolicy, OpenSampler
from bpns.envs.doors.world import DOOR_IS_OPEN, IN_ROOM, TOUCHING_DOOR
from bpns.learning.data.demonstrations import Demonstrations, collect
from bpns.learning.data.files import read_demonstrations, write_demonstrations
from bpns.learning.data.segmentation import Segment, segment
from bpns.learning.models.learn import LearnedSkill, learn_skills
from bpns.learning.models.load import read_model
from bpns.learning.models.save import entry_of, write_model
from bpns.learning.networks.policies import LearnedPolicy
from bpns.learning.operators.learn import OperatorData, learn_operators
from bpns.symbolic import planners
from bpns.symbolic.bilevel.execution import execute
from bpns.symbolic.bilevel.solve import Plan, solve
from bpns.symbolic.errors import InputError
from bpns.symbolic.skills.environment import abstract, holds, sample_tasks
from bpns.symbolic.skills.rollout import GroundSkill
from bpns.symbolic.skills.skill import GivenPolicy, Label, NoSampler
from bpns.symbolic.state import State, Trajectory
from bpns.symbolic.structs import Object, Predicate, Type
from tests.conftest import FEW

DOORS = envs.load("doors")
BLOCK, HAND = Type("block", ("x",)), Type("hand", ("x",))
A, B, C = (Object(name, BLOCK) for name in "abc")
ROBOT = Object("robot", HAND)
RED, NEAR = Predicate("Red", (BLOCK,)), Predicate("Near", (BLOCK, BLOCK))
STILL = Trajectory((State.of({A: [0]}),), ())


@pytest.fixture(scope="module")
def demos() -> Demonstrations:
    return collect(DOORS, 12, seed=0)


@pytest.fixture(scope="module")
def segments(demos: Demonstrations) -> list[Segment]:
    return [s for d in demos.demonstrations for s in segment(DOORS, d.trajectory, d.labels)]


@pytest.fixture(scope="module")
def learned(demos: Demonstrations) -> tuple[LearnedSkill, ...]:
    return learn_skills(DOORS, demos, FEW, seed=0)


@pytest.fixture
def model(learned: tuple[LearnedSkill, ...], tmp_path: Path) -> Path:
    skills = [(one.skill, entry_of(one.skill, one.segments, one.demonstrations, one.fits)) for one in learned]
    write_model(tmp_path / "model", DOORS, "doors", 0, skills, {"command": "test"}, "a header")
    return tmp_path / "model"


# ------------------------------------------------------------------------------------------- labels


def test_moving_is_labelled_and_opening_is_not(demos: Demonstrations) -> None:
    assert len(demos.demonstrations) >= 10
    for demo in demos.demonstrations:
        states, actions = demo.trajectory.states, demo.trajectory.actions
        assert len(demo.labels) == len(actions)
        for (before, after), action, label in zip(pairwise(states), actions, demo.labels, strict=True):
            opened = abstract(DOORS, after, {DOOR_IS_OPEN}) - abstract(DOORS, before, {DOOR_IS_OPEN})
            assert (label is None) == bool(opened)
            if label is not None:
                assert action[2] == 0
                assert [o.type.name for o in label.objects] == ["robot", "door"]
                through = label.skill == "MoveThroughDoor"
                assert holds(DOORS, DOOR_IS_OPEN(label.objects[1]), before) == through
    assert {label.skill for d in demos.demonstrations for label in d.labels if label} == {
        "MoveToDoor",
        "MoveThroughDoor",
    }


def test_files_keep_labels(demos: Demonstrations, tmp_path: Path) -> None:
    write_demonstrations(tmp_path / "demos.h5", demos, DOORS)
    again = read_demonstrations(tmp_path / "demos.h5", DOORS)
    assert [d.labels for d in again.demonstrations] == [d.labels for d in demos.demonstrations]
    for mine, theirs in zip(demos.demonstrations, again.demonstrations, strict=True):
        for one, two in zip(mine.trajectory.states, theirs.trajectory.states, strict=True):
            assert one.features == two.features


def unknown_skill(group: h5py.Group) -> None:
    group.attrs["given_skills"] = group.attrs["given_skills"].replace("MoveToDoor", "Teleport")


def swapped_objects(group: h5py.Group) -> None:
    calls = json.loads(group.attrs["given_skills"])
    group.attrs["given_skills"] = json.dumps([[name, *reversed(objects)] for name, *objects in calls])


def number_out_of_range(group: h5py.Group) -> None:
    group["given"][0] = 99


def number_below_none(group: h5py.Group) -> None:
    group["given"][0] = -2


def one_label_too_few(group: h5py.Group) -> None:
    numbers = group["given"][()]
    del group["given"]
    group["given"] = numbers[:-1]


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (unknown_skill, "given skill 'Teleport', which is not in the given_skills of 'doors'"),
        (swapped_objects, "Move.*Door is not over"),
        (number_out_of_range, "a label is out of range"),
        (number_below_none, "a label is out of range"),
        (one_label_too_few, "labels do not fit"),
    ],
)
def test_damaged_labels_are_one_clear_message(
    demos: Demonstrations, tmp_path: Path, damage: Callable[[Any], None], message: str
) -> None:
    path = tmp_path / "demos.h5"
    write_demonstrations(path, replace(demos, demonstrations=demos.demonstrations[:1]), DOORS)
    with h5py.File(path, "r+") as file:
        (group,) = file["demonstrations"].values()
        damage(group)
    with pytest.raises(InputError, match=message) as caught:
        read_demonstrations(path, DOORS)
    assert "\n" not in str(caught.value)


def test_a_segment_has_the_label_of_its_last_action(demos: Demonstrations) -> None:
    for demo in demos.demonstrations:
        place = 0
        for found in segment(DOORS, demo.trajectory, demo.labels):
            own = demo.labels[place : place + len(found.trajectory.actions)]
            assert found.label == own[-1]
            assert set(own) == {found.label}  # contacts change wherever the skill does
            place += len(own)


# ---------------------------------------------------------------------------------------- operators


def made(skill: str | None, *objects: Object, effect: tuple[Object, ...] = (A,)) -> Segment:
    """A segment that made its effect's objects red, with a label or none."""
    label = Label(skill, objects) if skill else None
    return Segment(STILL, frozenset(), frozenset(RED(o) for o in effect), label)


def test_the_same_effects_by_another_skill_or_none_do_not_unify() -> None:
    found = learn_operators([made("paint", A), made("dip", A), made(None), made("paint", B, effect=(B,))])
    assert [(o.given, len(o.members)) for o in found] == [("paint", 2), ("dip", 1), (None, 1)]
    reverse = learn_operators([made(None), made("paint", A), made(None, effect=(B,))])
    assert [(o.given, len(o.members)) for o in reverse] == [(None, 2), ("paint", 1)]


def test_the_same_skill_with_other_arguments_does_not_unify() -> None:
    found = learn_operators([made("paint", A), made("paint", B), made("paint", C)])
    assert [len(o.members) for o in found] == [1, 2]  # on what gets red, on something else


def test_arguments_count_by_place() -> None:
    (one, two) = learn_operators([made("paint", A, B), made("paint", B, A), made("paint", A, C)])
    assert [m.objects for m in one.members] == [(A, B), (A, C)]
    assert [v.name for v in one.arguments] == ["?x0", "?x1"]
    assert [v.name for v in two.arguments] == ["?x1", "?x0"]


def test_arguments_become_parameters_though_no_effect_names_them() -> None:
    (operator,) = learn_operators([made("paint", ROBOT, A), made("paint", ROBOT, B, effect=(B,))])
    assert [str(v) for v in operator.operator.parameters] == ["?x0:block", "?x1:hand"]
    assert [v.name for v in operator.arguments] == ["?x1", "?x0"]
    assert [m.objects for m in operator.members] == [(A, ROBOT), (B, ROBOT)]


def test_arguments_are_matched_before_effects() -> None:
    def both(first: Object, second: Object) -> Segment:
        return Segment(STILL, frozenset(), frozenset({RED(A), RED(B)}), Label("paint", (first, second)))

    (operator,) = learn_operators([both(A, B), both(B, A)])
    assert [m.objects for m in operator.members] == [(A, B), (B, A)]


def by_effect(operators: list[OperatorData], predicate: Predicate) -> list[OperatorData]:
    return [o for o in operators if predicate in {a.predicate for a in o.operator.add_effects}]


def test_operators_of_given_skills_have_their_arguments_in_order(segments: list[Segment]) -> None:
    operators = learn_operators(segments)
    (opening,) = by_effect(operators, DOOR_IS_OPEN)
    assert (opening.given, opening.arguments) == (None, ())
    (through,) = by_effect(operators, IN_ROOM)
    moving = by_effect(operators, TOUCHING_DOOR)
    assert through.given == "MoveThroughDoor"
    assert len(moving) == 2
    assert {o.given for o in moving} == {"MoveToDoor"}
    for operator in (through, *moving):
        assert [v.type.name for v in operator.arguments] == ["robot", "door"]
        for member in operator.members:
            binding = dict(zip(operator.operator.parameters, member.objects, strict=True))
            assert member.segment.label
            assert tuple(binding[v] for v in operator.arguments) == member.segment.label.objects


# ------------------------------------------------------------------------------------------- models


def test_given_skills_get_no_networks(learned: tuple[LearnedSkill, ...]) -> None:
    for one in learned:
        if DOOR_IS_OPEN in {a.predicate for a in one.skill.operator.add_effects}:
            assert isinstance(one.skill.policy, LearnedPolicy)
            assert one.fits
        else:
            assert isinstance(one.skill.policy, GivenPolicy)
            assert isinstance(one.skill.sampler, NoSampler)
            assert not one.fits
            assert one.skill.max_actions is None


def test_a_loaded_model_keeps_given_skills(learned: tuple[LearnedSkill, ...], model: Path) -> None:
    saved = read_model(model, DOORS)
    for one in learned:
        ours, theirs = one.skill, saved.skills[one.skill.operator.name]
        assert ours.operator == theirs.operator
        if isinstance(ours.policy, GivenPolicy):
            assert theirs.policy == ours.policy
            letters = tuple(Object(v.name, v.type) for v in theirs.operator.parameters)
            label = GroundSkill(theirs, theirs.operator.ground(letters)).label
            assert label
            assert [o.type.name for o in label.objects] == ["robot", "door"]
    tensors = (model / "skills.safetensors").read_bytes()
    given = [one.skill.operator.name for one in learned if isinstance(one.skill.policy, GivenPolicy)]
    assert not [name for name in given if f'"{name}.'.encode() in tensors]


def test_a_loaded_model_plans_and_acts(model: Path) -> None:
    skills = {
        name: replace(skill, policy=OpenPolicy(), sampler=OpenSampler(), max_actions=None)
        if isinstance(skill.policy, LearnedPolicy)  # trained too little to be good at anything
        else skill
        for name, skill in read_model(model, DOORS).skills.items()
    }
    solved = 0
    for task in sample_tasks(DOORS, "test", 4, 0):
        plan = solve(DOORS, task, skills, planners.load("astar"), DOORS.budget, seed=0)
        if isinstance(plan, Plan):
            assert execute(DOORS, task, plan).success
            solved += 1
    assert solved >= 3


def edit(change: Callable[[Any], object]) -> Callable[[Path], None]:
    """Change the entry of the first given skill in skills.json."""

    def apply(model: Path) -> None:
        path = model / "skills.json"
        file = json.loads(path.read_text())
        change(next(entry for entry in file["skills"].values() if entry["given"]))
        path.write_text(json.dumps(file))

    return apply


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (
            edit(lambda e: e["given"].update(skill="Teleport")),
            r"'Teleport' is no given skill of 'doors' \(have: MoveToDoor, MoveThroughDoor\)",
        ),
        (
            edit(lambda e: e["given"].update(arguments=["?x1", "?x9"])),
            "arguments of MoveToDoor are not among its parameters",
        ),
        (edit(lambda e: e["given"]["arguments"].reverse()), r"MoveToDoor does not take \(\?x0, \?x1\)"),
        (edit(lambda e: e["given"]["arguments"].pop()), r"MoveToDoor does not take \(\?x1\)"),
        (edit(lambda e: e["given"].update(arguments=[])), r"MoveToDoor does not take \(\)"),
        (edit(lambda e: e["given"].update(arguments=[1, 0])), "given.arguments.0: Input should be"),
        (edit(lambda e: e["given"].pop("skill")), "given.skill: Field required"),
        (edit(lambda e: e["given"].update(more=1)), "given.more: Extra inputs"),
        (edit(lambda e: e.update(given="MoveToDoor")), "given: Input should be"),
        (edit(lambda e: e.update(given=None)), r"Op0.policy.0.weights is missing"),
    ],
)
def test_damage_is_one_clear_message(model: Path, damage: Callable[[Path], None], message: str) -> None:
    damage(model)
    with pytest.raises(InputError, match=message) as caught:
        read_model(model, DOORS)
    assert "\n" not in str(caught.value)
    assert str(model) in str(caught.value)


def test_renamed_parameters_keep_their_places(model: Path) -> None:
    path = model / "domain.pddl"
    path.write_text(path.read_text().replace("?x", "?thing"))
    policies = [skill.policy for skill in read_model(model, DOORS).skills.values()]
    places = [policy.places for policy in policies if isinstance(policy, GivenPolicy)]
    assert places == [(1, 0), (1, 0), (2, 0)]
