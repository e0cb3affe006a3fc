"""How soon a planner has many abstract plans, and how early they differ.

On ../shared/pddl-bench. Per problem and planner: CPU seconds for reading and grounding, from then to the
first plan and to the last; how many different first three steps there are among the first 8, 30, 100 and all;
the shortest and the longest plan.
"""

import argparse
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from time import process_time

import numpy as np

from symbolic.grounding import GroundProblem, ground
from symbolic.pddl.read import read_domain, read_problem
from symbolic.planners import AbstractPlan, Limit, SearchRecord, load

FOLDER = Path(__file__).parents[2] / "shared" / "pddl-bench"
PROBLEMS = ("stick-10", "stick-15", "doors-20", "cover-6", "coffee-4", "doors-100")


def read(name: str) -> GroundProblem:
    """Read and ground a problem; its domain is named after its first word."""
    domain = read_domain(FOLDER / f"{name.split('-')[0]}-domain.pddl")
    problem = ground(domain, read_problem(FOLDER / f"{name}.pddl", domain))
    assert isinstance(problem, GroundProblem), str(problem)
    return problem


def row(name: str, planner: str, count: int, seed: int) -> Iterator[str]:
    """Yield a table's row, cell by cell."""
    start = process_time()
    problem = read(name)
    grounded = process_time()
    stream = load(planner).plans(problem, np.random.default_rng(seed), Limit(10**9), SearchRecord())
    found: list[AbstractPlan] = list(islice(stream, 1))
    first = process_time()
    found += islice(stream, count - 1)
    last = process_time()
    yield from (name, planner, f"{grounded - start:.3f}", f"{first - grounded:.3f}", f"{last - grounded:.3f}")
    yield str(len(found))
    for some in (8, 30, 100, count):
        yield str(len({plan.steps[:3] for plan in found[:some]}))
    yield f"{len(found[0].steps)}-{max(len(plan.steps) for plan in found)}" if found else "-"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("planners", nargs="*", default=["astar"])
    parser.add_argument("--plans", type=int, default=1000)
    parser.add_argument("--problems", nargs="+", default=PROBLEMS)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    heads = (
        "problem",
        "planner",
        "ground s",
        "first s",
        "all s",
        "plans",
        "of 8",
        "30",
        "100",
        "all",
        "steps",
    )
    print("".join(f"{head:>12}" for head in heads))
    for name in arguments.problems:
        for planner in arguments.planners:
            cells = row(name, planner, arguments.plans, arguments.seed)
            print("".join(f"{cell:>12}" for cell in cells), flush=True)


if __name__ == "__main__":
    main()
