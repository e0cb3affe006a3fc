"""How soon a planner has many abstract plans, and how early they differ.

On tests/data/pddl-bench. Per problem and planner: CPU seconds for reading and grounding, from then to the
first plan and to the last; how many different first three steps there are among the first 8, 30, 100 and all;
the shortest and the longest plan.

With --changing: milliseconds per plan of our own planner, and of the slowest plan, where three random
operators of each plan get another penalty (0, 0.5, 1, 2 or 4: costs rise and fall) before the next.
"""

import argparse
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from random import Random
from time import process_time

import numpy as np

from bpns.symbolic.grounding.ground import GroundProblem, ground
from bpns.symbolic.pddl.read import read_domain, read_problem
from bpns.symbolic.planners.astar import AStar
from bpns.symbolic.planners.costs import Costs
from bpns.symbolic.planners.protocol import AbstractPlan, Limit, SearchRecord
from bpns.symbolic.planners.registry import load

FOLDER = Path(__file__).parents[1] / "tests" / "data" / "pddl-bench"
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


def changing_row(name: str, count: int, seed: int) -> Iterator[str]:
    """Yield a row of the table of --changing."""
    problem, costs, random = read(name), Costs(), Random(seed)
    taken = []
    start = process_time()
    limit = Limit(10**9)
    for plan in islice(
        AStar().plans_at(problem, np.random.default_rng(seed), limit, SearchRecord(), costs), count
    ):
        taken.append(process_time() - start)
        for step in random.sample(plan.steps, min(3, len(plan.steps))):
            costs.set_penalty(step, random.choice([0, 0.5, 1, 2, 4]))
        start = process_time()
    yield from (name, str(len(taken)), f"{1000 * sum(taken) / len(taken):.2f}", f"{1000 * max(taken):.0f}")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("planners", nargs="*", default=["astar"])
    parser.add_argument("--plans", type=int, default=1000)
    parser.add_argument("--problems", nargs="+", default=PROBLEMS)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--changing", action="store_true", help="change costs after each plan")
    arguments = parser.parse_args()
    if arguments.changing:
        print("".join(f"{head:>12}" for head in ("problem", "plans", "ms a plan", "slowest ms")))
        for name in arguments.problems:
            cells = changing_row(name, arguments.plans, arguments.seed)
            print("".join(f"{cell:>12}" for cell in cells), flush=True)
        return
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
