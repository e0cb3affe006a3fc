"""All plans of a compiled problem in order of cost, the most different first."""

from collections.abc import Iterator
from heapq import heappop, heappush
from math import inf
from random import Random

import numpy as np

from bpns.symbolic.grounding.heuristics import Heuristic
from bpns.symbolic.grounding.masks import CompiledProblem
from bpns.symbolic.planners.astar.levels import Levels
from bpns.symbolic.planners.astar.nodes import EnoughError, Node, Path, State, StoppedError
from bpns.symbolic.planners.astar.product import CHEAP, Product
from bpns.symbolic.planners.costs import Costs
from bpns.symbolic.planners.protocol import Limit, SearchRecord

EXPLORE_AFTER = 1000  # states opened since costs change: fewer are no reason to look at all there are


class _CheapestPlans:
    """Finds the cheapest plan that was not given yet, again and again, and learns from it.

    ``best`` is A*. Then it raises the values of all nodes that it opened to what its result implies (Koenig
    and Likhachev, Adaptive A*, AAMAS 2005): values then fall from the root to a goal by just what each step
    costs. While plans of this cost are left, ``next_alike`` finds them without a queue.
    """

    def __init__(self, product: Product, random: Random) -> None:
        self.product = product
        self.random = random
        self.effort = 0  # states opened for the present plan

    def asks(self, state: Node, doubtful: bool) -> bool:
        """Evaluate a state if that may pay; say whether its value rose."""
        if not state.unsure:
            return False
        if self.product.landmarks is not None and not doubtful and self.effort < CHEAP:
            return False
        assert isinstance(state, State)
        before = state.value
        self.product.evaluate(state)
        return state.value > before

    def next_alike(self) -> Path | None:
        """Return a path that costs what the root's value says; None if there is none, and then it rises."""
        product, costs = self.product, self.product.costs
        path: Path = []
        node = product.root
        while not node.goal:
            children = node.children if node.children is not None else product.open(node)
            place = node.way
            extra = node.extra
            if place >= 0 and extra + costs[node.operators[place]] + children[place].value <= node.value:
                path.append((node, place))
                node = children[place]
                continue
            product.check()
            totals = [extra + costs[o] + c.value for o, c in zip(node.operators, children, strict=True)]
            least = min(totals, default=inf)
            if least <= node.value < inf:
                place = self.choose(node, [i for i, total in enumerate(totals) if total <= node.value])
                child = children[place]
                if not self.asks(child, totals[place] < node.value):
                    path.append((node, place))
                    node = child
                continue
            self.effort += 1
            node.value = least
            if not node.alive:
                product.can_end(node)
                path.clear()  # as it may have raised values along the path
                node = product.root
                continue
            if not path:
                return None
            node, _ = path.pop()
        return path

    def choose(self, node: Node, places: list[int]) -> int:
        """Choose among children: where plans were given, the least tried; elsewhere, where we were before."""
        assert node.children is not None
        if len(places) == 1:
            return places[0]
        if isinstance(node, State):
            known = [i for i in places if node.children[i].alive]
        else:
            fewest = min([node.children[i].given for i in places])
            known = [i for i in places if node.children[i].given == fewest]
        places = known or places
        return places[int(self.random.random() * len(places))]

    def best(self) -> Path | None:
        """Return the cheapest path to a goal, by A*; None where there is none."""
        product, costs = self.product, self.product.costs
        start = product.root
        first = isinstance(start, State)
        reached: dict[Node, float] = {start: 0}
        came_from: dict[Node, tuple[Node, int]] = {}
        closed: dict[Node, None] = {}
        deepest = -1.0
        queue: list[tuple[float, float, int, float, Node]] = []
        low = start.value

        def push(node: Node) -> None:
            if node.value < inf:
                entry = (reached[node] + node.value, node.value, node.given, self.random.random(), node)
                heappush(queue, entry)

        push(start)
        goal: Node | None = None
        total = inf
        while queue:
            product.check()
            estimate, value, _, _, node = heappop(queue)
            spent = reached[node]
            if spent + value < estimate:
                continue  # reached at less cost since
            if node.value > value or self.asks(node, estimate < low):
                push(node)
                continue
            low = max(low, estimate)
            self.effort += spent <= deepest  # what does not lead on
            deepest = max(deepest, spent)
            if node.goal:
                goal, total = node, spent
                break
            if not first and not node.alive and not product.can_end(node):
                continue
            closed[node] = None
            spent += node.extra
            for place, child in enumerate(self.product.open(node)):
                cost = spent + costs[node.operators[place]]
                if cost < reached.get(child, inf):
                    reached[child] = cost
                    came_from[child] = node, place
                    push(child)
        self._learn(closed, reached, total)
        return None if goal is None else _path(goal, came_from)

    def _learn(self, closed: dict[Node, None], reached: dict[Node, float], total: float) -> None:
        """Raise the values of opened nodes to what a search that came to a goal at this total implies."""
        costs = self.product.costs
        for node in closed:
            node.value = max(node.value, total - reached[node])
            if total == inf:
                node.base = inf
        for node in reversed(closed):  # where the way on from one of them costs more, say so
            assert node.children is not None
            ways = zip(node.operators, node.children, strict=True)
            least = min([costs[o] + c.value for o, c in ways], default=inf)
            node.value = max(node.value, node.extra + least)

    def next(self) -> Path | None:
        """Return the cheapest path to a goal; None where there is none."""
        root = self.product.root
        path = None if isinstance(root, State) else self.next_alike()
        while path is None and self.product.space is not None and root.value < inf:
            path = self.next_alike()  # values are exact but for plans just given: they rise quickly
        return self.best() if path is None and root.value < inf else path

    def plans(self, costs: Costs | None) -> Iterator[list[int]]:
        """Yield plans as lists of operator numbers: by ``Levels`` while all steps cost one."""
        product = self.product
        if product.landmarks is not None and not (costs and costs.version):
            first = self.best()
            if first is None:
                return
            given = []
            for steps in Levels(product, self.random).plans(first):
                yield steps
                if costs is not None:
                    given.append(steps)
                    if costs.version:
                        break
            else:
                return
            for steps in given:
                product.give(product.follow(steps))
        yield from self.plans_by_cost(costs)

    def plans_by_cost(self, costs: Costs | None) -> Iterator[list[int]]:
        """Yield the plans that are left, whatever the costs are at each moment."""
        product = self.product
        numbers = {o.ground: i for i, o in enumerate(product.problem.operators)} if costs else {}
        version = 0
        patience = product.record.nodes_expanded + EXPLORE_AFTER if costs else inf
        while True:
            self.effort = 0
            product.check()
            if costs is not None and costs.version > version:
                changed = [o for o in costs.changed_since(version) if o in numbers]
                product.change({numbers[o]: costs.of(o) for o in changed})
                for prefix in costs.prefixes_changed_since(version):
                    if all(o in numbers for o in prefix):
                        product.penalize([numbers[o] for o in prefix], costs.of_prefix(prefix))
                for prefix in costs.closed_since(version):
                    if all(o in numbers for o in prefix):
                        product.close([numbers[o] for o in prefix])
                version = costs.version
                if product.space is not None:
                    product.measure()
            product.patience = patience
            try:
                path = self.next()
            except EnoughError:
                patience = inf
                product.explore()
                continue
            finally:
                product.patience = inf
            if path is None:
                return
            for node, place in path:
                if isinstance(node, State):
                    node.alive, node.way = True, place
            steps = [node.operators[place] for node, place in path]
            product.give(path)
            yield steps


def _path(goal: Node, came_from: dict[Node, tuple[Node, int]]) -> Path:
    """Return how a goal was reached."""
    path: Path = []
    node = goal
    while node in came_from:
        path.append(came_from[node])
        node = path[-1][0]
    return path[::-1]


def enumerate_plans(
    problem: CompiledProblem,
    heuristic: Heuristic,
    rng: np.random.Generator,
    limit: Limit,
    record: SearchRecord,
    costs: Costs | None = None,
) -> Iterator[list[int]]:
    """Yield plans as lists of operator numbers, in order of cost where the heuristic is admissible.

    It must be so for unit costs. ``costs`` may change between plans; without them every step costs 1. Until a
    penalty is set, ``Levels`` lists the plans of our own lmcut, at little cost for each; after that, and with
    other heuristics, each plan is searched for.
    No step leaves the abstract state as it is.
    """
    try:
        product = Product(problem, heuristic, limit, record, costs is not None)
        yield from _CheapestPlans(product, Random(int(rng.integers(2**63)))).plans(costs)
    except StoppedError:
        return
