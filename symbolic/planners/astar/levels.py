"""All plans of one length after another, the most different first, while every step costs one."""

from collections import deque
from collections.abc import Iterator, Mapping
from math import inf
from random import Random
from typing import TypeAlias

from bpns.symbolic.planners.astar.nodes import Node, Path, State
from bpns.symbolic.planners.astar.product import Product

_IN_VAIN = 4  # states looked at in vain for one plan before the heuristic is asked about more of them
_FAILURES = 2  # lengths of which a state has no way before we ask whether it has any

Way: TypeAlias = "tuple[int, Way] | None"  # an operator and the way on from there; None at a goal


class Ways:
    """The ways of one length from a state to a goal: those found so far, and where there may be more."""

    __slots__ = ("done", "found", "later", "length", "sources", "state", "untried")

    def __init__(self, state: State, length: int) -> None:
        self.state = state
        self.length = length
        self.found: list[Way] = [None] if state.goal and not length else []
        self.done = state.goal  # whether all are found
        self.untried: list[int] | None = (
            None  # places among the children, the next one last; None: not looked
        )
        self.sources: deque[Source] = deque()  # the next one first
        self.later = inf  # no way that is longer is shorter than this


class Source:
    """A step to a child, and how many of the child's ways were taken."""

    __slots__ = ("operator", "taken", "ways")

    def __init__(self, operator: int, ways: Ways) -> None:
        self.operator = operator
        self.ways = ways
        self.taken = 0


class Levels:
    """Lists plans in order of length; of those equally long, every state takes turns among its children.

    What is found from a state serves all plans that come to it with as many steps left, and so does what is
    not found. A state's ways are put together from its children's, as by Jimenez and Marzal, Computing the K
    shortest paths, WAE 1999, but those of one length at a time, so that bounds apply and circles do no harm.
    """

    def __init__(self, product: Product, random: Random) -> None:
        self.product = product
        self.random = random
        self.by_length: list[dict[Node, Ways]] = []
        self.effort = 0  # states looked at in vain for the present plan

    def plans(self, first: Path) -> Iterator[list[int]]:
        """Yield all plans as operator numbers, given the path of one of the shortest."""
        start = self.product.root
        assert isinstance(start, State)
        yield [node.operators[place] for node, place in first]
        if start.goal:
            return
        length: float = len(first)
        self._lead(first)
        self._extend(self._ways(start, len(first)))  # what was just given
        while length < inf:
            ways = self._ways(start, int(length))
            while self._extend(ways):
                steps = []
                way = ways.found[-1]
                while way is not None:
                    number, way = way
                    steps.append(number)
                yield steps
            length = ways.later

    def _lead(self, path: Path) -> None:
        """Have a known plan found first."""
        for left, (node, place) in zip(range(len(path), 0, -1), path, strict=True):
            assert isinstance(node, State)
            untried = self._look(self._ways(node, left))
            untried.remove(place)
            untried.append(place)

    def _ways(self, state: State, length: int) -> Ways:
        """Return the ways of a length from a state, always the same object."""
        while len(self.by_length) <= length:
            self.by_length.append({})
        known = self.by_length[length]
        ways = known.get(state)
        if ways is None:
            ways = known[state] = Ways(state, length)
            self.product.record.nodes_created += 1
        return ways

    def _extend(self, top: Ways) -> bool:
        """Find one more way; False if there is none. Without recursion, as plans can be long."""
        self.product.check()
        self.effort = 0
        wanted = len(top.found)
        stack = [] if top.done else [top]
        while stack:
            ways = stack[-1]
            source = self._next_source(ways)
            if source is None:
                self._end(ways)
                stack.pop()
                continue
            child = source.ways
            if source.taken < len(child.found):
                ways.found.append((source.operator, child.found[source.taken]))
                ways.state.alive = True
                self.product.record.nodes_created += 1
                source.taken += 1
                ways.sources.rotate(-1)
                stack.pop()
            elif child.done:
                ways.sources.popleft()
                ways.later = min(ways.later, child.later + 1)
            else:
                stack.append(child)
        return len(top.found) > wanted

    def _look(self, ways: Ways) -> list[int]:
        """List the children that may lead to a goal in time; next is one from which a way is known."""
        self.product.check()
        left = ways.length - 1
        children = self.product.open(ways.state)
        ways.untried = untried = [place for place, child in enumerate(children) if child.value <= left]
        if len(untried) < len(children):
            ways.later = min([child.value for child in children if child.value > left]) + 1
        known: Mapping[Node, Ways] = self.by_length[left] if left < len(self.by_length) else {}
        for index, place in enumerate(untried):
            if (there := known.get(children[place])) and there.found:
                untried[index], untried[-1] = untried[-1], place
                return untried
        self._choose(untried)
        return untried

    def _choose(self, untried: list[int]) -> None:
        """Put any one of them last."""
        if len(untried) > 1:
            index = int(self.random.random() * len(untried))
            untried[index], untried[-1] = untried[-1], untried[index]

    def _next_source(self, ways: Ways) -> Source | None:
        """Return the child whose turn it is, new ones first; None if there is none."""
        if ways.sources and not ways.sources[0].taken:
            return ways.sources[0]
        left = ways.length - 1
        untried = ways.untried if ways.untried is not None else self._look(ways)
        while untried:
            place = untried.pop()
            self._choose(untried)
            child = self.product.open(ways.state)[place]
            assert isinstance(child, State)
            if child.unsure and self.effort > _IN_VAIN and child.value <= left:
                self.product.check()
                self.product.evaluate(child)
            if child.value > left:
                ways.later = min(ways.later, child.value + 1)
                continue
            ways.sources.appendleft(Source(ways.state.operators[place], self._ways(child, left)))
            break
        return ways.sources[0] if ways.sources else None

    def _end(self, ways: Ways) -> None:
        """Note that there are no more; if there are none at all, learn from it."""
        ways.done = True
        if not ways.found:
            self.effort += 1
            state = ways.state
            children = self.product.open(state)
            state.value = max(state.value, 1 + min([child.value for child in children], default=inf))
            state.failures += 1
            if state.failures > _FAILURES and not self.product.can_end(state):
                ways.later = inf
