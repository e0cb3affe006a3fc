"""The program as a user meets it: output, exit codes, one line for what is wrong."""

import json
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from PIL import Image

from bpns import envs
from bpns.learning.data.demonstrations import Demonstrations
from bpns.learning.data.files import write_demonstrations
from bpns.learning.models.learn import LearnedSkill
from bpns.learning.models.save import entry_of, write_model
from bpns.symbolic.state import Array, State
from tests.toy import Toy

Run = Callable[..., tuple[int, str, str]]
ROOT = Path(__file__).parents[2]
COMMANDS = (
    "demos",
    "learn",
    "operators",
    "export",
    "plan",
    "evaluate",
    "results",
    "replay",
    "planners",
    "envs",
)


class Faulty(Toy):
    def simulate(self, state: State, action: Array) -> State:
        raise KeyError("no such hinge")


def test_an_error_in_ones_own_code_is_one_line(bpns: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    code, _, err = bpns("evaluate", "--oracle", "tests.cli.test_cli:Faulty", "--tasks", 1)
    assert code == 70
    assert err.count("\n") == 1
    assert err.startswith("error: KeyError: 'no such hinge' ('bpns envs check NAME' says")
    monkeypatch.setenv("BPNS_TRACEBACK", "1")
    with pytest.raises(KeyError):
        bpns("evaluate", "--oracle", "tests.cli.test_cli:Faulty", "--tasks", 1)


def test_a_name_with_options_is_shown_as_it_was_given(bpns: Run) -> None:
    asked = "coffee:train_cups=1:test_cups=2"
    _, out, _ = bpns("evaluate", "--oracle", asked, "--tasks", 1)
    assert f"oracle:{asked}" in out
    _, out, _ = bpns("plan", "--oracle", asked, "--plans", 1)
    assert f"in {asked}" in out


@pytest.fixture
def model(learned: tuple[LearnedSkill, ...], tmp_path: Path) -> Path:
    skills = [(one.skill, entry_of(one.skill, one.segments, one.demonstrations, one.fits)) for one in learned]
    write_model(tmp_path / "model", envs.load("cover"), "cover", 0, skills, {}, "")
    return tmp_path / "model"


def imported_by(*words: str) -> tuple[str, set[str]]:
    """Run the program in a new interpreter; return its output and the modules that it imported."""
    code = (
        f"import sys, bpns.cli.main\nsys.argv = {['bpns', *words]!r}\n"
        "try: bpns.cli.main.main()\nexcept SystemExit: pass\nprint('\\nMODULES', *sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True)
    out, _, modules = done.stdout.rpartition("MODULES ")
    return out, set(modules.split())


def test_help_lists_every_command_without_slow_imports() -> None:
    out, modules = imported_by("--help")
    for command in COMMANDS:
        assert f"\n  {command} " in out
    assert not {"numpy", "torch", "h5py", "pydantic", "PIL", "rich", "lark"} & modules


def test_planning_does_not_import_torch(model: Path) -> None:
    out, modules = imported_by("plan", str(model), "--task", "0", "--preset", "paper")
    assert "planned:" in out
    assert "numpy" in modules
    assert not {"torch", "unified_planning", "pyperplan"} & modules


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help(bpns: Run, command: str) -> None:
    code, out, _ = bpns(command, "--help")
    assert code == 0
    assert "Usage: bpns" in out


def test_demos_says_what_it_gave(bpns: Run, tmp_path: Path) -> None:
    code, out, _ = bpns("demos", "cover", "--count", 3, "--workers", 1, "--out", tmp_path / "d.h5")
    assert code == 0
    assert out.startswith("3 demonstrations of 3 tasks")


def test_nothing_is_overwritten_unasked(bpns: Run, model: Path, tmp_path: Path) -> None:
    (tmp_path / "d.h5").write_text("mine")
    edited = (model / "domain.pddl").read_bytes() + b"; my note"
    (model / "domain.pddl").write_bytes(edited)
    bpns("export", model, "--out", tmp_path / "pddl", "--problems", 1)
    (tmp_path / "pddl/p01.pddl").write_text("mine")
    demos = tmp_path / "demos.h5"
    assert bpns("demos", "cover", "--count", 1, "--workers", 1, "--out", demos)[0] == 0
    for words in (
        ["demos", "cover", "--count", 1, "--out", tmp_path / "d.h5"],
        ["learn", demos, "--out", model],
        ["export", model, "--out", tmp_path / "pddl", "--problems", 1],
    ):
        code, _, err = bpns(*words)
        assert code == 36
        assert "exists: give --overwrite" in err
    assert (tmp_path / "d.h5").read_text() == (tmp_path / "pddl/p01.pddl").read_text() == "mine"
    assert (model / "domain.pddl").read_bytes() == edited
    assert bpns("demos", "cover", "--count", 1, "--out", tmp_path / "d.h5", "--overwrite")[0] == 0
    code, _, err = bpns("demos", "cover", "--out", tmp_path / "d.h5" / "below.h5")
    assert (code, err.count("is no folder")) == (36, 1)


def test_operators_as_in_the_paper(bpns: Run, model: Path) -> None:
    _, out, _ = bpns("operators", model)
    assert (
        "Op0:\n"
        "  Parameters: [?x0:block, ?x1:gripper]\n"
        "  Preconditions: [HandEmpty(), IsBlock(?x0:block)]\n"
        "  Add Effects: [Holding(?x0:block, ?x1:gripper)]\n"
        "  Delete Effects: [HandEmpty()]\n"
    ) in out
    _, out, _ = bpns("operators", model, "--json")
    assert [o["name"] for o in json.loads(out)] == ["Op0", "Op1"]


def test_export_and_plan_with_every_planner(bpns: Run, model: Path, tmp_path: Path) -> None:
    assert bpns("export", model, "--out", tmp_path / "out", "--problems", 3)[0] == 0
    names = sorted(path.name for path in (tmp_path / "out").iterdir())
    assert names == ["domain.pddl", "p01.pddl", "p02.pddl", "p03.pddl"]
    for planner in ("astar", "astar:hff", "pyperplan", "pyperplan:gbf:hff"):
        code, out, _ = bpns(
            "plan", tmp_path / "out/domain.pddl", "--problem", tmp_path / "out/p03.pddl", "--planner", planner
        )
        assert code == 0
        assert "; plan 1, 4 steps" in out
    _, out, _ = bpns("plan", model, "--problem", tmp_path / "out/p01.pddl", "--plans", 5, "--json")
    plans = json.loads(out)["plans"]
    assert plans[0] == ["(op0 block0 robby)", "(op1 block0 robby target0)"]
    assert len({tuple(plan) for plan in plans}) == 5


def test_plan_refines_executes_and_shows(bpns: Run, tmp_path: Path) -> None:
    code, out, _ = bpns("plan", "--oracle", "cover", "--task", 2, "--show", tmp_path / "plan.gif")
    assert code == 0
    for line in ("planned:  yes", "refined:  yes", "executed: yes"):
        assert line in out
    with Image.open(tmp_path / "plan.gif") as picture:
        assert picture.n_frames > 20  # type: ignore[attr-defined]
    code, out, _ = bpns("plan", "--oracle", "cover", "--task", 2, "--json")
    result = json.loads(out)
    assert result["executed"] is True
    assert len(result["plan"]) == 4


def test_plan_that_cannot_be_refined(bpns: Run, tmp_path: Path) -> None:
    """One sample a step and one plan: some task of the first twenty cannot be done like that."""
    for task in range(20):
        code, out, _ = bpns(
            "plan", "--oracle", "cover", "--task", task, "--plans", 1, "--samples", 1, "--preset", "paper"
        )
        if code:
            break
    assert code == 12
    assert "planned:  yes" in out
    assert "refined:  no" in out
    assert "  1 x plan 1, step" in out


UNSOLVABLE = """(define (problem p) (:domain cover)
  (:objects b - block r - gripper t - target) (:init (isblock b)) (:goal (and (covers b t))))"""


def test_no_plan(bpns: Run, tmp_path: Path) -> None:
    problem = tmp_path / "p.pddl"
    problem.write_text(UNSOLVABLE)
    code, out, err = bpns("plan", "pddl_out/cover/domain.pddl", "--problem", problem)
    assert (code, out) == (11, "")  # nothing that would be taken for a plan file
    assert "covers(b, t)" in err
    code, out, _ = bpns("plan", "pddl_out/cover/domain.pddl", "--problem", problem, "--json")
    assert code == 11
    assert json.loads(out)["plans"] == []


def test_an_environment_of_ones_own_goes_through_everything(bpns: Run, tmp_path: Path) -> None:
    demos, model = tmp_path / "toy.h5", tmp_path / "toy"
    assert bpns("demos", "tests.toy:Toy", "--count", 20, "--workers", 1, "--out", demos)[0] == 0
    assert bpns("learn", demos, "--out", model)[0] == 0
    assert "learned from 17 demonstrations, 17 segments" in (model / "domain.pddl").read_text()
    code, out, _ = bpns("plan", model)
    assert (code, "executed: yes" in out) == (0, True)
    assert bpns("plan", model, "--show", tmp_path / "toy.gif")[0] == 0
    assert bpns("export", model, "--out", tmp_path / "pddl", "--problems", 2)[0] == 0
    code, out, _ = bpns("plan", tmp_path / "pddl/domain.pddl", "--problem", tmp_path / "pddl/p01.pddl")
    assert out.endswith("(op0 hand0)\n(op1 door0 hand0)\n")
    assert bpns("evaluate", model, "--tasks", 2)[0] == 0
    assert "Op0" in bpns("operators", model)[1]


def test_models_of_one_name_are_kept_apart(bpns: Run, model: Path, tmp_path: Path) -> None:
    twin = tmp_path / "twin" / "model"
    shutil.copytree(model, twin)
    code, out, _ = bpns("evaluate", model, twin, "--tasks", 2, "--preset", "paper", "--json")
    assert code == 0
    assert [row["model"] for row in json.loads(out)["tasks"]] == [str(model)] * 2 + [str(twin)] * 2
    _, out, _ = bpns("evaluate", model, twin, "--tasks", 2, "--preset", "paper")
    assert "mean (std)" in out


def test_evaluate(bpns: Run, model: Path) -> None:
    code, out, _ = bpns("evaluate", "--oracle", "cover", "--tasks", 4, "--seeds", "0-1")
    assert code == 0
    assert "mean (std)" in out
    code, out, _ = bpns("evaluate", "--oracle", "cover", "--tasks", 4, "--seeds", "3", "--json")
    result = json.loads(out)
    assert [row["task"] for row in result["tasks"]] == [0, 1, 2, 3]
    assert result["summary"]["solved"]["mean"] == 25 * sum(row["executed"] for row in result["tasks"])


def test_envs_lists_and_checks(bpns: Run) -> None:
    code, out, _ = bpns("envs")
    assert code == 0
    assert "cover\n  types:      block(height, width" in out
    code, out, _ = bpns("envs", "check", "cover", "--tasks", 2)
    assert code == 0
    assert "ok       oracle plans: they solve 2 of 2 train tasks\n" in out
    assert out.endswith("cover: 12 ok, 0 fault, 0 warning, 0 skipped\n")


def test_envs_check_tells_everything_that_is_missing(bpns: Run) -> None:
    code, out, _ = bpns("envs", "check", "tests.toy:HAND")
    assert code == 1
    assert "FAULT    attributes: simulate is missing: symbolic/environment.py says what it is\n" in out
    assert "skipped  tasks: needs sample_task, types, classifiers, goal_predicates without fault\n" in out
    code, out, _ = bpns("envs", "check", "tests.toy:HAND", "--json")
    assert code == 1
    assert json.loads(out)["faults"] == out.count('"fault"')
    code, _, err = bpns("envs", "check", "nowhere")
    assert (code, err.count("\n")) == (36, 1)


def test_replay(bpns: Run, data: Path, tmp_path: Path) -> None:
    recording = data / "reference" / "cover.json.gz"
    code, out, _ = bpns("replay", recording)
    assert code == 0
    assert out.endswith("0 differences\n")
    code, out, _ = bpns("replay", recording, "--json")
    assert json.loads(out)["different"] == 0
    code, _, err = bpns("replay", data / "reference" / "coffee.json.gz", "--environment", "cover")
    assert (code, err.count("\n")) == (36, 1)
    assert "this recording is of 'coffee'" in err


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (["plan", "nowhere"], 36, "no model folder nowhere"),
        (["learn", "nowhere.h5", "--out", "x"], 36, "no such file"),
        (["learn", "README.md", "--out", "x"], 36, "not an HDF5 file"),
        (["replay", "nowhere.json"], 36, "cannot read nowhere.json"),
        (["demos", "nowhere"], 36, "unknown environment 'nowhere' (have: "),
        (["plan", "--oracle", "cover", "--planner", "nonsense"], 36, "unknown planner 'nonsense'"),
        (["plan", "--oracle", "cover", "--planner", "astar:best"], 36, "unknown heuristic 'astar:best'"),
        (["plan", "--oracle", "cover", "--show", "film.mp4"], 36, "use .gif, .webp or .png"),
        (["plan", "pddl_out/cover/domain.pddl", "--problem", "nowhere.pddl"], 36, "cannot read nowhere.pddl"),
        (["plan", "pddl_out/cover/p01.pddl", "--problem", "pddl_out/cover/p01.pddl"], 36, "p01.pddl:2:9:"),
        (["plan"], 2, "give a MODEL folder or --oracle"),
        (["plan", "--oracle", "cover", "--task", "-1"], 2, "--task"),
        (["evaluate", "--oracle", "cover", "--seeds", "a-b"], 2, "0-4 or 0,2,5-7"),
        (["dance"], 2, "No such command"),
    ],
)
def test_bad_input_is_one_line(
    bpns: Run, monkeypatch: pytest.MonkeyPatch, words: list[str], code: int, message: str
) -> None:
    monkeypatch.chdir(ROOT)
    found, out, err = bpns(*words)
    assert found == code
    assert message in err
    if code == 36:
        assert err.count("\n") == 1
        assert err.startswith("error: ")
        assert out == ""


@pytest.mark.parametrize(
    ("old", "new", "code", "place"),
    [
        ("(and", "(or", 37, "domain.pddl:19:19: unsupported PDDL: or"),
        ("(handempty)", "(handfull)", 36, "unknown predicate 'handfull'"),
    ],
)
def test_bad_pddl(bpns: Run, tmp_path: Path, old: str, new: str, code: int, place: str) -> None:
    text = (ROOT / "pddl_out/cover/domain.pddl").read_text()
    start = text.index("(:action op0")
    (tmp_path / "domain.pddl").write_text(text[:start] + text[start:].replace(old, new, 1))
    found, _, err = bpns("plan", tmp_path / "domain.pddl", "--problem", ROOT / "pddl_out/cover/p01.pddl")
    assert found == code
    assert place in err
    assert err.count("\n") == 1


def test_demonstrations_of_another_environment(
    bpns: Run,
    demonstrations: Demonstrations,
    tmp_path: Path,
) -> None:
    path = tmp_path / "demos.h5"
    write_demonstrations(path, demonstrations, envs.load("cover"))
    code, _, err = bpns("learn", path, "--environment", "tests.toy:Toy", "--out", tmp_path / "out")
    assert code == 36
    assert "demonstrations of 'cover', not of 'toy'" in err
    assert not (tmp_path / "out").exists()
