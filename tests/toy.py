"""A world without robots: find a key that fits, then open the door.

``search`` draws a key (a number); ``unlock`` works only with keys above 0.7, though every key gives the same
atoms. So a plan fails at its second step because of its first, and only backtracking solves it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from PIL import Image

from bpns.symbolic.operators import Operator
from bpns.symbolic.skills.environment import Budget, Classifier, EnvironmentFailure, Split
from bpns.symbolic.skills.skill import Controller, NoSampler, Skill
from bpns.symbolic.state import Array, State, Task
from bpns.symbolic.structs import GroundAtom, Object, Predicate, Type, Variable

HAND = Type("hand", ("key", "step"))
DOOR = Type("door", ("open",))
HAS_KEY = Predicate("HasKey", (HAND,))
IS_OPEN = Predicate("IsOpen", (DOOR,))
HAND_0, DOOR_0 = Object("hand0", HAND), Object("door0", DOOR)
_HAND, _DOOR = Variable("?hand", HAND), Variable("?door", DOOR)
SEARCH = Operator("search", (_HAND,), frozenset(), frozenset({HAS_KEY.lifted(_HAND)}), frozenset())
UNLOCK = Operator(
    "unlock",
    (_DOOR, _HAND),
    frozenset({HAS_KEY.lifted(_HAND)}),
    frozenset({IS_OPEN.lifted(_DOOR)}),
    frozenset({HAS_KEY.lifted(_HAND)}),
)


def _first_feature_is_positive(state: State, objects: tuple[Object, ...]) -> bool:
    return state[objects[0]][0] > 0


@dataclass(frozen=True)
class KeySampler:
    dimension: int = 1

    def sample(self, state: State, objects: tuple[Object, ...], rng: np.random.Generator) -> Array:
        return np.array([rng.uniform()], np.float32)


@dataclass(frozen=True)
class Repeat:
    """Sends the same action all the time: (kind, value)."""

    kind: float

    def begin(self, state: State, objects: tuple[Object, ...], subgoal: Array) -> Controller:
        value = float(subgoal[0]) if len(subgoal) else 0.0
        return lambda _: np.array([self.kind, value], np.float32)


SKILLS = {
    "search": Skill(SEARCH, Repeat(0), KeySampler()),
    "unlock": Skill(UNLOCK, Repeat(1), NoSampler()),
}


@dataclass(frozen=True)
class Toy:
    """``fails_below`` makes keys below it an environment failure."""

    fails_below: float = 0.0
    horizon: int = 20
    name: str = "toy"
    rollout_limit: int = 10
    budget: Budget = field(default_factory=lambda: Budget(3, 5))
    types = (HAND, DOOR)
    classifiers: Mapping[Predicate, Classifier] = field(
        default_factory=lambda: {
            HAS_KEY: _first_feature_is_positive,
            IS_OPEN: _first_feature_is_positive,
        }
    )
    goal_predicates = frozenset({IS_OPEN})
    contact_predicates = frozenset({HAS_KEY, IS_OPEN})
    oracle_skills = tuple(SKILLS.values())
    given_skills = ()
    action_low = np.array([0, 0], np.float32)
    action_high = np.array([1, 1], np.float32)

    def simulate(self, state: State, action: Array) -> State:
        kind, value = action.tolist()
        if not (0 <= kind <= 1 and 0 <= value <= 1):
            raise ValueError(f"action {action.tolist()} is not in the box (kind and value in [0, 1])")
        key, step = state[HAND_0]
        if kind == 0:
            if value < self.fails_below:
                raise EnvironmentFailure("the key broke")
            return state.changed({"hand0": (value, step + 1)})
        if key > 0.7:
            return state.changed({"hand0": (0.0, step + 1), "door0": (1.0,)})
        return state

    def sample_task(self, split: Split, index: int, rng: np.random.Generator) -> Task:
        return Task(State.of({HAND_0: (0, 0), DOOR_0: (0,)}), frozenset({IS_OPEN(DOOR_0)}))

    def draw(self, state: State, caption: str = "", goal: frozenset[GroundAtom] = frozenset()) -> Image.Image:
        return Image.new("RGB", (8, 8))
