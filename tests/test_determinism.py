"""The same command and seed give the same bytes, whatever PYTHONHASHSEED and the number of workers."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
TIMES = re.compile(r" +\d+\.\d{4}( \(\d+\.\d{4}\))?( *)$", re.MULTILINE)  # the last column


def run_all(folder: Path, environment_name: str, hash_seed: str, workers: int) -> dict[str, bytes]:
    """Demonstrate, learn, evaluate and export; return what that wrote, times aside."""

    def bpns(*words: object) -> str:
        command = [sys.executable, "-m", "bpns", *map(str, words)]
        environment = {**os.environ, "PYTHONHASHSEED": hash_seed, "PYTHONPATH": str(ROOT)}
        done = subprocess.run(
            command, capture_output=True, text=True, cwd=folder, env=environment, check=True
        )
        return done.stdout

    folder.mkdir()
    bpns("demos", environment_name, "--count", 30, "--seed", 3, "--workers", workers, "--out", "demos.h5")
    bpns("learn", "demos.h5", "--out", "model", "--workers", workers)
    table = bpns("evaluate", "model", "--tasks", 6, "--workers", workers)
    bpns("export", "model", "--out", "pddl", "--problems", 2)
    plans = bpns(
        "plan", "model", "--problem", "pddl/p01.pddl", "--plans", 20, "--planner", "pyperplan"
    ) + bpns("plan", "model", "--problem", "pddl/p02.pddl", "--plans", 20)
    files = {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}
    del files["model/run.json"]  # command, versions and times
    return files | {"table": TIMES.sub("", table).encode(), "plans": plans.encode()}


@pytest.mark.slow
@pytest.mark.parametrize("environment", ["cover", "doors"])
def test_hash_seed_and_workers_change_nothing(environment: str, tmp_path: Path) -> None:
    first = run_all(tmp_path / "first", environment, "0", 1)
    second = run_all(tmp_path / "second", environment, "1", 2)
    assert sorted(first) == sorted(second)
    for name, data in first.items():
        assert data == second[name], name
