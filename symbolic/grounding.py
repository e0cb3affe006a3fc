"""From operators with parameters to the ground operators that can ever be used."""

from collections import defaultdict, deque
from collections.abc import Iterator
from dataclasses import dataclass

from symbolic.structs import (
    Domain,
    GroundAtom,
    GroundOperator,
    LiftedAtom,
    Object,
    Operator,
    Problem,
    Variable,
    canonical_order,
    sort_atoms,
)


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


class _Relations:
    """The atoms reached so far, found by predicate, or by predicate and one object at one place."""

    def __init__(self) -> None:
        self._all: dict[str, list[GroundAtom]] = defaultdict(list)
        self._at: dict[tuple[str, int, str], list[GroundAtom]] = defaultdict(list)

    def add(self, atom: GroundAtom) -> None:
        self._all[atom.predicate.name].append(atom)
        for place, obj in enumerate(atom.objects):
            self._at[atom.predicate.name, place, obj.name].append(atom)

    def matching(self, atom: LiftedAtom, binding: dict[Variable, Object]) -> list[GroundAtom]:
        """Return atoms that may match: the shortest list that one bound argument leads to."""
        best = self._all[atom.predicate.name]
        for place, term in enumerate(atom.terms):
            obj = binding.get(term) if isinstance(term, Variable) else term
            if obj is not None:
                found = self._at[atom.predicate.name, place, obj.name]
                if len(found) < len(best):
                    best = found
        return best


def _unify(
    lifted: LiftedAtom, atom: GroundAtom, binding: dict[Variable, Object]
) -> dict[Variable, Object] | None:
    """Extend a binding so that the lifted atom becomes the ground one; None where that is impossible."""
    if lifted.predicate.name != atom.predicate.name:
        return None
    extended = dict(binding)
    for term, obj in zip(lifted.terms, atom.objects, strict=True):
        if isinstance(term, Variable):
            if extended.setdefault(term, obj) != obj or not obj.type.is_a(term.type):
                return None
        elif term != obj:
            return None
    return extended


def _bindings(
    operator: Operator,
    waiting: tuple[LiftedAtom, ...],
    binding: dict[Variable, Object],
    relations: _Relations,
    objects: tuple[Object, ...],
) -> Iterator[dict[Variable, Object]]:
    """Yield every way to match the waiting preconditions, then to fill the parameters left over."""
    if waiting:
        atom = max(waiting, key=lambda a: sum(t in binding for t in a.terms if isinstance(t, Variable)))
        rest = tuple(a for a in waiting if a is not atom)
        for found in relations.matching(atom, binding):
            extended = _unify(atom, found, binding)
            if extended is not None:
                yield from _bindings(operator, rest, extended, relations, objects)
        return
    free = next((v for v in operator.parameters if v not in binding), None)
    if free is None:
        yield binding
        return
    for obj in objects:
        if obj.type.is_a(free.type):
            yield from _bindings(operator, (), {**binding, free: obj}, relations, objects)


def _without_forbidden(
    operators: tuple[GroundOperator, ...], init: frozenset[GroundAtom]
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
            now = [o for o in allowed if o.preconditions <= reached]
            allowed = [o for o in allowed if not o.preconditions <= reached]
            kept += now
            reached.update(*(o.add_effects for o in now))
            growing = bool(now)
        operators = tuple(kept)


def ground(domain: Domain, problem: Problem) -> GroundProblem | Unreachable:
    """Ground a problem: each newly reached atom is joined with those reached before.

    This filters by static preconditions and by delete-relaxed reachability in one pass and never builds
    the cross product of all objects. Negative preconditions only drop operators that they always forbid.
    """
    objects = canonical_order((*domain.constants, *problem.objects))
    added = {atom.predicate.name for operator in domain.operators for atom in operator.add_effects}
    relations = _Relations()
    reached: set[GroundAtom] = set(problem.init)
    found: dict[tuple[str, tuple[Object, ...]], GroundOperator] = {}
    queue: deque[GroundAtom] = deque()
    triggers: dict[str, list[tuple[Operator, LiftedAtom]]] = defaultdict(list)

    def keep(operator: Operator, binding: dict[Variable, Object]) -> None:
        arguments = tuple(binding[v] for v in operator.parameters)
        if (operator.name, arguments) not in found:
            ground_operator = found[operator.name, arguments] = operator.ground(arguments)
            new = sort_atoms(ground_operator.add_effects - reached)
            reached.update(new)
            queue.extend(new)

    for atom in sort_atoms(problem.init):
        if atom.predicate.name in added:
            queue.append(atom)
        else:
            relations.add(atom)
    for operator in domain.operators:
        preconditions = tuple(sort_atoms(operator.preconditions))
        changing = [p for p in preconditions if p.predicate.name in added]
        for precondition in changing:
            triggers[precondition.predicate.name].append((operator, precondition))
        if not changing:
            for binding in _bindings(operator, preconditions, {}, relations, objects):
                keep(operator, binding)
    while queue:
        atom = queue.popleft()
        relations.add(atom)
        for operator, precondition in triggers[atom.predicate.name]:
            start = _unify(precondition, atom, {})
            if start is not None:
                rest = tuple(p for p in sort_atoms(operator.preconditions) if p is not precondition)
                for binding in _bindings(operator, rest, start, relations, objects):
                    keep(operator, binding)
    operators, permanent = _without_forbidden(tuple(found.values()), problem.init)
    reached = set(problem.init).union(*(o.add_effects for o in operators))
    never_true, never_false = problem.goal - reached, problem.negative_goal & permanent
    if never_true or never_false:
        return Unreachable(tuple(sort_atoms(never_true)), tuple(sort_atoms(never_false)))
    order = sorted(operators, key=lambda g: (g.operator.name, [o.name for o in g.objects]))
    return GroundProblem(domain, problem, tuple(order))
