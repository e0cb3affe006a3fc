"""Skills of the user's own, operator and policy, beside learned ones: ``module:attribute``."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from bpns.learning.models.binding import bind_operators
from bpns.symbolic.errors import InputError
from bpns.symbolic.operators import Operator
from bpns.symbolic.plugins import load_foreign
from bpns.symbolic.skills.environment import Environment, domain_of
from bpns.symbolic.skills.skill import Skill
from bpns.symbolic.structs import sort_atoms


def load_skill(name: str, environment: Environment, folders: Sequence[Path] = ()) -> Skill:
    """Return the skill ``module:attribute``; raise InputError where there is none, or it does not fit."""
    found = load_foreign("skill", name, folders)
    if not isinstance(found, Skill):
        raise InputError(f"'{name}' is no skill: make it with bpns.Skill(operator, policy, sampler)")
    known = {p.name for p in environment.classifiers}
    atoms = found.operator.preconditions | found.operator.add_effects | found.operator.delete_effects
    for atom in sort_atoms(atoms | found.operator.negative_preconditions):
        if atom.predicate.name not in known:
            raise InputError(f"skill '{name}': no predicate '{atom.predicate.name}' in '{environment.name}'")
    domain = domain_of(environment, (found.operator,))
    (operator,) = bind_operators(domain, environment, Path(name))
    return replace(found, operator=operator)


def own_skill(name: str, operator: Operator, environment: Environment, folders: Sequence[Path]) -> Skill:
    """Return the skill ``module:attribute`` with an operator that may have been edited.

    Raises InputError where the parameters are no longer those of the skill.
    """
    skill = load_skill(name, environment, folders)
    own = [v.type.name for v in skill.operator.parameters]
    found = [v.type.name for v in operator.parameters]
    if own != found:
        raise InputError(
            f"{operator.name} has parameters of types ({', '.join(found)}), but {name} needs "
            f"({', '.join(own)}): restore them in domain.pddl"
        )
    return replace(skill, operator=operator)
