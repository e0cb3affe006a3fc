"""The parts of a demonstration out of arrays and names, checked."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from bpns.learning.data.demonstrations import Demonstration
from bpns.symbolic.errors import InputError
from bpns.symbolic.skills.environment import Environment
from bpns.symbolic.skills.own_task import goal_atoms, parse_goal
from bpns.symbolic.skills.skill import Label
from bpns.symbolic.state import Array, State, Task, Trajectory
from bpns.symbolic.structs import Object


def demonstration(environment: Environment, number: int, recording: Mapping[str, Any]) -> Demonstration:
    """Return a demonstration; raise InputError with its number where a part is missing or does not fit.

    ``recording`` has "objects", "states", "actions", "goal" and perhaps "skills", as
    ``bpns.demonstrations_from_arrays`` describes them.
    """
    where = f"recording {number}"
    if missing := [key for key in ("objects", "states", "actions", "goal") if key not in recording]:
        raise InputError(f"{where}: no {', '.join(missing)}")
    try:
        objects = objects_of(environment, recording["objects"])
        states, actions = (np.asarray(recording[key], float) for key in ("states", "actions"))
        trajectory = trajectory_of(environment, objects, states, actions, where)
        init = trajectory.states[0]
        goal = recording["goal"]
        atoms = (
            parse_goal(environment, init, goal)
            if isinstance(goal, str)
            else frozenset(goal_atoms(environment, objects, goal))
        )
        calls = recording.get("skills") or [None] * len(trajectory.actions)
        if len(calls) != len(trajectory.actions):
            raise ValueError(f"{len(calls)} skills do not fit {len(trajectory.actions)} actions")
        labels = [
            None if call is None else labels_of(environment, objects, [call], where)[0] for call in calls
        ]
    except (InputError, ValueError, TypeError, KeyError) as error:
        text = f"unknown type {error}" if isinstance(error, KeyError) else str(error)
        raise InputError(text if text.startswith(where) else f"{where}: {text}") from error
    return Demonstration(number, Task(init, atoms), trajectory, tuple(labels))


def objects_of(environment: Environment, names: Mapping[str, str]) -> list[Object]:
    """Return objects by their names and types; raise KeyError for a type that there is not."""
    types = {t.name: t for t in environment.types}
    return [Object(name, types[kind]) for name, kind in names.items()]


def trajectory_of(
    environment: Environment, objects: Sequence[Object], rows: Array, actions: Array, where: str
) -> Trajectory:
    """Return a trajectory out of ``rows``, (T+1, F) features of the objects in order, and (T, A) actions.

    Raises ValueError for shapes that do not fit, and for what is no finite number.
    """
    width = sum(len(o.type.features) for o in objects)
    if rows.shape != (len(actions) + 1, width) or actions.shape[1:] != environment.action_low.shape:
        raise ValueError(
            f"{where}: states {rows.shape} and actions {actions.shape} do not fit: "
            f"they should be (T+1, {width}) and (T, {len(environment.action_low)})"
        )
    if not (np.isfinite(rows).all() and np.isfinite(actions).all()):
        raise ValueError(f"{where}: a feature or action is no finite number")
    by_name = {o.name: o for o in objects}
    ends = np.cumsum([len(o.type.features) for o in objects]).tolist()
    spans = {o: (end - len(o.type.features), end) for o, end in zip(objects, ends, strict=True)}
    values = rows.tolist()
    states = [State.of({o: values[0][start:end] for o, (start, end) in spans.items()})]
    names = [o.name for o in objects for _ in o.type.features]  # of the object of each column
    for before, after, row in zip(rows, rows[1:], values[1:], strict=False):  # most objects never change
        changed = {names[column] for column in np.flatnonzero(before != after).tolist()}
        pieces = {n: tuple(row[slice(*spans[by_name[n]])]) for n in changed}
        states.append(states[-1].changed(pieces))
    return Trajectory(tuple(states), tuple(actions.astype(np.float32)))


def labels_of(
    environment: Environment, objects: Sequence[Object], calls: Iterable[Sequence[str]], where: str
) -> list[Label]:
    """Return labels given as [skill, object, ...]; raise InputError where there is no such given skill."""
    given = {skill.name: skill for skill in environment.given_skills}
    by_name = {o.name: o for o in objects}
    labels: list[Label] = []
    for name, *arguments in calls:
        if name not in given:
            raise InputError(
                f"{where}: has actions of a given skill '{name}', which is not in the "
                f"given_skills of '{environment.name}' (have: {', '.join(given) or 'none'}): add it there"
            )
        label = Label(name, tuple(by_name[o] for o in arguments))
        types = given[name].types
        fits = len(types) == len(label.objects)
        if not fits or not all(o.type.is_a(t) for o, t in zip(label.objects, types, strict=True)):
            raise ValueError(f"{where}: {name} is not over {', '.join(arguments)}")
        labels.append(label)
    return labels
