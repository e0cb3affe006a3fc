"""Files of demonstrations: HDF5 that explains itself."""

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from bpns.learning.data.arrays import labels_of, objects_of, trajectory_of
from bpns.learning.data.demonstrations import Demonstration, Demonstrations
from bpns.symbolic.errors import InputError
from bpns.symbolic.files import replacing
from bpns.symbolic.skills.environment import Environment
from bpns.symbolic.skills.own_task import goal_atoms
from bpns.symbolic.state import Task
from bpns.symbolic.structs import Type

FORMAT = "bpns demonstrations 2"


def symbols(environment: Environment) -> dict[str, Any]:
    """Return types, features and predicates as JSON values."""
    types: dict[str, Any] = {}
    for leaf in environment.types:
        step: Type | None = leaf
        while step is not None:
            parent = step.parent.name if step.parent else None
            types[step.name] = {"features": list(step.features), "parent": parent}
            step = step.parent
    predicates = {p.name: [t.name for t in p.types] for p in environment.classifiers}
    return {"types": types, "predicates": predicates}


def write_demonstrations(
    path: Path, data: Demonstrations, environment: Environment, load: str = "", folder: Path | None = None
) -> None:
    """Write demonstrations; the same ones give the same bytes.

    ``load`` is how the environment is asked for where that is not its name: ``module:attribute``. ``folder``
    is where its module is, unless it is installed; the file knows it by the way from itself to there.
    """
    with replacing(path) as temporary, h5py.File(temporary, "w", libver="latest") as file:
        header = {
            "format": FORMAT,
            "environment": data.environment,
            "load": load or data.environment,
            "seed": data.seed,
            "asked": data.asked,
            "failures": data.failures,
            "budget": asdict(environment.budget),
            **symbols(environment),
            **({"folder": os.path.relpath(folder, path.parent)} if folder else {}),
        }
        for key, value in header.items():
            file.attrs[key] = value if isinstance(value, (str, int)) else json.dumps(value)
        file.attrs["layout"] = (
            "demonstrations/N/states: (T+1, F) features of the objects in order; actions: (T, A); "
            "given: (T,) which of the given skills produced an action, -1 for none; attributes "
            "objects {name: type}, goal [[predicate, object, ...], ...], given_skills [[skill, object, ...], "
            "...], task (index)"
        )
        for demonstration in data.demonstrations:
            group = file.create_group(f"demonstrations/{demonstration.task_index:06d}")
            states = demonstration.trajectory.states
            objects = states[0].objects
            group.attrs["task"] = demonstration.task_index
            group.attrs["objects"] = json.dumps({o.name: o.type.name for o in objects})
            goal = [[a.predicate.name, *(o.name for o in a.objects)] for a in demonstration.task.goal]
            group.attrs["goal"] = json.dumps(sorted(goal))
            group["states"] = np.array([s.vector(objects) for s in states], np.float64)
            group["actions"] = np.array(demonstration.trajectory.actions, np.float32)
            labels = list(dict.fromkeys(label for label in demonstration.labels if label))
            calls = [[label.skill, *(o.name for o in label.objects)] for label in labels]
            group.attrs["given_skills"] = json.dumps(calls)
            number = {label: i for i, label in enumerate(labels)}
            group["given"] = np.array([number[a] if a else -1 for a in demonstration.labels], np.int32)


def read_environment_name(path: Path) -> tuple[str, list[Path]]:
    """Return how to ask for the environment of demonstrations, and in which folder its module may be.

    Raises InputError as below.
    """
    with _open(path) as file, _reported(path):
        folder = file.attrs.get("folder")
        return str(file.attrs["load"]), [] if folder is None else [(path.parent / str(folder)).resolve()]


def read_demonstrations(path: Path, environment: Environment) -> Demonstrations:
    """Read demonstrations; raise InputError where the file is broken or of another environment."""
    with _open(path) as file, _reported(path):
        own = symbols(environment)
        if file.attrs["environment"] != environment.name:
            raise InputError(
                f"{path}: demonstrations of '{file.attrs['environment']}', not of '{environment.name}': "
                "give a file of this environment, or choose that one"
            )
        for key, values in own.items():
            if json.loads(file.attrs[key]) != values:
                raise InputError(
                    f"{path}: its {key} differ from those of '{environment.name}' here: "
                    f"make the demonstrations again with 'bpns demos {environment.name}'"
                )
        groups = file["demonstrations"].values() if "demonstrations" in file else ()
        found = [_read_one(group, environment) for group in groups]
        failures = tuple((int(i), str(why)) for i, why in json.loads(file.attrs["failures"]))
        return Demonstrations(
            environment.name, int(file.attrs["seed"]), int(file.attrs["asked"]), tuple(found), failures
        )


@contextmanager
def _reported(path: Path) -> Iterator[None]:
    """Turn whatever a damaged file leads to into one line."""
    try:
        yield
    except InputError as error:
        if str(error).startswith(str(path)):
            raise
        raise InputError(f"{path}: {error}") from error
    except (KeyError, ValueError, TypeError, AttributeError, IndexError, OSError, RuntimeError) as error:
        raise InputError(
            f"{path}: broken demonstrations file ({type(error).__name__}: {error}): "
            "make it again with 'bpns demos'"
        ) from error


def _open(path: Path) -> h5py.File:
    """Open a demonstrations file; raise InputError where it is none."""
    if not path.is_file():
        raise InputError(f"cannot read {path}: no such file (make one with 'bpns demos')")
    try:
        file = h5py.File(path, "r")
    except OSError as error:
        raise InputError(
            f"{path}: not an HDF5 file, or truncated: make it again with 'bpns demos'"
        ) from error
    if file.attrs.get("format") != FORMAT:
        file.close()
        raise InputError(f"{path}: an HDF5 file, but not of {FORMAT}: make one with 'bpns demos'")
    return file


def _read_one(group: h5py.Group, environment: Environment) -> Demonstration:
    objects = objects_of(environment, json.loads(group.attrs["objects"]))
    trajectory = trajectory_of(environment, objects, group["states"][()], group["actions"][()], group.name)
    goal = goal_atoms(environment, objects, json.loads(group.attrs["goal"]))
    labels = labels_of(environment, objects, json.loads(group.attrs["given_skills"]), group.file.filename)
    numbers = group["given"][()].tolist()
    if len(numbers) != len(trajectory.actions):
        raise ValueError(f"{group.name}: {len(numbers)} labels do not fit {len(trajectory.actions)} actions")
    if not all(-1 <= number < len(labels) for number in numbers):
        raise ValueError(f"{group.name}: a label is out of range")
    return Demonstration(
        int(group.attrs["task"]),
        Task(trajectory.states[0], frozenset(goal)),
        trajectory,
        tuple(None if number < 0 else labels[number] for number in numbers),
    )
