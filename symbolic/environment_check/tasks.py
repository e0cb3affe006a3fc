"""The tasks that an environment draws: values, names, goals. Every check draws its own."""

from collections.abc import Collection, Iterator
from typing import get_args

import numpy as np

from bpns.symbolic.environment_check.findings import Remarks, fault, kind_of
from bpns.symbolic.errors import InputError
from bpns.symbolic.operators import Problem
from bpns.symbolic.pddl.write import model_names
from bpns.symbolic.skills.environment import Environment, Split, domain_of, holds, sample_tasks
from bpns.symbolic.state import State, Task
from bpns.symbolic.structs import GroundAtom, Type, canonical_order, sort_atoms

SPLITS: tuple[Split, ...] = get_args(Split)


def tasks(environment: Environment, count: int, seed: int) -> Remarks:
    """Draw the tasks of both splits twice on the same object, and look at each."""
    first = {split: _drawn(environment, split, count, seed) for split in SPLITS}
    for split in SPLITS:
        again = _drawn(environment, split, count, seed)
        for number, (task, other) in enumerate(zip(first[split], again, strict=True)):
            where = f"{split} task {number}"
            wrong = _task_fault(environment, task, where)
            if not wrong and not same(task, other):
                wrong = (
                    f"{where}: the same generator gives another task the second time: "
                    "draw everything from rng, and keep nothing between calls"
                )
            if wrong:
                yield fault(wrong)
                return ""
    return f"{count} of each split, the same when drawn again"


def _drawn(environment: Environment, split: Split, count: int, seed: int) -> list[object]:
    return list(sample_tasks(environment, split, count, seed))


def same(one: object, other: object) -> bool:
    """Say whether both are tasks with equal features and goals."""
    return (
        isinstance(one, Task)
        and isinstance(other, Task)
        and isinstance(other.init, State)
        and one.goal == other.goal
        and one.init.features == other.init.features
        and one.init.objects == other.init.objects
    )


def _task_fault(environment: Environment, task: object, where: str) -> str:
    """Return what is wrong with a task, or nothing."""
    if not isinstance(task, Task):
        return f"{where}: sample_task gave a {kind_of(task)}: return a bpns.symbolic.state.Task"
    if wrong := state_fault(task.init, environment.types):
        return f"{where}: {wrong}"
    if not isinstance(task.goal, frozenset) or not all(isinstance(a, GroundAtom) for a in task.goal):
        return f"{where}: the goal is a {kind_of(task.goal)}: give a frozenset of ground atoms"
    if not task.goal:
        return f"{where}: the goal is empty: give at least one atom"
    for atom in sort_atoms(task.goal):
        if atom.predicate not in environment.goal_predicates:
            return f"{where}: the goal's {atom} is not over goal_predicates: add {atom.predicate.name} there"
        for obj in atom.objects:
            if obj not in task.init.objects:
                return f"{where}: the goal's {atom} names {obj}, which the state does not have: add it"
        try:
            atom.predicate.check([o.type for o in atom.objects])
        except ValueError as error:
            return f"{where}: the goal's {atom} does not fit: {error}"
    return ""


def state_fault(state: object, types: Collection[Type]) -> str:
    """Return what is wrong with a state, or nothing."""
    if not isinstance(state, State):
        return f"there is a {kind_of(state)} instead of a state: use State.of or state.changed"
    names = [o.name for o in state.objects]
    if len(set(names)) < len(names):
        return "two objects have the same name: rename one"
    if set(state.features) != set(names):
        odd = sorted(set(state.features) ^ set(names))
        return f"objects and features do not name the same things ({', '.join(odd)}): use State.of"
    for obj in state.objects:
        if obj.type not in types:
            return f"{obj} is of type {obj.type.name}, which is not in types: add it"
        values = state.features[obj.name]
        if not isinstance(values, tuple):
            return f"the features of {obj} are a {kind_of(values)}: give a tuple"
        if len(values) != len(obj.type.features):
            return f"{obj} has {len(values)} features, but a {obj.type.name} has {len(obj.type.features)}"
        for feature, value in zip(obj.type.features, values, strict=True):
            if type(value) is not float:
                return f"{obj}.{feature} is a {kind_of(value)}: turn it into a Python float"
            if not np.isfinite(value):
                return f"{obj}.{feature} is {value}: features must be finite"
    of_types = {t: tuple(o for o in state.objects if o.type.name == t) for t in state.by_type}
    if state.objects != canonical_order(state.objects) or dict(state.by_type) != of_types:
        return "objects or by_type are not in canonical order: use State.of or state.changed"
    return ""


def object_names(environment: Environment, count: int, seed: int) -> Remarks:
    """Ask whether PDDL can hold the objects' names beside those of types and predicates."""
    domain = domain_of(environment, (skill.operator for skill in environment.oracle_skills))
    for where, task in all_tasks(environment, count, seed):
        try:
            model_names(domain, Problem("p01", task.init.objects, frozenset(), task.goal))
        except InputError as error:
            yield fault(f"{where}: {error}")
            return ""
    return "PDDL can hold them too"


def goals(environment: Environment, count: int, seed: int) -> Remarks:
    """Ask for tasks that are solved before they begin."""
    for where, task in all_tasks(environment, count, seed):
        if all(holds(environment, atom, task.init) for atom in task.goal):
            text = ", ".join(map(str, sort_atoms(task.goal)))
            yield fault(f"{where}: the goal already holds at the start ({text}): draw another task")
            return ""
    return "none holds at the start"


def all_tasks(environment: Environment, count: int, seed: int) -> Iterator[tuple[str, Task]]:
    """Yield the tasks of both splits, each with what to call it."""
    for split in SPLITS:
        for number, task in enumerate(sample_tasks(environment, split, count, seed)):
            yield f"{split} task {number}", task
