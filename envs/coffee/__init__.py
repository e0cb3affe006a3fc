"""Coffee: a gripper heats a pot on a plate and pours into cups. Source: spec, coffee.md."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from bpns.envs.coffee.skills import ORACLE_SKILLS
from bpns.envs.coffee.tasks import sample_task
from bpns.envs.coffee.world import (
    BUTTON_PRESSED,
    CLASSIFIERS,
    CUP,
    CUP_FILLED,
    GRIPPER,
    HAND_EMPTY,
    IS_HOLDING,
    PLATE,
    POT,
    simulate,
)
from bpns.symbolic.skills.environment import Budget, Split
from bpns.symbolic.state import Array, State, Task
from bpns.symbolic.structs import GroundAtom

if TYPE_CHECKING:
    from PIL.Image import Image


@dataclass(frozen=True, slots=True)
class Coffee:
    """The environment; the options are how many cups there can be, each number as likely as the others."""

    train_cups: tuple[int, ...] = (1, 2)
    test_cups: tuple[int, ...] = (2, 3)

    name = "coffee"
    types = (GRIPPER, POT, PLATE, CUP)
    classifiers = CLASSIFIERS
    goal_predicates = frozenset({CUP_FILLED})
    contact_predicates = frozenset({IS_HOLDING, HAND_EMPTY, BUTTON_PRESSED, CUP_FILLED})
    oracle_skills = ORACLE_SKILLS
    given_skills = ()
    action_low = np.full(6, -1, np.float32)
    action_high = np.full(6, 1, np.float32)
    horizon = 1000
    rollout_limit = 1000
    budget = Budget(abstract_plans=1000, samples_per_step=10, samples_per_plan=100)

    def __post_init__(self) -> None:
        if not all(counts and min(counts) >= 1 for counts in (self.train_cups, self.test_cups)):
            raise ValueError("train_cups and test_cups are one or more numbers above 0")

    def simulate(self, state: State, action: Array) -> State:
        """Return the next state; the action is (dx, dy, dz, dtilt, dwrist, dfingers), each in [-1, 1]."""
        return simulate(state, action)

    def sample_task(self, split: Split, index: int, rng: np.random.Generator) -> Task:
        """Draw a task: fill all cups. Source: spec, coffee.md section 6."""
        return sample_task(rng, self.train_cups if split == "train" else self.test_cups)

    def draw(self, state: State, caption: str = "", goal: frozenset[GroundAtom] = frozenset()) -> "Image":
        """Return a picture of a state; the goal is not marked."""
        from bpns.envs.coffee.drawing import draw  # Pillow is slow to import

        return draw(state, caption)


ENVIRONMENT = Coffee()
