"""A task as a problem of unified-planning's, built by its API: its reader takes seconds for many actions."""

from collections import OrderedDict
from collections.abc import Mapping
from typing import Any

from unified_planning.shortcuts import (
    BoolType,
    Equals,
    Fluent,
    InstantaneousAction,
    Not,
    Object,
    Parameter,
    UserType,
)
from unified_planning.shortcuts import Problem as UpProblem

from bpns.symbolic.operators import Operator
from bpns.symbolic.pddl.rewriting.portable import Rewritten
from bpns.symbolic.structs import EQUAL, OBJECT, LiftedAtom, Type, sort_atoms


def up_problem(task: Rewritten) -> Any:
    """Return the problem; names are the task's."""
    domain, problem = task.domain, task.problem
    types = _types(task)
    built = UpProblem(problem.name)
    fluents = {}
    for predicate in domain.predicates:
        signature = [Parameter(f"x{i}", types[t]) for i, t in enumerate(predicate.types)]
        fluents[predicate.name] = Fluent(predicate.name, BoolType(), _signature=signature)
        built.add_fluent(fluents[predicate.name], default_initial_value=False)
    objects = {}
    for obj in (*domain.constants, *problem.objects):
        objects[obj.name] = Object(obj.name, types[obj.type])
        built.add_object(objects[obj.name])
    for operator in domain.operators:
        built.add_action(_action(operator, fluents, objects, types))
    for atom in sort_atoms(problem.init):
        built.set_initial_value(fluents[atom.predicate.name](*(objects[o.name] for o in atom.objects)), True)
    for atom in sort_atoms(problem.goal):
        built.add_goal(fluents[atom.predicate.name](*(objects[o.name] for o in atom.objects)))
    for atom in sort_atoms(problem.negative_goal):
        built.add_goal(Not(fluents[atom.predicate.name](*(objects[o.name] for o in atom.objects))))
    return built


def _types(task: Rewritten) -> dict[Type, Any]:
    """Return unified-planning's types; ``object`` only where it is needed, as some engines dislike it."""
    domain = task.domain
    used = [t for p in domain.predicates for t in p.types]
    used += [v.type for o in domain.operators for v in o.parameters]
    used += [o.type for o in (*domain.constants, *task.problem.objects)]
    root = UserType("object") if OBJECT in used else None
    types: dict[Type, Any] = {} if root is None else {OBJECT: root}

    def built(kind: Type) -> Any:
        if kind not in types:
            above = kind.parent
            father = root if above is None or above == OBJECT else built(above)
            types[kind] = UserType(kind.name, father)
        return types[kind]

    for kind in (*domain.types, *used):
        built(kind)
    return types


def _action(
    operator: Operator, fluents: Mapping[str, Any], objects: Mapping[str, Any], types: Mapping[Type, Any]
) -> Any:
    signature = OrderedDict((v.name[1:], types[v.type]) for v in operator.parameters)
    action = InstantaneousAction(operator.name, _parameters=signature)
    terms = {v.name: action.parameter(v.name[1:]) for v in operator.parameters} | dict(objects)

    def expression(atom: LiftedAtom) -> Any:
        arguments = [terms[t.name] for t in atom.terms]
        return Equals(*arguments) if atom.predicate == EQUAL else fluents[atom.predicate.name](*arguments)

    for atom in sort_atoms(operator.preconditions):
        action.add_precondition(expression(atom))
    for atom in sort_atoms(operator.negative_preconditions):
        action.add_precondition(Not(expression(atom)))
    for atom in sort_atoms(operator.add_effects):
        action.add_effect(expression(atom), True)
    for atom in sort_atoms(operator.delete_effects - operator.add_effects):
        action.add_effect(expression(atom), False)
    return action
