"""Approaches from the command line: learn, list, plan, evaluate."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from bpns import envs
from bpns.learning import approaches
from bpns.learning.data.demonstrations import Demonstrations
from bpns.learning.data.files import write_demonstrations
from bpns.learning.graphs.training import GraphTraining
from bpns.learning.models.settings import SkillConfig
from bpns.learning.networks.settings import Training

Run = Callable[..., tuple[int, str, str]]
SHORT = Training(100)


@pytest.fixture
def demos(demonstrations: Demonstrations, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A file of Cover's demonstrations; learning is short."""
    config = SkillConfig(policy=SHORT, generator=SHORT, discriminator=SHORT)
    monkeypatch.setattr("bpns.learning.models.learn.SkillConfig", lambda: config)
    monkeypatch.setattr(GraphTraining, "fast", classmethod(lambda cls: cls(epochs=5, check_every=5)))
    write_demonstrations(tmp_path / "demos.h5", demonstrations, envs.load("cover"))
    return tmp_path / "demos.h5"


@pytest.mark.parametrize(
    "approach", ["no-subgoal", "gnn-meta", "gnn-meta-no-subgoal", "gnn_bc", "pass-through"]
)
def test_every_approach_learns_plans_and_is_evaluated(
    bpns: Run, demos: Path, tmp_path: Path, approach: str
) -> None:
    code, out, err = bpns("learn", demos, "--approach", approach, "--out", tmp_path / "model")
    assert (code, err) == (0, "")
    assert ("graph network" in out) == approach.startswith("gnn")
    said = json.loads((tmp_path / "model" / "skills.json").read_text())
    assert said["approach"] == approach.replace("-", "_")
    code, out, err = bpns("plan", tmp_path / "model", "--task", "1", "--timeout", "2", "--json")
    assert code in (0, 12)
    found = json.loads(out)
    assert found["executed"] == (code == 0)
    assert (found["planned"] is None) == approach.startswith("gnn")
    results, limits = tmp_path / "results.sqlite", ("--tasks", "2", "--timeout", "1")
    code, out, err = bpns("evaluate", tmp_path / "model", *limits, "--out", results, "--json")
    assert (code, err) == (0, "")
    tasks = json.loads(out)["tasks"]
    assert len(tasks) == 2
    code, out, err = bpns("evaluate", tmp_path / "model", *limits, "--out", results, "--json")
    assert json.loads(out)["tasks"] == tasks
    code, out, err = bpns("results", results)
    assert (code, err) == (0, "")
    assert approaches.load(approach).title in out


def test_a_model_without_a_planner_shows_what_it_does(bpns: Run, demos: Path, tmp_path: Path) -> None:
    model, picture = tmp_path / "model", tmp_path / "acts.gif"
    bpns("learn", demos, "--approach", "gnn-bc", "--out", model)
    code, out, _ = bpns("plan", model, "--show", picture)
    assert code in (0, 12)
    assert "planned:  - (a graph network acts" in out
    assert picture.stat().st_size > 1000
    for option in (("--planner", "kairos"), ("--compare", "astar"), ("--plans", "2"), ("--no-loops",)):
        code, _, err = bpns("plan", model, *option)
        assert code == 2
        assert "acts without a planner" in err


def test_the_list_names_all(bpns: Run) -> None:
    code, out, _ = bpns("approaches")
    assert code == 0
    for title in ("BPNS", "GNN Meta No Subgoal", "Oracle", "Samples=1", "Abstract Plans=1", "No filter"):
        assert title in out


def test_wrong_approaches_are_one_line(bpns: Run, demos: Path, tmp_path: Path) -> None:
    words = ("learn", demos, "--approach", "gnn-bc", "--min-share", 0, "--out", tmp_path / "model")
    code, _, err = bpns(*words)
    assert (code, "'gnn-bc' learns no operators: leave --min-share out" in err) == (2, True)
    code, _, err = bpns("learn", demos, "--approach", "gnn", "--out", tmp_path / "model")
    assert code == 36
    assert "unknown approach 'gnn'" in err
    code, _, err = bpns("learn", demos, "--approach", "oracle", "--out", tmp_path / "model")
    assert code == 2
    assert "learns nothing" in err
    code, _, err = bpns("learn", demos, "--device", "toaster", "--out", tmp_path / "model")
    assert code == 36
    assert "no device 'toaster'" in err
    assert not (tmp_path / "model").exists()


def test_without_the_filter_every_operator_stays(bpns: Run, demos: Path, tmp_path: Path) -> None:
    code, _, err = bpns("learn", demos, "--min-share", "0.9", "--out", tmp_path / "none")
    assert code == 36
    assert "no operator has 90% of the" in err
    assert not (tmp_path / "none").exists()
    code, _, _ = bpns("learn", demos, "--approach", "pass-through", "--out", tmp_path / "some")
    assert code == 0
    code, _, _ = bpns("learn", demos, "--min-share", "0", "--out", tmp_path / "all")
    assert code == 0
    settings = json.loads((tmp_path / "all" / "run.json").read_text())["settings"]
    assert settings["min_share"] == 0
