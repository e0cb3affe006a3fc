"""The README's table: learn Cover from 1000 demonstrations for five seeds, evaluate on 50 tasks each.

Calls the program as a user would; learning runs in one process so that its CPU time is all of it.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path


def main() -> None:
    """Run everything that is not there yet and print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2, 3, 4])
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--full", action="store_true", help="the paper's training")
    arguments = parser.parse_args()

    def bpns(*words: str | Path) -> None:
        subprocess.run([sys.executable, "-m", "bpns", *map(str, words)], check=True)

    models = []
    for seed in arguments.seeds:
        demos, model = arguments.out / f"demos-{seed}.h5", arguments.out / f"model-{seed}"
        models.append(model)
        if not demos.exists():
            bpns("demos", "cover", "--count", arguments.count, "--seed", seed, "--out", demos)
        if not model.exists():
            bpns("learn", demos, "--out", model, *(["--full"] if arguments.full else []))
    print("learning, CPU seconds:")
    for model in models:
        run = json.loads((model / "run.json").read_text(encoding="utf-8"))
        print(f"  {model.name}: {run['cpu_seconds']:.1f} CPU, {run['seconds']:.1f} wall")
    bpns("evaluate", *models, "--tasks", "50")
    bpns("evaluate", "--oracle", "cover", "--tasks", "50", "--seeds", ",".join(map(str, arguments.seeds)))


if __name__ == "__main__":
    main()
