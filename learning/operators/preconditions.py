"""Preconditions: what holds at the start of every segment. Source: spec, algorithm.md section 5."""

from collections.abc import Sequence

from bpns.learning.operators.clustering import Member, lifted_atom
from bpns.symbolic.structs import LiftedAtom, Variable


def shared_preconditions(parameters: Sequence[Variable], members: Sequence[Member]) -> frozenset[LiftedAtom]:
    """Return the lifted initial atoms over the parameters that all members share."""
    first, *others = members
    lift = dict(zip(first.objects, parameters, strict=True))
    shared = {lifted_atom(a, lift) for a in first.segment.init_atoms if all(o in lift for o in a.objects)}
    for member in others:
        found = dict(zip(parameters, member.objects, strict=True))
        shared = {a for a in shared if a.ground(found) in member.segment.init_atoms}
    return frozenset(shared)
