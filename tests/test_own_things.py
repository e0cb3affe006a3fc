"""What users bring: goals, states, recordings, skills, environments in folders of their own."""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import bpns
from bpns.learning.data.demonstrations import Demonstrations

WORLD = bpns.load_environment("cover")
TASK = WORLD.task("test", 0)
Program = Callable[..., tuple[int, str, str]]


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory, demonstrations: Demonstrations) -> Path:
    """A saved model of Cover."""
    path = tmp_path_factory.mktemp("models") / "model"
    bpns.learn(WORLD, demonstrations, seed=0).save(path)
    return path


@pytest.mark.parametrize(
    "goal",
    [
        "Covers(block0, target1)",
        "Covers( block0 ,target1 ), HandEmpty()",
        "HandEmpty() and Covers(block0,target1)",
    ],
)
def test_goals_are_read(goal: str) -> None:
    atoms = {str(atom) for atom in WORLD.own_task(goal, TASK.init).goal}
    assert "Covers(block0, target1)" in atoms
    assert ("HandEmpty()" in atoms) == ("HandEmpty" in goal)


@pytest.mark.parametrize(
    ("goal", "message"),
    [
        ("", "the goal is empty"),
        ("Covers", "no atom at 'Covers'"),
        ("Covers(block0, target1) HandEmpty()", "no comma before 'HandEmpty"),
        ("Cover(block0, target1)", r"no predicate 'Cover' in 'cover': did you mean 'Covers'\?"),
        ("Covers(block9, target1)", r"no object 'block9': did you mean 'block\d'\?"),
        ("Covers(block0)", "Covers takes 2"),
        ("Covers(target0, block0)", "argument 1 is of type target, not block"),
    ],
)
def test_goals_that_are_none(goal: str, message: str) -> None:
    with pytest.raises(bpns.InputError, match=message):
        WORLD.own_task(goal, TASK.init)


def test_a_state_file_comes_back(tmp_path: Path, bpns_program: Program, folder: Path) -> None:
    path = tmp_path / "state.json"
    bpns.write_state(path, TASK.init)
    assert WORLD.own_task("HandEmpty()", path).init.features == TASK.init.features
    code, out, _ = bpns_program("plan", folder, "--goal", "Holding(block0, robby)", "--init", path)
    assert (code, "executed: yes" in out) == (0, True)
    code, _, err = bpns_program("plan", folder, "--init", path)
    assert (code, "--init goes with --goal" in err) == (2, True)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"type": "brick"}, r"block0: no type 'brick' in 'cover' \(have: block, "),
        ({"x": "left"}, "block0.x is 'left': give a finite number"),
        ({"x": float("nan")}, "block0.x is nan"),
        ({"color": 1.0}, "block0: a block has the features height, .*: unknown color"),
    ],
)
def test_states_that_are_none(tmp_path: Path, change: dict[str, object], message: str) -> None:
    path = tmp_path / "state.json"
    bpns.write_state(path, TASK.init)
    value = json.loads(path.read_text())
    value["block0"] |= change
    path.write_text(json.dumps(value))
    with pytest.raises(bpns.InputError, match=message):
        WORLD.own_task("HandEmpty()", path)


def test_a_model_comes_back_byte_for_byte(tmp_path: Path, folder: Path) -> None:
    bpns.load_model(folder).save(tmp_path / "again")
    for name in ("domain.pddl", "skills.json", "skills.safetensors", "run.json"):
        assert (tmp_path / "again" / name).read_bytes() == (folder / name).read_bytes()


def test_renaming_changes_names_alone(tmp_path: Path, folder: Path, bpns_program: Program) -> None:
    named = tmp_path / "named"
    assert (
        bpns_program("edit", folder, "--rename", "Op0=Pick", "--rename", "Op1=Place", "--out", named)[0] == 0
    )
    before, after = bpns.load_model(folder), bpns.load_model(named)
    assert bpns.diff(before, after).same
    plans = [model.plan(TASK, seed=1).plan for model in (before, after)]
    assert plans[0] is not None
    assert plans[1] is not None
    assert [str(step).replace("Op0", "Pick").replace("Op1", "Place") for step in plans[0].steps] == [
        str(step) for step in plans[1].steps
    ]
    for names, message in (
        ({"Op0": "Op1"}, "two operators"),
        ({"Nothing": "X"}, "no operator 'Nothing'"),
        ({"Op0": "a b"}, ""),
    ):
        with pytest.raises(bpns.InputError, match=message):
            before.renamed(names)


SKILLS = """
import bpns
PICK = bpns.oracle(bpns.load_environment("cover")).skills["Pick"]
NOTHING = 3
"""


def test_a_skill_of_ones_own_stands_beside_learned_ones(
    tmp_path: Path, folder: Path, bpns_program: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "skills_of_mine.py").write_text(SKILLS)
    monkeypatch.chdir(tmp_path)
    assert (
        bpns_program("edit", folder, "--remove", "Op0", "--add", "skills_of_mine:PICK", "--out", "mixed")[0]
        == 0
    )
    mixed = bpns.load_model("mixed")
    assert list(mixed.operators) == ["Op1", "Pick"]
    assert any(mixed.plan(WORLD.task("test", number), timeout=60).executed for number in range(3))
    assert "skills_of_mine:PICK, not learned" in (tmp_path / "mixed" / "domain.pddl").read_text()
    for name, message in (("skills_of_mine:NOTHING", "is no skill"), ("skills_of_mine", "MODULE:ATTRIBUTE")):
        with pytest.raises(bpns.InputError, match=message):
            mixed.with_skill(name)
    with pytest.raises(bpns.InputError, match="its policy is Python code"):
        mixed.with_skill(bpns.oracle(WORLD).skills["Place"]).save(tmp_path / "none")


def test_an_environment_is_found_from_any_folder(tmp_path: Path) -> None:
    home, elsewhere = tmp_path / "home", tmp_path / "elsewhere"
    home.mkdir()
    elsewhere.mkdir()

    def run(where: Path, *words: str | Path) -> str:
        command = [sys.executable, "-m", "bpns", *map(str, words)]
        return subprocess.run(command, cwd=where, check=True, capture_output=True, text=True).stdout

    run(home, "envs", "new", "far_away")
    run(home, "demos", "far_away:ENVIRONMENT", "--count", "20", "--out", "demos.h5")
    run(elsewhere, "learn", home / "demos.h5", "--out", "model")
    assert "executed: yes" in run(tmp_path, "plan", elsewhere / "model", "--task", "1")
    home.rename(tmp_path / "moved")  # both together: the way from one to the other is the same
    (tmp_path / "moved").rename(home)
    elsewhere.rename(home / "within")
    assert "executed: yes" in run(Path("/"), "plan", home / "within" / "model", "--task", "1")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"states": np.zeros((2, 3))}, r"recording 0: states \(2, 3\) and actions .* do not fit"),
        ({"objects": {"block0": "brick"}}, "recording 0: unknown type 'brick'"),
        ({"goal": "Covers(block0, nothing)"}, "recording 0: no object 'nothing'"),
        ({"skills": [None]}, "recording 0: 1 skills do not fit"),
    ],
)
def test_recordings_that_do_not_fit(
    demonstrations: Demonstrations, change: dict[str, object], message: str
) -> None:
    demo = demonstrations.demonstrations[0]
    objects = demo.task.init.objects
    recording = {
        "objects": {o.name: o.type.name for o in objects},
        "states": np.array([state.vector(objects) for state in demo.trajectory.states]),
        "actions": np.array(demo.trajectory.actions),
        "goal": "Covers(block0, target0)",
    }
    (found,) = bpns.demonstrations_from_arrays(WORLD, [recording]).demonstrations
    assert [s.features for s in found.trajectory.states] == [s.features for s in demo.trajectory.states]
    with pytest.raises(bpns.InputError, match=message):
        bpns.demonstrations_from_arrays(WORLD, [recording | change])


def test_values_print_short(folder: Path) -> None:
    model = bpns.load_model(folder)
    outcome = model.plan(TASK)
    assert outcome.plan is not None
    for value in (model, model.skills, outcome, outcome.plan, outcome.plan.steps, TASK, TASK.init, WORLD):
        assert len(repr(value)) < 400
    assert "<table>" in model.operators["Op0"]._repr_html_()


def test_a_planner_of_ones_own_and_comparison() -> None:
    model = bpns.oracle(WORLD)
    table = bpns.compare_planners(["astar", "pyperplan"], model, TASK)
    assert [row["planner"] for row in table] == ["astar", "pyperplan"]
    assert "pyperplan" in str(table)
    stream = bpns.abstract_plans(model, TASK)
    first, second = next(iter(stream)), next(iter(stream))  # it goes on where it stopped
    assert first != second
