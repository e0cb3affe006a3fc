"""The difference of two domains for people, and for other programs (JSON values)."""

from collections.abc import Iterator
from typing import Any

from bpns.symbolic.compare.description import atom_text, atoms_json, operators_json
from bpns.symbolic.compare.difference import Difference, NameChange, OperatorPair
from bpns.symbolic.operators import Operator
from bpns.symbolic.structs import Variable

WORDS = {
    "preconditions": "precondition",
    "negative_preconditions": "precondition",
    "add_effects": "add effect",
    "delete_effects": "delete effect",
}


def difference_text(difference: Difference) -> str:
    """Return a line for each operator and each difference, and a summary.

    >>> import bpns
    >>> model = bpns.oracle(bpns.load_environment("cover"))
    >>> print(bpns.difference_text(bpns.diff(model, model.without("Pick"))))
    same      Place
    removed   Pick(?block - block, ?gripper - gripper)
    operators: 1 same, 0 changed, 1 removed, 0 added
    """
    lines = [
        *_declared("type", difference.types),
        *_declared("predicate", difference.predicates),
        *_declared("constant", difference.constants),
    ]
    for pair in difference.pairs:
        lines.append(f"{'same' if pair.same else 'changed':10}{_names(pair)}")
        lines += [f"{'':12}{line}" for line in _changes(pair)]
    lines += [f"{'removed':10}{_call(operator)}" for operator in difference.removed]
    lines += [f"{'added':10}{_call(operator)}" for operator in difference.added]
    same = sum(pair.same for pair in difference.pairs)
    counts = (same, len(difference.pairs) - same, len(difference.removed), len(difference.added))
    words = ("same", "changed", "removed", "added")
    lines.append(
        "operators: " + ", ".join(f"{number} {word}" for number, word in zip(counts, words, strict=True))
    )
    return "\n".join(lines)


def difference_json(difference: Difference) -> dict[str, Any]:
    """Return a difference as JSON values; an atom is [predicate, term, ...], a parameter [name, type]."""
    return {
        "same": difference.same,
        "types": _names_json(difference.types),
        "predicates": _names_json(difference.predicates),
        "constants": _names_json(difference.constants),
        "operators": {
            "same": [_pair_json(pair) for pair in difference.pairs if pair.same],
            "changed": [_pair_json(pair) | _changes_json(pair) for pair in difference.pairs if not pair.same],
            "removed": operators_json(difference.removed),
            "added": operators_json(difference.added),
        },
    }


def _declared(kind: str, change: NameChange) -> Iterator[str]:
    for text in change.removed:
        yield f"{kind:10}- {text}"
    for text in change.added:
        yield f"{kind:10}+ {text}"
    for before, after in change.changed:
        yield f"{kind:10}- {before}  + {after}"


def _call(operator: Operator) -> str:
    return f"{operator.name}({', '.join(f'{v.name} - {v.type.name}' for v in operator.parameters)})"


def _names(pair: OperatorPair) -> str:
    """Return the operators' names, and the parameters' where these differ."""
    name, other = pair.before.name, pair.after.name
    new = [f"{a.name} -> {b.name}" for a, b in pair.renaming if a.name.lower() != b.name.lower()]
    title = name if name.lower() == other.lower() else f"{name} -> {other}"
    return title + (f" ({', '.join(new)})" if new else "")


def _changes(pair: OperatorPair) -> Iterator[str]:
    for before, after in pair.retyped:
        yield f"parameter      - {_typed(before)}  + {_typed(after)}"
    for sign, parameters in (("-", pair.removed), ("+", pair.added)):
        for parameter in parameters:
            yield f"parameter      {sign} {_typed(parameter)}"
    for change in pair.atoms:
        negation = "not " if change.part == "negative_preconditions" else ""
        for sign, atoms in (("-", change.removed), ("+", change.added)):
            for atom in atoms:
                yield f"{WORDS[change.part]:15}{sign} {negation}{atom_text(atom)}"


def _typed(variable: Variable) -> str:
    return f"{variable.name} - {variable.type.name}"


def _names_json(change: NameChange) -> dict[str, Any]:
    return {
        "removed": list(change.removed),
        "added": list(change.added),
        "changed": [list(pair) for pair in change.changed],
    }


def _pair_json(pair: OperatorPair) -> dict[str, Any]:
    return {
        "before": pair.before.name,
        "after": pair.after.name,
        "parameters": [[a.name, b.name] for a, b in pair.renaming],
    }


def _changes_json(pair: OperatorPair) -> dict[str, Any]:
    parameters = {
        "removed": [[v.name, v.type.name] for v in pair.removed],
        "added": [[v.name, v.type.name] for v in pair.added],
        "retyped": [[[a.name, a.type.name], [b.name, b.type.name]] for a, b in pair.retyped],
    }
    atoms = {
        change.part: {"removed": atoms_json(change.removed), "added": atoms_json(change.added)}
        for change in pair.atoms
    }
    return {"changed_parameters": parameters, "changed_atoms": atoms}
