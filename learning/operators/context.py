"""Context: parameters for objects that no effect names, but that contacts tie to those of the effects.

Not in the paper. With it, the policy that presses a button with a stick sees the gripper that holds it.
"""

from collections.abc import Sequence

from bpns.learning.operators.clustering import Member
from bpns.symbolic.structs import LiftedAtom, Object, Predicate, Variable


def with_context(
    variables: tuple[Variable, ...], members: Sequence[Member], contacts: frozenset[Predicate]
) -> tuple[tuple[Variable, ...], tuple[Member, ...]]:
    """Add variables for objects that one kind of contact atom ties to the others at every segment's start.

    That is an atom of which all other objects are parameters, and in each segment there is exactly one such
    atom: Grasped(gripper, stick) gives the gripper that holds the stick.
    """
    shared: dict[tuple[LiftedAtom, int], list[Object]] | None = None
    for member in members:
        ties = _ties(variables, member, contacts)
        if shared is None:
            shared = {tie: [found] for tie, found in ties.items()}
        else:
            shared = {tie: [*found, ties[tie]] for tie, found in shared.items() if tie in ties}
    columns: list[tuple[Object, ...]] = []  # the objects of each new parameter, a row for each segment
    for _, found in sorted((shared or {}).items(), key=lambda item: str(item[0])):
        if not any(one == other for column in columns for one, other in zip(column, found, strict=True)):
            columns.append(tuple(found))  # parameters are different objects, in every segment
    new = (Variable(f"?x{i}", column[0].type) for i, column in enumerate(columns, len(variables)))
    wider = (
        Member(member.segment, (*member.objects, *(column[row] for column in columns)))
        for row, member in enumerate(members)
    )
    return (*variables, *new), tuple(wider)


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
