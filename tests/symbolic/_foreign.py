"""A small task and planners for it that misbehave, as scripts."""

import os
import shlex
import time
from contextlib import suppress
from pathlib import Path

from bpns.symbolic.grounding.ground import GroundProblem
from bpns.symbolic.pddl.read import parse_domain, parse_problem
from bpns.symbolic.planners.protocol import Limit
from tests.symbolic._planning import grounded

WALK = parse_domain("""
(define (domain walk) (:requirements :strips :typing)
  (:types place)
  (:predicates (at ?p - place) (road ?a ?b - place) (rested))
  (:action walk :parameters (?a ?b - place) :precondition (and (at ?a) (road ?a ?b))
    :effect (and (at ?b) (not (at ?a))))
  (:action rest :parameters () :precondition (and) :effect (and (rested)))
  (:action wait :parameters (?a - place) :precondition (and (at ?a)) :effect (and (at ?a))))
""")


def walk(goal: str = "c") -> GroundProblem:
    """From a to the goal: a square a, b, c, d of roads in both directions."""
    roads = " ".join(f"(road {a} {b})" for a, b in ("ab", "ba", "bc", "cb", "cd", "dc", "da", "ad"))
    text = f"(define (problem p) (:domain walk) (:objects a b c d e - place) (:init (at a) {roads})"
    return grounded(WALK, parse_problem(f"{text} (:goal (at {goal})))", WALK))


GOOD = "(walk a b)\n(walk b c)\n"  # one of the two shortest plans to c
OTHER = "(walk a d)\n(walk d c)\n"


MARK = f"71.{os.getpid()}"  # seconds that nobody else sleeps


def script(folder: Path, text: str) -> str:
    """Write a shell script; return it as a command planner. ``$plan`` is its plan file."""
    path = folder / "planner.sh"
    path.write_text(
        f"#!/bin/sh\ndomain=$1 problem=$2 plan=$3\n{text.replace('MARK', MARK)}\n", encoding="utf-8"
    )
    path.chmod(0o755)
    return f"command:{shlex.quote(str(path))} {{domain}} {{problem}} {{plan}}"


def seconds(count: float) -> Limit:
    return Limit(1_000_000, time.monotonic() + count)


def alive(mark: str) -> list[int]:
    """Return the processes that have a word in their command lines; zombies have none."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdecimal() and int(entry.name) != os.getpid():
            try:
                words = (entry / "cmdline").read_bytes().split(b"\0")
            except OSError:
                continue
            if mark.encode() in words:
                found.append(int(entry.name))
    return found


def zombies() -> list[str]:
    """Return the children of this process that have ended and that nobody waited for."""
    found = []
    for entry in Path("/proc").iterdir():
        with suppress(OSError):
            name, _, rest = (entry / "stat").read_text().rpartition(")")
            if rest.split()[:2] == ["Z", str(os.getpid())]:
                found.append(name)
    return found


def there(mark: str, within: float = 20.0) -> bool:
    """Say whether a process with that word is there, or comes soon."""
    end = time.monotonic() + within
    while not alive(mark) and time.monotonic() < end:
        time.sleep(0.02)
    return bool(alive(mark))


def gone(mark: str, within: float = 10.0) -> bool:
    """Say whether no process with that word is left, at the latest after some seconds."""
    end = time.monotonic() + within
    while alive(mark):
        if time.monotonic() > end:
            return False
        time.sleep(0.02)
    return True
