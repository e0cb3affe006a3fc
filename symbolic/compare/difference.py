"""What two domains say differently, whatever their operators and parameters are called.

Names are compared in lower case, as in PDDL. Types, predicates and constants are known by their names.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import networkx as nx

from bpns.symbolic.compare.matching import (
    PARTS,
    TYPE,
    PlacedAtom,
    atoms_of,
    correspondence,
    fingerprint,
    most_in_common,
    placed_atoms,
    renamed,
    renaming,
    type_name,
)
from bpns.symbolic.operators import Domain, Operator
from bpns.symbolic.structs import OBJECT, LiftedAtom, Predicate, Variable, sort_atoms

ALIKE = 0.5  # the share of common atoms from which on two operators are one that has changed


@dataclass(frozen=True, slots=True)
class AtomChange:
    """Atoms that one part of an operator lost (in the names of before) and got (in those of after)."""

    part: str  # of matching.PARTS
    removed: tuple[LiftedAtom, ...]
    added: tuple[LiftedAtom, ...]


@dataclass(frozen=True, slots=True)
class OperatorPair:
    """One operator in two domains; the same if nothing was removed or added."""

    before: Operator
    after: Operator
    renaming: tuple[tuple[Variable, Variable], ...]  # corresponding parameters; types may differ
    removed: tuple[Variable, ...]  # parameters
    added: tuple[Variable, ...]
    atoms: tuple[AtomChange, ...]

    @property
    def retyped(self) -> tuple[tuple[Variable, Variable], ...]:
        """The corresponding parameters whose types differ."""
        return tuple((a, b) for a, b in self.renaming if type_name(a.type) != type_name(b.type))

    @property
    def same(self) -> bool:
        """Whether renaming is all."""
        return not (self.removed or self.added or self.atoms or self.retyped)


@dataclass(frozen=True, slots=True)
class NameChange:
    """Names that only one domain declares, or that both declare differently, as texts."""

    removed: tuple[str, ...]
    added: tuple[str, ...]
    changed: tuple[tuple[str, str], ...]

    @property
    def none(self) -> bool:
        """Whether there is no difference."""
        return not (self.removed or self.added or self.changed)


@dataclass(frozen=True, slots=True)
class Difference:
    """All differences of two domains; their names and the order of things do not count."""

    types: NameChange
    predicates: NameChange
    constants: NameChange
    pairs: tuple[OperatorPair, ...]  # in the order of before
    removed: tuple[Operator, ...]
    added: tuple[Operator, ...]

    @property
    def same(self) -> bool:
        """Whether the domains are equal up to renaming operators and parameters."""
        declared = self.types.none and self.predicates.none and self.constants.none
        return declared and not self.removed and not self.added and all(pair.same for pair in self.pairs)


def compare(before: Domain, after: Domain) -> Difference:
    """Compare two domains: equal operators are paired first, then those that share most atoms."""
    equal = _equal_pairs(before.operators, after.operators)
    left = [i for i in range(len(before.operators)) if i not in equal]
    right = sorted(set(range(len(after.operators))) - set(equal.values()))
    alike = _similar_pairs(before.operators, after.operators, left, right)
    partners = equal | alike
    return Difference(
        _declared(_types(before), _types(after)),
        _declared(_predicates(before), _predicates(after)),
        _declared(_constants(before), _constants(after)),
        tuple(_pair(before.operators[i], after.operators[partners[i]]) for i in sorted(partners)),
        tuple(before.operators[i] for i in left if i not in alike),
        tuple(after.operators[j] for j in right if j not in alike.values()),
    )


# ---------------------------------------------------------------------------------------- operators


def _equal_pairs(before: Sequence[Operator], after: Sequence[Operator]) -> dict[int, int]:
    """Return the places of operators that are equal up to renaming; equal names are paired first."""
    forms = [fingerprint(placed_atoms(operator)) for operator in before]
    same_form: dict[str, list[int]] = {}
    for j, operator in enumerate(after):
        same_form.setdefault(fingerprint(placed_atoms(operator)), []).append(j)
    pairs: dict[int, int] = {}
    for named in (True, False):
        for i, operator in enumerate(before):
            for j in same_form.get(forms[i], ()):
                free = i not in pairs and j not in pairs.values()
                fits = not named or after[j].name.lower() == operator.name.lower()
                if free and fits and renaming(operator, after[j]) is not None:
                    pairs[i] = j
    return pairs


def _similar_pairs(
    before: Sequence[Operator], after: Sequence[Operator], left: list[int], right: list[int]
) -> dict[int, int]:
    """Return the places of operators that have changed: pairs that together share the most atoms."""
    graph: nx.Graph[int] = nx.Graph()
    offset = len(before)  # the nodes of ``after`` come after those of ``before``
    for i in left:
        for j in right:
            similarity = _similarity(before[i], after[j])
            if similarity >= ALIKE:
                named = before[i].name.lower() == after[j].name.lower()
                weight = 2 * round(10_000 * similarity) + named
                graph.add_edge(i, offset + j, weight=weight)
    matched = sorted(sorted(edge) for edge in nx.max_weight_matching(graph))
    return {i: j - offset for i, j in matched}


def _similarity(before: Operator, after: Operator) -> float:
    """Return the share of atoms that two operators have in common: 0 to 1, or 0 if below ALIKE."""
    first, second = placed_atoms(before), placed_atoms(after)
    total = len(first) - len(before.parameters) + len(second) - len(after.parameters)
    if 2 * most_in_common(first, second) < ALIKE * max(total, 1):
        return 0.0
    common = renamed(first, correspondence(before, after)) & second
    return 2 * sum(part != TYPE for part, _, _ in common) / total


def _pair(before: Operator, after: Operator) -> OperatorPair:
    exact = renaming(before, after)
    places = correspondence(before, after) if exact is None else exact
    backwards = {other: place for place, other in places.items()}
    common = renamed(placed_atoms(before), places) & placed_atoms(after)
    kept = renamed(common, backwards)
    parameters = [(before.parameters[p], after.parameters[q]) for p, q in sorted(places.items())]
    changes = []
    for part in PARTS:
        removed = _others(before, part, kept)
        added = _others(after, part, common)
        if removed or added:
            changes.append(AtomChange(part, removed, added))
    return OperatorPair(
        before,
        after,
        tuple(parameters),
        tuple(v for place, v in enumerate(before.parameters) if place not in places),
        tuple(v for place, v in enumerate(after.parameters) if place not in backwards),
        tuple(changes),
    )


def _others(operator: Operator, part: str, common: frozenset[PlacedAtom]) -> tuple[LiftedAtom, ...]:
    """Return the atoms of one part that are not in common."""
    atoms = atoms_of(operator).items()
    return tuple(sort_atoms(atom for placed, atom in atoms if placed[0] == part and placed not in common))


# ------------------------------------------------------------------- types, predicates, constants


def _declared(before: Mapping[str, str], after: Mapping[str, str]) -> NameChange:
    return NameChange(
        tuple(before[name] for name in sorted(before.keys() - after.keys())),
        tuple(after[name] for name in sorted(after.keys() - before.keys())),
        tuple(
            (before[name], after[name])
            for name in sorted(before.keys() & after.keys())
            if before[name] != after[name]
        ),
    )


def _types(domain: Domain) -> dict[str, str]:
    return {t.name.lower(): f"{t.name.lower()} - {type_name(t.parent or OBJECT)}" for t in domain.types}


def _predicates(domain: Domain) -> dict[str, str]:
    return {p.name.lower(): _signature(p) for p in domain.predicates}


def _signature(predicate: Predicate) -> str:
    return f"{predicate.name.lower()}({', '.join(map(type_name, predicate.types))})"


def _constants(domain: Domain) -> dict[str, str]:
    return {o.name.lower(): f"{o.name} - {o.type.name}".lower() for o in domain.constants}
