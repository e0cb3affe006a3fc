"""Which operators enable which: an add effect of one can be a precondition of another."""

from collections.abc import Sequence
from itertools import combinations, product

import networkx as nx
from networkx.utils import UnionFind

from bpns.symbolic.operators import Operator
from bpns.symbolic.structs import LiftedAtom, Object, Variable


def enabling_graph(operators: Sequence[Operator]) -> "nx.DiGraph[str]":
    """Return a graph over the operators' names; an edge's ``predicates`` are those that lead along it.

    There is an edge from A to B where an add effect of A unifies with a precondition of B: with some objects
    the two are the same ground atom. An operator may enable itself, with other objects.
    """
    graph: nx.DiGraph[str] = nx.DiGraph()
    graph.add_nodes_from(operator.name for operator in operators)
    for first in operators:
        for second in operators:
            predicates = {
                effect.predicate.name
                for effect in first.add_effects
                for condition in second.preconditions
                if unify(effect, condition)
            }
            if predicates:
                graph.add_edge(first.name, second.name, predicates=tuple(sorted(predicates)))
    return graph


def unify(effect: LiftedAtom, condition: LiftedAtom) -> bool:
    """Say whether atoms of two operators can be equal; the same parameter in both means two things."""
    if effect.predicate.name != condition.predicate.name or len(effect.terms) != len(condition.terms):
        return False
    terms: list[tuple[str, Variable | Object]] = []  # whose it is; constants are everybody's
    for owner, atom in (("effect", effect), ("condition", condition)):
        terms += [(owner if isinstance(term, Variable) else "", term) for term in atom.terms]
    equal = UnionFind(terms)
    for one, other in zip(terms[: len(effect.terms)], terms[len(effect.terms) :], strict=True):
        equal.union(one, other)
    return all(_one_object([term for _, term in group]) for group in equal.to_sets())


def _one_object(terms: Sequence[Variable | Object]) -> bool:
    """Say whether all terms can be one object: at most one constant, types along one line of descent."""
    constants = {term for term in terms if isinstance(term, Object)}
    types = sorted({term.type for term in terms}, key=lambda t: t.name)
    if len(constants) > 1:
        return False
    if constants:
        (constant,) = constants
        return all(constant.type.is_a(t) for t in types)
    choices = product(*(t.either or (t,) for t in types))
    return any(all(a.is_a(b) or b.is_a(a) for a, b in combinations(kinds, 2)) for kinds in choices)
