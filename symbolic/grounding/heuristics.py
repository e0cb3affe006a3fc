"""Delete-relaxation heuristics on compiled problems: how far is the goal if nothing is ever deleted.

``LmCut`` never overestimates; ``hadd`` and ``hff`` may. All ignore negative preconditions and goals, which
keeps ``LmCut`` admissible. A value of infinity proves that the goal cannot be reached.
"""

from collections.abc import Callable
from heapq import heappop, heappush
from math import inf
from typing import TypeAlias

from bpns.symbolic.grounding.masks import CompiledProblem, bits

Heuristic: TypeAlias = Callable[[int], float]


class Relaxed:
    """The relaxed problem as lists: atoms by number, then 'always true' and 'goal' as two more."""

    def __init__(self, problem: CompiledProblem) -> None:
        self.true = len(problem.atoms)
        self.goal = self.true + 1
        self.atoms = self.true + 2
        self.preconditions = [bits(o.preconditions) or [self.true] for o in problem.operators]
        self.preconditions.append(bits(problem.goal) or [self.true])
        self.effects = [bits(o.add & ~o.preconditions) for o in problem.operators] + [[self.goal]]
        self.costs = [1.0] * len(problem.operators) + [0.0]
        self.missing = [len(p) for p in self.preconditions]
        self.users: list[list[int]] = [[] for _ in range(self.atoms)]
        for number, atoms in enumerate(self.preconditions):
            for atom in atoms:
                self.users[atom].append(number)

    def start(self, state: int) -> list[int]:
        """Return the atoms of a state."""
        return [*bits(state), self.true]

    def sums(self, state: int) -> tuple[list[float], list[int]]:
        """Return each atom's cost and achiever, where several atoms cost the sum of each one's cost."""
        value = [inf] * self.atoms
        achiever = [-1] * self.atoms
        missing = self.missing.copy()
        sums = self.costs.copy()
        heap: list[tuple[float, int]] = []
        for atom in self.start(state):
            value[atom] = 0
            heap.append((0, atom))
        heap.sort()
        while heap:
            cost, atom = heappop(heap)
            if cost > value[atom]:
                continue
            for number in self.users[atom]:
                missing[number] -= 1
                sums[number] += cost
                if missing[number]:
                    continue
                reached = sums[number]
                for effect in self.effects[number]:
                    if reached < value[effect]:
                        value[effect] = reached
                        achiever[effect] = number
                        heappush(heap, (reached, effect))
        return value, achiever


def hadd(problem: CompiledProblem) -> Heuristic:
    """Sum of the goal atoms' relaxed costs."""
    relaxed = Relaxed(problem)
    return lambda state: relaxed.sums(state)[0][relaxed.goal]


def hff(problem: CompiledProblem) -> Heuristic:
    """Cost of a relaxed plan, read off the cheapest achievers by hadd."""
    relaxed = Relaxed(problem)

    def evaluate(state: int) -> float:
        value, achiever = relaxed.sums(state)
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


class LmCut:
    """Number of disjoint sets of operators (landmarks) of which every plan uses one each; admissible.

    A landmark of a state is one of its successor too unless it contains the operator between them. Looking
    for landmarks starts from those, so that a search pays for the few that are new, not for all.

    Source: Helmert and Domshlak, Landmarks, critical paths and abstractions, ICAPS 2009; Pommerening and
    Helmert, Incremental LM-cut, ICAPS 2013.
    """

    def __init__(self, problem: CompiledProblem) -> None:
        self.relaxed = Relaxed(problem)
        self.landmarks: dict[int, tuple[frozenset[int], ...]] = {}  # state -> found so far; mostly shared
        self.achievers: list[list[int]] = [[] for _ in range(self.relaxed.atoms)]
        for number, effects in enumerate(self.relaxed.effects):
            for effect in effects:
                self.achievers[effect].append(number)

    def inherit(self, state: int, parent: int, operator: int) -> None:
        """Let a state that was never called begin with what its parent has; the parent must have some."""
        known = self.landmarks[parent]
        if state not in self.landmarks:
            kept = tuple(landmark for landmark in known if operator not in landmark)
            self.landmarks[state] = known if len(kept) == len(known) else kept

    def known(self, state: int) -> tuple[int, frozenset[int]]:
        """Return how many landmarks a state has so far, and all their operators: each leads to one less."""
        landmarks = self.landmarks[state]
        return len(landmarks), frozenset().union(*landmarks)

    def __call__(self, state: int) -> float:
        """Return the number of landmarks, infinity where the goal cannot be reached."""
        relaxed = self.relaxed
        landmarks = list(self.landmarks.get(state, ()))
        free = bytearray(len(relaxed.costs))  # operators in a landmark, which cost nothing from then on
        free[-1] = 1  # the one that reaches the goal
        for landmark in landmarks:
            for number in landmark:
                free[number] = 1
        while True:
            level, missing = self._levels(state, free)
            if level[relaxed.goal] == inf:
                return inf
            if level[relaxed.goal] == 0:
                self.landmarks[state] = tuple(landmarks)
                return len(landmarks)
            supporter = self._supporters(level, missing)
            cut = self._cut(state, supporter, self._zone(supporter, free))
            landmarks.append(cut)
            for number in cut:
                free[number] = 1

    def _levels(self, state: int, free: bytearray) -> tuple[list[float], list[int]]:
        """Return each atom's cost, that of several being the highest, and how many each operator lacks.

        Ends once the goal is free.
        """
        relaxed = self.relaxed
        level = [inf] * relaxed.atoms
        missing = relaxed.missing.copy()
        now, cost = relaxed.start(state), 0
        for atom in now:
            level[atom] = 0
        while now and level[relaxed.goal]:
            later: list[int] = []
            for atom in now:  # which grows meanwhile
                if level[atom] < cost:
                    continue
                for number in relaxed.users[atom]:
                    missing[number] -= 1
                    if missing[number]:
                        continue
                    reached, reachable = (cost, now) if free[number] else (cost + 1, later)
                    for effect in relaxed.effects[number]:
                        if level[effect] > reached:
                            level[effect] = reached
                            reachable.append(effect)
            now, cost = later, cost + 1
        return level, missing

    def _supporters(self, level: list[float], missing: list[int]) -> list[int]:
        """Return each operator's most expensive precondition, -1 where one is out of reach.

        Of several such, the last by number, and so one with the last predicate by name: where operators
        choose alike, each set holds fewer of them and there are more sets.
        """
        supporter = [-1] * len(missing)
        for atom in sorted((f for f in range(len(level)) if level[f] < inf), key=level.__getitem__):
            for number in self.relaxed.users[atom]:
                supporter[number] = atom
        return [-1 if lacks else atom for lacks, atom in zip(missing, supporter, strict=True)]

    def _zone(self, supporter: list[int], free: bytearray) -> set[int]:
        """Return the atoms from which the goal follows at no cost."""
        stack = [self.relaxed.goal]
        zone = set(stack)
        while stack:
            for number in self.achievers[stack.pop()]:
                atom = supporter[number]
                if atom >= 0 and free[number] and atom not in zone:
                    zone.add(atom)
                    stack.append(atom)
        return zone

    def _cut(self, state: int, supporter: list[int], zone: set[int]) -> frozenset[int]:
        """Return the operators that lead from the atoms reached outside the zone into it."""
        relaxed = self.relaxed
        stack = relaxed.start(state)
        seen = set(stack)
        cut = []
        while stack:
            atom = stack.pop()
            for number in relaxed.users[atom]:
                if supporter[number] != atom:
                    continue
                effects = relaxed.effects[number]
                if not zone.isdisjoint(effects):
                    cut.append(number)
                    continue
                for effect in effects:
                    if effect not in seen:
                        seen.add(effect)
                        stack.append(effect)
        return frozenset(cut)


HEURISTICS: dict[str, Callable[[CompiledProblem], Heuristic]] = {"lmcut": LmCut, "hadd": hadd, "hff": hff}
