"""Which parameters of two operators correspond: exactly where renaming makes them equal, else at best."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field

import networkx as nx

from bpns.symbolic.operators import Operator
from bpns.symbolic.structs import EQUAL, LiftedAtom, Type, Variable

PARTS = ("preconditions", "negative_preconditions", "add_effects", "delete_effects")
TYPE = "type"  # the part of placed atoms that say a parameter's type
MAX_TRIES = 20_000  # pairs of parameters, in the search for the best correspondence of two operators

PlacedAtom = tuple[str, str, tuple[int | str, ...]]
"""Part, predicate (or type), arguments: places of parameters, names of constants; all in lower case."""
Places = Mapping[int, int]
"""Places of the first operator's parameters -> places of the second's."""


def placed_atoms(operator: Operator) -> frozenset[PlacedAtom]:
    """Return all that an operator says, its parameters' types included, without their names."""
    types = {(TYPE, type_name(v.type), (place,)) for place, v in enumerate(operator.parameters)}
    return frozenset(types | atoms_of(operator).keys())


def atoms_of(operator: Operator) -> dict[PlacedAtom, LiftedAtom]:
    """Return an operator's atoms by part, name and terms."""
    places = {v.name.lower(): place for place, v in enumerate(operator.parameters)}

    def placed(part: str, atom: LiftedAtom) -> PlacedAtom:
        names = [(t, t.name.lower()) for t in atom.terms]
        terms = tuple(places[name] if isinstance(t, Variable) else name for t, name in names)
        return part, atom.predicate.name.lower(), _ordered(atom.predicate.name, terms)

    return {placed(part, atom): atom for part in PARTS for atom in getattr(operator, part)}


def type_name(kind: Type) -> str:
    """Return a type's name as PDDL compares it: in lower case, alternatives in order."""
    names = sorted(type_name(one) for one in kind.either)
    return f"(either {' '.join(names)})" if names else kind.name.lower()


def _ordered(predicate: str, terms: tuple[int | str, ...]) -> tuple[int | str, ...]:
    """Return terms in an order that says what the atom says: equality has no first and second."""
    return tuple(sorted(terms, key=repr)) if predicate == EQUAL.name else terms


def renamed(placed: frozenset[PlacedAtom], places: Places) -> frozenset[PlacedAtom]:
    """Return placed atoms with other places of parameters, without those where a place has no image."""
    return frozenset(
        (part, name, _ordered(name, tuple(places[t] if isinstance(t, int) else t for t in terms)))
        for part, name, terms in placed
        if all(t in places for t in terms if isinstance(t, int))
    )


# ----------------------------------------------------------------------------- equal up to renaming


def fingerprint(placed: frozenset[PlacedAtom]) -> str:
    """Return a text that placed atoms which are equal up to renaming share, and others hardly ever."""
    return " ".join(sorted(colour for _, colour in _graph(placed).nodes(data="colour")))


def renaming(first: Operator, second: Operator) -> dict[int, int] | None:
    """Return a bijection of the parameters that makes two operators equal; None where there is none.

    Parameters keep their names, or else their places, where they can.
    """
    placed, wanted = placed_atoms(first), placed_atoms(second)
    places = {v.name.lower(): place for place, v in enumerate(second.parameters)}
    by_name = [places.get(v.name.lower(), -1) for v in first.parameters]
    if len(placed) != len(wanted) or len(by_name) != len(places):
        return None
    for attempt in (by_name, range(len(places))):
        found = dict(enumerate(attempt))
        if renamed(placed, found) == wanted:
            return found
    one, other = _graph(placed), _graph(wanted)
    nodes = nx.vf2pp_isomorphism(one, other, node_label="colour")
    if nodes is None:
        return None
    return {place: nodes[place] for place in range(len(places))}


def _graph(placed: frozenset[PlacedAtom]) -> "nx.Graph[int]":
    """Return placed atoms as a coloured graph: isomorphic graphs are equal up to renaming.

    A parameter's node has its place for a number. An atom's node is joined to its arguments' nodes (one for
    each position), these to the parameters. Weisfeiler-Lehman colours leave few nodes to choose from.
    """
    graph: nx.Graph[int] = nx.Graph()
    graph.add_nodes_from(range(sum(part == TYPE for part, _, _ in placed)), label="parameter")
    for part, name, terms in sorted(placed, key=repr):
        constants = [t if isinstance(t, str) else "" for t in _ordered(name, terms)]
        owner = len(graph)
        graph.add_node(owner, label=repr((part, name, constants)))
        for position, term in enumerate(terms):
            if isinstance(term, int):
                argument = len(graph)
                graph.add_node(argument, label="either" if name == EQUAL.name else str(position))
                graph.add_edge(owner, argument)
                graph.add_edge(argument, term)
    colours = nx.weisfeiler_lehman_subgraph_hashes(
        graph, node_attr="label", iterations=9, include_initial_labels=True
    )
    nx.set_node_attributes(graph, {node: found[-1] for node, found in colours.items()}, "colour")
    return graph


# --------------------------------------------------------------------------- as equal as can be


def most_in_common(first: frozenset[PlacedAtom], second: frozenset[PlacedAtom]) -> int:
    """Return a number of atoms that two operators share at most, whatever the renaming."""
    return (_kinds(first) & _kinds(second)).total()


def _kinds(placed: frozenset[PlacedAtom]) -> Counter[tuple[str, str]]:
    return Counter((part, name) for part, name, _ in placed if part != TYPE)


def correspondence(first: Operator, second: Operator) -> dict[int, int]:
    """Return pairs of parameters under which two operators share most placed atoms; equal names decide ties.

    A search with bounds. After MAX_TRIES the best pairs so far are taken: for operators with many parameters
    that are alike these may not be the best.
    """
    search = _Matching.of(first, second)
    search.run(0, {}, 0, 0)
    return search.best


@dataclass(slots=True)
class _Matching:
    """Assigns the first operator's parameters in ``order``, those in most placed atoms first."""

    order: list[int]
    decided: list[list[PlacedAtom]]  # by depth: the placed atoms whose last parameter is assigned there
    wanted: frozenset[PlacedAtom]
    possible: list[int]  # by depth: placed atoms that can still be shared after it
    candidates: dict[int, list[int]]  # for each parameter, the most similar first
    names: set[tuple[int, int]]  # parameters with one name
    best: dict[int, int] = field(default_factory=dict)
    score: tuple[int, int] = (-1, 0)
    tries: int = 0
    complete: bool = False  # whether every parameter has been considered once

    @classmethod
    def of(cls, first: Operator, second: Operator) -> "_Matching":
        placed, wanted = placed_atoms(first), placed_atoms(second)
        mine, others = _roles(placed), _roles(wanted)
        names = {
            (place, other)
            for place, a in enumerate(first.parameters)
            for other, b in enumerate(second.parameters)
            if a.name.lower() == b.name.lower()
        }
        order = sorted(mine, key=lambda place: (-mine[place].total(), place))
        candidates = {}
        for place in order:
            alike = {other: (mine[place] & roles).total() for other, roles in others.items()}
            fit = [other for other in alike if alike[other] or (place, other) in names]
            candidates[place] = sorted(fit, key=lambda o: (-alike[o], (place, o) not in names, o))
        depth = {place: number for number, place in enumerate(order)}
        decided: list[list[PlacedAtom]] = [[] for _ in order]
        for atom in sorted(placed, key=repr):
            numbers = [depth[t] for t in atom[2] if isinstance(t, int)]
            if numbers:
                decided[max(numbers)].append(atom)
        kinds = Counter((part, name) for part, name, _ in wanted)
        possible = []
        for number in range(len(order) + 1):
            left = Counter((part, name) for rows in decided[number:] for part, name, _ in rows)
            possible.append((left & kinds).total())
        return cls(order, decided, wanted, possible, candidates, names)

    def run(self, depth: int, places: dict[int, int], shared: int, same_names: int) -> None:
        """Try all assignments from ``depth`` on that can be better than the best one."""
        if (shared, same_names) > self.score:
            self.best, self.score = dict(places), (shared, same_names)
        self.complete = self.complete or depth == len(self.order)
        if depth == len(self.order) or (self.complete and self.tries >= MAX_TRIES):
            return
        place = self.order[depth]
        used = set(places.values())
        options: list[tuple[int, int | None]] = [(0, None)]
        for other in self.candidates[place]:
            if other not in used:
                found = renamed(frozenset(self.decided[depth]), places | {place: other})
                options.append((len(found & self.wanted), other))
        self.tries += len(options)
        options.sort(key=lambda option: (option[1] is None, -option[0]))
        for gain, choice in options:
            named = same_names + ((place, choice) in self.names)
            most = (shared + gain + self.possible[depth + 1], named + len(self.order) - depth - 1)
            if most > self.score:
                after = places if choice is None else places | {place: choice}
                self.run(depth + 1, after, shared + gain, named)


def _roles(placed: frozenset[PlacedAtom]) -> dict[int, Counter[tuple[str, str, int]]]:
    """Return how often each parameter stands where in what."""
    roles: dict[int, Counter[tuple[str, str, int]]] = {}
    for part, name, terms in placed:
        for position, term in enumerate(terms):
            if isinstance(term, int):
                roles.setdefault(term, Counter())[part, name, position] += 1
    return roles
