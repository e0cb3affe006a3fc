"""All plans of a compiled problem in order of cost: A* that keeps every path."""

from collections.abc import Iterator
from heapq import heappop, heappush
from math import inf
from typing import NamedTuple

import numpy as np

from symbolic.compile import CompiledProblem, applicable_operators
from symbolic.heuristics import Heuristic, LmCut
from symbolic.planners import Limit, SearchRecord


class Node(NamedTuple):
    """A path: how its last state was reached."""

    state: int
    length: int
    parent: "Node | None"
    operator: int

    def steps(self) -> list[int]:
        """Return the numbers of the operators along the path."""
        steps = []
        node = self
        while node.parent is not None:
            steps.append(node.operator)
            node = node.parent
        return steps[::-1]


class _PathSearch:
    """A* over paths with estimates that sharpen as states are visited again.

    Until the first plan, a path to a state that was expanded at no greater length is set aside: this is
    A* on states, which proves that there is no plan when the queue runs empty. From then on every path
    counts. What keeps that from exploding are the estimates: no expanded state can be nearer to a goal
    than the first plan's length minus its own depth, and no state nearer than its best successor.

    Paths into states from which no goal can be reached are dropped then; they would go in circles forever.

    Among paths of equal estimated length, those nearest to a goal go first until there is a plan, and
    random ones afterwards: a first plan soon, then plans that differ.

    With LM-cut, a new state's estimate is at first only what its parent's landmarks give. Evaluating it is
    put off until a path to it is taken from the queue, which most never are.
    """

    def __init__(
        self, problem: CompiledProblem, heuristic: Heuristic, rng: np.random.Generator, record: SearchRecord
    ) -> None:
        self.problem = problem
        self.heuristic = heuristic
        self.rng = rng
        self.record = record
        self.queue: list[tuple[float, float, float, int, Node]] = []  # length, tie, random tie, serial number
        self.applicable = applicable_operators(problem)
        self.estimates: dict[int, float] = {}  # state -> lower bound on the length of the rest
        self.unsure: set[int] = set()  # states that are not evaluated yet
        self.successors: dict[int, list[tuple[int, int]]] = {}  # state -> (operator, next state)
        self.depth: dict[int, int] = {}  # expanded state -> least length of a path to it so far
        self.aside: list[Node] | None = []  # None once there is a plan
        self.alive: set[int] = set()  # states from which a goal can be reached, as far as known
        self.serial = 0  # keeps the queue from ever comparing nodes
        self.discover(problem.init, None, -1)
        self.push(Node(problem.init, 0, None, -1))

    def estimate(self, state: int) -> float:
        """Return the best lower bound on the rest of a plan from a state; evaluates what was put off."""
        if state in self.unsure:
            self.unsure.remove(state)
            if not self.problem.is_goal(state):
                self.estimates[state] = max(self.estimates[state], self.heuristic(state))
        return self.estimates[state]

    def discover(self, state: int, parent: int | None, operator: int) -> None:
        """Estimate a new state, at first only roughly where that is cheap."""
        self.unsure.add(state)
        self.estimates[state] = 0
        if parent is not None and isinstance(self.heuristic, LmCut):
            self.estimates[state] = self.heuristic.inherit(state, parent, operator)
        else:
            self.estimate(state)

    def push(self, node: Node) -> None:
        """Queue a new path unless no goal can be reached from its end."""
        self.record.nodes_created += 1
        self.requeue(node)

    def requeue(self, node: Node) -> None:
        """Queue a path by the present estimate."""
        rest = self.estimates[node.state]
        if rest < inf:
            self.serial += 1
            tie = 0 if self.aside is None else rest
            heappush(self.queue, (node.length + rest, tie, self.rng.random(), self.serial, node))

    def expand(self, state: int) -> list[tuple[int, int]]:
        """Return operators and next states."""
        if state not in self.successors:
            operators = self.problem.operators
            found = [(number, operators[number].apply(state)) for number in self.applicable(state)]
            self.successors[state] = found
            for number, following in found:
                if following not in self.estimates:
                    self.discover(following, state, number)
        return self.successors[state]

    def sharpen(self, node: Node) -> bool:
        """Raise the estimates along a path to what the successors allow; say whether its end's rose."""
        rose = False
        step: Node | None = node
        while step is not None:
            best = min((1 + self.estimates[s] for _, s in self.expand(step.state)), default=inf)
            if best <= self.estimates[step.state]:
                break
            self.estimates[step.state] = best
            rose = True
            step = step.parent
        return rose

    def can_end(self, state: int, limit: Limit) -> bool:
        """Say whether a goal can be reached from a state; yes where a limit ends the question.

        Where no goal can be reached, no estimate is high enough.
        """
        came_from: dict[int, int | None] = {state: None}
        queue = [(self.estimate(state), state)]
        while queue:
            rest, now = heappop(queue)
            if self.estimate(now) > rest:
                if self.estimates[now] < inf:
                    heappush(queue, (self.estimates[now], now))
                continue
            if limit.late or len(came_from) > limit.nodes:
                return True
            if now in self.alive or self.problem.is_goal(now):
                step: int | None = now
                while step is not None:
                    self.alive.add(step)
                    step = came_from[step]
                return True
            for _, following in self.expand(now):
                if following not in came_from and self.estimates[following] < inf:
                    came_from[following] = now
                    heappush(queue, (self.estimates[following], following))
        self.estimates.update(dict.fromkeys(came_from, inf))
        return False

    def found_first(self, length: int) -> None:
        """Use the first plan's length, and queue all paths anew with those that were set aside."""
        nodes = [entry[-1] for entry in self.queue] + (self.aside or [])
        self.queue, self.aside = [], None
        for state, depth in self.depth.items():
            self.estimates[state] = max(self.estimates[state], length - depth)
        for node in nodes:
            self.requeue(node)

    def run(self, limit: Limit) -> Iterator[list[int]]:
        """Yield plans as lists of operator numbers."""
        while self.queue:
            if self.record.nodes_created >= limit.nodes or limit.late:
                self.record.stopped_by = "time limit" if limit.late else "node limit"
                return
            total, _, _, _, node = heappop(self.queue)
            if node.length + self.estimate(node.state) > total:
                self.requeue(node)
            elif self.problem.is_goal(node.state):
                if self.aside is not None:
                    self.found_first(node.length)
                yield node.steps()
            elif self.aside is not None and self.depth.get(node.state, inf) <= node.length:
                self.aside.append(node)
            elif self.aside is None and (not self.can_end(node.state, limit) or self.sharpen(node)):
                self.requeue(node)  # unless it is dead
            else:
                self.depth[node.state] = min(node.length, self.depth.get(node.state, node.length))
                self.record.nodes_expanded += 1
                for number, state in self.expand(node.state):
                    self.push(Node(state, node.length + 1, node, number))


def enumerate_plans(
    problem: CompiledProblem,
    heuristic: Heuristic,
    rng: np.random.Generator,
    limit: Limit,
    record: SearchRecord,
) -> Iterator[list[int]]:
    """Yield plans as lists of operator numbers; in order of length where the heuristic is admissible."""
    return _PathSearch(problem, heuristic, rng, record).run(limit)
