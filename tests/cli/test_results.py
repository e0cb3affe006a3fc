"""bpns evaluate --out and bpns results: resumed, killed, several at once."""

import json
import os
import signal
import sqlite3
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from bpns import envs
from bpns.learning.experiments.evaluation import Result
from bpns.learning.experiments.results import Run, add_result, open_results
from bpns.learning.models.learn import LearnedSkill
from bpns.learning.models.origin import Origin
from bpns.learning.models.save import entry_of, write_model

Program = Callable[..., tuple[int, str, str]]
ROOT = Path(__file__).parents[2]
TIMES = ("planning_seconds", "policy_seconds")
KEY = ("environment", "model", "preset", "seed", "task")


def rows(path: Path) -> list[dict[str, Any]]:
    """Return all rows without their times, in the order of their keys."""
    with closing(sqlite3.connect(path)) as store:
        store.row_factory = sqlite3.Row
        found = [dict(row) for row in store.execute(f"SELECT * FROM results ORDER BY {', '.join(KEY)}")]
    return [{name: value for name, value in row.items() if name not in TIMES} for row in found]


def start(*words: str | int | Path) -> subprocess.Popen[str]:
    program = [sys.executable, "-m", "bpns", "evaluate", *map(str, words)]
    return subprocess.Popen(program, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=ROOT)


def count(path: Path) -> int:
    """Return the number of rows; open to write, which mends what a killed process left in the middle."""
    try:
        with closing(sqlite3.connect(f"{path.as_uri()}?mode=rw", uri=True)) as store:
            found: int = store.execute("SELECT count(*) FROM results").fetchone()[0]
            return found
    except sqlite3.OperationalError:  # no file yet, or no table
        return 0


def test_what_is_there_is_not_run_again(bpns: Program, tmp_path: Path) -> None:
    out = tmp_path / "results.sqlite"
    words = ("evaluate", "--oracle", "cover", "--out", out, "--seeds")
    code, text, _ = bpns(*words, "0-1", "--tasks", 3)
    assert (code, f"0 of 6 tasks were in {out} already\n" in text) == (0, True)
    before = out.read_bytes()
    _, text, err = bpns(*words, "0-1", "--tasks", 3, "--json")
    again = json.loads(text)
    assert (again["found"], len(again["tasks"]), err, out.read_bytes()) == (6, 6, "", before)
    _, text, _ = bpns(*words, "1-2", "--tasks", 4)
    assert f"3 of 8 tasks were in {out} already\n" in text
    assert len(rows(out)) == 11  # seed 0: 3, seed 1: 4, seed 2: 4
    code, text, _ = bpns("evaluate", "--oracle", "cover", "--seeds", "1-2", "--tasks", 4, "--json")
    assert "found" not in json.loads(text)
    stored = [row for row in rows(out) if row["seed"] > 0]
    for new, old in zip(json.loads(text)["tasks"], stored, strict=True):
        for name in ("seed", "task", "executed", "nodes_created", "abstract_plans", "samples", "plan_length"):
            assert new[name] == old[name]


@pytest.mark.parametrize("workers", [1, 2])
def test_killed_and_started_again(
    bpns: Program, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, workers: int
) -> None:
    """No row is lost, none there twice, and no worker stays behind."""
    gate = tmp_path / "gate"  # without it, no process gets beyond 60 steps
    monkeypatch.setenv("BPNS_TEST_GATE", str(gate))
    words = ("--oracle", "tests.gated:Gated", "--seeds", "0-1", "--tasks", 60, "--out")
    killed, whole = tmp_path / "killed.sqlite", tmp_path / "whole.sqlite"
    process = start(*words, killed, "--workers", workers)
    deadline = time.monotonic() + 60
    while count(killed) < 2 and time.monotonic() < deadline:
        time.sleep(0.01)
    os.kill(process.pid, signal.SIGKILL)
    gate.touch()
    process.communicate(timeout=20)  # ends when all that write to it have ended: workers too
    assert process.returncode == -signal.SIGKILL
    kept = count(killed)
    assert 2 <= kept < 120
    _, text, _ = bpns("evaluate", *words, killed)
    assert f"{kept} of 120 tasks were in {killed} already\n" in text
    assert bpns("evaluate", *words, whole)[0] == 0
    assert rows(killed) == rows(whole)
    assert len(rows(killed)) == 120


def test_several_at_once_on_one_file(bpns: Program, tmp_path: Path) -> None:
    """Two with the same tasks and one with others; the file is new to all three."""
    out, alone = tmp_path / "results.sqlite", tmp_path / "alone.sqlite"
    words = ("--oracle", "cover", "--tasks", 15, "--seeds")
    processes = [start(*words, seeds, "--out", out) for seeds in ("0-1", "0-1", "2-3")]
    texts = [process.communicate(timeout=60)[0] for process in processes]
    assert [process.returncode for process in processes] == [0, 0, 0], texts
    assert bpns("evaluate", *words, "0-3", "--out", alone)[0] == 0
    assert rows(out) == rows(alone)
    assert len(rows(out)) == 60


@pytest.mark.parametrize("kind", ["text", "database", "version", "folder"])
@pytest.mark.parametrize("command", ["evaluate", "results"])
def test_a_file_that_is_no_such_file(bpns: Program, tmp_path: Path, kind: str, command: str) -> None:
    path = tmp_path / "results.sqlite"
    if kind == "text":
        path.write_text("my results\n")
    elif kind == "folder":
        path.mkdir()
    else:
        sql = "CREATE TABLE results (mine)"
        if kind == "version":
            with open_results(path, create=True):
                sql = "PRAGMA user_version = 99"
        with closing(sqlite3.connect(path)) as store:
            store.execute(sql)
    before = path.read_bytes() if path.is_file() else None
    words = (
        ("evaluate", "--oracle", "cover", "--tasks", 1, "--out") if command == "evaluate" else ("results",)
    )
    code, out, err = bpns(*words, path)
    assert (code, out, err.count("\n"), err.startswith("error: ")) == (36, "", 1, True)
    assert (path.read_bytes() if path.is_file() else None) == before
    assert [p.name for p in tmp_path.iterdir()] == ["results.sqlite"]


def test_wrong_usage_makes_no_file(bpns: Program, tmp_path: Path) -> None:
    code, _, _ = bpns("evaluate", "--oracle", "cover", "--samples", 0, "--out", tmp_path / "new.sqlite")
    assert code == 2
    code, _, err = bpns("results", tmp_path / "new.sqlite")
    assert (code, err.count("\n"), "make them with 'bpns evaluate --out'" in err) == (36, 1, True)
    assert not list(tmp_path.iterdir())


@pytest.fixture
def stored(tmp_path: Path) -> Path:
    """Two models of 50 and two of 1000 demonstrations, two tasks each, and the oracle in a variant."""
    path = tmp_path / "results.sqlite"
    with open_results(path, create=True) as store:
        for asked, outcomes in ((50, (False, True, True, True)), (1000, (True,) * 4)):
            for number, executed in enumerate(outcomes):
                seed, task = divmod(number, 2)
                origin = Origin("bpns", f"{asked}-{seed}", "default", 0.01, asked, seed, 4.0)
                run = Run(
                    *("cover", origin, "default", "adaptive", "astar", None),
                    *(None, None, 20_000, 500_000, None, "0.1.0"),
                )
                result = Result(
                    seed, task, True, True, executed, "", (), 10 + 2 * seed, 5, 1, 4, 2, 1.0 + seed, 0.5
                )
                add_result(store, run, result)
    return path


def test_tables(bpns: Program, stored: Path) -> None:
    assert bpns("evaluate", "--oracle", "doors:rows=3:columns=3", "--tasks", 1, "--out", stored)[0] == 0
    code, out, _ = bpns("results", stored)
    assert code == 0
    lines = [line.split() for line in out.splitlines()]
    solved_and_nodes = ["100.0", "(0.0)", "75.0", "(25.0)", "11.00", "(1.00)"]
    assert ["BPNS", "50", "2", "2", "100.0", "(0.0)", *solved_and_nodes] == lines[4][:12]
    assert lines[4][-2:] == ["2.0000", "(0.5000)"]  # 1.5 and 2.5
    assert lines[5][:10] == ["BPNS", "1000", "2", "2", "100.0", "(0.0)", "100.0", "(0.0)", "100.0", "(0.0)"]
    assert ["doors:rows=3:columns=3"] in lines
    _, out, _ = bpns("results", stored, "--json", "--environment", "cover")
    found = json.loads(out)
    assert [(row["title"], row["demonstrations"]) for row in found] == [("BPNS", 50), ("BPNS", 1000)]
    assert found[0]["summary"]["solved"] == {"mean": 75.0, "std": 25.0}
    assert found[0]["runs"][1] == {"seed": 1, "learning_seed": 1, "model": "50-1", "tasks": 2}
    code, _, err = bpns("results", stored, "--environment", "stick")
    assert (code, "has no results of 'stick' (have: cover, doors:rows=3:columns=3)" in err) == (36, True)


def test_plot(bpns: Program, stored: Path, tmp_path: Path) -> None:
    picture = tmp_path / "plot.png"
    assert bpns("results", stored, "--plot", picture)[0] == 0
    with Image.open(picture) as image:
        assert image.size == (750, 750)
    before = picture.read_bytes()
    assert bpns("results", stored, "--plot", picture)[0] == 36  # it exists
    assert bpns("results", stored, "--plot", picture, "--overwrite")[0] == 0
    assert picture.read_bytes() == before
    assert bpns("results", stored, "--plot", tmp_path / "plot.mp4")[0] == 36
    bpns("evaluate", "--oracle", "cover", "--tasks", 1, "--out", tmp_path / "oracle.sqlite")
    code, _, err = bpns("results", tmp_path / "oracle.sqlite", "--plot", tmp_path / "none.png")
    assert (code, err.count("\n"), (tmp_path / "none.png").exists()) == (36, 1, False)


def test_an_edited_model_is_another_run(
    bpns: Program, learned: tuple[LearnedSkill, ...], tmp_path: Path
) -> None:
    model, out = tmp_path / "model", tmp_path / "results.sqlite"
    skills = [(one.skill, entry_of(one.skill, one.segments, one.demonstrations, one.fits)) for one in learned]
    write_model(model, envs.load("cover"), "cover", 0, skills, {"demonstrations": {"asked": 40}}, "")
    words = ("evaluate", model, "--tasks", 2, "--preset", "paper", "--plans", 1, "--samples", 2, "--out", out)
    assert bpns(*words)[0] == 0
    assert "2 of 2 tasks" in bpns(*words)[1]
    with (model / "domain.pddl").open("a") as file:
        file.write("; edited\n")
    assert "0 of 2 tasks" in bpns(*words)[1]
    _, text, _ = bpns("results", out)
    assert "Abstract Plans=1, paper's search: 2 models of learning seed 0 in one mean: " in text
    assert [row["demonstrations"] for row in rows(out)] == [40] * 4
