"""``bpns diff``: exit codes as of diff, text and JSON."""

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

Run = Callable[..., tuple[int, str, str]]
ROOT = Path(__file__).parents[2]
COVER = ROOT / "pddl_out" / "cover"


@pytest.fixture
def oracle(bpns: Run, tmp_path: Path) -> Path:
    assert bpns("export", "--oracle", "stick_button", "--problems", 0, "--out", tmp_path / "oracle")[0] == 0
    return tmp_path / "oracle"


def test_learned_and_written_operators_of_cover_are_the_same(bpns: Run, tmp_path: Path) -> None:
    bpns("export", "--oracle", "cover", "--problems", 0, "--out", tmp_path)
    code, out, err = bpns("diff", COVER / "domain.pddl", tmp_path)
    assert (code, err) == (0, "")
    assert out == (
        "same      op0 -> pick (?x0 -> ?block, ?x1 -> ?gripper)\n"
        "same      op1 -> place (?x0 -> ?block, ?x1 -> ?gripper, ?x2 -> ?target)\n"
        "operators: 2 same, 0 changed, 0 removed, 0 added\n"
    )


def test_what_learning_did_otherwise_in_stick_button(bpns: Run, oracle: Path) -> None:
    code, out, _ = bpns("diff", ROOT / "pddl_out/stick_button", oracle)
    assert code == 1
    assert (
        "changed   op1 -> pickstickfrombutton (?x0 -> ?from, ?x1 -> ?robot, ?x2 -> ?stick)\n"
        "            precondition   - pressed(?x0)\n"
    ) in out
    assert (
        "same      op2 -> stickpressbuttonfromnothing (?x0 -> ?button, ?x1 -> ?stick, ?x2 -> ?robot)" in out
    )
    assert out.endswith("operators: 3 same, 3 changed, 0 removed, 0 added\n")
    code, out, _ = bpns("diff", ROOT / "pddl_out/stick_button", oracle, "--json")
    found = json.loads(out)
    assert (code, found["same"], len(found["operators"]["same"])) == (1, False, 3)
    (change,) = (c for c in found["operators"]["changed"] if c["before"] == "op4")
    assert change["after"] == "stickpressbuttonfrombutton"
    assert change["parameters"] == [
        ["?x0", "?from"],
        ["?x1", "?button"],
        ["?x2", "?stick"],
        ["?x3", "?robot"],
    ]
    assert change["changed_parameters"] == {"removed": [], "added": [], "retyped": []}
    assert change["changed_atoms"] == {"preconditions": {"removed": [["pressed", "?x0"]], "added": []}}


def test_a_parameter_that_is_only_in_one(bpns: Run, oracle: Path, tmp_path: Path) -> None:
    """Without the hand, as the paper learns it, pressing with the stick lacks a parameter and a condition."""
    text = (ROOT / "pddl_out/stick_button/domain.pddl").read_text()
    text = text.replace("(?x0 - button ?x1 - stick ?x2 - gripper)", "(?x0 - button ?x1 - stick)", 1)
    text = text.replace("(grasped ?x2 ?x1)", "", 1)
    (tmp_path / "domain.pddl").write_text(text)
    code, out, _ = bpns("diff", tmp_path / "domain.pddl", oracle)
    assert code == 1
    assert (
        "changed   op2 -> stickpressbuttonfromnothing (?x0 -> ?button, ?x1 -> ?stick)\n"
        "            parameter      + ?robot - gripper\n"
        "            precondition   + grasped(?robot, ?stick)\n"
    ) in out
    _, out, _ = bpns("diff", tmp_path / "domain.pddl", oracle, "--json")
    (change,) = (c for c in json.loads(out)["operators"]["changed"] if c["before"] == "op2")
    assert change["changed_parameters"] == {"removed": [], "added": [["?robot", "gripper"]], "retyped": []}
    assert change["changed_atoms"] == {
        "preconditions": {"removed": [], "added": [["grasped", "?robot", "?stick"]]}
    }


def test_the_hash_seed_changes_nothing(oracle: Path) -> None:
    def printed(seed: str) -> str:
        words = [sys.executable, "-m", "bpns", "diff", "pddl_out/coffee", str(oracle)]
        environment = os.environ | {"PYTHONHASHSEED": seed}
        return subprocess.run(words, capture_output=True, text=True, cwd=ROOT, env=environment).stdout

    assert printed("1") == printed("2") != ""


def test_files_that_cannot_be_read(bpns: Run, tmp_path: Path) -> None:
    for words, message in (
        ((COVER, tmp_path), "cannot read"),
        ((COVER, tmp_path / "nowhere.pddl"), "cannot read"),
        ((COVER / "p01.pddl", COVER), "p01.pddl:2:9:"),
    ):
        code, out, err = bpns("diff", *words)
        assert (code, out, err.count("\n")) == (36, "", 1)
        assert message in err
    assert bpns("diff", COVER)[0] == 2
    shutil.copytree(COVER, tmp_path / "copy")
    assert bpns("diff", COVER, tmp_path / "copy")[0] == 0
