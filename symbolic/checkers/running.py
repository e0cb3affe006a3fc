"""Each checker in a process of its own: one that crashes, hangs or chatters harms nobody."""

import multiprocessing
import os
import signal
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib import import_module
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from threading import Thread
from time import monotonic

from bpns.symbolic.checkers.reports import Inputs, Report, Verdict
from bpns.symbolic.errors import MissingPackage


def check(inputs: Inputs, checkers: Sequence[str], seconds: float) -> list[Report]:
    """Let checkers look at the inputs, all at the same time, each for so many seconds at most."""
    deadline = monotonic() + seconds
    with _started(inputs, checkers) as running:
        return [_collect(name, inputs, *running[name], deadline, seconds) for name in checkers]


@contextmanager
def _started(inputs: Inputs, checkers: Sequence[str]) -> Iterator[dict[str, tuple[SpawnProcess, Connection]]]:
    context = multiprocessing.get_context("spawn")
    running = {}
    try:
        for name in checkers:
            ours, theirs = context.Pipe(duplex=False)
            process = context.Process(target=_work, args=(name, inputs, theirs), daemon=True)
            process.start()
            theirs.close()  # so that its end is seen
            running[name] = (process, ours)
        yield running
    finally:
        for process, connection in running.values():
            if process.pid is not None:
                with suppress(ProcessLookupError, PermissionError):  # not yet a group: the next line ends it
                    os.killpg(process.pid, signal.SIGKILL)
            process.kill()
            process.join()
            connection.close()


def _collect(
    name: str,
    inputs: Inputs,
    process: SpawnProcess,
    connection: Connection,
    deadline: float,
    seconds: float,
) -> Report:
    """Take what a process sends: its version, or how to install it; then verdicts."""
    version, found, reason = "", [], ""
    try:
        while not reason:
            if not connection.poll(max(0.0, deadline - monotonic())):
                reason = f"not done after {seconds:g} s (--timeout changes that)"
            else:
                kind, value = connection.recv()
                if kind == "missing":
                    return Report(name, missing=value)
                if kind == "version":
                    version = value
                elif kind == "verdict":
                    found.append(value)
                else:
                    reason = value or "done"
    except (EOFError, OSError):
        process.join(1)
        reason = f"it ended with {process.exitcode}"
    if reason != "done":
        found.append(Verdict("failed", reason))
    found += [Verdict("skipped")] * (len(inputs.items) - len(found))
    return Report(name, version, tuple(found[: len(inputs.items)]))


def _work(name: str, inputs: Inputs, connection: Connection) -> None:
    """Run a checker and send what it says; the process's own group and silence come first."""
    with suppress(PermissionError):
        os.setsid()
    Thread(target=_end_with_the_parent, daemon=True).start()
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(nowhere, stream)
    try:
        module = import_module(f"bpns.symbolic.checkers.{name}")
        connection.send(("version", module.version()))
        for verdict in module.verdicts(inputs):
            connection.send(("verdict", verdict))
        connection.send(("end", ""))
    except MissingPackage as error:
        connection.send(("missing", str(error)))
    except Exception as error:  # a stranger's code: whatever it raises is its failure, not ours
        text = " ".join(f"{type(error).__name__}: {error}".split())[:300]
        connection.send(("end", f"internal error {text}"))


def _end_with_the_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os.killpg(0, signal.SIGKILL)
