"""Abstract states, and those states again with what was already given: what our search walks on.

A ``State`` is an abstract state. A ``Branch`` is a state reached by the first steps of a plan that was given;
its children are that state's, but where given plans go on there are branches, and where they end is nothing.
So the plans not yet given are exactly the paths from the root to a goal.
"""

from collections.abc import Sequence
from math import inf
from typing import TypeAlias


class State:
    """An abstract state; ``value`` is at most what the cheapest way from it to a goal costs."""

    __slots__ = (
        "alive", "base", "branches", "children", "failures", "given", "goal", "mask", "number", "operators",
        "origin", "parents", "unsure", "value", "way",
    )  # fmt: skip

    extra = 0.0

    def __init__(self, mask: int, goal: bool, value: float, origin: "tuple[State, int] | None") -> None:
        self.mask = mask
        self.number = -1  # in the space of all states, once there is one
        self.goal = goal
        self.value = self.base = value  # base: the part that holds whatever the penalties are
        self.operators: Sequence[int] = ()
        self.children: list[Node] | None = None  # one for each operator; None until it is opened
        self.given = 0
        self.failures = 0  # lengths of which it has no way to a goal
        self.alive = goal  # whether a goal is known to be within reach
        self.unsure = not goal  # whether the heuristic was not asked yet
        self.origin = origin  # where it was discovered, and by which operator
        self.way = -1  # which child the last plan through it went on to
        self.parents: list[tuple[State, int]] | None = (
            None  # opened states, and which child of theirs this is
        )
        self.branches: list[Branch] | None = None


class Branch:
    """A state after the first steps of given plans; ``value`` is about the plans not given yet.

    ``extra`` is paid on entering it, and is a part of ``value``.
    """

    __slots__ = (
        "above", "base", "children", "depth", "extra", "failures", "given", "number", "operators", "place",
        "rest", "state", "value",
    )  # fmt: skip

    goal = False
    alive = True
    way = -1
    unsure = False

    def __init__(
        self, state: State, rest: Sequence[int], above: "Branch | None", place: int, number: int
    ) -> None:
        self.number = number
        self.depth: int = 0 if above is None else above.depth + 1
        self.state = state
        self.rest = rest  # how the one given plan goes on: places among the children, until it is opened
        self.above = above  # the branch before it, and its place among that one's children
        self.place = place
        self.operators = state.operators
        self.children: list[Node] | None = None if rest else []
        self.value, self.base = (state.value, state.base) if rest else (inf, inf)
        self.given = 1  # plans given that begin like this
        self.extra = 0.0


Node: TypeAlias = State | Branch
Path: TypeAlias = list[tuple[Node, int]]  # nodes and which of its children each is left by


class StoppedError(Exception):
    """A limit was reached."""


class EnoughError(Exception):
    """So many states were opened that it pays to look at all there are."""
