"""Checking a simulator against recorded tasks, demonstrations and transitions."""

import gzip
import json
import zlib
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from bpns.symbolic.errors import InputError
from bpns.symbolic.skills.environment import Environment, EnvironmentFailure, abstract
from bpns.symbolic.state import State
from bpns.symbolic.structs import Object

TOLERANCE = 1e-9  # on every feature of a next state

Json = Mapping[str, Any]


@dataclass(slots=True)
class Replay:
    """How many things of each kind were compared, how many differ, and what the first ones are."""

    compared: Counter[str] = field(default_factory=Counter)
    different: Counter[str] = field(default_factory=Counter)
    examples: list[str] = field(default_factory=list)

    def check(self, kind: str, where: str, difference: str) -> None:
        """Count one comparison; ``difference`` is empty where both agree."""
        self.compared[kind] += 1
        if difference:
            self.different[kind] += 1
            self.examples.append(f"{kind}, {where}: {difference}")


def read_recording(path: Path) -> Json:
    """Return a recording, gzip'ed or plain JSON; raise InputError where the file is none."""
    try:
        data = path.read_bytes()
        if data[:2] == b"\x1f\x8b":
            data = gzip.decompress(data)
        recording = json.loads(data)
        missing = {"environment", "types", "train_tasks", "test_tasks", "demos", "transitions"} - set(
            recording
        )
    except (OSError, EOFError, ValueError, TypeError, RecursionError, zlib.error) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"cannot read {path} as a recording (JSON or JSON.gz): {reason}") from error
    if not isinstance(recording, dict) or missing:
        raise InputError(f"{path}: not a recording: no {', '.join(sorted(missing))}")
    return recording


def replay(recording: Json, environment: Environment) -> Replay:
    """Compare everything in a recording with what the environment does; raise InputError on broken parts."""
    result = Replay()
    foreign = sorted(set(recording["types"]) - {t.name for t in environment.types})
    if foreign:
        raise InputError(
            f"this recording is of '{recording['environment']}': environment '{environment.name}' has no "
            f"type '{foreign[0]}': give the right --environment"
        )
    try:
        _check_definition(recording, environment, result)
        inits: dict[tuple[str, int], State] = {}
        for split in ("train", "test"):
            for number, task in enumerate(recording[f"{split}_tasks"]):
                types = {t.name: t for t in environment.types}
                objects = {n: Object(n, types[t]) for n, t in task["objects"].items()}
                state = State.of({objects[n]: values for n, values in task["init"].items()})
                inits[split, number] = state
                where = f"{split} task {number}"
                result.check("task atoms", where, _atoms(environment, state, task["init_atoms"]))
        for number, demo in enumerate(recording["demos"]):
            _check_demonstration(demo, number, inits["train", demo["task"]], environment, result)
        for number, transition in enumerate(recording["transitions"]):
            split, task = transition["task"]
            _check_transition(transition, number, inits[split, task], environment, result)
    except (KeyError, TypeError, ValueError, AttributeError, IndexError, OverflowError) as error:
        raise InputError(f"broken recording: {type(error).__name__}: {error}") from error
    return result


def _check_definition(recording: Json, environment: Environment, result: Replay) -> None:
    """Compare types, predicates, bounds and limits."""
    bounds = [
        [None if abs(v) == inf else v for v in bound.astype(float).tolist()]
        for bound in (environment.action_low, environment.action_high)
    ]
    own = {
        "types": {t.name: list(t.features) for t in environment.types},
        "predicates": {p.name: [t.name for t in p.types] for p in environment.classifiers},
        "goal_predicates": sorted(p.name for p in environment.goal_predicates),
        "action_low": bounds[0],
        "action_high": bounds[1],
        "horizon": environment.horizon,
        "skill_rollout_limit": environment.rollout_limit,
    }
    for key, value in own.items():
        if key in recording:
            found = sorted(recording[key]) if key == "goal_predicates" else recording[key]
            result.check("definition", key, "" if found == value else f"{found} recorded, {value} here")


def _check_demonstration(
    demo: Json, number: int, init: State, environment: Environment, result: Replay
) -> None:
    """Step through a demonstration's actions, each from the state that came out of the step before."""
    state = init
    for step, (changes, atoms) in enumerate(zip(demo["states"], demo["atoms"], strict=True)):
        where = f"demonstration {number}, state {step}"
        if step:
            try:
                state = environment.simulate(state, np.array(demo["actions"][step - 1], np.float32))
            except EnvironmentFailure as failure:
                result.check("demonstration states", where, f"fails here: {failure}")
                return
        result.check("demonstration states", where, _states(state, _changed(init, changes)))
        result.check("demonstration atoms", where, _atoms(environment, state, atoms))


def _check_transition(
    transition: Json, number: int, init: State, environment: Environment, result: Replay
) -> None:
    """Take one recorded step."""
    where = f"transition {number}"
    state = _changed(init, transition["state"])
    action = np.array(transition["action"], np.float32)
    try:
        following = environment.simulate(state, action)
    except EnvironmentFailure as failure:
        fault = "" if transition["next_state"] is None else f"fails here only: {failure}"
        result.check("transition failures", where, fault)
        return
    if transition["next_state"] is None:
        result.check("transition failures", where, f"failed when recorded only: {transition['failure']}")
        return
    result.check("transition states", where, _states(following, _changed(init, transition["next_state"])))
    result.check("transition atoms", where, _atoms(environment, following, transition["next_atoms"]))


def _changed(init: State, changes: Json) -> State:
    return init.changed({name: tuple(map(float, values)) for name, values in changes.items()})


def _states(ours: State, recorded: State) -> str:
    """Return the first feature that differs, in words."""
    for obj in recorded.objects:
        for feature, mine, theirs in zip(obj.type.features, ours[obj], recorded[obj], strict=True):
            if not abs(mine - theirs) <= TOLERANCE:
                return f"{obj.name}.{feature} is {theirs!r} recorded, {mine!r} here"
    return ""


def _atoms(environment: Environment, state: State, recorded: Iterable[Iterable[str]]) -> str:
    """Return the atoms that only one side has, in words."""
    ours = {
        f"{a.predicate.name}({', '.join(o.name for o in a.objects)})" for a in abstract(environment, state)
    }
    theirs = {f"{name}({', '.join(arguments)})" for name, *arguments in recorded}
    parts = [f"{', '.join(sorted(theirs - ours))} recorded only" if theirs - ours else ""]
    parts += [f"{', '.join(sorted(ours - theirs))} here only" if ours - theirs else ""]
    return "; ".join(filter(None, parts))
