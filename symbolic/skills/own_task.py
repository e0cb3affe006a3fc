"""Tasks that a user writes: a goal as text, an initial state as JSON.

A state file has one entry for each object: ``{"block0": {"type": "block", "width": 0.1, ...}, ...}``.
"""

import re
from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from math import isfinite
from pathlib import Path
from typing import Any

from bpns.symbolic.errors import InputError
from bpns.symbolic.files import read_json, write_json
from bpns.symbolic.skills.environment import Environment
from bpns.symbolic.state import State
from bpns.symbolic.structs import GroundAtom, Object

_ATOM = re.compile(r"\s*([^\s(),;]+)\s*\(([^()]*)\)\s*")
_BETWEEN = re.compile(r"\s*(?:,|;|\band\b)\s*")
_EXAMPLE = "write it as 'Covers(block0, target1), HandEmpty()'"


def parse_goal(environment: Environment, state: State, text: str) -> frozenset[GroundAtom]:
    """Read ground atoms such as ``Covers(block0, target1), HandEmpty()`` over a state's objects.

    Raises InputError for what is no atom, and for predicates and objects that there are not.
    """
    calls: list[list[str]] = []
    place = 0
    while place < len(text.rstrip()):
        found = _ATOM.match(text, place)
        if found is None:
            raise InputError(f"goal '{text}': no atom at '{text[place:].strip()}': {_EXAMPLE}")
        arguments = [name.strip() for name in found[2].split(",")] if found[2].strip() else []
        calls.append([found[1], *arguments])
        place = found.end()
        if between := _BETWEEN.match(text, place):
            place = between.end()
        elif place < len(text):
            raise InputError(f"goal '{text}': no comma before '{text[place:].strip()}': {_EXAMPLE}")
    if not calls:
        raise InputError(f"the goal is empty: {_EXAMPLE}")
    return frozenset(goal_atoms(environment, state.objects, calls))


def goal_atoms(
    environment: Environment, objects: Iterable[Object], calls: Iterable[Iterable[str]]
) -> list[GroundAtom]:
    """Return atoms given as [predicate, object, ...]; raise InputError for what there is not."""
    predicates = {p.name: p for p in environment.classifiers}
    by_name = {o.name: o for o in objects}
    found = []
    for name, *arguments in calls:
        if name not in predicates:
            have = ", ".join(p.signature for p in predicates.values())
            raise InputError(
                f"no predicate '{name}' in '{environment.name}'{_near(name, predicates)} (have: {have})"
            )
        for argument in arguments:
            if argument not in by_name:
                raise InputError(
                    f"no object '{argument}'{_near(argument, by_name)} (have: {', '.join(by_name)})"
                )
        try:
            found.append(predicates[name](*(by_name[argument] for argument in arguments)))
        except ValueError as error:
            raise InputError(f"goal atom {name}({', '.join(arguments)}): {error}") from error
    return found


def state_of(
    environment: Environment, objects: Mapping[str, Mapping[str, Any]], where: str = "state"
) -> State:
    """Return a state from what a state file holds: for each object its type and its features by name.

    Raises InputError for types and features that there are not, and for what is no finite number.
    """
    types = {t.name: t for t in environment.types}
    values: dict[Object, tuple[float, ...]] = {}
    for name, entry in objects.items():
        if not isinstance(entry, Mapping) or entry.get("type") not in types:
            given = entry.get("type") if isinstance(entry, Mapping) else entry
            raise InputError(
                f"{where}: {name}: no type {given!r} in '{environment.name}' (have: {', '.join(types)})"
            )
        kind = types[str(entry["type"])]
        given = {key: value for key, value in entry.items() if key != "type"}
        if set(given) != set(kind.features):
            missing = ", ".join(f for f in kind.features if f not in given)
            extra = ", ".join(f for f in given if f not in kind.features)
            fault = "; ".join([f"no {missing}"] * bool(missing) + [f"unknown {extra}"] * bool(extra))
            raise InputError(
                f"{where}: {name}: a {kind.name} has the features {', '.join(kind.features)}: {fault}"
            )
        for feature, value in given.items():
            if isinstance(value, bool) or not isinstance(value, (int, float)) or not isfinite(value):
                raise InputError(f"{where}: {name}.{feature} is {value!r}: give a finite number")
        values[Object(name, kind)] = tuple(float(given[feature]) for feature in kind.features)
    if not values:
        raise InputError(f"{where}: there is no object")
    return State.of(values)


def state_json(state: State) -> dict[str, dict[str, Any]]:
    """Return what a state file holds; ``state_of`` is the way back."""
    return {
        o.name: {"type": o.type.name, **dict(zip(o.type.features, state[o], strict=True))}
        for o in state.objects
    }


def read_state(path: Path, environment: Environment) -> State:
    """Read a state file; raise InputError with the place of a fault."""
    value = read_json(path)
    if not isinstance(value, Mapping):
        raise InputError(f'{path}: not a state: write {{"block0": {{"type": "block", "x": 0.5, ...}}, ...}}')
    return state_of(environment, value, str(path))


def write_state(path: Path, state: State) -> None:
    """Write a state file."""
    write_json(path, state_json(state))


def _near(name: str, names: Iterable[str]) -> str:
    """Return a question for the name that was perhaps meant."""
    found = get_close_matches(name, names, 1)
    return f": did you mean '{found[0]}'?" if found else ""
