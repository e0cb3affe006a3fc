"""Planners that are programs: what passes of their plans, and what is said when they fail."""

import os
import sys
import threading
from collections.abc import Generator
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

from bpns.symbolic.errors import InputError
from bpns.symbolic.pddl.rewriting.portable import Rewritten
from bpns.symbolic.planners.foreign.alternatives import more_and_more
from bpns.symbolic.planners.foreign.exchange import Words
from bpns.symbolic.planners.protocol import About, Limit, SearchRecord
from bpns.symbolic.planners.registry import load
from tests.symbolic._foreign import GOOD, MARK, OTHER, alive, gone, script, seconds, walk, zombies
from tests.symbolic._planning import check_plan, key, plans

FIRST = ("walk(a, b)", "walk(b, c)")
SECOND = ("walk(a, d)", "walk(d, c)")


def first_and_fault(command: str, timeout: float = 20, goal: str = "c") -> tuple[list[tuple[str, ...]], str]:
    """Return what a planner gives before anybody else goes on, and why it ended."""
    stream, record = plans(walk(goal), command, seconds(timeout))
    found = []
    for plan in islice(stream, 3):
        if any("goes on" in remark for remark in record.remarks):
            break
        found.append(key(plan))
    return found, record.fault or record.stopped_by


# ------------------------------------------------------------------------------------ what passes


@pytest.mark.parametrize(
    "text",
    [
        GOOD,
        GOOD.upper(),
        "(walk a b)\r\n(walk b c)\r\n; cost = 2 (unit cost)",
        "0.000: (walk a b) [1.000]\n1.000: (walk b c) [1.000]\n",
        "; a header\n\n  ( walk  a b )\n(walk b c) ; the last",
        GOOD + "(walk c d)\n(walk d c)\n",
        "(wait a)\n(walk a b)\n(rest)\n(wait b)\n(walk b c)\n",
        "\ufeff" + GOOD,
    ],
    ids=["plain", "upper", "cost", "times", "spaces", "beyond", "idle", "mark"],
)
def test_plan_is_read_in_any_spelling_and_ends_at_its_first_goal_state(tmp_path: Path, text: str) -> None:
    (tmp_path / "text").write_text(text, encoding="utf-8")
    problem = walk()
    plan = next(plans(problem, script(tmp_path, f'cp {tmp_path}/text "$plan"'), seconds(20))[0])
    check_plan(problem.problem, plan)
    assert [step for step in key(plan) if not step.startswith("rest")] == list(FIRST)


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("(walk a b)\n(walk b", "plan:2:1: expected one step such as (pick block0), found '(walk b'"),
        ("(walk a b)\n", "invalid plan: goal not reached: at(c)"),
        ("", "invalid plan: goal not reached: at(c)"),
        ("(walk a c)\n", "invalid plan: step 1 (walk a c) can never be taken"),
        ("(walk b c)\n", "invalid plan: step 1 walk(b, c): needs at(b)"),
        ("(fly a c)\n", "invalid plan: unknown operator 'fly'"),
        (GOOD + "(fly to the moon)\n", "invalid plan: unknown operator 'fly'"),
        ("(walk a z)\n", "invalid plan: unknown object 'z' in a step of 'walk'"),
        ("(walk a)\n", "invalid plan: operator 'walk' takes 2 object(s), not 1"),
        ("Segmentation fault (core dumped)\n", "plan:1:1: expected one step"),
        ("()\n", "plan:1:1: expected one step"),
        ("(walk \x1b[31m\x07 b)\n", "unknown object '[31m'"),
        ("(walk " + "a" * 5000 + " b)\n", "unknown object 'aaaa"),
    ],
)
def test_plan_that_is_none_is_one_clear_line(tmp_path: Path, text: str, fault: str) -> None:
    (tmp_path / "text").write_text(text, encoding="utf-8")
    found, end = first_and_fault(script(tmp_path, f'cp {tmp_path}/text "$plan"'))
    assert not found
    assert fault in end
    assert end.isprintable()
    assert len(end) < 500


def test_binary_is_no_plan(tmp_path: Path) -> None:
    assert first_and_fault(script(tmp_path, r"printf '(walk a b)\377\n' > plan")) == (
        [],
        "plan is no text (byte 10 is no UTF-8)",
    )
    assert first_and_fault(script(tmp_path, "mkdir plan")) == ([], "plan is no file")
    assert first_and_fault(script(tmp_path, "ln -s /dev/zero plan")) == ([], "plan is no file")


def test_goal_that_holds_has_the_empty_plan_and_no_other(tmp_path: Path) -> None:
    assert first_and_fault(script(tmp_path, ": > plan"), goal="a") == ([()], "")


def test_plans_come_once_each_and_then_others_follow(tmp_path: Path) -> None:
    text = "i=0; while [ $((i += 1)) -le 1000 ]; do printf '%s' \"$steps\" > plan.$i; done"
    command = script(
        tmp_path, f"grep -q node0 $problem && exit 12\nsteps='{GOOD}'\n{text}\nprintf '{OTHER}' > plan.$i"
    )
    stream, record = plans(walk(), command, seconds(60))
    got = [key(plan) for plan in islice(stream, 5)]
    assert got[:2] == [FIRST, SECOND]
    assert len(set(got)) == 5
    assert record.remarks == [
        "only the first 2 plan(s) came from command, without a proof that there are no others: astar goes on"
    ]


def test_program_is_asked_again_without_its_plans(tmp_path: Path) -> None:
    """Until it says that there are no others."""
    count = f"n=$(cat {tmp_path}/count); echo $((n + 1)) > {tmp_path}/count"
    (tmp_path / "count").write_text("0")
    walks = "$(grep -c node $problem)"
    command = script(
        tmp_path, f"{count}\n[ $n = 0 ] && printf '{GOOD}' > plan && exit 0\n[ {walks} -gt 0 ] && exit 11"
    )
    assert first_and_fault(command) == ([FIRST], "")
    assert (tmp_path / "count").read_text() == "2\n"


@pytest.mark.parametrize(
    ("answers", "proven", "count"), [(0, False, 3), (0, True, 0), (1, False, 3), (1, True, 1)]
)
def test_fewer_plans_than_asked_for_are_all_only_if_the_planner_says_so(
    answers: int, proven: bool, count: int
) -> None:
    """A top-k planner that ran out of memory gives fewer as well."""

    def ask(task: Rewritten, number: int, limit: Limit) -> Generator[list[Words], None, bool]:
        plans: list[list[Words]] = [[("walk", "a", "b"), ("walk", "b", "c")]]
        yield from plans[:answers]
        return proven

    about, record = About("many", "top-k", optimal=True, proves=True), SearchRecord()
    stream = more_and_more(about, ask, 10, walk(), np.random.default_rng(0), seconds(60), record)
    assert len(list(islice(stream, 3))) == count
    assert [remark.endswith("astar goes on") for remark in record.remarks] == [True] * (count == 3)


# ------------------------------------------------------------------------------------- exit codes


@pytest.mark.parametrize(
    ("code", "said"),
    [
        (0, "wrote no plan file"),
        *((code, "") for code in (10, 11, 12)),
        (1, "exit code 1: the last words"),
        (2, "exit code 2: the last words"),
        (22, "exit code 22 (out of memory): the last words"),
        (23, "exit code 23 (out of time): the last words"),
        (32, "exit code 32 (a critical error): the last words"),
        (34, "exit code 34 (it does not support the task): the last words"),
        (36, "exit code 36 (it refuses the input): the last words"),
        (99, "exit code 99: the last words"),
        (127, "exit code 127 (not found, or a program that it needs is not there): the last words"),
    ],
)
def test_exit_code_without_a_plan(tmp_path: Path, code: int, said: str) -> None:
    command = script(tmp_path, f"echo first; echo the last words >&2; exit {code}")
    found, end = first_and_fault(command)
    assert not found
    assert end.startswith(f"planner.sh{' ' if code == 0 else ': '}{said}" if said else "")
    assert bool(end) == bool(said)
    stream, record = plans(walk(), command, seconds(20))
    assert bool(list(islice(stream, 1))) == (code == 12)
    goes_on = "command found no plan, without a proof that there are no others: astar goes on"
    assert record.remarks == ([goes_on] if code == 12 else [])


@pytest.mark.parametrize("code", [0, 1, 2, 3, 10, 11, 12])
def test_plan_counts_whatever_the_exit_code(tmp_path: Path, code: int) -> None:
    first = f"grep -q node0 $problem && exit 11\nprintf '{GOOD}' > $plan; exit {code}"
    assert first_and_fault(script(tmp_path, first)) == ([FIRST], "")


def test_plan_before_a_crash_counts_and_the_crash_is_told(tmp_path: Path) -> None:
    command = script(tmp_path, f"printf '{GOOD}' > plan.1; printf '{OTHER}' > plan.2; kill -SEGV $$")
    assert first_and_fault(command) == (
        [FIRST, SECOND],
        "planner.sh: killed by signal 11: it printed nothing",
    )


def test_file_that_was_only_opened_does_not_hide_the_crash(tmp_path: Path) -> None:
    assert first_and_fault(script(tmp_path, ": > plan; echo out of luck; exit 7")) == (
        [],
        "planner.sh: exit code 7: out of luck",
    )


# -------------------------------------------------------------------------- sleeping, flooding, hiding


@pytest.mark.parametrize(
    "text",
    [
        "sleep MARK",
        "trap '' TERM INT HUP; sleep MARK; sleep MARK",
        "sleep MARK & sleep MARK & sleep MARK",
        "sleep MARK >/dev/null 2>&1 & sleep MARK",
        "(sleep MARK &) ; sleep MARK",
        "timeout 99 sleep MARK & timeout 99 sleep MARK",
        "timeout 99 sleep MARK",
        "kill -STOP $$; sleep MARK",
    ],
)
def test_sleeper_is_ended_at_the_deadline_with_all_that_it_started(tmp_path: Path, text: str) -> None:
    assert first_and_fault(script(tmp_path, text), 0.2) == ([], "time limit")
    assert gone(MARK, 2)


def test_timeout_as_the_program_itself_is_ended_too(tmp_path: Path) -> None:
    command = f"command:timeout 99 {script(tmp_path, 'sleep MARK')[8:]}"
    assert first_and_fault(command, 0.3) == ([], "time limit")
    assert gone(MARK, 2)


def test_nobody_waits_for_a_child_that_holds_the_output_open(tmp_path: Path) -> None:
    command = script(
        tmp_path, f"sleep MARK &\n[ $(grep -c node0 $problem) = 0 ] && printf '{GOOD}' > plan || exit 11"
    )
    assert first_and_fault(command) == ([FIRST], "")
    assert gone(MARK, 2)


def test_program_may_wait_for_all_its_children(tmp_path: Path) -> None:
    """The watchman is none of them."""
    waits = "try:\n    os.wait()\nexcept ChildProcessError:\n    pass\n"
    (tmp_path / "waits.py").write_text(f"import os\nopen('plan', 'w').write({GOOD!r})\n{waits}")
    command = f"command:{sys.executable} {tmp_path}/waits.py {{domain}} {{problem}}"
    assert next(plans(walk(), command, seconds(20))[0]) is not None


def test_plan_is_taken_at_the_deadline_where_it_is_complete(tmp_path: Path) -> None:
    assert first_and_fault(script(tmp_path, f"printf '{GOOD}' > plan; sleep MARK"), 0.5) == (
        [FIRST],
        "time limit",
    )
    assert gone(MARK, 2)


def test_finished_plans_come_while_the_program_runs(tmp_path: Path) -> None:
    """A file is finished when the next one is there, or when it ends with its cost."""
    text = f"printf '{GOOD}' > plan.1; printf '{OTHER}; cost = 2 (unit cost)\\n' > plan.2; sleep MARK"
    stream, record = plans(walk(), script(tmp_path, text), seconds(60))
    assert [key(next(stream)), key(next(stream))] == [FIRST, SECOND]
    assert alive(MARK)
    stream.close()  # type: ignore[attr-defined]
    assert gone(MARK, 2)
    assert record.stopped_by == ""


@pytest.mark.parametrize("stream", ["", pytest.param(">&2", marks=pytest.mark.slow)])
@pytest.mark.parametrize("flood", ["yes MARK", "exec tail -c +1 /dev/zero", "cat /dev/urandom"])
def test_flood_of_output_does_no_harm(tmp_path: Path, flood: str, stream: str) -> None:
    assert first_and_fault(script(tmp_path, f"{flood} {stream}"), 0.2) == ([], "time limit")
    assert gone(MARK, 2)


def test_last_words_of_a_flood_are_cut(tmp_path: Path) -> None:
    text = "head -c 3000000 /dev/zero | tr '\\0' x; exit 5"
    assert first_and_fault(script(tmp_path, text)) == ([], "planner.sh: exit code 5: " + "x" * 200)


@pytest.mark.parametrize("ending", ["", "sleep MARK"])
@pytest.mark.parametrize("name", ["plan", "plan.1"])
def test_endless_plan_is_refused_as_soon_as_it_is_too_long(tmp_path: Path, name: str, ending: str) -> None:
    found, end = first_and_fault(
        script(tmp_path, f"yes '(walk a b)' | head -c 10000009 > {name}; {ending}"), 60
    )
    assert (found, end) == ([], f"{name} has more than 10 MB: that is no plan")


def test_endless_plan_files_end_at_the_deadline(tmp_path: Path) -> None:
    text = f"i=0; while true; do printf '{GOOD}' > plan.$((i += 1)); done"
    assert first_and_fault(script(tmp_path, text), 0.5) == ([FIRST], "time limit")


# --------------------------------------------------------------------------- opening and leaving


def own_descriptors() -> int:
    return len(os.listdir("/proc/self/fd"))


def test_nothing_is_left_behind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "tmp").mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "tmp"))
    command = script(tmp_path, f"printf '{GOOD}' > plan.1; : > plan.2; sleep MARK")
    problem = walk()
    before, threads = own_descriptors(), threading.active_count()
    for number in range(15):
        stream, _ = plans(problem, command, seconds(60))
        assert key(next(stream)) == FIRST
        if number % 2:
            stream.close()  # type: ignore[attr-defined]
        del stream
    assert own_descriptors() == before
    assert threading.active_count() == threads
    assert not list((tmp_path / "tmp").iterdir())
    assert gone(MARK, 2)
    assert not zombies()


def test_streams_of_one_planner_can_be_interleaved_and_used_in_threads(tmp_path: Path) -> None:
    text = f"printf '{GOOD}' > plan.1; printf '{OTHER}' > plan.2; exit 0"
    planner, problem = load(script(tmp_path, text)), walk()
    (one, _), (two, _) = (plans(problem, planner.name, seconds(60)) for _ in range(2))
    assert [key(next(s)) for s in (one, two, two, one)] == [FIRST, FIRST, SECOND, SECOND]
    results: list[list[tuple[str, ...]]] = []

    def take() -> None:
        results.append([key(plan) for plan in islice(plans(problem, planner.name, seconds(60))[0], 2)])

    threads = [threading.Thread(target=take) for _ in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert results == [[FIRST, SECOND]] * 6


def test_deadline_that_has_passed_ends_the_stream(tmp_path: Path) -> None:
    assert first_and_fault(script(tmp_path, "sleep MARK"), -1) == ([], "time limit")
    assert gone(MARK, 2)


# ------------------------------------------------------------------------------------ the command


@pytest.mark.parametrize(
    ("command", "fault"),
    [
        ("", r"has no \{domain\}"),
        ("planner {domain}", r"has no \{problem\}"),
        ("no-such-planner {domain} {problem}", "there is no program 'no-such-planner' on this machine"),
        ("./no-such {domain} {problem}", "there is no program './no-such'"),
        ("./plain.txt {domain} {problem}", "'./plain.txt' is not executable"),
        ("sh '{domain} {problem}", "No closing quotation"),
    ],
)
def test_command_that_cannot_be_run_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: str, fault: str
) -> None:
    (tmp_path / "plain.txt").write_text("")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=fault):
        load(f"command:{command}")


@pytest.mark.parametrize("folder", ["plain", "with space", "it's", 'a "b" $HOME'])
def test_command_may_name_files_of_the_current_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, folder: str
) -> None:
    place = tmp_path / folder
    place.mkdir()
    script(place, 'cp "$4" "$plan"')
    (place / "answer").write_text(GOOD)
    monkeypatch.chdir(place)
    for command in ("./planner.sh", "sh planner.sh"):
        stream, _ = plans(walk(), f"command:{command} {{domain}} {{problem}} {{plan}} answer", seconds(20))
        assert key(next(stream)) == FIRST


def test_plan_file_of_the_current_folder_is_left_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "plan").write_text("(mine)")
    monkeypatch.chdir(tmp_path)
    script(tmp_path, f"printf '{GOOD}' > $3")
    assert key(next(plans(walk(), "command:./planner.sh {domain} {problem} plan", seconds(20))[0])) == FIRST
    assert (tmp_path / "plan").read_text() == "(mine)"


def test_long_words_and_colons_stay_as_they_are(tmp_path: Path) -> None:
    long = "let(" + "x" * 300 + ",{a:b})"
    command = f"{script(tmp_path, f'echo $4 > {tmp_path}/said; exit 11')} '{long}'"
    assert list(plans(walk(), command, seconds(20))[0]) == []
    assert (tmp_path / "said").read_text() == f"{long}\n"
    assert load(load(command).name) == load(command)


def test_program_with_a_missing_interpreter(tmp_path: Path) -> None:
    path = tmp_path / "odd"
    path.write_text("#!/no/such/interpreter\n")
    path.chmod(0o755)
    found, end = first_and_fault(f"command:{path} {{domain}} {{problem}}")
    assert not found
    assert end.startswith("odd: exit code 12")
    assert "needs is not there" in end


def test_program_without_end_and_without_deadline(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("bpns.symbolic.planners.foreign.program.PATIENCE", 0.2)
    stream, record = plans(walk(), script(tmp_path, "sleep MARK"), Limit(1000))
    assert list(stream) == []
    assert record.fault == "planner.sh gave no plan within 0 s (--timeout changes that)"
    assert gone(MARK, 2)
    monkeypatch.setattr("bpns.symbolic.planners.foreign.alternatives.PATIENCE", 0.2)
    text = f"i=0; while true; do printf '{GOOD}' > plan.$((i += 1)); done"
    stream, record = plans(walk(), script(tmp_path, text), Limit(1000))
    assert [key(plan) for plan in stream] == [FIRST]
    assert record.fault == "command gave no new plan within 0 s (--timeout changes that)"
