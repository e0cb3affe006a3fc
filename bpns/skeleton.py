"""A hand on a rail puts items into bins. Change this small world into your own, step by step.

    bpns envs check FILE:ENVIRONMENT                  says what is missing or wrong; run it after every change
    bpns demos FILE:ENVIRONMENT --out demos.h5        the oracle skills below solve tasks
    bpns learn demos.h5 --out model                   learns operators, policies and samplers
    bpns plan model --task 3 --show plan.gif          plans with what was learned

What you have to supply: a simulator, predicates that can be decided in any state, tasks, and either skills
that demonstrate (as here) or recordings of your own.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from PIL import Image, ImageDraw

import bpns

# 1. Types, with the features that a state has for each object. Only numbers; the learner sees nothing else,
#    and a policy sees only the features of the objects that its operator names.
HAND = bpns.Type("hand", ("x", "closed"))
ITEM = bpns.Type("item", ("x", "held"))
BIN = bpns.Type("bin", ("x", "width"))

# 2. Predicates. Name every object that matters: Holding names hand *and* item, so that the operators which
#    change it take both as parameters.
HAND_EMPTY = bpns.Predicate("HandEmpty", (HAND,))
HOLDING = bpns.Predicate("Holding", (HAND, ITEM))
IN_BIN = bpns.Predicate("InBin", (ITEM, BIN))

STEP, REACH = 0.1, 0.03  # metres: of one action, and from which the hand can grasp


# 3. Classifiers: each decides its predicate in a state, for objects in the order of the predicate's types.
def hand_empty(state: bpns.State, objects: tuple[bpns.Object, ...]) -> bool:
    """Say whether the hand holds nothing."""
    return not any(holding(state, (objects[0], item)) for item in state.of_type(ITEM))


def holding(state: bpns.State, objects: tuple[bpns.Object, ...]) -> bool:
    """Say whether the hand holds the item."""
    return state[objects[1]][1] > 0.5


def in_bin(state: bpns.State, objects: tuple[bpns.Object, ...]) -> bool:
    """Say whether the item lies in the bin."""
    (x, held), (middle, width) = (state[one] for one in objects)
    return held < 0.5 and abs(x - middle) <= width / 2


# 4. Oracle skills, which demonstrate: leave them out if you bring recordings. An operator says what a skill
#    needs and changes; its sampler proposes a subgoal (here: where to let go); its policy gives actions.
@dataclass(frozen=True)
class MoveAnd:
    """Moves the hand to a place, then opens or closes it."""

    close: bool

    def begin(
        self, state: bpns.State, objects: tuple[bpns.Object, ...], subgoal: np.ndarray
    ) -> Callable[[bpns.State], np.ndarray]:
        """Fix the place; what is returned gives one action for each state."""
        hand, target = objects[0], state[objects[-1]][0] + (float(subgoal[0]) if len(subgoal) else 0.0)

        def act(now: bpns.State) -> np.ndarray:
            distance = target - now[hand][0]
            grip = (1.0 if self.close else -1.0) if abs(distance) < 0.01 else (-1.0 if self.close else 1.0)
            return np.array([np.clip(distance, -STEP, STEP), grip], np.float32)

        return act


@dataclass(frozen=True)
class AnywhereInBin:
    """Proposes where to let go: metres from the middle of the bin."""

    dimension: int = 1  # numbers in a subgoal

    def sample(
        self, state: bpns.State, objects: tuple[bpns.Object, ...], rng: np.random.Generator
    ) -> np.ndarray:
        """Return a subgoal; all randomness comes from ``rng``, so that runs repeat."""
        width = state[objects[-1]][1]
        return np.array([rng.uniform(-0.4, 0.4) * width], np.float32)


hand, item, bin_ = bpns.Variable("?hand", HAND), bpns.Variable("?item", ITEM), bpns.Variable("?bin", BIN)
PICK = bpns.Operator(
    "Pick",
    parameters=(hand, item),
    preconditions=frozenset({HAND_EMPTY.lifted(hand)}),
    add_effects=frozenset({HOLDING.lifted(hand, item)}),
    delete_effects=frozenset({HAND_EMPTY.lifted(hand)}),
)
PLACE = bpns.Operator(
    "Place",
    parameters=(hand, item, bin_),
    preconditions=frozenset({HOLDING.lifted(hand, item)}),
    add_effects=frozenset({IN_BIN.lifted(item, bin_), HAND_EMPTY.lifted(hand)}),
    delete_effects=frozenset({HOLDING.lifted(hand, item)}),
)


@dataclass(frozen=True)
class Sorting:
    """The world. Fields with defaults are options: ``FILE:ENVIRONMENT:test_items=4``."""

    test_items: int = 3

    name: str = "sorting"  # the PDDL domain's name
    horizon: int = 200  # actions in a task, at most
    rollout_limit: int = 50  # actions of one skill, at most: a skill that is not over then has failed
    budget: bpns.Budget = field(default_factory=lambda: bpns.Budget(abstract_plans=8, samples_per_step=10))
    types = (HAND, ITEM, BIN)
    classifiers: Mapping[bpns.Predicate, Callable[[bpns.State, tuple[bpns.Object, ...]], bool]] = field(
        default_factory=lambda: {HAND_EMPTY: hand_empty, HOLDING: holding, IN_BIN: in_bin}
    )
    goal_predicates = frozenset({IN_BIN})  # goals are made of these
    # Where one of these changes, a demonstration is cut: what lies between two cuts is one skill. Choose what
    # says that a skill has done its work, such as contact; not what changes on the way.
    contact_predicates = frozenset({HOLDING, IN_BIN})
    oracle_skills = (
        bpns.Skill(PICK, MoveAnd(close=True), bpns.NoSampler()),
        bpns.Skill(PLACE, MoveAnd(close=False), AnywhereInBin()),
    )
    given_skills = ()  # policies that need no learning, such as a motion planner's
    action_low = np.array([-STEP, -1.0], np.float32)  # an action: metres to move, and open (< 0) or close
    action_high = np.array([STEP, 1.0], np.float32)

    def simulate(self, state: bpns.State, action: np.ndarray) -> bpns.State:
        """Return the next state. The same state and action must always give the same one.

        Raise bpns.EnvironmentFailure where there is none, such as after a collision, and ValueError for
        actions outside the box.
        """
        if not ((self.action_low <= action) & (action <= self.action_high)).all():
            raise ValueError(f"action {action.tolist()} is not in the box")
        robot = state.of_type(HAND)[0]
        move, grip = (float(number) for number in action)
        x = state[robot][0] + move
        changes: dict[str, tuple[float, ...]] = {robot.name: (x, float(grip > 0))}
        held = next((one for one in state.of_type(ITEM) if state[one][1] > 0.5), None)
        if held is not None:
            changes[held.name] = (x, float(grip > 0))
        elif grip > 0:
            near = [one for one in state.of_type(ITEM) if abs(state[one][0] - x) < REACH]
            if near:
                nearest = min(near, key=lambda one: abs(state[one][0] - x))
                changes[nearest.name] = (x, 1.0)
        return state.changed(changes)

    def sample_task(self, split: str, index: int, rng: np.random.Generator) -> bpns.Task:
        """Return a task; ``split`` is "train" (of demonstrations) or "test" (of evaluations)."""
        count = int(rng.integers(1, 3)) if split == "train" else self.test_items
        features: dict[bpns.Object, tuple[float, ...]] = {bpns.Object("hand0", HAND): (0.0, 0.0)}
        bins = [bpns.Object(f"bin{n}", BIN) for n in range(2)]
        items = [bpns.Object(f"item{n}", ITEM) for n in range(count)]
        places = rng.permutation(np.linspace(0.1, 1.9, 3 * count + 2))  # nothing lies upon another thing
        for number, one in enumerate(bins):
            features[one] = (2.2 + 0.3 * number, 0.2)
        for number, one in enumerate(items):
            features[one] = (float(places[number]), 0.0)
        goal = frozenset(IN_BIN(one, bins[int(rng.integers(2))]) for one in items)
        return bpns.Task(bpns.State.of(features), goal)

    def draw(
        self, state: bpns.State, caption: str = "", goal: frozenset[bpns.GroundAtom] = frozenset()
    ) -> Image.Image:
        """Return a picture; ``caption`` is up to three lines: the step, what changes, the goal."""
        picture = Image.new("RGB", (640, 200), "white")
        pen = ImageDraw.Draw(picture)
        pen.multiline_text((10, 8), caption, fill="black")

        def column(x: float) -> float:
            return 20 + 200 * x

        for one in state.of_type(BIN):
            x, width = state[one]
            pen.rectangle((column(x - width / 2), 130, column(x + width / 2), 170), outline="black")
            pen.text((column(x) - 10, 175), one.name, fill="black")
        for one in state.of_type(ITEM):
            x, is_held = state[one]
            middle = 110 if is_held else 155
            pen.ellipse((column(x) - 8, middle - 8, column(x) + 8, middle + 8), fill="orange")
            pen.text((column(x) - 4, middle - 6), one.name[4:], fill="black")
        for one in state.of_type(HAND):
            x, closed = state[one]
            pen.line((column(x), 70, column(x), 98), fill="black", width=6 if closed else 2)
        return picture


ENVIRONMENT = Sorting()
