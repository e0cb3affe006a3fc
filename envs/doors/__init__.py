"""Doors: a robot opens doors to get from room to room. Source: spec, doors.md.

Moving is given, by motion planning; opening doors is to be learned.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from bpns.envs.doors.skills import MOVE_THROUGH_DOOR, MOVE_TO_DOOR, ORACLE_SKILLS
from bpns.envs.doors.tasks import sample_task
from bpns.envs.doors.world import (
    CLASSIFIERS,
    DOOR,
    IN_ROOM,
    OBSTACLE,
    ROBOT,
    ROOM,
    STEP,
    TOUCHING_DOOR,
    simulate,
)
from bpns.symbolic.skills.environment import Budget, Split
from bpns.symbolic.state import Array, State, Task
from bpns.symbolic.structs import GroundAtom

MOST_OBSTACLES = 4  # that surely fit around a room's center

if TYPE_CHECKING:
    from PIL.Image import Image


@dataclass(frozen=True, slots=True)
class Doors:
    """The environment; the options are the size of the map and how full it is."""

    rows: int = 5
    columns: int = 5
    room_share: tuple[float, float] = (0.25, 0.75)  # of the cells of the grid: least and most
    obstacles: tuple[int, int] = (0, 3)  # in a room: least and most

    name = "doors"
    types = (ROBOT, DOOR, ROOM, OBSTACLE)
    classifiers = CLASSIFIERS
    goal_predicates = frozenset({IN_ROOM})
    contact_predicates = frozenset({TOUCHING_DOOR, IN_ROOM})
    oracle_skills = ORACLE_SKILLS
    given_skills = (MOVE_TO_DOOR, MOVE_THROUGH_DOOR)
    action_low = np.array([-STEP, -STEP, -np.inf], np.float32)
    action_high = np.array([STEP, STEP, np.inf], np.float32)
    horizon = 1000
    rollout_limit = 1000
    budget = Budget(abstract_plans=8, samples_per_step=10)

    def __post_init__(self) -> None:
        if min(self.rows, self.columns) < 1:
            raise ValueError("rows and columns are numbers above 0")
        if len(self.room_share) != 2 or not 0 <= self.room_share[0] <= self.room_share[1] <= 1:
            raise ValueError("room_share is two numbers in 0..1: least,most")
        if int(self.room_share[0] * self.rows * self.columns) < 2:
            raise ValueError("there must be two rooms at least: more rows, columns or room_share")
        if len(self.obstacles) != 2 or not 0 <= self.obstacles[0] <= self.obstacles[1] <= MOST_OBSTACLES:
            raise ValueError(f"obstacles is two numbers in 0..{MOST_OBSTACLES}: least,most in a room")

    def simulate(self, state: State, action: Array) -> State:
        """Return the next state; the action is (dx, dy, rotation), the last one absolute."""
        return simulate(state, action)

    def sample_task(self, split: Split, index: int, rng: np.random.Generator) -> Task:
        """Draw a task; both splits are alike. Source: spec, doors.md section 6."""
        return sample_task(rng, self.rows, self.columns, self.room_share, self.obstacles)

    def draw(self, state: State, caption: str = "", goal: frozenset[GroundAtom] = frozenset()) -> "Image":
        """Return a picture of a state; rooms that the goal names have a color of their own."""
        from bpns.envs.doors.drawing import draw  # Pillow is slow to import

        return draw(state, caption, goal)


ENVIRONMENT = Doors()
