"""Stick Button: a robot presses buttons by hand, or with a stick where its hand cannot go.

Source: spec, stick_button.md.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from bpns.envs.stick_button.skills import ORACLE_SKILLS
from bpns.envs.stick_button.tasks import sample_task
from bpns.envs.stick_button.world import (
    BUTTON,
    CLASSIFIERS,
    GRASPED,
    GRIPPER,
    HOLDER,
    PRESSED,
    STICK,
    simulate,
)
from bpns.symbolic.skills.environment import Budget, Split
from bpns.symbolic.state import Array, State, Task
from bpns.symbolic.structs import GroundAtom

if TYPE_CHECKING:
    from PIL.Image import Image


@dataclass(frozen=True, slots=True)
class StickButton:
    """The environment; the counts of buttons are drawn from these."""

    train_buttons: tuple[int, ...] = (1, 2)
    test_buttons: tuple[int, ...] = (3, 4)

    name = "stick_button"
    types = (GRIPPER, BUTTON, STICK, HOLDER)
    classifiers = CLASSIFIERS
    goal_predicates = frozenset({PRESSED})
    contact_predicates = frozenset({GRASPED, PRESSED})
    oracle_skills = ORACLE_SKILLS
    given_skills = ()
    action_low = np.array([-1, -1, -1], np.float32)
    action_high = np.array([1, 1, 1], np.float32)
    horizon = 100
    rollout_limit = 50
    budget = Budget(abstract_plans=1000, samples_per_step=10, samples_per_plan=100)

    def __post_init__(self) -> None:
        if not all(counts and min(counts) >= 1 for counts in (self.train_buttons, self.test_buttons)):
            raise ValueError("train_buttons and test_buttons are one or more numbers above 0")

    def simulate(self, state: State, action: Array) -> State:
        """Return the next state; the action is (dx, dy, force)."""
        return simulate(state, action)

    def sample_task(self, split: Split, index: int, rng: np.random.Generator) -> Task:
        """Draw a task: press all buttons. Source: spec, stick_button.md section 6."""
        return sample_task(rng, self.train_buttons if split == "train" else self.test_buttons)

    def draw(self, state: State, caption: str = "", goal: frozenset[GroundAtom] = frozenset()) -> "Image":
        """Return a picture of a state; the goal is not marked."""
        from bpns.envs.stick_button.drawing import draw  # Pillow is slow to import

        return draw(state, caption)


ENVIRONMENT = StickButton()
