"""Segments -> clusters of segments that are alike but for the objects.

Source: spec, algorithm.md section 4.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from bpns.learning.data.segmentation import Segment
from bpns.symbolic.structs import (
    GroundAtom,
    LiftedAtom,
    Object,
    Variable,
    canonical_order,
    sort_atoms,
)


@dataclass(frozen=True, slots=True, eq=False)
class Member:
    """A segment of an operator; ``objects`` are those that its parameters stand for, in order."""

    segment: Segment
    objects: tuple[Object, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Cluster:
    """Segments of one given skill, or of none, whose effects are alike but for the objects."""

    variables: tuple[Variable, ...]
    given: str | None
    arguments: tuple[Variable, ...]  # that the given skill gets
    add_effects: frozenset[LiftedAtom]
    delete_effects: frozenset[LiftedAtom]
    members: list[Member]  # grows as segments join


def cluster(segments: Sequence[Segment]) -> list[Cluster]:
    """Return the clusters of all segments, in order of discovery.

    A segment joins the first cluster whose given skill, with its arguments, and whose effects become its
    own under a one-to-one, type-preserving map of variables to objects.
    """
    clusters: list[Cluster] = []
    for segment in segments:
        for one in clusters:
            match = _match(one, segment)
            if match is not None:
                one.members.append(Member(segment, tuple(match[v] for v in one.variables)))
                break
        else:
            clusters.append(_new_cluster(segment))
    return clusters


def lifted_atom(atom: GroundAtom, lift: Mapping[Object, Variable]) -> LiftedAtom:
    """Return an atom on the variables that stand for its objects."""
    return LiftedAtom(atom.predicate, tuple(lift[o] for o in atom.objects))


def _new_cluster(segment: Segment) -> Cluster:
    effects = segment.add_effects | segment.delete_effects
    arguments = segment.label.objects if segment.label else ()
    objects = canonical_order({o for atom in effects for o in atom.objects} | set(arguments))
    lift = {o: Variable(f"?x{i}", o.type) for i, o in enumerate(objects)}
    return Cluster(
        tuple(lift.values()),
        segment.label.skill if segment.label else None,
        tuple(lift[o] for o in arguments),
        frozenset(lifted_atom(atom, lift) for atom in segment.add_effects),
        frozenset(lifted_atom(atom, lift) for atom in segment.delete_effects),
        [Member(segment, objects)],
    )


def _match(cluster: Cluster, segment: Segment) -> dict[Variable, Object] | None:
    """Return a map under which the cluster's skill and effects are the segment's, or None."""
    if cluster.given != (segment.label.skill if segment.label else None):
        return None
    start = _bind({}, cluster.arguments, segment.label.objects if segment.label else ())
    if start is None:
        return None
    pairs = []
    for lifted, ground in (
        (cluster.add_effects, segment.add_effects),
        (cluster.delete_effects, segment.delete_effects),
    ):
        if sorted(a.predicate.name for a in lifted) != sorted(a.predicate.name for a in ground):
            return None
        pairs.append((sort_atoms(lifted), sort_atoms(ground)))
    (added, adds), (deleted, deletes) = pairs
    return _extend(start, added, adds, deleted, deletes)


def _extend(
    found: dict[Variable, Object],
    lifted: list[LiftedAtom],
    ground: list[GroundAtom],
    later_lifted: list[LiftedAtom],
    later_ground: list[GroundAtom],
) -> dict[Variable, Object] | None:
    """Match the first lifted atom with each ground one in turn, then the rest; add effects come first."""
    if not lifted:
        return _extend(found, later_lifted, later_ground, [], []) if later_lifted else found
    for i, atom in enumerate(ground):
        extended = _unify(lifted[0], atom, found)
        if extended is not None:
            rest = ground[:i] + ground[i + 1 :]
            result = _extend(extended, lifted[1:], rest, later_lifted, later_ground)
            if result is not None:
                return result
    return None


def _unify(
    lifted: LiftedAtom, atom: GroundAtom, found: Mapping[Variable, Object]
) -> dict[Variable, Object] | None:
    """Extend a one-to-one, type-preserving map so that the lifted atom becomes the ground one."""
    return _bind(found, lifted.terms, atom.objects) if lifted.predicate == atom.predicate else None


def _bind(
    found: Mapping[Variable, Object], terms: Iterable[Variable | Object], objects: Iterable[Object]
) -> dict[Variable, Object] | None:
    """Extend a one-to-one, type-preserving map so that the variables become the objects."""
    extended = dict(found)
    for variable, obj in zip(terms, objects, strict=True):
        assert isinstance(variable, Variable)  # learned operators mention no constants
        if variable in extended:
            if extended[variable] != obj:
                return None
        elif variable.type != obj.type or obj in extended.values():
            return None
        else:
            extended[variable] = obj
    return extended
