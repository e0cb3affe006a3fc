"""Operators for people (the notation of the paper's figure 10) and for other programs (JSON values)."""

from collections.abc import Iterable
from typing import Any

from symbolic.structs import LiftedAtom, Operator, sort_atoms


def operator_text(operator: Operator) -> str:
    """Return an operator in the paper's notation."""

    def atoms(lifted: frozenset[LiftedAtom], prefix: str = "") -> list[str]:
        return [f"{prefix}{atom}" for atom in sort_atoms(lifted)]

    conditions = atoms(operator.preconditions) + atoms(operator.negative_preconditions, "not ")
    return "\n".join(
        [
            f"{operator.name}:",
            f"  Parameters: [{', '.join(map(str, operator.parameters))}]",
            f"  Preconditions: [{', '.join(conditions)}]",
            f"  Add Effects: [{', '.join(atoms(operator.add_effects))}]",
            f"  Delete Effects: [{', '.join(atoms(operator.delete_effects))}]",
        ]
    )


def operators_json(operators: Iterable[Operator]) -> list[dict[str, Any]]:
    """Return operators as JSON values; an atom is [predicate, term, ...]."""

    def atoms(lifted: frozenset[LiftedAtom]) -> list[list[str]]:
        return [[a.predicate.name, *(t.name for t in a.terms)] for a in sort_atoms(lifted)]

    return [
        {
            "name": operator.name,
            "parameters": [[v.name, v.type.name] for v in operator.parameters],
            "preconditions": atoms(operator.preconditions),
            "negative_preconditions": atoms(operator.negative_preconditions),
            "add_effects": atoms(operator.add_effects),
            "delete_effects": atoms(operator.delete_effects),
        }
        for operator in operators
    ]
