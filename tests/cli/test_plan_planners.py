"""``bpns plan`` with planners that are programs: what is printed, and exit codes."""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.symbolic._foreign import MARK, gone, script

Run = Callable[..., tuple[int, str, str]]
COVER = Path(__file__).parents[2] / "pddl_out/cover"
PROBLEM = ("plan", COVER / "domain.pddl", "--problem", COVER / "p02.pddl")
TASK = ("plan", "--oracle", "cover", "--task", 2)

FAULTS = [
    ("sleep MARK", 12, "time limit", ""),
    ("kill -SEGV $$", 32, "planner.sh: killed by signal 11: it printed nothing", ""),
    ("echo oh no; exit 33", 32, "planner.sh: exit code 33 (it does not support the task): oh no", ""),
    ("yes", 12, "time limit", ""),
    ("echo '(op0 block0' > plan", 32, "planner.sh wrote no plan: plan:1:1: expected one step", ""),
    (
        "yes '(op0 block0 robby)' | head -c 20000000 > plan",
        32,
        "plan has more than 10 MB: that is no plan",
        "",
    ),
    ("exit 11", 11, "no plan exists", ""),
    ("exit 12", 0, "", "command found no plan, without a proof that there are no others: astar goes on"),
]


@pytest.mark.parametrize(("text", "code", "said", "remark"), FAULTS)
@pytest.mark.parametrize("words", [PROBLEM, TASK], ids=["problem", "task"])
def test_planner_that_fails(
    bpns: Run, tmp_path: Path, words: tuple[str, ...], text: str, code: int, said: str, remark: str
) -> None:
    found, out, err = bpns(
        *words, "--planner", script(tmp_path, text), "--timeout", 0.5 if code == 12 else 30
    )
    assert found == code
    told = err if words is PROBLEM and code else out  # where there is no plan, nothing goes into a plan file
    assert not (out if told is err else err)
    assert not said or told.count(said) == 1
    assert remark in told
    assert gone(MARK, 2)


def test_json_says_the_same(bpns: Run, tmp_path: Path) -> None:
    words = ("--json", "--planner", script(tmp_path, "echo oh no; exit 33"))
    code, out, _ = bpns(*PROBLEM, *words)
    assert code == 32
    assert json.loads(out)["plans"] == []
    assert "exit code 33" in json.loads(out)["ended"]
    code, out, _ = bpns(*TASK, *words)
    assert code == 32
    assert "exit code 33" in json.loads(out)["fault"]


def test_plan_of_a_program_is_refined_and_others_follow(bpns: Run, tmp_path: Path) -> None:
    """The program here is bpns itself."""
    own = script(tmp_path, f"exec {sys.executable} -m bpns plan $domain --problem $problem > plan")
    code, out, _ = bpns(*TASK, "--planner", own)
    assert code == 0
    assert "executed: yes" in out


@pytest.mark.parametrize("planner", ["command:", "command:no-such {domain} {problem}", "command:sh {domain}"])
def test_command_that_is_none_is_bad_input(bpns: Run, planner: str) -> None:
    code, out, err = bpns(*PROBLEM, "--planner", planner)
    assert (code, out) == (36, "")
    assert err.startswith("error: planner 'command:")
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    "planner", ["pyperplan", *(pytest.param(name, marks=pytest.mark.slow) for name in ("kairos", "kstar"))]
)
def test_output_does_not_depend_on_the_hash_seed(planner: str) -> None:
    pytest.importorskip({"kstar": "kstar_planner"}.get(planner, planner))
    outputs = {
        subprocess.run(
            [
                sys.executable,
                "-c",
                "from bpns.cli.main import main; main()",
                *map(str, PROBLEM),
                "--planner",
                planner,
                "--plans",
                "25",
            ],
            env={"PATH": "/usr/bin:/bin", "PYTHONHASHSEED": seed},
            capture_output=True,
            check=True,
        ).stdout
        for seed in ("0", "1")
    }
    assert len(outputs) == 1
    assert outputs.pop().count(b"; plan ") == 25


@pytest.mark.slow
def test_workers_of_evaluate_have_planners_of_their_own(bpns: Run) -> None:
    pytest.importorskip("pyperplan")
    results = []
    for workers in (1, 2):
        words = ("evaluate", "--oracle", "cover", "--tasks", 4, "--planner", "pyperplan", "--json")
        code, out, _ = bpns(*words, "--workers", workers)
        assert code == 0
        results.append(json.loads(out))
    assert str(results[0]).count("True") == str(results[1]).count("True")
