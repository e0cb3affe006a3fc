"""Programs end with the process that runs them, however that ends."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.symbolic._foreign import MARK, gone, script, there

ROOT = Path(__file__).parents[2]

CALLER = """
import sys
import numpy as np
from bpns.symbolic.planners import load
from bpns.symbolic.planners.protocol import SearchRecord
from tests.symbolic._foreign import seconds, walk
record = SearchRecord()
stream = load(sys.argv[1]).plans(walk(), np.random.default_rng(0), seconds(60), record)
print(next(stream), flush=True)
next(stream)
"""


def caller(command: str) -> "subprocess.Popen[str]":
    """Start a process that takes a plan and then waits for the next one."""
    process = subprocess.Popen(
        [sys.executable, "-c", CALLER, command],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "walk(a, b), walk(b, c)\n"
    return process


@pytest.mark.parametrize(
    "how", [signal.SIGKILL, signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.slow)]
)
def test_program_ends_with_its_caller(tmp_path: Path, how: signal.Signals) -> None:
    plans = "printf '(walk a b)\\n(walk b c)\\n' > plan.1; : > plan.2"
    sleeps = "trap '' TERM INT HUP; timeout 99 sleep MARK & sleep MARK; sleep MARK"
    process = caller(script(tmp_path, f"{plans}; {sleeps}"))
    assert there(MARK)
    process.send_signal(how)
    _, said = process.communicate(timeout=60)
    assert process.returncode == -how
    assert "Exception ignored" not in said
    assert gone(MARK, 5)


@pytest.mark.parametrize("how", [signal.SIGKILL, pytest.param(signal.SIGINT, marks=pytest.mark.slow)])
@pytest.mark.parametrize("what", ["starts", pytest.param("sleeps", marks=pytest.mark.slow)])
def test_planner_apart_ends_with_its_caller(what: str, how: signal.Signals) -> None:
    """And so does what it started, in a session of its own or not."""
    process = caller(f"tests.symbolic._odd_planner:create:{what}")
    mark = f"71.{process.pid}"
    if what == "starts":
        assert there(mark)
    process.send_signal(how)
    _, said = process.communicate(timeout=60)
    assert process.returncode == -how
    assert "Exception ignored" not in said
    assert gone(mark, 5)
    assert gone("tests.symbolic._odd_planner", 5)
