"""Cover: a gripper over a line picks blocks and puts them on targets. Source: spec, cover.md."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from bpns.envs.cover.skills import ORACLE_SKILLS
from bpns.envs.cover.tasks import sample_task
from bpns.envs.cover.world import (
    BLOCK,
    BLOCK_REGION,
    CLASSIFIERS,
    COVERS,
    GRIPPER,
    HAND_EMPTY,
    IS_HOLDING,
    TARGET,
    TARGET_REGION,
    simulate,
)
from bpns.symbolic.skills.environment import Budget, Split
from bpns.symbolic.state import Array, State, Task
from bpns.symbolic.structs import GroundAtom

if TYPE_CHECKING:
    from PIL.Image import Image


@dataclass(frozen=True, slots=True)
class Cover:
    """The environment; the options are those of the paper's supplementary experiments."""

    train_irrelevant_blocks: int = 0  # tiny ones, far away
    test_irrelevant_blocks: int = 0

    name = "cover"
    types = (BLOCK, TARGET, GRIPPER, BLOCK_REGION, TARGET_REGION)
    classifiers = CLASSIFIERS
    goal_predicates = frozenset({COVERS})
    contact_predicates = frozenset({COVERS, HAND_EMPTY, IS_HOLDING})
    oracle_skills = ORACLE_SKILLS
    given_skills = ()
    action_low = np.array([-np.inf, -np.inf, -1], np.float32)
    action_high = np.array([np.inf, np.inf, 1], np.float32)
    horizon = 100
    rollout_limit = 1000
    budget = Budget(abstract_plans=8, samples_per_step=10)

    def simulate(self, state: State, action: Array) -> State:
        """Return the next state; the action is (dx, dy, grip)."""
        return simulate(state, action)

    def sample_task(self, split: Split, index: int, rng: np.random.Generator) -> Task:
        """Draw a task; the goals take turns. Source: spec, cover.md section 6."""
        irrelevant = self.train_irrelevant_blocks if split == "train" else self.test_irrelevant_blocks
        return sample_task(rng, index, irrelevant)

    def draw(self, state: State, caption: str = "", goal: frozenset[GroundAtom] = frozenset()) -> "Image":
        """Return a picture of a state; the goal is not marked."""
        from bpns.envs.cover.drawing import draw  # Pillow is slow to import

        return draw(state, caption)


ENVIRONMENT = Cover()
