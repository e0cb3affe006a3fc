"""Segments -> operators: clustering by unification, preconditions by intersection.

Source: spec, algorithm.md sections 4 and 5.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from bpns.learning.data.segmentation import Segment
from bpns.symbolic.operators import Operator
from bpns.symbolic.structs import (
    GroundAtom,
    LiftedAtom,
    Object,
    Predicate,
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
class OperatorData:
    """A learned operator and the segments that it was learned from.

    Where these are of a given skill, ``given`` names it and ``arguments`` are the parameters that it gets.
    The last ``context`` parameters are of no effect: they are in contact with those that are.
    """

    operator: Operator
    members: tuple[Member, ...]
    given: str | None = None
    arguments: tuple[Variable, ...] = ()
    context: int = 0


@dataclass(slots=True)
class _Cluster:
    variables: tuple[Variable, ...]
    given: str | None
    arguments: tuple[Variable, ...]
    add_effects: frozenset[LiftedAtom]
    delete_effects: frozenset[LiftedAtom]
    members: list[Member] = field(default_factory=list)
    context: int = 0  # how many of the variables are context objects


def learn_operators(
    segments: Sequence[Segment], min_share: float = 0.01, contacts: frozenset[Predicate] = frozenset()
) -> list[OperatorData]:
    """Return the operators with at least ``min_share`` of all segments, named Op<i> in order of discovery.

    A segment joins the first cluster whose given skill, with its arguments, and whose effects become its
    own under a one-to-one, type-preserving map of variables to objects. Objects that atoms of ``contacts``
    tie to those become parameters too; see ``_add_context``. Without ``contacts``, none do, as in the paper.
    """
    clusters: list[_Cluster] = []
    for segment in segments:
        for cluster in clusters:
            match = _match(cluster, segment)
            if match is not None:
                cluster.members.append(Member(segment, tuple(match[v] for v in cluster.variables)))
                break
        else:
            clusters.append(_new_cluster(segment))
    for cluster in clusters:
        _add_context(cluster, contacts)
    return [
        OperatorData(
            Operator(
                f"Op{number}",
                cluster.variables,
                _preconditions(cluster),
                cluster.add_effects,
                cluster.delete_effects,
            ),
            tuple(cluster.members),
            cluster.given,
            cluster.arguments,
            cluster.context,
        )
        for number, cluster in enumerate(clusters)
        if len(cluster.members) >= len(segments) * min_share
    ]


def _new_cluster(segment: Segment) -> _Cluster:
    effects = segment.add_effects | segment.delete_effects
    arguments = segment.label.objects if segment.label else ()
    objects = canonical_order({o for atom in effects for o in atom.objects} | set(arguments))
    lift = {o: Variable(f"?x{i}", o.type) for i, o in enumerate(objects)}
    return _Cluster(
        tuple(lift.values()),
        segment.label.skill if segment.label else None,
        tuple(lift[o] for o in arguments),
        frozenset(_lifted(atom, lift) for atom in segment.add_effects),
        frozenset(_lifted(atom, lift) for atom in segment.delete_effects),
        [Member(segment, objects)],
    )


def _add_context(cluster: _Cluster, contacts: frozenset[Predicate]) -> None:
    """Add parameters for objects that one kind of contact atom ties to the others at every segment's start.

    That is an atom of which all other objects are parameters, and in each segment there is exactly one such
    atom: Grasped(gripper, stick) gives the gripper that holds the stick.
    """
    shared: dict[tuple[LiftedAtom, int], list[Object]] | None = None
    for member in cluster.members:
        ties = _ties(cluster.variables, member, contacts)
        if shared is None:
            shared = {tie: [found] for tie, found in ties.items()}
        else:
            shared = {tie: [*found, ties[tie]] for tie, found in shared.items() if tie in ties}
    columns: list[tuple[Object, ...]] = []  # the objects of each new parameter, a row for each segment
    for _, found in sorted((shared or {}).items(), key=lambda item: str(item[0])):
        if not any(one == other for column in columns for one, other in zip(column, found, strict=True)):
            columns.append(tuple(found))  # parameters are different objects, in every segment
    for column in columns:
        name = f"?x{len(cluster.variables)}"
        cluster.variables += (Variable(name, column[0].type),)
        cluster.context += 1
        cluster.members = [
            Member(member.segment, (*member.objects, obj))
            for member, obj in zip(cluster.members, column, strict=True)
        ]


def _ties(
    variables: tuple[Variable, ...], member: Member, contacts: frozenset[Predicate]
) -> dict[tuple[LiftedAtom, int], Object]:
    """Return the objects that are tied to a segment's, each by an atom with a hole (where, which place)."""
    lift = dict(zip(member.objects, variables, strict=True))
    found: dict[tuple[LiftedAtom, int], Object | None] = {}
    for atom in member.segment.init_atoms:
        if atom.predicate not in contacts or len(atom.objects) == 1:
            continue
        strange = [place for place, obj in enumerate(atom.objects) if obj not in lift]
        if len(strange) != 1:
            continue
        (place,) = strange
        obj = atom.objects[place]
        hole = Variable("?hole", obj.type)
        terms = tuple(hole if o == obj else lift[o] for o in atom.objects)
        tie = LiftedAtom(atom.predicate, terms), place
        found[tie] = None if tie in found else obj
    return {tie: obj for tie, obj in found.items() if obj is not None}


def _lifted(atom: GroundAtom, lift: Mapping[Object, Variable]) -> LiftedAtom:
    return LiftedAtom(atom.predicate, tuple(lift[o] for o in atom.objects))


def _preconditions(cluster: _Cluster) -> frozenset[LiftedAtom]:
    """Return the lifted initial atoms over the parameters that all members share."""
    first, *others = cluster.members
    lift = dict(zip(first.objects, cluster.variables, strict=True))
    shared = {_lifted(a, lift) for a in first.segment.init_atoms if all(o in lift for o in a.objects)}
    for member in others:
        found = dict(zip(cluster.variables, member.objects, strict=True))
        shared = {a for a in shared if a.ground(found) in member.segment.init_atoms}
    return frozenset(shared)


def _match(cluster: _Cluster, segment: Segment) -> dict[Variable, Object] | None:
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
