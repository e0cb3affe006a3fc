"""Recorded tasks, demonstrations and transitions of the four environments, against our simulators."""

from pathlib import Path
from typing import Any

import pytest

from bpns import envs
from bpns.symbolic.skills.environment import sample_tasks
from bpns.symbolic.skills.recording import read_recording, replay


def recording(data: Path, name: str) -> Any:
    return read_recording(data / "reference" / f"{name}.json.gz")


@pytest.mark.parametrize("name", envs.names())
def test_recording_is_reproduced(name: str, data: Path) -> None:
    recorded = recording(data, name)
    result = replay(recorded, envs.load(name))
    assert result.examples == []
    failed = sum(t["next_state"] is None for t in recorded["transitions"])
    assert result.compared["transition failures"] == failed
    assert result.compared["transition states"] == len(recorded["transitions"]) - failed


@pytest.mark.parametrize("split", ["train", "test"])
@pytest.mark.parametrize("name", ["coffee", "cover", "stick_button"])  # doors: see test_doors.py
def test_tasks_are_those_recorded_with_seed_0(name: str, split: Any, data: Path) -> None:
    tasks = sample_tasks(envs.load(name), split, 20, 0)
    for task, recorded in zip(tasks, recording(data, name)[f"{split}_tasks"], strict=True):
        assert {n: list(v) for n, v in task.init.features.items()} == recorded["init"]
        goal = {(a.predicate.name, *(o.name for o in a.objects)) for a in task.goal}
        assert goal == set(map(tuple, recorded["goal"]))
