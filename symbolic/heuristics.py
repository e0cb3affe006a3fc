"""Delete-relaxation heuristics on compiled problems: how far is the goal if nothing is ever deleted.

``lmcut`` never overestimates; ``hadd`` and ``hff`` may. All ignore negative preconditions and goals, which
keeps ``lmcut`` admissible. A value of infinity proves that the goal cannot be reached.
"""

from collections.abc import Callable
from heapq import heappop, heappush
from math import inf
from typing import TypeAlias

from symbolic.compile import CompiledProblem, bits

Heuristic: TypeAlias = Callable[[int], float]


class Relaxed:
    """The relaxed problem as lists: facts are atoms by number, then 'always true', then 'goal'."""

    def __init__(self, problem: CompiledProblem) -> None:
        self.true = len(problem.atoms)
        self.goal = self.true + 1
        self.facts = self.true + 2
        self.preconditions = [bits(o.preconditions) or [self.true] for o in problem.operators]
        self.preconditions.append(bits(problem.goal) or [self.true])
        self.effects = [bits(o.add & ~o.preconditions) for o in problem.operators] + [[self.goal]]
        self.costs = [1.0] * len(problem.operators) + [0.0]
        self.users: list[list[int]] = [[] for _ in range(self.facts)]
        for number, facts in enumerate(self.preconditions):
            for fact in facts:
                self.users[fact].append(number)

    def start(self, state: int) -> list[int]:
        """Return the facts of a state."""
        return [*bits(state), self.true]

    def explore(
        self, state: int, costs: list[float], *, add: bool
    ) -> tuple[list[float], list[int], list[int]]:
        """Return each fact's value and achiever, and each operator's most expensive precondition.

        An operator's value is the sum (``add``) or the maximum of its preconditions' values.
        """
        value = [inf] * self.facts
        achiever = [-1] * self.facts
        supporter = [-1] * len(costs)
        missing = [len(p) for p in self.preconditions]
        sums = [0.0] * len(costs)
        heap: list[tuple[float, int]] = []
        for fact in self.start(state):
            value[fact] = 0
            heap.append((0, fact))
        heap.sort()
        while heap:
            cost, fact = heappop(heap)
            if cost > value[fact]:
                continue
            for number in self.users[fact]:
                missing[number] -= 1
                sums[number] += cost
                if missing[number]:
                    continue
                supporter[number] = fact  # facts leave the heap by value: the last one is the maximum
                reached = costs[number] + (sums[number] if add else cost)
                for effect in self.effects[number]:
                    if reached < value[effect]:
                        value[effect] = reached
                        achiever[effect] = number
                        heappush(heap, (reached, effect))
        return value, achiever, supporter


def hadd(problem: CompiledProblem) -> Heuristic:
    """Sum of the goal atoms' relaxed costs."""
    relaxed = Relaxed(problem)
    return lambda state: relaxed.explore(state, relaxed.costs, add=True)[0][relaxed.goal]


def hff(problem: CompiledProblem) -> Heuristic:
    """Cost of a relaxed plan, read off the cheapest achievers by hadd."""
    relaxed = Relaxed(problem)

    def evaluate(state: int) -> float:
        value, achiever, _ = relaxed.explore(state, relaxed.costs, add=True)
        if value[relaxed.goal] == inf:
            return inf
        plan: set[int] = set()
        stack = [relaxed.goal]
        while stack:
            number = achiever[stack.pop()]
            if number >= 0 and number not in plan:
                plan.add(number)
                stack.extend(relaxed.preconditions[number])
        return sum(relaxed.costs[number] for number in plan)

    return evaluate


def lmcut(problem: CompiledProblem) -> Heuristic:
    """Sum of the costs of disjunctive action landmarks; admissible.

    Source: Helmert and Domshlak, Landmarks, critical paths and abstractions, ICAPS 2009.
    """
    relaxed = Relaxed(problem)
    achievers: list[list[int]] = [[] for _ in range(relaxed.facts)]
    for number, effects in enumerate(relaxed.effects):
        for effect in effects:
            achievers[effect].append(number)

    def evaluate(state: int) -> float:
        costs = list(relaxed.costs)
        total = 0.0
        while True:
            value, _, supporter = relaxed.explore(state, costs, add=False)
            if value[relaxed.goal] == inf:
                return inf
            if value[relaxed.goal] == 0:
                return total
            zone = {relaxed.goal}  # facts from which the goal follows at no cost
            stack = [relaxed.goal]
            while stack:
                for number in achievers[stack.pop()]:
                    fact = supporter[number]
                    if fact >= 0 and costs[number] == 0 and fact not in zone:
                        zone.add(fact)
                        stack.append(fact)
            cut = _cut(relaxed, state, supporter, zone)
            cheapest = min(costs[number] for number in cut)
            total += cheapest
            for number in cut:
                costs[number] -= cheapest

    return evaluate


def _cut(relaxed: Relaxed, state: int, supporter: list[int], zone: set[int]) -> list[int]:
    """Return the operators that lead from the facts reached outside the zone into it."""
    stack = relaxed.start(state)
    seen = set(stack)
    cut = []
    while stack:
        fact = stack.pop()
        for number in relaxed.users[fact]:
            if supporter[number] != fact:
                continue
            if any(effect in zone for effect in relaxed.effects[number]):
                cut.append(number)
                continue
            for effect in relaxed.effects[number]:
                if effect not in seen:
                    seen.add(effect)
                    stack.append(effect)
    return cut


HEURISTICS: dict[str, Callable[[CompiledProblem], Heuristic]] = {"lmcut": lmcut, "hadd": hadd, "hff": hff}
