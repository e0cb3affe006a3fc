"""The README's table: learn from 1000 demonstrations, evaluate on 50 tasks, for each environment and seed.

Calls the program as a user would; learning runs in one process so that its CPU time is all of it. What is
already in the output folder is not made again.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path

import envs


def bpns(*words: str | Path) -> None:
    """Run a command of the program."""
    subprocess.run([sys.executable, "-m", "bpns", *map(str, words)], check=True)


def measure(environment: str, out: Path, seeds: list[int], count: int, full: bool) -> None:
    """Make demonstrations and models of one environment and print its figures."""
    models = []
    for seed in seeds:
        demos, model = out / f"{environment}-{seed}.h5", out / f"{environment}-{seed}"
        models.append(model)
        if not demos.exists():
            bpns("demos", environment, "--count", str(count), "--seed", str(seed), "--out", demos)
        if not model.exists():
            bpns("learn", demos, "--out", model, *(["--full"] if full else []))
    print(f"\n== {environment}\nlearning, CPU seconds:")
    for model in models:
        run = json.loads((model / "run.json").read_text(encoding="utf-8"))
        print(
            f"  {model.name}: {run['cpu_seconds']:.1f} CPU, {run['seconds']:.1f} wall, "
            f"from {run['demonstrations']['given']} demonstrations",
            flush=True,
        )
    bpns("evaluate", *models, "--tasks", "50")
    bpns("evaluate", "--oracle", environment, "--tasks", "50", "--seeds", ",".join(map(str, seeds)))


def main() -> None:
    """Run everything that is not there yet and print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("environments", nargs="*", metavar="ENVIRONMENT", help="(default: all)")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2])
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--full", action="store_true", help="the paper's training")
    arguments = parser.parse_args()
    for environment in arguments.environments or envs.names():
        measure(environment, arguments.out, arguments.seeds, arguments.count, arguments.full)


if __name__ == "__main__":
    main()
