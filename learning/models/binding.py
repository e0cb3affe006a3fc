"""Operators that were written as text, over an environment's own types and predicates."""

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
