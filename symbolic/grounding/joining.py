"""Joining an operator's preconditions with the atoms reached so far, on numbers instead of objects.

An operator becomes a pattern: a term is the number of a slot to be filled, or ``-1 - n`` for object n.
Parameters that must be equal share a slot, so that a positive equality costs nothing.
"""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from time import monotonic
from typing import TypeAlias

from bpns.symbolic.operators import Operator
from bpns.symbolic.structs import EQUAL, LiftedAtom, Object, Type, Variable

Term: TypeAlias = Variable | Object
Row: TypeAlias = tuple[int, ...]  # terms of a lifted atom, or the objects of a ground one
NumberedAtom: TypeAlias = tuple[str, Row]  # with its predicate's name
_FREE = -1  # in a binding: a slot that is not filled yet
_TICKS = 256  # between two looks at the clock


class TimeIsUp(Exception):
    """The deadline has passed."""


class Clock:
    """Raises TimeIsUp after a point of time.monotonic, without looking at the time too often."""

    def __init__(self, deadline: float | None) -> None:
        self._deadline = float("inf") if deadline is None else deadline
        self._left = 0

    def tick(self) -> None:
        """Count one step of work."""
        self._left -= 1
        if self._left < 0:
            self._left = _TICKS
            if monotonic() > self._deadline:
                raise TimeIsUp


@dataclass(frozen=True, slots=True)
class Pattern:
    """An operator, prepared for joining."""

    operator: Operator
    arguments: Row  # a term for each parameter
    needs: tuple[NumberedAtom, ...]  # the preconditions
    adds: tuple[NumberedAtom, ...]
    fits: tuple[frozenset[int], ...]  # the objects that may fill each slot
    different: tuple[tuple[int, int], ...]  # terms that must not be the same object


class Objects:
    """The objects of a problem, numbered; asks each type only once which objects it has."""

    def __init__(self, objects: Sequence[Object]) -> None:
        self.all = list(objects)
        self._numbers = {obj: number for number, obj in enumerate(objects)}
        self._fits: dict[Type, frozenset[int]] = {}

    def number(self, obj: Object) -> int:
        """Return an object's number; raise KeyError where the problem does not have it."""
        return self._numbers[obj]

    def of(self, kind: Type) -> frozenset[int]:
        """Return the objects of a type."""
        if kind not in self._fits:
            kinds = {obj.type for obj in self.all}
            fitting = {k for k in kinds if k.is_a(kind)}
            self._fits[kind] = frozenset(n for n, obj in enumerate(self.all) if obj.type in fitting)
        return self._fits[kind]


def prepare(operator: Operator, objects: Objects) -> Pattern | None:
    """Return an operator as a pattern; None if its types and equalities leave no way to use it."""
    leader = _leaders(operator)
    if leader is None:
        return None

    slots: dict[Term, int] = {}
    fits: list[frozenset[int]] = []
    for variable in operator.parameters:
        kind, first = objects.of(variable.type), _leading(variable, leader)
        if isinstance(first, Object):
            slots[first] = -1 - objects.number(first)
            if -1 - slots[first] not in kind:
                return None
        elif first in slots:
            fits[slots[first]] &= kind
        else:
            slots[first] = len(fits)
            fits.append(kind)

    def term_of(term: Term) -> int:
        first = _leading(term, leader)
        return -1 - objects.number(first) if isinstance(first, Object) else slots[first]

    def numbered(atoms: frozenset[LiftedAtom]) -> tuple[NumberedAtom, ...]:
        kept = (a for a in atoms if a.predicate.name != EQUAL.name)
        return tuple(sorted({(a.predicate.name, tuple(map(term_of, a.terms))) for a in kept}))

    unlike = [a.terms for a in operator.negative_preconditions if a.predicate.name == EQUAL.name]
    different = sorted({(term_of(one), term_of(two)) for one, two in unlike})
    if not all(fits) or any(one == two for one, two in different):
        return None
    return Pattern(
        operator,
        tuple(map(term_of, operator.parameters)),
        numbered(operator.preconditions),
        numbered(operator.add_effects),
        tuple(fits),
        tuple((one, two) for one, two in different if one >= 0 or two >= 0),
    )


def _leaders(operator: Operator) -> dict[Term, Term] | None:
    """Return for terms that must be equal to another which one to take; None where two objects would be."""
    leader: dict[Term, Term] = {}

    for atom in operator.preconditions:
        if atom.predicate.name == EQUAL.name:
            one, two = (_leading(term, leader) for term in atom.terms)
            if one != two and isinstance(one, Object):
                one, two = two, one
            if one != two and isinstance(one, Object):
                return None
            if one != two:
                leader[one] = two
    return leader


def _leading(term: Term, leader: Mapping[Variable | Object, Variable | Object]) -> Variable | Object:
    while term in leader:
        term = leader[term]
    return term


class Relations:
    """The atoms reached so far, found by predicate, or by predicate and one object at one place."""

    def __init__(self) -> None:
        self._known: set[NumberedAtom] = set()
        self._all: dict[str, list[Row]] = defaultdict(list)
        self._at: dict[tuple[str, int, int], list[Row]] = defaultdict(list)

    def add(self, atom: NumberedAtom) -> None:
        """Remember an atom."""
        name, row = atom
        self._known.add(atom)
        self._all[name].append(row)
        for place, obj in enumerate(row):
            self._at[name, place, obj].append(row)

    def knows(self, name: str, row: Row) -> bool:
        """Say whether an atom was reached."""
        return (name, row) in self._known

    def matching(self, name: str, row: Row) -> Sequence[Row]:
        """Return atoms that may match, where -1 is any object: the shortest list that one object leads to."""
        best: Sequence[Row] = self._all.get(name, ())
        for place, obj in enumerate(row):
            if obj != _FREE:
                found = self._at.get((name, place, obj), ())
                if len(found) < len(best):
                    best = found
        return best


def unify(pattern: Pattern, terms: Row, row: Row, binding: list[int]) -> list[int] | None:
    """Extend a binding so that the terms become the objects; None where that is impossible."""
    extended = binding.copy()
    for term, obj in zip(terms, row, strict=True):
        if term < 0:
            if obj != -1 - term:
                return None
        elif extended[term] == _FREE:
            if obj not in pattern.fits[term]:
                return None
            extended[term] = obj
        elif extended[term] != obj:
            return None
    return extended if not pattern.different or _differ(pattern, extended) else None


def _differ(pattern: Pattern, binding: list[int]) -> bool:
    """Say whether no two terms that must differ are bound to one object."""
    for one, two in pattern.different:
        left = binding[one] if one >= 0 else -1 - one
        if left != _FREE and left == (binding[two] if two >= 0 else -1 - two):
            return False
    return True


def bindings(
    pattern: Pattern, needs: tuple[NumberedAtom, ...], start: list[int], relations: Relations, clock: Clock
) -> Iterator[list[int]]:
    """Yield every way to match the needs, those with few candidates first, and to fill what is left."""
    stack = [(start, needs)]
    while stack:
        clock.tick()
        binding, waiting = stack.pop()
        open_needs = _still_open(waiting, binding, relations)
        if open_needs is None:
            continue
        if open_needs:
            candidates, terms, rest = _fewest(open_needs)
            for row in candidates:
                clock.tick()
                extended = unify(pattern, terms, row, binding)
                if extended is not None:
                    stack.append((extended, rest))
            continue
        free = binding.index(_FREE) if _FREE in binding else None
        if free is None:
            yield binding
            continue
        for obj in sorted(pattern.fits[free], reverse=True):
            clock.tick()
            extended = binding.copy()
            extended[free] = obj
            if not pattern.different or _differ(pattern, extended):
                stack.append((extended, ()))


def _still_open(
    waiting: tuple[NumberedAtom, ...], binding: list[int], relations: Relations
) -> list[tuple[NumberedAtom, Sequence[Row]]] | None:
    """Return the needs that have free slots, with the atoms that may match; None where one is never met."""
    found = []
    for need in waiting:
        name, terms = need
        row = tuple([binding[term] if term >= 0 else -1 - term for term in terms])
        if _FREE in row:
            candidates = relations.matching(name, row)
            if not candidates:
                return None
            found.append((need, candidates))
        elif not relations.knows(name, row):
            return None
    return found


def _fewest(
    needs: list[tuple[NumberedAtom, Sequence[Row]]],
) -> tuple[Sequence[Row], Row, tuple[NumberedAtom, ...]]:
    """Return the least candidates of a need, its terms, and the other needs."""
    least = min(range(len(needs)), key=lambda i: len(needs[i][1]))
    (_, terms), candidates = needs[least]
    return candidates, terms, tuple(need for i, (need, _) in enumerate(needs) if i != least)
