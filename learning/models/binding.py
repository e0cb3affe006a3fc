"""Operators that were written as text, over an environment's own types and predicates."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from bpns.symbolic.errors import InputError
from bpns.symbolic.operators import Domain, Operator
from bpns.symbolic.skills.environment import Environment, domain_of
from bpns.symbolic.structs import LiftedAtom, Object, Variable


def bind_operators(domain: Domain, environment: Environment, path: Path) -> tuple[Operator, ...]:
    """Return a PDDL domain's operators over an environment's own types and predicates."""
    types = {t.name: t for t in domain_of(environment, ()).types}
    predicates = {p.name: p for p in environment.classifiers}
    for predicate in domain.predicates:
        own = predicates.get(predicate.name)
        if own is None or [t.name for t in own.types] != [t.name for t in predicate.types]:
            have = ", ".join(p.signature for p in predicates.values())
            raise InputError(
                f"{path}: predicate {predicate.signature} is none of environment '{environment.name}' "
                f"(have: {have})"
            )
    if domain.constants:
        raise InputError(f"{path}: a model's operators cannot mention constants: use parameters")

    def bind(operator: Operator) -> Operator:
        for variable in operator.parameters:
            if variable.type.name not in types:
                raise InputError(
                    f"{path}: {operator.name}: type '{variable.type.name}' is none of environment "
                    f"'{environment.name}' (have: {', '.join(types)})"
                )
        variables = {v: Variable(v.name, types[v.type.name]) for v in operator.parameters}

        def atoms(lifted: frozenset[LiftedAtom]) -> frozenset[LiftedAtom]:
            return frozenset(
                LiftedAtom(
                    predicates[a.predicate.name],
                    tuple(t if isinstance(t, Object) else variables[t] for t in a.terms),
                )
                for a in lifted
            )

        return Operator(
            operator.name,
            tuple(variables.values()),
            atoms(operator.preconditions),
            atoms(operator.add_effects),
            atoms(operator.delete_effects),
            atoms(operator.negative_preconditions),
        )

    return tuple(bind(operator) for operator in domain.operators)


def in_order(operator: Operator, parameters: Sequence[tuple[str, str]], path: Path) -> Operator:
    """Return an operator with its parameters in the order in which its weights know them, as (name, type).

    A parameter is known by its name, wherever it stands. One that was renamed is known by its type, where
    that leaves no choice, or else by its place. Raises InputError where another type stands there, or where
    the types are others.
    """
    wanted, found = [kind for _, kind in parameters], [v.type.name for v in operator.parameters]
    if sorted(wanted) != sorted(found):
        raise InputError(
            f"{path}: {operator.name} has parameters of types ({', '.join(found)}), "
            f"but its weights need ({', '.join(wanted)}): restore them, or learn again"
        )
    by_name = {(v.name.lower(), v.type.name): v for v in operator.parameters}
    known = [by_name.get((name.lower(), kind)) for name, kind in parameters]
    left = [v for v in operator.parameters if v not in known]
    order = []
    for (name, kind), variable, there in zip(parameters, known, operator.parameters, strict=True):
        if variable is None:
            fit = [v for v in left if v.type.name == kind]
            if len(fit) > 1 and there not in fit:
                raise InputError(
                    f"{path}: {operator.name}: which of {', '.join(v.name for v in fit)} was {name}? Put it "
                    f"in its old place, or rename {name} in skills.json too: weights know parameters by name"
                )
            variable = fit[0] if len(fit) == 1 else there
        order.append(variable)
    if len(set(order)) < len(order):
        raise InputError(f"{path}: {operator.name}: put renamed parameters in their old places")
    return operator if tuple(order) == operator.parameters else replace(operator, parameters=tuple(order))
