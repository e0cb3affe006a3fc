"""astar and pyperplan on real PDDL: shortest length, seconds, and the first plans checked independently.

Every problem of pddl_out/ and, where they are there, of ../shared/pddl and ../shared/pddl-bench. For each,
both planners get the time limit; astar goes on to 100 plans, which must be in order of length, distinct, and
valid for kairos (and for our own validator). Prints one row per problem; exits with 1 on any disagreement.
"""

import argparse
import sys
import warnings
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from time import monotonic

import kairos
import numpy as np

from symbolic import planners
from symbolic.errors import InputError
from symbolic.grounding import GroundProblem, Unreachable, ground
from symbolic.pddl.read import read_domain, read_problem
from symbolic.planners import AbstractPlan, Limit, SearchRecord
from symbolic.validate import first_fault

ROOT = Path(__file__).parents[1]


def problems() -> Iterator[tuple[Path, Path]]:
    """Yield domain and problem files."""
    for path in sorted(ROOT.glob("pddl_out/*/p*.pddl")):
        yield path.parent / "domain.pddl", path
    shared = ROOT.parent / "shared"
    for path in sorted(shared.glob("pddl-bench/*.pddl")):
        if "domain" not in path.name:
            for domain in shared.glob("pddl-bench/*-domain.pddl"):
                if domain.name.split("-")[0] == path.name.split("-")[0]:
                    yield domain, path
    for path in sorted(shared.glob("pddl/*/task*.pddl")):
        own = path.parent / path.name.replace("task", "domain")
        yield (own if own.exists() else path.parent / "domain.pddl"), path


def run(
    name: str, problem: GroundProblem, count: int, seconds: float
) -> tuple[list[AbstractPlan], float, str]:
    """Return the first plans, the seconds to the first one, and what stopped the search."""
    start, record = monotonic(), SearchRecord()
    stream = planners.load(name).plans(
        problem, np.random.default_rng(0), Limit(10**9, start + seconds), record
    )
    found, first = [], 0.0
    for plan in islice(stream, count):
        first = first or monotonic() - start
        found.append(plan)
    return found, first, record.stopped_by


def faults(plans: list[AbstractPlan], problem: GroundProblem, files: tuple[Path, Path]) -> Iterator[str]:
    """Yield what is wrong with a planner's plans."""
    lengths = [len(plan.steps) for plan in plans]
    if lengths != sorted(lengths):
        yield "not in order of length"
    if len({plan.steps for plan in plans}) < len(plans):
        yield "a plan twice"
    domain_file, problem_file = files
    parsed = kairos.load_problem(problem_file, kairos.load_domain(domain_file))
    for plan in plans:
        fault = first_fault(problem.problem, plan.steps)
        text = "\n".join(_call(plan)) + "\n"
        if fault or not kairos.validate(parsed, kairos.parse_plan(text)).valid:
            yield f"invalid plan: {fault or text}"
            return


def _call(plan: AbstractPlan) -> list[str]:
    return [f"({' '.join([s.operator.name, *(o.name for o in s.objects)])})" for s in plan.steps]


def main() -> None:
    """Compare and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=30)
    parser.add_argument("--plans", type=int, default=100)
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    compared = wrong = 0
    print(f"{'problem':28}{'ground':>8}{'astar':>7}{'s':>8}{'plans':>7}{'pyperplan':>11}{'s':>8}")
    for domain_path, path in problems():
        label = f"{path.parent.name}/{path.stem}"
        try:
            domain = read_domain(domain_path)
            problem = ground(domain, read_problem(path, domain))
        except InputError as error:
            print(f"{label:28}{str(error).split(':', 3)[-1].strip()}")
            continue
        if isinstance(problem, Unreachable):
            print(f"{label:28}{problem}")
            continue
        plans, first, stopped = run("astar", problem, arguments.plans, arguments.seconds)
        others, other_first, other_stopped = run("pyperplan", problem, 1, arguments.seconds)
        remarks = list(faults(plans, problem, (domain_path, path)))
        remarks += list(faults(others, problem, (domain_path, path)))
        lengths = [str(len(found[0].steps)) if found else "-" for found in (plans, others)]
        if plans and others:
            compared += 1
            if lengths[0] != lengths[1]:
                remarks.append("lengths differ")
        wrong += bool(remarks)
        print(
            f"{label:28}{len(problem.operators):8}{lengths[0]:>7}{first:8.2f}{len(plans):7}"
            f"{lengths[1]:>11}{other_first:8.2f}  {stopped or other_stopped} {'; '.join(remarks)}",
            flush=True,
        )
    print(f"{compared} problems solved by both, {wrong} with a fault")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
