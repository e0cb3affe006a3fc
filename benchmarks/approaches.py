"""All approaches, variants and ablations of the paper, into one file of results: docs/approaches.md.

Calls the program as a user would. Models are kept, and results are in a file to which several processes may
add at once: what is there is not run again, so that this can be stopped and started, or be run for several
environments side by side.
"""

import argparse
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmark import bpns

from bpns.symbolic.files import write_text

ENVIRONMENTS = ("cover", "stick_button", "coffee", "doors")
GRAPHS = ("gnn-meta", "gnn-meta-no-subgoal", "gnn-bc")
TRAINING_COUNTS = {"stick_button": "stick_button:test_buttons=1,2", "coffee": "coffee:test_cups=1,2"}
PARTS = ("planning", "graphs", "counts", "pass-through", "filter")
SECONDS = "5"  # for a task: ours needs a hundredth of that


@dataclass(frozen=True, slots=True)
class Model:
    """What to learn."""

    environment: str
    approach: str = "bpns"
    preset: str = "default"
    options: tuple[str, ...] = ()


def work(environments: Sequence[str], parts: Sequence[str]) -> Iterator[tuple[Model, list[str]]]:
    """Yield models, and options of their evaluation."""
    limit = ["--timeout", SECONDS]
    for name in environments if "planning" in parts else ():
        for approach in ("bpns", "no-subgoal"):
            yield Model(name, approach), limit
        yield Model(name), [*limit, "--samples", "1"]
        yield Model(name), [*limit, "--plans", "1"]
    for name in environments if "graphs" in parts else ():
        for approach in GRAPHS:
            yield Model(name, approach), limit
    for name in environments if "counts" in parts else ():
        if name in TRAINING_COUNTS:
            yield Model(name, "gnn-meta"), [*limit, "--environment", TRAINING_COUNTS[name]]
    if "pass-through" in parts and "cover" in environments:
        for approach in ("bpns", "pass-through"):
            yield Model("cover", approach, "paper"), ["--preset", "paper"]
    if "filter" in parts and "stick_button" in environments:
        for options in ((), ("--min-share", "0")):
            yield Model("stick_button", preset="paper", options=options), ["--preset", "paper"]


def learned(out: Path, model: Model, seed: int) -> Path:
    """Return a model's folder; make it where it is not there, and the demonstrations too."""
    demos = out / f"{model.environment}-1000-{seed}.h5"
    name = "-".join((model.environment, model.approach, model.preset, *model.options, str(seed)))
    folder = out / name.replace("---", "-").replace("--", "-")
    if not demos.exists():
        bpns("demos", model.environment, "--count", "1000", "--seed", str(seed), "--out", demos)
    if not folder.exists():
        how = ["--approach", model.approach, "--preset", model.preset, *model.options, "--device", "cpu"]
        bpns("learn", demos, *how, "--out", folder)
    return folder


def main() -> None:
    """Run what is not there yet, seed by seed, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("environments", nargs="*", metavar="ENVIRONMENT", help="(default: all)")
    parser.add_argument("--out", type=Path, default=Path("runs/approaches"), help="models and results")
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2])
    parser.add_argument("--parts", nargs="+", choices=PARTS, default=PARTS)
    parser.add_argument("--tasks", default="50")
    parser.add_argument("--docs", type=Path, help="folder for approaches.md, with whatever is there so far")
    arguments = parser.parse_args()
    results = arguments.out / "results.sqlite"
    arguments.out.mkdir(parents=True, exist_ok=True)
    for seed in arguments.seeds:
        for model, options in work(arguments.environments or ENVIRONMENTS, arguments.parts):
            folder = learned(arguments.out, model, seed)
            bpns("evaluate", folder, *options, "--tasks", arguments.tasks, "--out", results)
            print(seed, model, *options, flush=True)
    if arguments.docs:
        command = [sys.executable, "-m", "bpns", "results", str(results)]
        printed = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
        made = "python benchmarks/approaches.py"
        text = f"# Approaches\n\nMade by `{made}`, then `bpns results`.\n\n```\n{printed.rstrip()}\n```\n"
        write_text(arguments.docs / "approaches.md", text)


if __name__ == "__main__":
    main()
