"""Motion planning for a point among obstacles: bidirectional RRT with smoothing.

Source: spec, doors.md section 7; Kuffner and LaValle, RRT-Connect, ICRA 2000.
"""

from collections.abc import Callable
from math import floor, hypot
from typing import NamedTuple

import numpy as np

from bpns.envs.shapes2d import Point

ATTEMPTS, ITERATIONS, SMOOTHING_TRIES = 10, 100, 50

Free = Callable[[Point], bool]


class _Node(NamedTuple):
    point: Point
    parent: "_Node | None"

    def path(self) -> list[Point]:
        """Return the points from the tree's root to here."""
        points = []
        node: _Node | None = self
        while node is not None:
            points.append(node.point)
            node = node.parent
        return points[::-1]


def line(start: Point, end: Point, step: float) -> list[Point]:
    """Return points on the way to ``end``, which is the last one, at most ``step`` apart."""
    count = floor(hypot(end[0] - start[0], end[1] - start[1]) / step) + 1
    shares = [i / count for i in range(1, count + 1)]
    return [(start[0] * (1 - s) + end[0] * s, start[1] * (1 - s) + end[1] * s) for s in shares]


def plan_motion(
    start: Point,
    target: Point,
    free: Free,
    sample: Callable[[], Point],
    step: float,
    rng: np.random.Generator,
) -> list[Point] | None:
    """Return points from start to target, at most ``step`` apart and all free; None where none were found."""
    if not free(start) or not free(target):
        return None
    direct = line(start, target, step)
    if all(map(free, direct)):
        return [start, *direct]
    for _ in range(ATTEMPTS):
        path = _connect(start, target, free, sample, step)
        if path is not None:
            return _smoothed(path, free, step, rng)
    return None


def _connect(
    start: Point, target: Point, free: Free, sample: Callable[[], Point], step: float
) -> list[Point] | None:
    """Grow a tree from either end until they meet."""
    one, two = [_Node(start, None)], [_Node(target, None)]
    swapped = False
    for _ in range(ITERATIONS):
        if len(one) > len(two):
            one, two, swapped = two, one, not swapped
        here, _ = _extend(one, sample(), free, step)
        there, met = _extend(two, here.point, free, step)
        if met:
            path = here.path() + there.path()[-2::-1]  # both end at the same point
            return path[::-1] if swapped else path
    return None


def _extend(tree: list[_Node], goal: Point, free: Free, step: float) -> tuple[_Node, bool]:
    """Grow a tree from its nearest node towards a point; return the last node and whether it is there."""
    x, y = goal
    node = min(tree, key=lambda n: (n.point[0] - x) ** 2 + (n.point[1] - y) ** 2)
    for point in line(node.point, goal, step):
        if not free(point):
            return node, False
        node = _Node(point, node)
        tree.append(node)
    return node, True


def _smoothed(path: list[Point], free: Free, step: float, rng: np.random.Generator) -> list[Point]:
    """Try shortcuts between random points."""
    for _ in range(SMOOTHING_TRIES):
        i, j = sorted(rng.integers(0, len(path) - 1, size=2).tolist())
        if j - i <= 1:
            continue
        shortcut = line(path[i], path[j], step)
        if len(shortcut) < j - i and all(map(free, shortcut)):
            path = path[: i + 1] + shortcut + path[j + 1 :]
    return path
