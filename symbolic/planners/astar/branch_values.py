"""What the plans cost that are left below each branch, for all branches at once."""

from array import array
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(slots=True)
class _Level:
    """The opened branches at one distance from the root, and the ways on from them, one after another."""

    branches: "array[int]" = field(default_factory=lambda: array("q"))
    starts: "array[int]" = field(default_factory=lambda: array("q"))  # where each one's ways begin
    operators: "array[int]" = field(default_factory=lambda: array("q"))
    targets: "array[int]" = field(default_factory=lambda: array("q"))


class BranchValues:
    """Branches by number; a target is the number of a state, or that of a branch after all states.

    A branch is worth what its state is until it is opened.
    """

    def __init__(self, states: int) -> None:
        self.first = states  # the target that stands for branch 0
        self._states = array("q")
        self.extras = array("d")  # paid on entering each; infinite where nothing is left
        self._levels: list[_Level] = []
        self._rows: dict[int, tuple[_Level, int]] = {}  # an opened branch's level and first way

    def __len__(self) -> int:
        return len(self._states)

    def add(self, state: int) -> None:
        """Add the next branch, of a state."""
        self._states.append(state)
        self.extras.append(0.0)

    def set_ways(self, branch: int, depth: int, operators: Sequence[int], targets: list[int]) -> None:
        """Set where a branch's operators lead; again if that changes."""
        if branch not in self._rows:
            while len(self._levels) <= depth:
                self._levels.append(_Level())
            level = self._levels[depth]
            self._rows[branch] = level, len(level.operators)
            level.branches.append(branch)
            level.starts.append(len(level.operators))
            level.operators.extend(operators)
            level.targets.extend(targets)
        else:
            level, start = self._rows[branch]
            level.targets[start : start + len(targets)] = array("q", targets)

    def measure(self, distances: Floats, costs: Sequence[float]) -> Floats:
        """Return all branches' values, from the states' distances; infinite where no way is left."""
        if not self._states:
            return distances[:0]
        prices = np.array(costs)
        extras = np.frombuffer(self.extras, np.float64)
        values = np.concatenate([distances, distances[np.frombuffer(self._states, np.int64)] + extras])
        for level in reversed(self._levels):
            operators, targets = (np.frombuffer(a, np.int64) for a in (level.operators, level.targets))
            least = np.minimum.reduceat(prices[operators] + values[targets], level.starts)
            rows = np.frombuffer(level.branches, np.int64)
            values[self.first + rows] = extras[rows] + least
        return values[self.first :]
