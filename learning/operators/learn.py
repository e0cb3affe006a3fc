"""Segments -> operators: clusters that are frequent, with context and preconditions.

Source: spec, algorithm.md sections 4 and 5.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from bpns.learning.data.segmentation import Segment
from bpns.learning.operators.clustering import Member, cluster
from bpns.learning.operators.context import with_context
from bpns.learning.operators.preconditions import shared_preconditions
from bpns.symbolic.operators import Operator
from bpns.symbolic.structs import Predicate, Variable


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


def learn_operators(
    segments: Sequence[Segment], min_share: float = 0.01, contacts: frozenset[Predicate] = frozenset()
) -> list[OperatorData]:
    """Return the operators with at least ``min_share`` of all segments, named Op<i> in order of discovery.

    Objects that atoms of ``contacts`` tie to those of the effects become parameters too; see
    ``with_context``. Without ``contacts``, none do, as in the paper.
    """
    found = []
    for number, one in enumerate(cluster(segments)):
        if len(one.members) < len(segments) * min_share:
            continue
        parameters, members = with_context(one.variables, one.members, contacts)
        preconditions = shared_preconditions(parameters, members)
        operator = Operator(f"Op{number}", parameters, preconditions, one.add_effects, one.delete_effects)
        context = len(parameters) - len(one.variables)
        found.append(OperatorData(operator, members, one.given, one.arguments, context))
    return found
