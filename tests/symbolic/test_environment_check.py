"""The checker of environments: one broken environment for each kind of fault gives that fault only."""

import re
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from PIL import Image

from bpns.symbolic.environment_check import Finding, attributes, check
from bpns.symbolic.skills.environment import Budget, Environment, EnvironmentFailure, Split
from bpns.symbolic.skills.skill import Controller, GivenPolicy, GivenSkill, NoSampler
from bpns.symbolic.state import Array, State, Task
from bpns.symbolic.structs import GroundAtom, Object, Predicate, Type
from tests.toy import DOOR, DOOR_0, HAND, HAND_0, HAS_KEY, IS_OPEN, SEARCH, SKILLS, UNLOCK, Toy

TOY = Toy()
TWIN = Predicate("hasKEY", (HAND,))
WINDOW = Type("window", ("open",))
START = {HAND_0: (0.0, 0.0), DOOR_0: (0.0,)}
CALLS: list[int] = []  # hidden state, which environments must not have


def toy(**changes: Any) -> SimpleNamespace:
    """Return an environment that has the toy's attributes, with changes."""
    return SimpleNamespace(**{name: getattr(TOY, name) for name in attributes.NAMES} | changes)


def without(name: str) -> SimpleNamespace:
    """Return the toy without an attribute."""
    broken = toy()
    delattr(broken, name)
    return broken


def with_classifier(predicate: Predicate, classifier: object) -> SimpleNamespace:
    """Return the toy with one other classifier."""
    return toy(classifiers={**TOY.classifiers, predicate: classifier})


def with_skill(name: str, **changes: Any) -> SimpleNamespace:
    """Return the toy with a change in one oracle skill."""
    skills = {**SKILLS, name: replace(SKILLS[name], **changes)}
    return toy(oracle_skills=tuple(skills.values()))


def faults(environment: object, tasks: int = 2) -> list[Finding]:
    return [finding for finding in check(environment, tasks) if finding.level == "fault"]


# ------------------------------------------------------------------------------- parts of broken toys


def task_of(goal: frozenset[GroundAtom], state: State | None = None) -> Task:
    return Task(state or State.of(START), goal)


def no_task(split: Split, index: int, rng: np.random.Generator) -> Any:
    return {"init": START}


def unseeded_task(split: Split, index: int, rng: np.random.Generator) -> Task:
    CALLS.append(index)
    return task_of(frozenset({IS_OPEN(DOOR_0)}), State.of({**START, HAND_0: (0.0, len(CALLS))}))


def goalless_task(split: Split, index: int, rng: np.random.Generator) -> Task:
    return task_of(frozenset())


def foreign_goal_task(split: Split, index: int, rng: np.random.Generator) -> Task:
    return task_of(frozenset({IS_OPEN(Object("door1", DOOR))}))


def other_goal_task(split: Split, index: int, rng: np.random.Generator) -> Task:
    return task_of(frozenset({HAS_KEY(HAND_0)}))


def solved_task(split: Split, index: int, rng: np.random.Generator) -> Task:
    return task_of(frozenset({IS_OPEN(DOOR_0)}), State.of({**START, DOOR_0: (1,)}))


def nan_task(split: Split, index: int, rng: np.random.Generator) -> Task:
    return task_of(frozenset({IS_OPEN(DOOR_0)}), State.of({**START, DOOR_0: (float("nan"),)}))


def numbered_door_task(split: Split, index: int, rng: np.random.Generator) -> Task:
    door = Object("2nd-door", DOOR)
    state = State.of({HAND_0: (0.0, 0.0), DOOR_0: (0.0,), door: (0.0,)})
    return task_of(frozenset({IS_OPEN(DOOR_0)}), state)


def task_in_a_hurry(split: Split, index: int) -> Task:
    return task_of(frozenset({IS_OPEN(DOOR_0)}))


def changing_simulate(state: State, action: Array) -> State:
    state.features["hand0"] = (1.0, 1.0)  # type: ignore[index]
    return state


def action_changing_simulate(state: State, action: Array) -> State:
    after = TOY.simulate(state, action)
    action[0] += 1
    return after


def random_simulate(state: State, action: Array) -> State:
    TOY.simulate(state, action)
    CALLS.append(0)
    return state.changed({"hand0": (0.0, float(len(CALLS)))})


def numpy_simulate(state: State, action: Array) -> State:
    TOY.simulate(state, action)
    return state.changed({"hand0": (np.float64(0.5), 0.0)})


def short_simulate(state: State, action: Array) -> State:
    TOY.simulate(state, action)
    return state.changed({"hand0": (0.5,)})


def creating_simulate(state: State, action: Array) -> State:
    return State.of({**START, Object("door1", DOOR): (0,)})


def no_simulate(state: State, action: Array) -> Any:
    return None


def crashing_simulate(state: State, action: Array) -> State:
    raise KeyError("hand1")


def one_when_positive(state: State, objects: tuple[Object, ...]) -> Any:
    return np.bool_(state[objects[0]][0] > 0)


def crashing_classifier(state: State, objects: tuple[Object, ...]) -> bool:
    return state[Object("hand1", HAND)][0] > 0


def fickle_classifier(state: State, objects: tuple[Object, ...]) -> bool:
    CALLS.append(0)
    return len(CALLS) % 2 == 0


def changing_classifier(state: State, objects: tuple[Object, ...]) -> bool:
    state.features["door0"] = (state[DOOR_0][0] + 1,)  # type: ignore[index]
    return False


def never(state: State, objects: tuple[Object, ...]) -> bool:
    return False


def no_picture(state: State, *more: Any) -> Any:
    return np.zeros((8, 8, 3))


def wild_picture(state: State, *more: Any) -> Image.Image:
    state.features["door0"] = (1.0,)  # type: ignore[index]
    return TOY.draw(state, *more)


class Policy:
    """Like the toy's unlocking, with an action of one's own."""

    def __init__(self, action: Any) -> None:
        self.action = action

    def begin(self, state: State, objects: tuple[Object, ...], subgoal: Array) -> Controller:
        return self.act

    def act(self, state: State) -> Any:
        return self.action


class GrowingPolicy(Policy):
    """Does each time something else."""

    def act(self, state: State) -> Array:
        self.action = self.action + 1
        if len(CALLS) + self.action > 1_000_000:
            raise ArithmeticError("too much")
        return np.array([0, 1 - 1 / self.action], np.float32)


class WideSampler(NoSampler):
    """Says that there is nothing to choose, and chooses."""

    def sample(self, state: State, objects: tuple[Object, ...], rng: np.random.Generator) -> Array:
        return np.ones(2, np.float64)


BAD_OPERATOR = replace(
    UNLOCK, add_effects=frozenset({Predicate("Ajar", (DOOR,)).lifted(UNLOCK.parameters[0])})
)
LOOSE_OPERATOR = replace(UNLOCK, parameters=UNLOCK.parameters[:1])
FIXED_OPERATOR = replace(UNLOCK, preconditions=frozenset({HAS_KEY.lifted(HAND_0)}))
BUDGET = Budget(3, 0)
HALF = np.array([0.5, 0.5], np.float32)


def tolerant_simulate(state: State, action: Array) -> State:
    return TOY.simulate(state, np.nan_to_num(np.clip(action[:2], 0, 1)))


def always_failing(state: State, action: Array) -> State:
    raise EnvironmentFailure("the end")


CASES: dict[str, tuple[object, str, str]] = {
    "missing": (without("budget"), "attributes", "budget is missing: symbolic/environment.py says"),
    "bare name": (toy(name=7), "attributes", "name is 7: give a text"),
    "types": (toy(types=[HAND, DOOR]), "attributes", "types is .*: give a tuple"),
    "classifier": (with_classifier(IS_OPEN, True), "attributes", "no function for IsOpen, but True"),
    "goals": (toy(goal_predicates=frozenset()), "attributes", "goal_predicates is .* at least one"),
    "contacts": (toy(contact_predicates={IS_OPEN}), "attributes", "contact_predicates is .* frozenset"),
    "skills": (toy(oracle_skills=(SEARCH,)), "attributes", "oracle_skills is .*: give a tuple of"),
    "given": (toy(given_skills=("walk",)), "attributes", "given_skills is .*: give a tuple of"),
    "given, not said": (
        with_skill("search", policy=GivenPolicy(GivenSkill("walk", (HAND,), SKILLS["search"].policy), (0,))),
        "symbols",
        "search uses given skill walk, which is not in given_skills",
    ),
    "no policy": (with_skill("search", policy=None), "attributes", "search, whose policy has no method"),
    "low": (toy(action_low=np.zeros(2)), "attributes", r"action_low is float64 of shape \(2,\)"),
    "bounds": (toy(action_low=HALF * 4), "attributes", "action_low must .* be at most as high"),
    "horizon": (toy(horizon=0), "attributes", "horizon is 0: give a positive int"),
    "budget": (toy(budget=BUDGET), "attributes", "budget has samples_per_step = 0"),
    "draw": (toy(draw=None), "attributes", "draw is None: write a method"),
    "window": (
        with_classifier(Predicate("Clean", (WINDOW,)), never),
        "symbols",
        r"Clean\(window\) is over window, which is not in types",
    ),
    "no classifier": (
        toy(goal_predicates=frozenset({IS_OPEN, TWIN})),
        "symbols",
        "goal_predicates has hasKEY",
    ),
    "operator": (with_skill("unlock", operator=BAD_OPERATOR), "symbols", "unlock uses Ajar.*no classifier"),
    "parameter": (with_skill("unlock", operator=LOOSE_OPERATOR), "symbols", r"\?hand.*not among its param"),
    "constant": (with_skill("unlock", operator=FIXED_OPERATOR), "symbols", "unlock names the object hand0"),
    "twins": (with_classifier(TWIN, never), "names", "two predicates are called 'haskey'"),
    "title": (toy(name="my toy"), "names", "'my toy' is no PDDL name"),
    "object name": (
        toy(sample_task=numbered_door_task),
        "object names",
        "object '2nd-door' is no PDDL name",
    ),
    "no task": (toy(sample_task=no_task), "tasks", "train task 0: sample_task gave a dict"),
    "signature": (toy(sample_task=task_in_a_hurry), "tasks", "TypeError: task_in_a_hurry.* takes 2"),
    "unseeded": (toy(sample_task=unseeded_task), "tasks", "train task 0: the same generator gives another"),
    "no goal": (toy(sample_task=goalless_task), "tasks", "train task 0: the goal is empty"),
    "lost goal": (toy(sample_task=foreign_goal_task), "tasks", r"IsOpen\(door1\) names door1"),
    "other goal": (toy(sample_task=other_goal_task), "tasks", r"HasKey\(hand0\) is not over goal_predicates"),
    "nan": (toy(sample_task=nan_task), "tasks", "train task 0: door0.open is nan"),
    "solved": (toy(sample_task=solved_task), "goals", r"already holds at the start \(IsOpen\(door0\)\)"),
    "changes": (toy(simulate=changing_simulate), "simulate", "changes the state it was given"),
    "changes action": (toy(simulate=action_changing_simulate), "simulate", "changes the action"),
    "random": (toy(simulate=random_simulate), "simulate", "two results for the same state and action"),
    "numpy": (
        toy(simulate=numpy_simulate),
        "simulate",
        "hand0.key is a numpy.float64: turn it into a Python float",
    ),
    "short": (toy(simulate=short_simulate), "simulate", "hand0 has 1 features, but a hand has 2"),
    "creates": (toy(simulate=creating_simulate), "simulate", r"adds or removes objects \(door1\)"),
    "nothing": (toy(simulate=no_simulate), "simulate", "there is a NoneType instead of a state"),
    "crash": (
        toy(simulate=crashing_simulate),
        "simulate",
        r"^KeyError: 'hand1', in crashing_simulate \(.*test_environment_check.py:\d+\)$",
    ),
    "numpy bool": (
        with_classifier(HAS_KEY, one_when_positive),
        "classifiers",
        r"HasKey\(hand0\) is a numpy.bool",
    ),
    "classifier crash": (
        with_classifier(HAS_KEY, crashing_classifier),
        "classifiers",
        r"train task 0: HasKey\(hand0\): KeyError: 'hand1', in crashing_classifier \(",
    ),
    "fickle": (with_classifier(HAS_KEY, fickle_classifier), "classifiers", "once true and once false"),
    "meddling": (with_classifier(HAS_KEY, changing_classifier), "classifiers", "changes the state"),
    "shape": (
        with_skill("unlock", policy=Policy(np.array([1, 0]))),
        "oracle plans",
        "step 2 unlock.*: the policy sends int64 of shape",
    ),
    "endless": (with_skill("search", terminal=never), "oracle plans", "never ended, it was stopped after 10"),
    "subgoal": (
        with_skill("unlock", sampler=WideSampler()),
        "oracle plans",
        r"the subgoal is float64 of shape \(2,\): sample float32 of shape \(0,\)",
    ),
    "forgetful": (with_skill("search", policy=GrowingPolicy(1)), "oracle plans", "second time|not again"),
    "policy crash": (
        with_skill("search", policy=GrowingPolicy(2_000_000)),
        "oracle plans",
        r"ArithmeticError: too much, in act \(",
    ),
    "no picture": (toy(draw=no_picture), "drawing", "draw gave a numpy.ndarray: return a Pillow image"),
    "wild picture": (toy(draw=wild_picture), "drawing", "draw changes the state"),
    "lambda": (with_classifier(HAS_KEY, lambda *_: False), "workers", "cannot be sent to worker processes"),
}


@pytest.mark.parametrize("case", CASES)
def test_a_broken_environment_gives_its_fault_and_no_other(case: str) -> None:
    environment, where, text = CASES[case]
    (found,) = faults(environment)
    assert found.check == where
    assert re.search(text, found.text)
    assert "\n" not in found.text


def test_the_toy_passes_every_check() -> None:
    found = list(check(TOY, 2))
    assert {finding.level for finding in found} == {"ok"}
    assert [finding.check for finding in found][:3] == ["attributes", "symbols", "names"]


def test_the_checker_knows_every_attribute_of_the_protocol() -> None:
    wrong = SimpleNamespace(**dict.fromkeys(attributes.NAMES))  # all None
    found = [finding.text for finding in check(wrong) if finding.check == "attributes"]
    assert len(found) == len(attributes.NAMES)
    assert all(" is None" in text for text in found)


def test_everything_missing_is_told_at_once() -> None:
    found = list(check(object()))
    assert [f.text.partition(" ")[0] for f in found if f.check == "attributes"] == attributes.NAMES
    assert {f.level for f in found if f.check != "attributes"} == {"skipped"}


class Unfinished(Environment):
    """Takes the protocol's attributes for its own."""

    name = "unfinished"


def test_what_a_subclass_of_the_protocol_leaves_open_is_missing() -> None:
    unfinished = Unfinished()  # type: ignore[abstract]
    found = [finding.text for finding in check(unfinished) if finding.level == "fault"]
    assert "simulate is missing" in " ".join(found)
    assert len(found) == len(attributes.NAMES) - 1


def test_warnings() -> None:
    for environment, where, text in (
        (
            toy(simulate=tolerant_simulate),
            "refusals",
            "simulate takes actions of the wrong shape, below the box, above",
        ),
        (toy(oracle_skills=()), "oracle plans", "no oracle skills"),
        (
            with_skill("search", sampler=NoSampler()),
            "oracle plans",
            "they solve none of 2 train tasks; .*missing HasKey",
        ),
        (toy(horizon=1), "oracle plans", "they solve none of 2 train tasks"),
    ):
        (found,) = (f for f in check(environment, 2) if f.level != "ok")
        assert (found.check, found.level) == (where, "warning")
        assert re.search(text, found.text)


def test_environment_failures_are_no_faults() -> None:
    assert not faults(Toy(fails_below=0.9))
    assert not faults(toy(simulate=always_failing))
