"""``bpns validate`` as a user meets it: table, JSON, exit codes."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

Run = Callable[..., tuple[int, str, str]]
COVER = Path(__file__).parents[2] / "pddl_out" / "cover"
FILES = (COVER / "domain.pddl", COVER / "p01.pddl")
OURS = ("--checker", "bpns", "--checker", "kairos")


def test_what_we_print_is_a_plan_file_and_valid(bpns: Run, tmp_path: Path) -> None:
    _, printed, _ = bpns("plan", FILES[0], "--problem", FILES[1], "--plans", 5)
    plans = tmp_path / "plans.txt"
    plans.write_text(printed)
    code, out, err = bpns("validate", *FILES, plans, *OURS)
    assert (code, err) == (0, "")
    assert "5 plans" in out
    assert out.splitlines()[-1] == "valid: bpns, kairos agree"


def test_all_that_is_installed_runs_by_default(bpns: Run, tmp_path: Path) -> None:
    plan = tmp_path / "plan"
    plan.write_text("(op1 block0 robby target0)\n")
    code, out, _ = bpns("validate", *FILES, plan, "--json")
    said = json.loads(out)
    assert code == 1
    assert said["outcome"] == "invalid"
    assert said["disagreements"] == []
    by_name = {checker["checker"]: checker for checker in said["checkers"]}
    assert list(by_name) == ["bpns", "kairos", "unified_planning", "val"]
    for name in ("bpns", "kairos", "unified_planning"):
        assert [v["level"] for v in by_name[name]["verdicts"]] == ["ok", "ok", "fault"]
        assert "holding" in by_name[name]["verdicts"][2]["text"].lower()


def test_disagreement_is_said(bpns: Run, data: Path) -> None:
    folder = data / "pddl-cases" / "i28-dup-type"
    code, out, _ = bpns("validate", folder / "domain.pddl", folder / "problem.pddl", *OURS)
    assert code == 1
    assert out.splitlines()[-2:] == ["DISAGREE on domain: valid says kairos; invalid says bpns", "INVALID"]
    assert f"bpns: fault: {folder / 'domain.pddl'}:3:" in out


def test_a_domain_alone(bpns: Run) -> None:
    code, out, _ = bpns("validate", FILES[0], *OURS)
    assert (code, out.splitlines()[-1]) == (0, "valid: bpns, kairos agree")


def test_unsupported_is_no_fault(bpns: Run, data: Path) -> None:
    folder = data / "pddl-cases" / "v13-cond-effect"
    files = (folder / "domain.pddl", folder / "problem.pddl")
    code, out, _ = bpns("validate", *files, "--checker", "bpns")
    assert code == 37
    assert "unsupported PDDL: when" in out
    assert bpns("validate", *files, *OURS)[0] == 0


@pytest.mark.parametrize("text", ["(op0 block0 robby\n", "stopped by the time limit\n"])
def test_a_plan_that_cannot_be_read_is_a_finding(bpns: Run, tmp_path: Path, text: str) -> None:
    plan = tmp_path / "plan"
    plan.write_text(text)
    code, out, _ = bpns("validate", *FILES, plan, *OURS)
    assert code == 1
    assert f"bpns: fault: {plan}:1:1: expected one step such as" in out


def test_files_that_cannot_be_read_are_bad_input(bpns: Run, tmp_path: Path) -> None:
    binary = tmp_path / "binary"
    binary.write_bytes(b"\xff\xfe\x00")
    for files in ((tmp_path / "missing",), (tmp_path,), (binary,), (*FILES, tmp_path / "missing")):
        code, out, err = bpns("validate", *files)
        assert (code, out, err.count("\n")) == (36, "", 1)


@pytest.mark.parametrize(
    "words", [(), ("--timeout", "0", "d"), ("--timeout", "nan", "d"), ("--checker", "x", "d")]
)
def test_wrong_usage(bpns: Run, words: tuple[str, ...]) -> None:
    assert bpns("validate", *words)[0] == 2
