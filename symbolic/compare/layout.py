"""Where the nodes, arrows and labels of a directed graph go: nodes on an ellipse, labels where there is room.

All lengths are in inches, x to the right, y upwards. Nothing is random.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from math import cos, pi, sin

import networkx as nx
import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Edge = tuple[str, str]
Size = tuple[float, float]  # width, height

WIDTH, NARROW = 7.4, 3.8  # of the picture; of the ellipse at least
GAP = 0.04  # kept free around boxes
NEAR = 0.1  # arrows that are nearer than this look like one
BENDS = (0.05, 0.12, 0.2, 0.3, -0.08, -0.18)  # of an arrow to the left, as a share of its length
SAMPLES = 100  # points of an arrow
PLACES = np.linspace(0.2, 0.8, 13)  # of a label along its arrow
SIDES = (0.0, 1.0, -1.0)  # of an arrow, for its label: on it, to the left, to the right
PASSES = 8
LARGE = 80  # arrows; with more, nothing is improved, as it takes long and is too much to read anyway


@dataclass(frozen=True, slots=True)
class Layout:
    """A graph's geometry."""

    nodes: Mapping[str, Array]  # (2,) centres
    arrows: Mapping[Edge, Array]  # (P, 2) points from box to box
    labels: Mapping[Edge, Array]  # (2,) centres


def lay_out(graph: "nx.DiGraph[str]", boxes: Mapping[str, Size], labels: Mapping[Edge, Size]) -> Layout:
    """Return a layout for a graph, whose nodes' boxes and edges' labels have the given sizes.

    Arrows and labels take the best of their places in turn, until none moves or PASSES are over.
    """
    order = circular_order(list(graph), list(graph.edges))
    centres = _centres(order, boxes)
    nodes = {name: _box(centres[name], boxes[name]) for name in graph}
    edges = list(graph.edges)
    arrows = {edge: _arrow(centres, boxes, edge, BENDS[0]) for edge in edges}
    places = {edge: arrows[edge][len(arrows[edge]) // 2] for edge in edges}
    for _ in range(PASSES if len(edges) <= LARGE else 0):
        before = dict(places)
        for edge in edges:
            others = [other for other in edges if other != edge]
            taken = np.array([*nodes.values(), *(_box(places[o], labels[o]) for o in others)])
            lines = np.concatenate([np.empty((0, 2)), *(arrows[o][::3] for o in others)])
            bent = [(bend, _arrow(centres, boxes, edge, bend)) for bend in BENDS]
            arrows[edge], places[edge] = _best(bent, labels[edge], taken, lines)
        if all(np.array_equal(before[edge], places[edge]) for edge in edges):
            break
    return Layout(centres, arrows, places)


def circular_order(nodes: Sequence[str], edges: Sequence[Edge]) -> list[str]:
    """Return an order around a circle with few crossings and short edges; no move of one node helps."""
    links = sorted({(min(e), max(e)) for e in edges if e[0] != e[1]})

    def cost(order: Sequence[str]) -> float:
        place = {name: number for number, name in enumerate(order)}
        spans = [sorted((place[a], place[b])) for a, b in links]
        crossings = sum(a < c < b < d or c < a < d < b for (a, b), (c, d) in combinations(spans, 2))
        return crossings + 0.4 * sum(min(b - a, len(order) - b + a) for a, b in spans)

    best = list(nodes)
    lowest = cost(best)
    improved = len(edges) <= LARGE
    while improved:
        improved = False
        for name in nodes:
            rest = [other for other in best if other != name]
            for place in range(1, len(best)):
                order = [*rest[:place], name, *rest[place:]]
                if (found := cost(order)) < lowest:
                    best, lowest, improved = order, found, True
    first = best.index(nodes[0]) if nodes else 0
    return best[first:] + best[:first]


def _centres(order: Sequence[str], boxes: Mapping[str, Size]) -> dict[str, Array]:
    """Return the nodes' centres on an ellipse, clockwise from the top; two stand side by side."""
    count = len(order)
    widest = max((width for width, _ in boxes.values()), default=0.0)
    size = np.array([max(NARROW, WIDTH - widest), 1.5 + 0.5 * count if count > 2 else 0.0])
    top = pi / 2 if count > 2 else pi
    angles = [top - 2 * pi * number / count for number in range(count)]
    while True:
        centres = [size / 2 * (cos(angle), sin(angle)) for angle in angles]
        placed = [_box(centre, boxes[name]) for centre, name in zip(centres, order, strict=True)]
        apart = ((a[:2] > b[2:]) | (b[:2] > a[2:]) for a, b in combinations(placed, 2))
        if all(sides.any() for sides in apart):
            return dict(zip(order, centres, strict=True))
        size *= (1.1, 1.03)


def _box(centre: Array, size: Size) -> Array:
    """Return (left, bottom, right, top) with the gap around it."""
    half = np.array(size) / 2 + GAP
    return np.concatenate([centre - half, centre + half])


def _arrow(centres: Mapping[str, Array], boxes: Mapping[str, Size], edge: Edge, bend: float) -> Array:
    """Return the points of a bent line between two boxes; one from a node to itself is a loop, outwards."""
    start, end = (centres[name] for name in edge)
    share = np.linspace(0, 1, SAMPLES)[:, None]
    if edge[0] == edge[1]:
        away = start / max(1e-9, float(np.hypot(*start)))
        aside = np.array([-away[1], away[0]])
        reach = 0.9 + 2 * bend + abs(away[0]) * boxes[edge[0]][0] / 2
        one, two = start + reach * away + 0.7 * aside, start + reach * away - 0.7 * aside
        ends = (1 - share) ** 3 * start + share**3 * end
        points = ends + 3 * (1 - share) * share * ((1 - share) * one + share * two)
    else:
        along = end - start
        middle = (start + end) / 2 + bend * np.array([-along[1], along[0]])
        points = (1 - share) ** 2 * start + 2 * (1 - share) * share * middle + share**2 * end
    outside = ~_inside(points, _box(start, boxes[edge[0]])) & ~_inside(points, _box(end, boxes[edge[1]]))
    return np.asarray(points[outside] if outside.sum() > 3 else points)


def _inside(points: Array, boxes: Array) -> npt.NDArray[np.bool_]:
    """Say which points (P, 2) are in which boxes (..., 4): (..., P)."""
    x, y = points[:, 0], points[:, 1]
    left, bottom, right, top = (boxes[..., None, side] for side in range(4))
    return np.asarray((x > left) & (x < right) & (y > bottom) & (y < top))


def _best(
    bent: Sequence[tuple[float, Array]], label: Size, taken: Array, lines: Array
) -> tuple[Array, Array]:
    """Return the arrow, of some with their bends, and its label's place that disturb others least.

    ``taken`` (B, 4) are the boxes of nodes and other labels, ``lines`` (L, 2) the points of other arrows.
    """
    best: tuple[float, Array, Array] | None = None
    for bend, points in bent:
        aside, above = (np.abs(points[::2, None, axis] - lines[:, axis]) for axis in (0, 1))
        near = np.maximum(aside, above).min(axis=1, initial=np.inf) < NEAR
        cost = 3 * _inside(points, taken).sum() + 0.5 * near.sum() + 5 * abs(bend)
        places, dislike = _label_places(points, label)
        room = np.concatenate(
            [places - np.array(label) / 2 - GAP, places + np.array(label) / 2 + GAP], axis=1
        )
        shared = np.minimum(room[:, None, 2:], taken[:, 2:]) - np.maximum(room[:, None, :2], taken[:, :2])
        overlap = np.maximum(shared, 0).prod(axis=2).sum(axis=1)
        crossed = _inside(lines, room + NEAR * np.array([-1, -1, 1, 1])).sum(axis=1)
        covered = _inside(points, room).mean(axis=1)
        costs = cost + 1000 * overlap + crossed + 6 * covered**2 + dislike
        number = int(costs.argmin())
        if best is None or costs[number] < best[0]:
            best = float(costs[number]), points, places[number]
    assert best is not None
    return best[1], best[2]


def _label_places(points: Array, label: Size) -> tuple[Array, Array]:
    """Return centres for a label, on a line and on both sides of it, and how much each is disliked."""
    numbers = np.rint(PLACES * (len(points) - 1)).astype(int)
    along = points[np.minimum(numbers + 1, len(points) - 1)] - points[np.maximum(numbers - 1, 0)]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    across /= np.maximum(1e-9, np.hypot(along[:, 0], along[:, 1]))[:, None]
    free = np.hypot(across[:, 0] * label[0], across[:, 1] * label[1]) / 2 + 2 * GAP
    sides = np.array(SIDES)[:, None, None]
    places = points[numbers] + sides * free[:, None] * across
    dislike = np.abs(sides[..., 0]) + 4 * np.abs(PLACES - 0.5)
    return places.reshape(-1, 2), dislike.reshape(-1)
