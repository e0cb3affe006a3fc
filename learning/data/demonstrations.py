"""Demonstrations: made with oracle skills, kept in HDF5 files that explain themselves."""

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from bpns.learning.parallel import parallel_map
from bpns.symbolic import planners
from bpns.symbolic.bilevel.execution import execute
from bpns.symbolic.bilevel.exhaustive import exhaustive
from bpns.symbolic.bilevel.solve import NoPlan, solve
from bpns.symbolic.errors import InputError
from bpns.symbolic.files import replacing
from bpns.symbolic.skills.environment import Environment, sample_tasks
from bpns.symbolic.skills.skill import Label
from bpns.symbolic.state import State, Task, Trajectory
from bpns.symbolic.structs import GroundAtom, Object, Predicate, Type

FORMAT = "bpns demonstrations 2"


@dataclass(frozen=True, slots=True, eq=False)
class Demonstration:
    """A trajectory that solves a task; ``labels`` has one entry per action, None where no skill is given."""

    task_index: int
    task: Task
    trajectory: Trajectory
    labels: tuple[Label | None, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Demonstrations:
    """What one run of ``collect`` gave; ``failures`` says for each task without demonstration why."""

    environment: str  # its name
    seed: int
    asked: int
    demonstrations: tuple[Demonstration, ...]
    failures: tuple[tuple[int, str], ...]


def demonstrate(environment: Environment, seed: int, numbered: tuple[int, Task]) -> Demonstration | str:
    """Solve a train task with the oracle skills and carry the whole plan out; or say why that failed.

    Source: spec, algorithm.md section 1.
    """
    index, task = numbered
    skills = {skill.operator.name: skill for skill in environment.oracle_skills}
    plan = solve(
        environment,
        task,
        skills,
        planners.load("astar"),
        environment.budget,
        seed + index + 1,
        strategy=exhaustive,
    )
    if isinstance(plan, NoPlan):
        return plan.text
    execution = execute(environment, task, plan, whole=True)
    if execution.fault:
        return execution.fault
    labels = tuple(plan.steps[step].skill.label for step in execution.steps)
    return Demonstration(index, task, execution.trajectory, labels)


def collect(
    environment: Environment,
    count: int,
    seed: int,
    workers: int = 1,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Demonstrations:
    """Demonstrate the first ``count`` train tasks; the result does not depend on ``workers``."""
    tasks = list(enumerate(sample_tasks(environment, "train", count, seed)))
    work = partial(demonstrate, environment, seed)
    found, failures = [], []
    for index, result in enumerate(parallel_map(work, tasks, workers, chunk=10)):
        if isinstance(result, str):
            failures.append((index, result))
        else:
            found.append(result)
        progress(index + 1, count)
    return Demonstrations(environment.name, seed, count, tuple(found), tuple(failures))


# -------------------------------------------------------------------------------------------- files


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


def write_demonstrations(path: Path, data: Demonstrations, environment: Environment, load: str = "") -> None:
    """Write demonstrations; the same ones give the same bytes.

    ``load`` is how the environment is asked for where that is not its name: ``module:attribute``.
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


def read_environment_name(path: Path) -> str:
    """Return how to ask for the environment of demonstrations; raise InputError as below."""
    with _open(path) as file, _reported(path):
        return str(file.attrs["load"])


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
    except InputError:
        raise
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
    types = {t.name: t for t in environment.types}
    objects = {n: Object(n, types[t]) for n, t in json.loads(group.attrs["objects"]).items()}
    predicates: dict[str, Predicate] = {p.name: p for p in environment.classifiers}
    goal: frozenset[GroundAtom] = frozenset(
        predicates[name](*(objects[o] for o in arguments))
        for name, *arguments in json.loads(group.attrs["goal"])
    )
    rows, actions = group["states"][()], group["actions"][()]
    width = sum(len(o.type.features) for o in objects.values())
    if rows.shape != (len(actions) + 1, width) or actions.shape[1:] != environment.action_low.shape:
        raise ValueError(f"{group.name}: states {rows.shape} and actions {actions.shape} do not fit")
    if not (np.isfinite(rows).all() and np.isfinite(actions).all()):
        raise ValueError(f"{group.name}: a feature or action is no finite number")
    ends = np.cumsum([len(o.type.features) for o in objects.values()]).tolist()
    spans = {o: (end - len(o.type.features), end) for o, end in zip(objects.values(), ends, strict=True)}
    values = rows.tolist()
    states = [State.of({o: values[0][start:end] for o, (start, end) in spans.items()})]
    names = [o.name for o in objects.values() for _ in o.type.features]  # of the object of each column
    for before, after, row in zip(rows, rows[1:], values[1:], strict=False):  # most objects never change
        changed = {names[column] for column in np.flatnonzero(before != after).tolist()}
        pieces = {n: tuple(row[slice(*spans[objects[n]])]) for n in changed}
        states.append(states[-1].changed(pieces))
    trajectory = Trajectory(tuple(states), tuple(actions.astype(np.float32)))
    labels = _read_labels(group, environment, objects)
    if len(labels) != len(actions):
        raise ValueError(f"{group.name}: {len(labels)} labels do not fit {len(actions)} actions")
    return Demonstration(int(group.attrs["task"]), Task(states[0], goal), trajectory, labels)


def _read_labels(
    group: h5py.Group, environment: Environment, objects: dict[str, Object]
) -> tuple[Label | None, ...]:
    """Return the label of every action."""
    given = {skill.name: skill for skill in environment.given_skills}
    labels: list[Label | None] = []
    for name, *arguments in json.loads(group.attrs["given_skills"]):
        if name not in given:
            raise InputError(
                f"{group.file.filename}: has actions of a given skill '{name}', which is not in the "
                f"given_skills of '{environment.name}' (have: {', '.join(given) or 'none'}): add it there"
            )
        label = Label(name, tuple(objects[o] for o in arguments))
        types = given[name].types
        fits = len(types) == len(label.objects)
        if not fits or not all(o.type.is_a(t) for o, t in zip(label.objects, types, strict=True)):
            raise ValueError(f"{group.name}: {name} is not over {', '.join(arguments)}")
        labels.append(label)
    numbers = group["given"][()].tolist()
    if not all(-1 <= number < len(labels) for number in numbers):
        raise ValueError(f"{group.name}: a label is out of range")
    labels.append(None)  # found as -1
    return tuple(labels[number] for number in numbers)
