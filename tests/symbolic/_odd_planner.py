"""A planner in a process apart that misbehaves as it is told: ``tests.symbolic._odd_planner:create:WHAT``."""

import ctypes
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from bpns.symbolic.grounding.ground import GroundProblem
from bpns.symbolic.planners.foreign.apart import Apart
from bpns.symbolic.planners.protocol import About, AbstractPlan, Limit, SearchRecord

FIRST, SECOND = [("a", "b"), ("b", "c")], [("a", "d"), ("d", "c")]


@dataclass(frozen=True, slots=True)
class Odd:
    """It behaves where the goal is d; elsewhere it gives one plan and then misbehaves."""

    what: str

    @property
    def name(self) -> str:
        return f"tests.symbolic._odd_planner:create:{self.what}"

    def plans(
        self, problem: GroundProblem, rng: np.random.Generator, limit: Limit, record: SearchRecord
    ) -> Iterator[AbstractPlan]:
        walks = {tuple(o.name for o in g.objects): g for g in problem.operators}

        def plan(*edges: tuple[str, str]) -> AbstractPlan:
            return AbstractPlan.follow(problem, [walks[edge] for edge in edges])

        mark = f"71.{os.getppid()}"  # the caller's; see _foreign.py
        record.remarks.append(f"process {os.getpid()}")
        if "(d)" in "".join(map(str, problem.problem.goal)):
            yield plan(("a", "d"))
            return
        if not self.what.startswith("early"):
            yield plan(*FIRST)
        match self.what.removeprefix("early-"):
            case "prints":
                print("(walk a b)\n" * 100_000, flush=True)
                os.write(2, b"\xff\x00" * 100_000)
                yield plan(*SECOND)
            case "raises":
                raise RuntimeError("out of\n luck")
            case "exits":
                print("so long")
                sys.exit(3)
            case "ends":
                os._exit(0)
            case "crashes":
                ctypes.string_at(0)
            case "sleeps":
                time.sleep(70)
            case "starts":  # as unified-planning starts its engines
                command = ["sh", "-c", f"trap '' TERM; echo up; sleep {mark}; sleep {mark}"]
                child = subprocess.Popen(command, start_new_session=True, stdout=subprocess.PIPE)
                try:
                    child.communicate()
                finally:
                    child.kill()
            case "streams":
                with subprocess.Popen(["sleep", mark]) as child:
                    try:
                        yield plan(*SECOND)
                    finally:
                        child.kill()
            case "cheats":
                yield plan(("a", "b"))
            case "shortens":
                yield plan(("a", "b"), ("b", "a"), *FIRST)
                yield plan(*SECOND)
            case "limits":
                record.stopped_by = "node limit" if limit.nodes == 7 else "?"


def create(what: str) -> Apart:
    """Return the planner."""
    return Apart(Odd(what), About("odd", "stream", optimal=True, negation=True, equality=True))
