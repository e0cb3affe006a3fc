"""From operators with parameters to the ground operators that can ever be used."""

from collections import defaultdict, deque
from collections.abc import Iterable
from dataclasses import dataclass
from typing import overload

from bpns.symbolic.grounding.joining import (
    Clock,
    NumberedAtom,
    Objects,
    Pattern,
    Relations,
    TimeIsUp,
    bindings,
    prepare,
    unify,
)
from bpns.symbolic.operators import Domain, GroundOperator, Problem
from bpns.symbolic.structs import GroundAtom, Object, canonical_order, sort_atoms


@dataclass(frozen=True, slots=True)
class GroundProblem:
    """A problem with every ground operator that is reachable when delete effects are ignored."""

    domain: Domain
    problem: Problem
    operators: tuple[GroundOperator, ...]  # by operator name, then objects: a fixed order for any input


@dataclass(frozen=True, slots=True)
class Unreachable:
    """Parts of the goal that no sequence of operators achieves, even if nothing stood in its way."""

    never_true: tuple[GroundAtom, ...]
    never_false: tuple[GroundAtom, ...] = ()

    def __str__(self) -> str:
        parts = [f"{atom}, which nothing makes true" for atom in self.never_true]
        parts += [f"not {atom}, which nothing makes false" for atom in self.never_false]
        return "no plan exists: the goal needs " + "; ".join(parts)


@dataclass(frozen=True, slots=True)
class OutOfTime:
    """Grounding did not end before the deadline."""

    def __str__(self) -> str:
        return "the time limit passed before all ground operators were found"


@overload
def ground(domain: Domain, problem: Problem, deadline: None = None) -> GroundProblem | Unreachable: ...
@overload
def ground(
    domain: Domain, problem: Problem, deadline: float | None
) -> GroundProblem | Unreachable | OutOfTime: ...
def ground(
    domain: Domain, problem: Problem, deadline: float | None = None
) -> GroundProblem | Unreachable | OutOfTime:
    """Ground a problem: each newly reached atom is joined with those reached before.

    This filters by static preconditions and by delete-relaxed reachability in one pass and never builds
    the cross product of all objects. Negative preconditions only drop operators that they always forbid.
    The deadline is a point of time.monotonic.
    """
    clock = Clock(deadline)
    try:
        operators, permanent = _without_forbidden(_usable(domain, problem, clock), problem.init, clock)
    except TimeIsUp:
        return OutOfTime()
    reached = set(problem.init).union(*(o.add_effects for o in operators))
    never_true, never_false = problem.goal - reached, problem.negative_goal & permanent
    if never_true or never_false:
        return Unreachable(tuple(sort_atoms(never_true)), tuple(sort_atoms(never_false)))
    order = sorted(operators, key=lambda g: (g.operator.name, [o.name for o in g.objects]))
    return GroundProblem(domain, problem, tuple(order))


def _usable(domain: Domain, problem: Problem, clock: Clock) -> tuple[GroundOperator, ...]:
    """Return the ground operators that are reachable when deletions and negations are ignored."""
    objects = Objects(canonical_order((*domain.constants, *problem.objects)))
    added = {atom.predicate.name for operator in domain.operators for atom in operator.add_effects}
    init = _numbered(problem.init, objects)
    relations, queue = Relations(), deque(f for f in init if f[0] in added)
    for atom in init:
        if atom[0] not in added:
            relations.add(atom)
    reached = set(init)
    found: dict[tuple[str, tuple[Object, ...]], GroundOperator] = {}

    def keep(pattern: Pattern, binding: list[int]) -> None:
        numbers = (binding[term] if term >= 0 else -1 - term for term in pattern.arguments)
        arguments = tuple(objects.all[number] for number in numbers)
        key = (pattern.operator.name, arguments)
        if key in found:
            return
        found[key] = pattern.operator.ground(arguments)
        for name, terms in pattern.adds:
            atom = (name, tuple(binding[term] if term >= 0 else -1 - term for term in terms))
            if atom not in reached:
                reached.add(atom)
                queue.append(atom)

    triggers: dict[str, list[tuple[Pattern, NumberedAtom, tuple[NumberedAtom, ...]]]] = defaultdict(list)
    for operator in domain.operators:
        pattern = prepare(operator, objects)
        if pattern is None:
            continue
        changing = [need for need in pattern.needs if need[0] in added]
        for need in changing:
            rest = tuple(other for other in pattern.needs if other is not need)
            triggers[need[0]].append((pattern, need, rest))
        if not changing:
            for binding in bindings(pattern, pattern.needs, [-1] * len(pattern.fits), relations, clock):
                keep(pattern, binding)
    while queue:
        atom = queue.popleft()
        relations.add(atom)
        for pattern, need, rest in triggers[atom[0]]:
            start = unify(pattern, need[1], atom[1], [-1] * len(pattern.fits))
            if start is not None:
                for binding in bindings(pattern, rest, start, relations, clock):
                    keep(pattern, binding)
    return tuple(found.values())


def _numbered(atoms: Iterable[GroundAtom], objects: Objects) -> list[NumberedAtom]:
    """Return atoms as numbers, in a fixed order."""
    return sorted((a.predicate.name, tuple(map(objects.number, a.objects))) for a in atoms)


def _without_forbidden(
    operators: tuple[GroundOperator, ...], init: frozenset[GroundAtom], clock: Clock
) -> tuple[tuple[GroundOperator, ...], frozenset[GroundAtom]]:
    """Drop operators that a permanent atom forbids, and those that only the dropped ones made reachable.

    Returns the others and the initial atoms that none of them deletes.
    """
    while True:
        permanent = init.difference(*(o.delete_effects for o in operators))
        allowed = [o for o in operators if not o.negative_preconditions & permanent]
        if len(allowed) == len(operators):
            return operators, permanent
        reached, kept = set(init), []
        growing = True
        while growing:
            clock.tick()
            now = [o for o in allowed if o.preconditions <= reached]
            allowed = [o for o in allowed if not o.preconditions <= reached]
            kept += now
            reached.update(*(o.add_effects for o in now))
            growing = bool(now)
        operators = tuple(kept)
