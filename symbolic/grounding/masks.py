"""A ground problem as numbered atoms and bit masks: what search and heuristics work on."""

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from bpns.symbolic.grounding.ground import GroundProblem
from bpns.symbolic.operators import GroundOperator
from bpns.symbolic.structs import GroundAtom, sort_atoms


@dataclass(frozen=True, slots=True)
class CompiledOperator:
    """A ground operator as masks over the numbered atoms."""

    ground: GroundOperator
    preconditions: int
    forbidden: int
    add: int
    keep: int  # all ones except the atoms that are deleted and not added

    def applicable(self, state: int) -> bool:
        """Say whether the preconditions hold."""
        return state & self.preconditions == self.preconditions and not state & self.forbidden

    def apply(self, state: int) -> int:
        """Return the next abstract state."""
        return state & self.keep | self.add


@dataclass(frozen=True, slots=True)
class CompiledProblem:
    """Bit i of a state says whether ``atoms[i]`` holds. Atoms that can never change are left out."""

    atoms: tuple[GroundAtom, ...]
    constant: frozenset[GroundAtom]  # initial atoms that always hold
    operators: tuple[CompiledOperator, ...]
    init: int
    goal: int
    forbidden_goal: int

    def is_goal(self, state: int) -> bool:
        """Say whether the goal holds."""
        return state & self.goal == self.goal and not state & self.forbidden_goal

    def decode(self, state: int) -> frozenset[GroundAtom]:
        """Return the abstract state that a mask stands for."""
        return self.constant | {atom for i, atom in enumerate(self.atoms) if state >> i & 1}


def bits(mask: int) -> list[int]:
    """Return the positions of the ones, ascending."""
    found = []
    while mask:
        low = mask & -mask
        found.append(low.bit_length() - 1)
        mask ^= low
    return found


def compile_problem(ground: GroundProblem) -> CompiledProblem:
    """Give numbers to the atoms that can change; sorted, so that the same problem gives the same numbers."""
    problem = ground.problem
    changing = {a for o in ground.operators for a in o.add_effects | o.delete_effects}
    possible = problem.init | {a for o in ground.operators for a in o.add_effects}
    numbered = changing & possible
    atoms = tuple(sort_atoms(numbered))
    index = {atom: i for i, atom in enumerate(atoms)}
    everything = (1 << len(atoms)) - 1

    def mask(chosen: Iterable[GroundAtom]) -> int:
        return sum(1 << index[a] for a in set(chosen) if a in index)

    operators = tuple(
        CompiledOperator(
            o,
            mask(o.preconditions),
            mask(o.negative_preconditions),
            mask(o.add_effects),
            everything & ~mask(o.delete_effects - o.add_effects),
        )
        for o in ground.operators
    )
    constant = problem.init - numbered
    return CompiledProblem(
        atoms, constant, operators, mask(problem.init), mask(problem.goal), mask(problem.negative_goal)
    )


def successor_function(problem: CompiledProblem) -> Callable[[int], list[tuple[int, int]]]:
    """Return a function that lists the operators applicable in a state, ascending, with the next state.

    It looks only at operators that wait for an atom of the state: each waits for its precondition that
    fewest operators share.
    """
    preconditions = [bits(o.preconditions) for o in problem.operators]
    shared = Counter(atom for atoms in preconditions for atom in atoms)
    waiting: dict[int, list[tuple[int, int, int, int, int]]] = defaultdict(list)  # a bit, or 0 for nothing
    for number, (atoms, o) in enumerate(zip(preconditions, problem.operators, strict=True)):
        bit = 1 << min(atoms, key=lambda atom: shared[atom]) if atoms else 0
        waiting[bit].append((number, o.preconditions, o.forbidden, o.keep, o.add))
    always = waiting.pop(0, [])
    watched = sum(waiting)

    def find(state: int) -> list[tuple[int, int]]:
        candidates = always.copy()
        rest = state & watched
        while rest:
            bit = rest & -rest
            rest ^= bit
            candidates += waiting[bit]
        found = [
            (number, state & keep | add)
            for number, needed, forbidden, keep, add in candidates
            if state & needed == needed and not state & forbidden
        ]
        found.sort()
        return found

    return find


def applicable_operators(problem: CompiledProblem) -> Callable[[int], list[int]]:
    """Return a function that lists the operators applicable in a state, ascending."""
    successors = successor_function(problem)
    return lambda state: [number for number, _ in successors(state)]
