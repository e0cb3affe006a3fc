"""Planners in a process apart: whatever a library does there, the next problem gets an answer."""

import os
import pickle
import subprocess
import sys
import threading
from dataclasses import replace
from pathlib import Path
from time import sleep
from typing import Any

import numpy as np
import pytest

from bpns.symbolic.planners.foreign.apart import Apart
from bpns.symbolic.planners.protocol import Limit, SearchRecord
from bpns.symbolic.structs import Object
from tests.symbolic._foreign import MARK, gone, seconds, walk, zombies
from tests.symbolic._odd_planner import create
from tests.symbolic._planning import key

FIRST, SECOND = ("walk(a, b)", "walk(b, c)"), ("walk(a, d)", "walk(d, c)")
ROOT = Path(__file__).parents[2]


def slow(*values: Any) -> list[Any]:
    return [
        pytest.param(*([value] if isinstance(value, str) else value), marks=pytest.mark.slow)
        for value in values
    ]


def ask(planner: Apart, goal: str = "c", timeout: float = 60) -> tuple[list[tuple[str, ...]], SearchRecord]:
    record = SearchRecord()
    stream = planner.plans(walk(goal), np.random.default_rng(0), seconds(timeout), record)
    return [key(plan) for plan in stream], record


def process(record: SearchRecord) -> str:
    return next(remark for remark in record.remarks if remark.startswith("process"))


@pytest.fixture(scope="module")
def odd_prints() -> Apart:
    return create("prints")


def test_what_a_library_prints_goes_elsewhere(odd_prints: Apart, capfd: pytest.CaptureFixture[str]) -> None:
    found, record = ask(odd_prints)
    assert (found, record.stopped_by) == ([FIRST, SECOND], "")
    assert capfd.readouterr() == ("", "")


def test_process_is_kept_and_streams_do_not_mix(odd_prints: Apart) -> None:
    one, two = SearchRecord(), SearchRecord()
    first = odd_prints.plans(walk(), np.random.default_rng(0), seconds(60), one)
    other = odd_prints.plans(walk(), np.random.default_rng(0), seconds(60), two)
    assert [key(next(s)) for s in (first, other, first, other)] == [FIRST, FIRST, SECOND, SECOND]
    assert process(one) != process(two)
    del first, other
    _, again = ask(odd_prints, "d")
    assert process(again) in (process(one), process(two))
    assert len(odd_prints.idle) == 2


def test_process_that_was_killed_is_replaced(odd_prints: Apart) -> None:
    _, record = ask(odd_prints, "d")
    killed = int(process(record).split()[1])
    os.kill(killed, 9)
    assert gone_pid(killed)
    found, record = ask(odd_prints, "d")
    assert (found, record.fault) == ([("walk(a, d)",)], "")


def test_planner_can_go_to_another_process(odd_prints: Apart) -> None:
    copy = pickle.loads(pickle.dumps(odd_prints))
    assert copy == odd_prints
    assert not copy.idle


def test_request_larger_than_a_pipe(odd_prints: Apart) -> None:
    problem = walk("d")
    kind = next(o for o in problem.problem.objects if o.name == "e").type
    more = tuple(Object(f"far-away-place-number-{number}", kind) for number in range(20_000))
    large = replace(problem.problem, objects=(*problem.problem.objects, *more))
    record = SearchRecord()
    stream = odd_prints.plans(replace(problem, problem=large), np.random.default_rng(0), seconds(1), record)
    found = [key(plan) for plan in stream]  # on a slow machine it may be late
    assert found == [("walk(a, d)",)] or record.stopped_by == "time limit"


@pytest.mark.parametrize(
    ("what", "fault"),
    [
        ("crashes", "tests.symbolic._odd_planner:create:crashes: killed by signal 11: it printed nothing"),
        ("early-raises", "RuntimeError: out of luck"),
        *slow(
            ("raises", "RuntimeError: out of luck"),
            ("exits", "tests.symbolic._odd_planner:create:exits: exit code 3: so long"),
            ("ends", "tests.symbolic._odd_planner:create:ends: exit code 0: it printed nothing"),
            ("cheats", "invalid plan: goal not reached: at(c)"),
        ),
    ],
)
def test_failure_is_one_line_and_the_next_problem_has_an_answer(what: str, fault: str) -> None:
    planner = create(what)
    found, record = ask(planner)
    assert found == ([] if what.startswith("early") else [FIRST])
    assert (record.stopped_by, record.fault) == ("planner failed", fault)
    assert ask(planner, "d")[0] == [("walk(a, d)",)]


@pytest.mark.parametrize("what", ["starts", *slow("sleeps", "early-sleeps")])
def test_planner_that_misses_the_deadline_is_ended(what: str) -> None:
    planner = create(what)
    warm, _ = ask(planner, "d")
    found, record = ask(planner, timeout=0.2)
    assert record.stopped_by == "time limit"
    assert found == ([] if what.startswith("early") else [FIRST])
    assert gone(MARK, 2)
    again, later = ask(planner, "d")
    assert again == warm
    assert process(later) != process(record) if found else process(later)


def test_what_a_stream_began_ends_when_it_is_left_and_the_process_stays() -> None:
    planner, record = create("streams"), SearchRecord()
    stream = planner.plans(walk(), np.random.default_rng(0), seconds(60), record)
    assert [key(next(stream)), key(next(stream))] == [FIRST, SECOND]
    del stream
    assert gone(MARK)
    found, later = ask(planner, "d")
    assert found == [("walk(a, d)",)]
    assert process(later) == process(record)


def test_remarks_and_limits_of_both_sides_are_kept() -> None:
    planner = create("shortens")
    _, record = ask(planner)
    assert record.remarks[1:] == ["plans are out of order: 2 steps after 4"]
    record = SearchRecord()
    stream = create("limits").plans(walk(), np.random.default_rng(0), Limit(7), record)
    assert [key(plan) for plan in stream] == [FIRST]
    assert record.stopped_by == "node limit"


def test_threads_have_processes_of_their_own() -> None:
    planner = create("prints")
    found: list[list[tuple[str, ...]]] = []
    threads = [threading.Thread(target=lambda: found.append(ask(planner)[0])) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [[FIRST, SECOND]] * 3
    assert 1 <= len(planner.idle) <= 3


def test_nothing_is_left_behind() -> None:
    before, threads = len(os.listdir("/proc/self/fd")), threading.active_count()
    planner = create("prints")
    ask(planner, "d")
    del planner
    assert len(os.listdir("/proc/self/fd")) == before
    assert threading.active_count() == threads
    assert not zombies()


ENDS = """
import sys, numpy as np
from itertools import islice
from tests.symbolic._foreign import seconds, walk
from tests.symbolic._odd_planner import create
from bpns.symbolic.planners.protocol import SearchRecord
planner = create("prints")
stream = planner.plans(walk(), np.random.default_rng(0), seconds(60), record := SearchRecord())
print(next(stream), *record.remarks)
{end}
"""


@pytest.mark.parametrize(
    "end", ["", *slow("import os; os._exit(1)", "stream.close()", "sys.exit(3)", "stream.self = 1")]
)
def test_interpreter_ends_in_silence(end: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", ENDS.format(end=end)], cwd=ROOT, capture_output=True, text=True
    )
    pid = int(done.stdout.split()[-1])
    assert gone_pid(pid)
    assert done.stderr == "" or "AttributeError" in done.stderr.splitlines()[-1]
    assert "Exception ignored" not in done.stderr


def gone_pid(pid: int) -> bool:
    for _ in range(100):
        if not Path(f"/proc/{pid}/cmdline").exists() or not Path(f"/proc/{pid}/cmdline").read_bytes():
            return True
        sleep(0.02)
    return False


def test_modules_of_the_current_folder_are_not_taken_for_libraries(tmp_path: Path) -> None:
    for name in ("json", "numpy", "symbolic", "pyperplan", "select", "tempfile"):
        (tmp_path / f"{name}.py").write_text(f"open('imported-{name}', 'w')\n")
    done = subprocess.run(
        [sys.executable, "-P", "-c", f"import sys; sys.path.insert(0, {str(ROOT)!r})\n{ENDS.format(end='')}"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    assert done.stdout.startswith("walk(a, b), walk(b, c)")
    assert not list(tmp_path.glob("imported-*"))


def test_engines_do_not_write_into_our_folder(
    odd_prints: Apart, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    _, record = ask(odd_prints, "d")
    own = int(process(record).split()[1])
    assert Path(f"/proc/{own}/cwd").resolve() not in (tmp_path, ROOT)


def test_planner_under_a_wrong_name_does_not_start_process_after_process() -> None:
    wrong = create("prints")
    _, record = ask(Apart(_Renamed(wrong.planner), wrong.about))
    assert record.fault == "'astar:lmcut' is not the name of a planner that runs apart"


class _Renamed:
    name = "astar"

    def __init__(self, planner: Any) -> None:
        self.plans = planner.plans
