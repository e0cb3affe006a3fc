"""All abstract states within reach at once, as arrays, and exact distances to the goal under any costs."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bpns.symbolic.grounding.masks import CompiledProblem

MOST_PAIRS, MOST_STEPS = 3_000_000, 150_000  # of states and operators: what takes a fraction of a second
_ENTRIES = 1 << 22  # of the largest array that is made at once
_WORD = 64

Words = NDArray[np.uint64]


class Space:
    """The states that can be reached, and the steps between them; a plan ends at its first goal state."""

    def __init__(self, problem: CompiledProblem, masks: Words, edges: Sequence[NDArray[np.intp]]) -> None:
        self.words = masks.shape[1]
        self.index = {row.tobytes(): number for number, row in enumerate(masks)}
        self.sources, self.operators, self.targets = edges  # sources ascend
        self.goals = _goals(problem, masks)
        self.starts = np.flatnonzero(np.diff(self.sources, prepend=-1))
        self.distances = np.zeros(len(masks))

    def measure(self, costs: Sequence[float]) -> None:
        """Compute each state's distance to the nearest goal; infinite where there is none."""
        steps = np.asarray(costs)[self.operators]
        distances = np.where(self.goals, 0.0, np.inf)
        leaving = self.sources[self.starts]
        while len(leaving):
            least = np.minimum.reduceat(steps + distances[self.targets], self.starts)
            if np.array_equal(least, distances[leaving]):
                break
            distances[leaving] = least
        self.distances = distances

    def number(self, mask: int) -> int:
        """Return a state's number."""
        return self.index[mask.to_bytes(8 * self.words, "little")]


def explore(problem: CompiledProblem) -> Space | None:
    """Return the space of a problem; None where it is too large."""
    words = max(1, -(-len(problem.atoms) // _WORD))
    needed, forbidden, keep, add = (
        _rows([getattr(o, part) for o in problem.operators], words)
        for part in ("preconditions", "forbidden", "keep", "add")
    )
    key = np.dtype(np.uint64 if words == 1 else (np.void, 8 * words))
    layer = _rows([problem.init], words)
    number = {layer[0].tobytes(): 0}
    layers = [layer]
    sources: list[NDArray[np.intp]] = []
    operators: list[NDArray[np.intp]] = []
    targets: list[NDArray[np.intp]] = []
    first = 0  # number of the layer's first state
    while len(layer):
        if len(number) * len(problem.operators) > MOST_PAIRS:
            return None
        rows, taken = _steps(layer, ~_goals(problem, layer), needed, forbidden)
        if sum(map(len, targets)) + len(rows) > MOST_STEPS:
            return None
        after = (layer[rows] & keep[taken]) | add[taken]
        changing = (after != layer[rows]).any(axis=1)
        rows, taken, after = rows[changing], taken[changing], after[changing]
        distinct, places = np.unique(after.view(key).ravel(), return_inverse=True)
        names = [one.tobytes() for one in distinct]
        new = [name for name in names if name not in number]
        number |= {name: len(number) + place for place, name in enumerate(new)}
        sources.append(rows + first)
        operators.append(taken)
        targets.append(np.array([number[name] for name in names], np.intp)[places])
        first += len(layer)
        layer = np.frombuffer(b"".join(new), np.uint64).reshape(-1, words)
        layers.append(layer)
    edges = [np.concatenate(parts) for parts in (sources, operators, targets)]
    return Space(problem, np.concatenate(layers), edges)


def _rows(masks: Sequence[int], words: int) -> Words:
    data = b"".join(mask.to_bytes(8 * words, "little") for mask in masks)
    return np.frombuffer(data, np.dtype("<u8")).reshape(-1, words)


def _goals(problem: CompiledProblem, masks: Words) -> NDArray[np.bool_]:
    goal, forbidden = _rows([problem.goal, problem.forbidden_goal], masks.shape[1])
    return np.asarray(((masks & goal) == goal).all(axis=1) & ((masks & forbidden) == 0).all(axis=1))


def _steps(
    layer: Words, open_: NDArray[np.bool_], needed: Words, forbidden: Words
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return which operators are applicable where: rows of the layer, ascending, and operators."""
    chunk = max(1, _ENTRIES // max(1, needed.size))
    found = []
    for begin in range(0, len(layer), chunk):
        states = layer[begin : begin + chunk, None]
        fits = ((states & needed) == needed).all(axis=2) & ((states & forbidden) == 0).all(axis=2)
        fits &= open_[begin : begin + chunk, None]
        rows, operators = np.nonzero(fits)
        found.append((rows + begin, operators))
    rows, operators = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return rows, operators
