"""Operators as Markdown and as JSON values; ``str`` gives the notation of the paper."""

from collections.abc import Iterable
from typing import Any

from bpns.symbolic.operators import Operator
from bpns.symbolic.structs import LiftedAtom, sort_atoms


def operator_markdown(operator: Operator) -> str:
    """Return an operator as a section of Markdown: its name above a table."""

    def row(title: str, items: Iterable[str]) -> str:
        return f"| {title} | {', '.join(f'`{item}`' for item in items) or 'none'} |"

    def atoms(lifted: frozenset[LiftedAtom], prefix: str = "") -> list[str]:
        return [f"{prefix}{atom_text(atom)}" for atom in sort_atoms(lifted)]

    conditions = atoms(operator.preconditions) + atoms(operator.negative_preconditions, "not ")
    return "\n".join(
        [
            f"### {operator.name}",
            "",
            row("parameters", (f"{v.name} - {v.type.name}" for v in operator.parameters)),
            "|---|---|",
            row("preconditions", conditions),
            row("add effects", atoms(operator.add_effects)),
            row("delete effects", atoms(operator.delete_effects)),
        ]
    )


def atom_text(atom: LiftedAtom) -> str:
    """Return an atom without its terms' types: ``Holding(?block, ?robot)``."""
    return f"{atom.predicate.name}({', '.join(t.name for t in atom.terms)})"


def atoms_json(atoms: Iterable[LiftedAtom]) -> list[list[str]]:
    """Return atoms as JSON values, each [predicate, term, ...], in order."""
    return [[a.predicate.name, *(t.name for t in a.terms)] for a in sort_atoms(atoms)]


def operators_json(operators: Iterable[Operator]) -> list[dict[str, Any]]:
    """Return operators as JSON values; an atom is [predicate, term, ...]."""
    return [
        {
            "name": operator.name,
            "parameters": [[v.name, v.type.name] for v in operator.parameters],
            "preconditions": atoms_json(operator.preconditions),
            "negative_preconditions": atoms_json(operator.negative_preconditions),
            "add_effects": atoms_json(operator.add_effects),
            "delete_effects": atoms_json(operator.delete_effects),
        }
        for operator in operators
    ]
