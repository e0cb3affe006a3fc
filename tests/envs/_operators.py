"""Compare operators with tables written as text."""

from collections.abc import Mapping

from bpns.symbolic.operators import Operator


def assert_operator(
    operator: Operator, short: Mapping[str, str], head: str, conditions: str, add: str, delete: str
) -> None:
    """``head`` is ``Name a,b``, the others atoms with blanks between; ``short`` gives variables' letters."""
    assert f"{operator.name} {','.join(short[v.name] for v in operator.parameters)}" == head
    for atoms, text in (
        (operator.preconditions, conditions),
        (operator.add_effects, add),
        (operator.delete_effects, delete),
    ):
        words = {f"{a.predicate.name}({','.join(short[t.name] for t in a.terms)})" for a in atoms}
        assert words == set(text.split())
    assert not operator.negative_preconditions
