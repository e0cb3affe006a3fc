"""Exact values: once all states are known, each measurement takes one pass over arrays."""

from collections.abc import Iterable, Sequence
from math import inf

from bpns.symbolic.planners.astar.branch_values import BranchValues
from bpns.symbolic.planners.astar.nodes import Branch, State
from bpns.symbolic.planners.astar.space import Space


def measure(
    space: Space,
    values: BranchValues,
    costs: Sequence[float],
    states: Iterable[State],
    branches: Sequence[Branch],
    touched: Iterable[Branch],
) -> None:
    """Set all values to what follows from exact distances at these costs.

    ``branches`` are all there are, in the order in which they were made; ``touched`` are those that changed
    since the last time.
    """
    space.measure(costs)
    distances = space.distances.tolist()
    for state in states:
        if state.number < 0:
            state.number = space.number(state.mask)
        state.value, state.unsure = distances[state.number], False
    for branch in branches[len(values) :]:
        values.add(branch.state.number)
    for branch in touched:
        values.extras[branch.number] = inf if branch.children == [] else branch.extra
        if branch.children:
            targets = [c.number + (values.first if isinstance(c, Branch) else 0) for c in branch.children]
            values.set_ways(branch.number, branch.depth, branch.operators, targets)
    found = values.measure(space.distances, costs).tolist()
    for branch, value in zip(branches, found, strict=True):
        branch.value = value
