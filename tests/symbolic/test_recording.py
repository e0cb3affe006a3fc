"""The comparison itself: what is changed in a recording must be found."""

import copy
import gzip
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bpns.symbolic.errors import InputError
from bpns.symbolic.skills.environment import abstract, sample_tasks
from bpns.symbolic.skills.recording import read_recording, replay
from tests.toy import Toy


def recorded() -> dict[str, Any]:
    """A recording of the toy world, made by the toy world."""
    environment = Toy(fails_below=0.1)
    init = sample_tasks(environment, "train", 1, 0)[0].init

    def atoms(state: Any) -> list[list[str]]:
        return [[a.predicate.name, *(o.name for o in a.objects)] for a in abstract(environment, state)]

    def full(state: Any) -> dict[str, list[float]]:
        return {name: list(values) for name, values in state.features.items()}

    action = [0.0, 0.75]
    after = environment.simulate(init, np.array(action, np.float32))
    task = {
        "objects": {o.name: o.type.name for o in init.objects},
        "init": full(init),
        "goal": [["IsOpen", "door0"]],
        "init_atoms": atoms(init),
    }
    step = {"task": ["train", 0], "state": {}, "action": action}
    return {
        "environment": "toy",
        "types": {"hand": ["key", "step"], "door": ["open"]},
        "train_tasks": [task],
        "test_tasks": [],
        "demos": [
            {
                "task": 0,
                "states": [{}, full(after)],
                "actions": [action],
                "atoms": [atoms(init), atoms(after)],
            }
        ],
        "transitions": [
            {**step, "next_state": full(after), "next_atoms": atoms(after)},
            {**step, "action": [0.0, 0.05], "next_state": None, "next_atoms": None, "failure": "broke"},
        ],
    }


ENVIRONMENT = Toy(fails_below=0.1)


def test_a_true_recording_has_no_difference() -> None:
    result = replay(recorded(), ENVIRONMENT)
    assert result.examples == []
    assert result.compared == {
        "definition": 1,
        "task atoms": 1,
        "demonstration states": 2,
        "demonstration atoms": 2,
        "transition states": 1,
        "transition atoms": 1,
        "transition failures": 1,
    }


def change(path: list[Any], value: Any) -> dict[str, Any]:
    copied = copy.deepcopy(recorded())
    place = copied
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value
    return copied


@pytest.mark.parametrize(
    ("path", "value", "kind", "text"),
    [
        (["types", "door"], ["shut"], "definition", "types"),
        (
            ["train_tasks", 0, "init_atoms"],
            [["IsOpen", "door0"]],
            "task atoms",
            "IsOpen(door0) recorded only",
        ),
        (["demos", 0, "states", 1, "hand0", 0], 0.75 + 2e-9, "demonstration states", "hand0.key"),
        (["demos", 0, "atoms", 1], [], "demonstration atoms", "HasKey(hand0) here only"),
        (["transitions", 0, "next_state", "hand0"], [0.75, 2.0], "transition states", "hand0.step"),
        (["transitions", 0, "next_state", "hand0"], [float("nan"), 1.0], "transition states", "hand0.key"),
        (["transitions", 0, "next_atoms"], [], "transition atoms", "HasKey(hand0) here only"),
        (["transitions", 1, "action"], [0.0, 0.5], "transition failures", "failed when recorded only"),
        (["transitions", 0, "action"], [0.0, 0.05], "transition failures", "fails here only"),
    ],
)
def test_a_change_is_found(path: list[Any], value: Any, kind: str, text: str) -> None:
    result = replay(change(path, value), ENVIRONMENT)
    assert result.different[kind] == 1
    assert any(text in example for example in result.examples)


def test_rounding_below_the_tolerance_is_no_difference() -> None:
    close = change(["demos", 0, "states", 1, "hand0", 0], 0.75 + 5e-10)
    assert replay(close, ENVIRONMENT).examples == []


@pytest.mark.parametrize("path", [["train_tasks", 0, "init", "hand0"], ["transitions", 0, "state"]])
def test_broken_parts_are_one_message(path: list[Any]) -> None:
    with pytest.raises(InputError, match="broken recording"):
        replay(change(path, 7), ENVIRONMENT)


def test_files(tmp_path: Path) -> None:
    plain, packed = tmp_path / "r.json", tmp_path / "r.json.gz"
    plain.write_text(json.dumps(recorded()))
    packed.write_bytes(gzip.compress(plain.read_bytes()))
    assert read_recording(plain) == read_recording(packed) == recorded()
    whole = packed.read_bytes()
    packed.write_bytes(whole[:-20])
    damaged = tmp_path / "damaged.json.gz"
    damaged.write_bytes(whole[:30] + bytes(20) + whole[50:])
    for path in (packed, damaged, tmp_path / "missing.json", tmp_path):
        with pytest.raises(InputError, match="cannot read"):
            read_recording(path)
    plain.write_text("[1, 2]")
    with pytest.raises(InputError, match="not a recording"):
        read_recording(plain)
