"""Variants of the adaptive strategy: what feedback is shared, and how long plans are tried.

Development tasks (seed 50000), which no reported figure uses. Prints solved tasks, abstract plans, samples
and seconds of each variant; ``--model`` plans with a learned model instead of the oracle skills.
"""

import argparse
import time
from dataclasses import replace
from math import inf
from pathlib import Path
from statistics import fmean

from bpns import envs
from bpns.learning.models.load import read_model
from bpns.symbolic import planners
from bpns.symbolic.bilevel.adaptive import Adaptive, adaptive
from bpns.symbolic.bilevel.exhaustive import exhaustive
from bpns.symbolic.bilevel.solve import Plan, solve
from bpns.symbolic.bilevel.strategy import Strategy
from bpns.symbolic.skills.environment import sample_tasks

SEED = 50_000
NAMES = ("stick_button", "stick_button:test_buttons=6", "stick_button:test_buttons=10", "coffee:test_cups=10")


def variants() -> dict[str, Strategy]:
    """Return the strategies that are compared."""
    ours = adaptive.sharing
    return {
        "exhaustive (the paper's)": exhaustive,
        "no feedback": Adaptive(replace(ours, weight=0.0)),
        "feedback per ground operator": Adaptive(replace(ours, prefix=inf, effects=inf)),
        "... and per effect": Adaptive(replace(ours, prefix=inf)),
        "... and per prefix (ours)": adaptive,
        "weight 1": Adaptive(replace(ours, weight=1.0)),
        "weight 4": Adaptive(replace(ours, weight=4.0)),
        "3 failures a visit": replace(adaptive, failures=3),
        "12 failures a visit": replace(adaptive, failures=12),
        "1 try a state": replace(adaptive, tries=1),
        "4 tries a state": replace(adaptive, tries=4),
        "no cost of coming back": replace(adaptive, return_cost=0.0),
        "4 for coming back": replace(adaptive, return_cost=4.0),
    }


def main() -> None:
    """Print a line for each variant and environment."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("environments", nargs="*", default=NAMES)
    parser.add_argument("--model", type=Path)
    parser.add_argument("--tasks", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=5.0, help="for each task")
    arguments = parser.parse_args()
    for name in arguments.environments:
        environment = envs.load(name)
        if arguments.model:
            skills = read_model(arguments.model, environment).skills
        else:
            skills = {skill.operator.name: skill for skill in environment.oracle_skills}
        tasks = sample_tasks(environment, "test", arguments.tasks, SEED)
        print(f"\n{name}, {len(tasks)} tasks{'':22} solved   plans  samples  seconds")
        for label, strategy in variants().items():
            rows = []
            for index, task in enumerate(tasks):
                begin = time.monotonic()
                budget, planner = environment.budget, planners.load("astar")
                seed, deadline = SEED + index + 1, begin + arguments.seconds
                found = solve(environment, task, skills, planner, budget, seed, deadline, strategy)
                if isinstance(found, Plan):
                    effort = found.effort
                    rows.append((effort.abstract_plans, effort.samples, time.monotonic() - begin))
            means = [fmean(column) for column in zip(*rows, strict=True)] or [0.0, 0.0, 0.0]
            numbers = f"{len(rows):8d}{means[0]:8.1f}{means[1]:9.1f}{means[2]:9.3f}"
            print(f"{label:<50}{numbers}", flush=True)


if __name__ == "__main__":
    main()
