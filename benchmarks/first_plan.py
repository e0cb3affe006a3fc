"""Seconds to ground a problem and to find its first abstract plan, with the number of nodes it took.

Takes environments, whose first evaluation tasks it plans for with the oracle's operators, and PDDL problem
files, or folders with all that is below them: ``doors:rows=10:columns=10 pddl_out``. A PDDL problem's domain
file is the one of its folder that fits its name best: ``domain.pddl``, or ``domain01.pddl`` for
``task01.pddl``, or ``doors-domain.pddl`` for ``doors-100.pddl``.

With --repeat, PDDL problems are read, grounded and planned for so many times in this process, and the median
milliseconds of all that are printed instead.
"""

import argparse
import sys
from collections.abc import Iterator, Sequence
from itertools import chain
from pathlib import Path
from statistics import median
from time import monotonic

import numpy as np

from bpns import envs
from bpns.symbolic import planners
from bpns.symbolic.errors import InputError
from bpns.symbolic.grounding.ground import GroundProblem, Unreachable, ground
from bpns.symbolic.operators import Domain, Problem
from bpns.symbolic.pddl.read import read_domain, read_problem
from bpns.symbolic.planners.protocol import Limit, SearchRecord
from bpns.symbolic.skills.environment import domain_of as environment_domain
from bpns.symbolic.skills.environment import problem_of, sample_tasks


def domain_of(path: Path) -> Path | None:
    """Return the domain file next to a problem file."""
    choices = (
        path.with_name(path.name.replace("task", "domain")),
        path.with_name(f"{path.stem.rpartition('-')[0]}-domain.pddl"),
        path.with_name("domain.pddl"),
    )
    return next((file for file in choices if file != path and file.exists()), None)


def pddl_tasks(given: Path) -> Iterator[tuple[str, Domain, Problem]]:
    """Yield a label, domain and problem for a PDDL problem, or for all in a folder."""
    for path in sorted(given.rglob("*.pddl")) if given.is_dir() else [given]:
        label = f"{path.parent.name}/{path.stem}"
        domain_file = None if "domain" in path.name else domain_of(path)
        if domain_file is None:
            continue
        try:
            domain = read_domain(domain_file)
            yield label, domain, read_problem(path, domain)
        except InputError as error:
            print(f"{label:34}{str(error).split(':', 3)[-1].strip()}")


def environment_tasks(name: str, count: int) -> Iterator[tuple[str, Domain, Problem]]:
    """Yield a label, domain and problem for each of an environment's first evaluation tasks of seed 0."""
    environment = envs.load(name)
    domain = environment_domain(environment, (skill.operator for skill in environment.oracle_skills))
    for number, task in enumerate(sample_tasks(environment, "test", count, 0)):
        yield f"{name} {number}", domain, problem_of(environment, task)


def first_plan(
    name: str, problem: GroundProblem, count: int, seconds: float
) -> tuple[list[int], float, float, SearchRecord, int]:
    """Return the plans' lengths, seconds to the first and to all, the record, and nodes up to the first."""
    record = SearchRecord()
    start = monotonic()
    limit = Limit(10**9, start + seconds)
    lengths: list[int] = []
    first, nodes = 0.0, 0
    for plan in planners.load(name).plans(problem, np.random.default_rng(0), limit, record):
        if not lengths:
            first, nodes = monotonic() - start, record.nodes_created
        lengths.append(len(plan.steps))
        if len(lengths) == count:
            break
    total = monotonic() - start
    return lengths, first if lengths else total, total, record, nodes or record.nodes_created


def repeated(given: Sequence[str], name: str, times: int, allowed: float | None) -> None:
    """Print each PDDL problem's median milliseconds from its files to the first plan; exit."""
    planner = planners.load(name)
    medians = []
    for path in chain.from_iterable(
        Path(g).rglob("*.pddl") if Path(g).is_dir() else [Path(g)] for g in given
    ):
        domain_file = None if "domain" in path.name else domain_of(path)
        if domain_file is None:
            continue
        taken = []
        for _ in range(times + 1):
            start = monotonic()
            domain = read_domain(domain_file)
            problem = ground(domain, read_problem(path, domain))
            if isinstance(problem, GroundProblem):
                next(planner.plans(problem, np.random.default_rng(0), Limit(10**9), SearchRecord()), None)
            taken.append(1000 * (monotonic() - start))
        medians.append(median(taken[1:]))  # the first one imports things
        print(f"{path.parent.name}/{path.stem:20}{medians[-1]:9.2f} ms", flush=True)
    print(f"{len(medians)} problems: median {median(medians):.2f} ms, longest {max(medians):.2f} ms")
    sys.exit(1 if allowed is not None and median(medians) > 1000 * allowed else 0)


def main() -> None:
    """Measure and print one row per problem; exit with 1 where a first plan took longer than allowed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", nargs="+", help="environments, PDDL problem files, folders of these")
    parser.add_argument("--tasks", type=int, default=10, help="of each environment")
    parser.add_argument("--planner", default="astar")
    parser.add_argument("--plans", type=int, default=1, help="how many plans to take (lengths are printed)")
    parser.add_argument("--seconds", type=float, default=30, help="when to give up on a problem")
    parser.add_argument("--allowed", type=float, help="most seconds for grounding and the first plan")
    parser.add_argument("--repeat", type=int, help="read, ground and plan so many times; PDDL files only")
    arguments = parser.parse_args()
    if arguments.repeat:
        repeated(arguments.what, arguments.planner, arguments.repeat, arguments.allowed)
    slow = 0
    print(f"{'problem':34}{'ground':>8}{'s':>8}{'steps':>7}{'nodes':>9}{'first s':>9}{'all s':>8}")
    tasks = chain.from_iterable(
        pddl_tasks(Path(what)) if Path(what).exists() else environment_tasks(what, arguments.tasks)
        for what in arguments.what
    )
    for label, domain, problem in tasks:
        start = monotonic()
        found = ground(domain, problem)
        grounding = monotonic() - start
        if isinstance(found, Unreachable):
            print(f"{label:34}{found}")
            continue
        lengths, first, total, record, nodes = first_plan(
            arguments.planner, found, arguments.plans, arguments.seconds
        )
        slow += arguments.allowed is not None and grounding + first > arguments.allowed
        counts = {n: lengths.count(n) for n in sorted(set(lengths))}
        tail = f"  {record.stopped_by}" + (f"  {counts}" if arguments.plans > 1 else "")
        print(
            f"{label:34}{len(found.operators):8}{grounding:8.3f}{lengths[0] if lengths else '-':>7}"
            f"{nodes:9}{first:9.3f}{total:8.2f}{tail}",
            flush=True,
        )
    sys.exit(1 if slow else 0)


if __name__ == "__main__":
    main()
