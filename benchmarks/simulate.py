"""Steps per second of each environment's ``simulate``, on the states and actions of oracle demonstrations."""

import argparse
from time import perf_counter

from bpns import envs
from bpns.learning.data.demonstrations import Demonstration, demonstrate
from bpns.symbolic.skills.environment import sample_tasks


def main() -> None:
    """Measure each environment and print one row for it: the median of some rounds over all steps."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("environments", nargs="*", metavar="ENVIRONMENT", help="(default: all)")
    parser.add_argument("--tasks", type=int, default=30)
    parser.add_argument("--rounds", type=int, default=15)
    arguments = parser.parse_args()
    for name in arguments.environments or envs.names():
        environment = envs.load(name)
        tasks = enumerate(sample_tasks(environment, "train", arguments.tasks, 0))
        made = [demonstrate(environment, 0, task) for task in tasks]
        steps = [
            pair
            for d in made
            if isinstance(d, Demonstration)
            for pair in zip(d.trajectory.states, d.trajectory.actions, strict=False)
        ]
        rounds = []
        for _ in range(arguments.rounds):
            start = perf_counter()
            for state, action in steps:
                environment.simulate(state, action)
            rounds.append(perf_counter() - start)
        speed = len(steps) / sorted(rounds)[len(rounds) // 2]
        print(f"{name:28}{len(steps):7} steps {speed:12,.0f} steps/s", flush=True)


if __name__ == "__main__":
    main()
