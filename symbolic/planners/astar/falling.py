"""Values that fall with costs: only what rests on a cost that fell is looked at.

A value above its ``base`` is never above the least of cost plus value among the children (see ``Product``).
Lowering a value to what one child allows keeps that true.
"""

from collections.abc import Sequence

from bpns.symbolic.planners.astar.nodes import Branch, Node, State


def spread(lowered: list[Node], costs: Sequence[float]) -> None:
    """Lower what rests on nodes whose values fell."""
    while lowered:
        node = lowered.pop()
        if isinstance(node, Branch):
            if node.above is not None:
                _relax(node.above, node.place, costs, lowered)
            continue
        for branch in node.branches or ():
            if branch.children is None and branch.value > node.value:
                branch.value = node.value
                lowered.append(branch)
        for state, place in node.parents or ():
            relax_all(state, place, node, costs, lowered)


def relax_all(
    state: State, place: int, child: Node | None, costs: Sequence[float], lowered: list[Node]
) -> None:
    """Relax a state and its branches; only those that have the given child, if one is given."""
    _relax(state, place, costs, lowered)
    for branch in state.branches or ():
        if branch.children is not None and child in (None, branch.children[place]):
            _relax(branch, place, costs, lowered)


def _relax(node: Node, place: int, costs: Sequence[float], lowered: list[Node]) -> None:
    """Lower a value to what one child allows, but not below its base."""
    if node.value > node.base:
        assert node.children is not None
        cost = node.extra + costs[node.operators[place]]
        bound = max(node.base, cost + node.children[place].value)
        if bound < node.value:
            node.value = bound
            lowered.append(node)
