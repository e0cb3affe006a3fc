"""The other process of a planner that runs apart; see _apart.py."""

import json
import os
import subprocess
from collections.abc import Generator, Iterator
from dataclasses import asdict
from time import monotonic
from typing import Any

import numpy as np

from bpns.symbolic import planners
from bpns.symbolic.errors import InputError
from bpns.symbolic.grounding.ground import Unreachable, ground
from bpns.symbolic.pddl.read import parse_domain, parse_problem
from bpns.symbolic.planners.foreign.apart import Apart
from bpns.symbolic.planners.foreign.exchange import one_line
from bpns.symbolic.planners.protocol import AbstractPlan, Limit, SearchRecord

# A program in a session of its own, watched as in _program.py: unified-planning starts its engines so, and
# nobody would find them when this process is killed.
_SESSION = """
exec 3<&0 </dev/null
"$@" 3<&- &
program=$!
{ read -r line <&3; kill -KILL 0; } >/dev/null 2>&1 &
wait $program
code=$?
kill -KILL $!
exit $code
"""


def main(requests: int, replies: int) -> None:
    """Answer requests until the pipe ends: a new problem, one more plan of the same, or no more of it."""
    for pipe in (requests, replies):
        os.set_inheritable(pipe, False)
    _watch_sessions()
    with (
        os.fdopen(requests, encoding="utf-8") as incoming,
        os.fdopen(replies, "w", encoding="utf-8") as outgoing,
    ):
        record = SearchRecord()
        stream: Iterator[AbstractPlan] = iter(())
        for line in incoming:
            request, plan, failed = json.loads(line), None, False
            try:
                if "leave" in request:
                    if isinstance(stream, Generator):
                        stream.close()
                    stream = iter(())
                if "planner" in request:
                    record = SearchRecord()
                    stream = _opened(request, record)
                plan = next(stream, None)
            except Exception as error:  # of a library that we do not know
                kind = "" if isinstance(error, InputError) else f"{type(error).__name__}: "
                record.stopped_by, record.fault = "planner failed", one_line(f"{kind}{error}")
                failed = True
            steps = None if plan is None else [step.call[1:-1].split() for step in plan.steps]
            outgoing.write(json.dumps({"plan": steps, "failed": failed, "record": asdict(record)}) + "\n")
            outgoing.flush()


def _watch_sessions() -> None:
    """Let every session that a library begins from now on end with this process."""
    begin = subprocess.Popen.__init__
    ours, _held = os.pipe()  # the other end closes with this process

    def watched(self: Any, args: Any, *more: Any, **options: Any) -> None:
        plain = not more and not options.get("shell") and isinstance(args, list | tuple)
        if plain and options.get("start_new_session") and options.get("stdin") is None:
            args = ["/bin/sh", "-c", _SESSION, "sh", *args]
            options["stdin"] = ours
        begin(self, args, *more, **options)

    subprocess.Popen.__init__ = watched  # type: ignore[method-assign]


def _opened(request: dict[str, Any], record: SearchRecord) -> Iterator[AbstractPlan]:
    """Return a planner's plans for a problem."""
    planner = planners.load(request["planner"])
    if not isinstance(planner, Apart):  # it would start a process that starts a process ...
        raise InputError(f"'{planner.name}' is not the name of a planner that runs apart")
    domain = parse_domain(request["domain"])
    problem = ground(domain, parse_problem(request["problem"], domain))
    assert not isinstance(problem, Unreachable)  # it was reachable over there
    seconds = request["seconds"]
    limit = Limit(request["nodes"], None if seconds is None else monotonic() + seconds)
    return planner.planner.plans(problem, np.random.default_rng(request["seed"]), limit, record)
