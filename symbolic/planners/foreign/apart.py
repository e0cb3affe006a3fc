"""Planners in a process of their own, so that they can be stopped whatever they do.

The process is kept for the next problem: importing some libraries takes seconds. It works only while somebody
waits for a plan. Requests and replies are lines of JSON; what the library prints goes elsewhere.
"""

import json
import os
import select
import subprocess
import sys
import weakref
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from fcntl import F_DUPFD_CLOEXEC, fcntl
from pathlib import Path
from tempfile import TemporaryDirectory
from time import monotonic
from typing import Any

import numpy as np

from bpns.symbolic.grounding.ground import GroundProblem
from bpns.symbolic.pddl.write import write_domain, write_problem
from bpns.symbolic.planners.foreign.exchange import (
    DeadlinePassed,
    PlanFilter,
    PlannerFailed,
    original_words,
    prepared,
    recorded,
)
from bpns.symbolic.planners.foreign.program import PATIENCE, Program, running
from bpns.symbolic.planners.protocol import About, AbstractPlan, Limit, Planner, SearchRecord

GRACE = 0.5  # seconds after the deadline in which a planner can stop by itself
_START = """
import sys
sys.path[:] = sys.argv[3:]
from bpns.symbolic.planners.foreign.worker import main
main(int(sys.argv[1]), int(sys.argv[2]))
"""


class Worker:
    """The process and the pipes to it; started when first asked, ended with this object."""

    def __init__(self, name: str) -> None:
        ours = ExitStack()
        self.end = weakref.finalize(self, ours.close)  # kills the process and all that it started
        self._rest = b""  # what came and was not read yet
        self._owed = 0  # replies that nobody waits for any more
        paths = [str(Path(path).absolute()) for path in sys.path]
        try:
            with ExitStack() as theirs:
                requests, self._to = _pipe(theirs, ours)
                self._from, replies = _pipe(ours, theirs)
                os.set_blocking(self._to, False)
                command = [sys.executable, "-P", "-c", _START, str(requests), str(replies), *paths]
                # Some engines write into the current folder, where two at once would mix.
                folder = ours.enter_context(TemporaryDirectory(prefix="bpns-", ignore_cleanup_errors=True))
                self._program: Program = ours.enter_context(
                    running(name, command, Path(folder), (requests, replies))
                )
        except OSError as error:
            self.end()
            raise PlannerFailed(f"{name} cannot be started: {error.strerror or error}") from error

    def ask(self, request: dict[str, Any], limit: Limit) -> dict[str, Any]:
        """Send a request, return the reply; raise DeadlinePassed, PlannerFailed where the process is gone."""
        left = PATIENCE if limit.deadline is None else limit.deadline - monotonic() + GRACE
        until = monotonic() + left
        waiting = (json.dumps(request) + "\n").encode()
        while True:
            waiting = self._exchange(waiting)
            while b"\n" in self._rest:
                line, _, self._rest = self._rest.partition(b"\n")
                if self._owed == 0:
                    reply: dict[str, Any] = json.loads(line)
                    return reply
                self._owed -= 1
            if self._program.ended() is not None:
                raise PlannerFailed(self._program.how_it_ended())
            if monotonic() > until and limit.deadline is not None:
                raise DeadlinePassed
            if monotonic() > until:
                raise PlannerFailed(
                    f"{self._program.name} gave no plan within {PATIENCE:.0f} s (--timeout changes that)"
                )

    def leave(self) -> None:
        """Tell the process that nobody wants more plans of this problem: it stops what it began."""
        self._owed += 1
        try:
            if self._exchange(b'{"leave": true}\n'):
                self.end()
        except PlannerFailed:
            self.end()

    def _exchange(self, waiting: bytes) -> bytes:
        """Wait a little, send and receive what goes through the pipes; return what is still to be sent."""
        ready = select.poll()
        ready.register(self._from, select.POLLIN)
        if waiting:
            ready.register(self._to, select.POLLOUT)
        try:
            for pipe, _ in ready.poll(50):
                if pipe == self._to:
                    waiting = waiting[os.write(self._to, waiting) :]
                elif piece := os.read(self._from, 1 << 20):
                    self._rest += piece
                else:
                    raise BrokenPipeError
        except OSError as error:
            with suppress(subprocess.TimeoutExpired):
                self._program.process.wait(GRACE)
            raise PlannerFailed(self._program.how_it_ended()) from error
        return waiting


def _pipe(reader: ExitStack, writer: ExitStack) -> tuple[int, int]:
    """Return the ends of a pipe, to be closed by two stacks, with numbers that no shell uses itself."""
    low = os.pipe()
    try:
        read = fcntl(low[0], F_DUPFD_CLOEXEC, 20)
        reader.callback(os.close, read)
        write = fcntl(low[1], F_DUPFD_CLOEXEC, 20)
        writer.callback(os.close, write)
    finally:
        os.close(low[0])
        os.close(low[1])
    return read, write


class _Idle(list[Worker]):
    """Workers that wait for a problem. They stay here when their planner goes to another process."""

    def __reduce__(self) -> tuple[type["_Idle"], tuple[()]]:
        return _Idle, ()


@dataclass(frozen=True, slots=True)
class Apart:
    """A planner that runs in another process."""

    planner: Planner
    about: About
    idle: _Idle = field(default_factory=_Idle, compare=False, repr=False)

    @property
    def name(self) -> str:
        """How to ask for this planner."""
        return self.planner.name

    def plans(
        self, problem: GroundProblem, rng: np.random.Generator, limit: Limit, record: SearchRecord
    ) -> Iterator[AbstractPlan]:
        """Yield the plans that come from the other process; see Planner."""
        passing = PlanFilter(problem, record, self.about.optimal)
        rewritten = prepared(problem, self.about)
        request = {
            "planner": self.name,
            "domain": write_domain(rewritten.domain),
            "problem": write_problem(rewritten.problem, rewritten.domain),
            "seed": int(rng.integers(2**32)),
            "nodes": limit.nodes,
        }
        with recorded(record):
            worker = self._worker(limit)
            unsure, more = True, True  # whether the worker is in order, and whether it has more to say
            try:
                while True:
                    left = None if limit.deadline is None else limit.deadline - monotonic()
                    unsure = True
                    reply = worker.ask({**request, "seconds": left}, limit)
                    unsure, more = reply["failed"], reply["plan"] is not None
                    request = {}
                    self._note(reply["record"], passing)
                    if not more:
                        return
                    found = passing.accept([original_words(rewritten, tuple(s)) for s in reply["plan"]])
                    if found is not None:
                        yield found
            finally:
                if unsure:
                    worker.end()
                elif more:
                    worker.leave()
                if worker.end.alive:
                    self.idle.append(worker)

    def _worker(self, limit: Limit) -> Worker:
        """Return a worker that waits for a problem and still answers, or a new one."""
        while self.idle:
            try:
                worker = self.idle.pop()
            except IndexError:  # another thread was faster
                break
            try:
                worker.ask({"leave": True}, limit)
            except PlannerFailed:  # it died in the meantime
                worker.end()
            except DeadlinePassed:
                worker.end()
                raise
            else:
                return worker
        return Worker(self.name)

    def _note(self, news: dict[str, Any], passing: PlanFilter) -> None:
        """Enter what the worker says of its search."""
        for remark in news.pop("remarks"):
            passing.remark(remark)
        for key, value in news.items():
            setattr(passing.record, key, value)
