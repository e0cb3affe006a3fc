"""Foreign programs: run in a folder, a session and a process group of their own, which end when we do."""

import os
import re
import select
import signal
import subprocess
from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Thread
from time import monotonic, sleep

from bpns.symbolic.errors import PddlError
from bpns.symbolic.pddl.plan_file import parse_plan
from bpns.symbolic.pddl.rewriting.portable import Rewritten
from bpns.symbolic.planners.foreign.exchange import DeadlinePassed, PlannerFailed, Words
from bpns.symbolic.planners.protocol import Limit

TAIL = 20_000  # bytes of a program's output that are kept, for messages
LARGEST_PLAN = 10_000_000  # bytes
PATIENCE = 300.0  # seconds for a plan where nobody set a deadline
PAUSE = 0.005  # seconds between looks at the plan files
SOLVED = (0, 1, 2, 3)  # Fast Downward's exit codes; 1 to 3: and then out of memory, time, or both
UNSOLVABLE, GAVE_UP = (10, 11), (0, 12)  # without a plan; some end with 0 although they found none
MEANINGS = {
    **dict.fromkeys((20, 22), "out of memory"),
    **dict.fromkeys((21, 23, 24), "out of time"),
    **dict.fromkeys((30, 32), "a critical error"),
    **dict.fromkeys((31, 36), "it refuses the input"),
    **dict.fromkeys((33, 34, 37), "it does not support the task"),
    126: "it cannot be executed",
    127: "not found, or a program that it needs is not there",
}

# A watchman in the program's group: it reads from a pipe of ours, which ends when we end, however that
# happens, and then it kills the whole group. It is nobody's child, as some programs wait for all they have.
# Groups that the program's children made (``timeout`` does) are found by their session where ps can tell.
_WATCHED = """
exec 3<&0 </dev/null
({
    trap "" HUP INT TERM
    read -r line <&3
    ps -A -o pid= -o sess= -o pgid= | while read -r pid session group; do
        [ "$session" = $$ ] && [ "$group" != $$ ] && kill -KILL "$pid"
    done
    kill -KILL 0
} >/dev/null 2>&1 &)
exec "$@" 3<&-
"""


@contextmanager
def task_folder(task: Rewritten) -> Iterator[Path]:
    """Give a temporary folder with a task's domain.pddl and problem.pddl."""
    with TemporaryDirectory(prefix="bpns-", ignore_cleanup_errors=True) as name:
        folder = Path(name)
        for file, text in zip(("domain.pddl", "problem.pddl"), task.texts, strict=True):
            (folder / file).write_text(text, encoding="utf-8")
        yield folder


@dataclass(slots=True)
class Program:
    """A running program and the end of what it printed."""

    name: str
    process: subprocess.Popen[bytes]
    kept: bytearray = field(default_factory=bytearray)
    left: bool = False  # nobody is interested in its output any more
    reader: Thread = field(init=False)

    def __post_init__(self) -> None:
        self.reader = Thread(target=self._read, daemon=True)
        self.reader.start()

    def _read(self) -> None:
        """Read all output, so that the program never waits for us, and keep its end."""
        assert self.process.stdout is not None
        with self.process.stdout as stream:
            ready = select.poll()
            ready.register(stream, select.POLLIN)
            while not self.left:  # not until its end, as somebody who escaped us may hold it open for ever
                if ready.poll(100):
                    piece = os.read(stream.fileno(), 65536)
                    if not piece:
                        return
                    self.kept += piece
                    del self.kept[:-TAIL]

    def ended(self) -> int | None:
        """Return the exit code; None while it runs."""
        return self.process.poll()

    def how_it_ended(self) -> str:
        """Return exit code, its meaning and the last words, for a message."""
        code = self.ended()
        if code is None:
            return f"{self.name} closed its pipes"
        meaning = f"killed by signal {-code}" if code < 0 else f"exit code {code}"
        known = f" ({MEANINGS[code]})" if code in MEANINGS else ""
        return f"{self.name}: {meaning}{known}: {self.last_words()}"

    def last_words(self) -> str:
        """Return the last line of the output that says something, for a message."""
        self.reader.join(0.2)
        lines = bytes(self.kept).decode("utf-8", "replace").splitlines()
        said = [line.strip() for line in lines if line.strip()]
        return "".join(c for c in said[-1] if c.isprintable())[:200] if said else "it printed nothing"


@contextmanager
def running(name: str, command: Sequence[str], folder: Path, pipes: Sequence[int] = ()) -> Iterator[Program]:
    """Run a program, with some open pipes; leaving kills it and all that it started in its session.

    Raises PlannerFailed where it cannot be started.
    """
    try:
        process = subprocess.Popen(
            ["/bin/sh", "-c", _WATCHED, "sh", *command],
            cwd=folder,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            pass_fds=pipes,
        )
    except OSError as error:
        raise PlannerFailed(f"{name} cannot be started: {error.strerror or error}") from error
    program = None
    try:
        program = Program(name, process)
        yield program
    finally:
        _kill(process)
        assert process.stdin is not None
        process.stdin.close()
        if program is not None:
            program.left = True
            program.reader.join(1)


def _kill(process: subprocess.Popen[bytes]) -> None:
    """Kill a program's group, and where it was at work those that its children made in its session."""
    interrupted = process.poll() is None
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, signal.SIGKILL)
    if interrupted:
        with suppress(OSError):
            found = subprocess.run(["ps", "-A", "-o", "pid="], capture_output=True, check=False).stdout
            for pid in map(int, found.split()):
                with suppress(ProcessLookupError, PermissionError):
                    if os.getsid(pid) == process.pid:
                        os.kill(pid, signal.SIGKILL)
    process.wait()


def plan_files(
    program: Program, folder: Path, names: Sequence[str], limit: Limit
) -> Iterator[tuple[str, str]]:
    """Yield name and text of each plan file as it is finished: ``plan``, or ``plan.1``, ``plan.2``, ...

    A file is finished when the next one is there, when it ends as Fast Downward's do (``; cost = 3``), or
    when the program has ended. Raises DeadlinePassed at the deadline, after what is there then, or
    PlannerFailed where nobody set one after PATIENCE seconds without a plan.
    """
    number, since = 1, monotonic()
    while True:
        over = program.ended() is not None
        path = _plan_file(folder, names, number)
        if path is not None and (over or (_finished(path) and not limit.late)):
            yield path.name, _text(path)
            number, since = number + 1, monotonic()
        elif over:
            return
        elif limit.late:
            if path is not None:
                yield path.name, _text(path)
            raise DeadlinePassed
        elif limit.deadline is None and monotonic() > since + PATIENCE:
            raise PlannerFailed(
                f"{program.name} gave no plan within {PATIENCE:.0f} s (--timeout changes that)"
            )
        else:
            sleep(PAUSE)


def _plan_file(folder: Path, names: Sequence[str], number: int) -> Path | None:
    """Return the file of the plan of this number, the first also without one; None where there is none."""
    endings = (".1", "") if number == 1 else (f".{number}",)
    paths = (folder / f"{name}{ending}" for ending in endings for name in names)
    return next((path for path in paths if path.exists()), None)


_LAST_LINES = re.compile(rb"\)\s*\n\s*;\s*cost\b[^\n]*\n\s*\Z")


def _finished(path: Path) -> bool:
    """Say whether a numbered file will not change any more; one without a number can be written anew."""
    size = path.stat().st_size
    if size > LARGEST_PLAN:
        return True  # and refused
    stem, _, number = path.name.rpartition(".")
    if not number.isdecimal():
        return False
    if path.with_name(f"{stem}.{int(number) + 1}").exists():
        return True
    with suppress(OSError), path.open("rb") as file:
        file.seek(max(0, size - 1000))
        return _LAST_LINES.search(file.read(1000)) is not None
    return False


def _text(path: Path) -> str:
    try:
        if not path.is_file():
            raise PlannerFailed(f"{path.name} is no file")
        with path.open("rb") as file:
            content = file.read(LARGEST_PLAN + 1)
    except OSError as error:
        raise PlannerFailed(f"{path.name} cannot be read: {error.strerror or error}") from error
    if len(content) > LARGEST_PLAN:
        raise PlannerFailed(f"{path.name} has more than {LARGEST_PLAN // 10**6} MB: that is no plan")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise PlannerFailed(f"{path.name} is no text (byte {error.start} is no UTF-8)") from error


def read_plans(
    program: Program, folder: Path, names: tuple[str, ...], limit: Limit
) -> Generator[list[Words], None, bool]:
    """Yield a program's plans and return whether its exit code says that there is none; see Ask."""
    given = 0
    for name, text in plan_files(program, folder, names, limit):
        try:
            steps = parse_plan(text, name)
        except PddlError as error:
            raise PlannerFailed(f"{program.name} wrote no plan: {error}") from error
        if steps or program.ended() in SOLVED:  # else it is a file that was opened and never written
            given += 1
            yield [step.words for step in steps]
    code = program.ended()
    if code not in UNSOLVABLE + GAVE_UP and not (given and code in SOLVED):
        raise PlannerFailed(program.how_it_ended())  # 1 is also Python's exit code after an exception
    return code in UNSOLVABLE
