"""Both presets, learned and oracle skills, all environments, beside the paper's numbers: docs/benchmark.md.

Calls the program as a user would, and keeps what each call printed: what is in the output folder already is
not run again. Learning and evaluation use one process: CPU seconds and planning times are all there is.
"""

import argparse
import json
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean, median, pstdev
from typing import Any

import numpy as np
from _commit import commit

from bpns.symbolic.files import write_json, write_text

TASKS = 50
PARTS = ("own", "larger", "few")
LARGER = {"stick_button": "stick_button:test_buttons=10", "coffee": "coffee:test_cups=10"}
# Table 3 of the paper's appendix: solved %, seconds, nodes created; learned and oracle skills.
PAPER = {
    ("cover", "learned"): (99.4, 2.02, 7.15),
    ("cover", "oracle"): (98.8, 0.03, 7.01),
    ("doors", "learned"): (98.8, 1.33, 41.94),
    ("doors", "oracle"): (100.0, 1.04, 84.12),
    ("stick_button", "learned"): (83.6, 51.80, 421.51),
    ("stick_button", "oracle"): (90.4, 0.18, 320.32),
    ("coffee", "learned"): (98.0, 49.39, 53.68),
    ("coffee", "oracle"): (100.0, 0.07, 67.25),
}


@dataclass(frozen=True, slots=True)
class Run:
    """One evaluation: a row of the table once its seeds are put together."""

    environment: str
    skills: str  # learned or oracle
    preset: str
    variant: str = ""  # another environment for the tasks
    count: int = 1000  # demonstrations asked for

    def title(self) -> str:
        """Return the row's name."""
        told = self.variant or self.environment
        return told if self.count == 1000 else f"{told}, {self.count} demonstrations"

    def file(self, seed: int) -> str:
        """Return the name of the file with one seed's results."""
        tasks = (self.variant or self.environment).replace(":", "-")
        return f"{tasks}-{self.skills}-{self.preset}-{self.count}-{seed}.json"


def bpns(*words: str | Path) -> str:
    """Run a command of the program and return what it printed."""
    command = [sys.executable, "-m", "bpns", *map(str, words)]
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


def model(out: Path, environment: str, preset: str, count: int, seed: int) -> Path:
    """Return a model's folder, and make it where it is not there."""
    demos = out / f"{environment}-{count}-{seed}.h5"
    folder = out / f"{environment}-{preset}-{count}-{seed}"
    if not demos.exists():
        bpns("demos", environment, "--count", str(count), "--seed", str(seed), "--out", demos)
    if not folder.exists():
        bpns("learn", demos, "--preset", preset, "--out", folder)
    return folder


def results(out: Path, run: Run, seed: int) -> dict[str, Any]:
    """Return what ``bpns evaluate`` says of one seed, and how long learning took."""
    path = out / run.file(seed)
    if not path.exists():
        limits = ["--preset", run.preset, "--tasks", str(TASKS), "--seeds", str(seed), "--json"]
        seconds = None
        if run.skills == "oracle":
            printed = bpns("evaluate", "--oracle", run.variant or run.environment, *limits)
        else:
            folder = model(out, run.environment, run.preset, run.count, seed)
            variant = ["--environment", run.variant] if run.variant else []
            printed = bpns("evaluate", folder, *variant, *limits)
            seconds = json.loads((folder / "run.json").read_text(encoding="utf-8"))["cpu_seconds"]
        write_json(path, {**json.loads(printed), "learning": seconds})
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return found


def runs(environments: Sequence[str], presets: Sequence[str], parts: Sequence[str]) -> Iterator[Run]:
    """Yield all runs, the most important first."""
    for preset in presets if "own" in parts else ():
        for skills in ("oracle", "learned"):
            for environment in environments:
                yield Run(environment, skills, preset)
    for environment in environments if "larger" in parts else ():
        for skills in ("oracle", "learned") if environment in LARGER else ():
            yield Run(environment, skills, "default", LARGER[environment])
    for environment in environments if "few" in parts else ():
        yield Run(environment, "learned", "default", count=50)


def row(run: Run, found: Sequence[dict[str, Any]]) -> list[str]:
    """Return a line of the table: means over seeds; seconds over all solved tasks."""
    tasks = [task for one in found for task in one["tasks"]]
    solved = [task for task in tasks if task["executed"]]
    shares = [100 * fmean(task["executed"] for task in one["tasks"]) for one in found]
    seconds = [task["planning_seconds"] + task["policy_seconds"] for task in solved]
    paper = PAPER.get((run.environment, run.skills)) if not run.variant and run.count == 1000 else None
    times = [fmean(seconds), median(seconds), float(np.percentile(seconds, 95))] if seconds else []
    learning = [one["learning"] for one in found if one["learning"] is not None]
    return [
        run.title(),
        run.skills,
        str(len(found)),
        f"{fmean(shares):.1f} ({pstdev(shares):.1f})",
        f"{paper[0]:.1f}" if paper else "",
        *([f"{time:.3f}" for time in times] or ["", "", ""]),
        f"{paper[1]:.2f}" if paper else "",
        *(
            f"{fmean(t[key] for t in solved):.1f}" if solved else ""
            for key in ("nodes_created", "abstract_plans", "samples")
        ),
        f"{paper[2]:.1f}" if paper else "",
        f"{fmean(learning):.1f}" if learning else "",
    ]


HEADER = [
    "tasks",
    "skills",
    "seeds",
    "solved % (std)",
    "paper",
    "mean s",
    "median s",
    "95 % s",
    "paper",
    "nodes",
    "plans",
    "samples",
    "paper's nodes",
    "learning CPU s",
]


def markdown(lines: Sequence[Sequence[str]]) -> str:
    """Return a table."""
    rule = ["---"] * 2 + ["---:"] * (len(lines[0]) - 2)
    return "".join(f"| {' | '.join(cells)} |\n" for cells in (lines[0], rule, *lines[1:]))


def plot(found: dict[Run, list[dict[str, Any]]], path: Path) -> None:
    """Draw success over planning time, as the paper's figure 5, for the environments' own tasks."""
    from matplotlib.figure import Figure

    environments = list(dict.fromkeys(run.environment for run in found))
    figure = Figure(figsize=(3.4 * len(environments), 3.2), layout="constrained")
    axes = figure.subplots(1, len(environments), sharey=True, squeeze=False)[0]
    for axis, environment in zip(axes, environments, strict=True):
        for run, seeds in found.items():
            if run.environment != environment or run.variant or run.count != 1000:
                continue
            tasks = [task for one in seeds for task in one["tasks"]]
            times = sorted(t["planning_seconds"] + t["policy_seconds"] for t in tasks if t["executed"])
            share = 100 * np.arange(1, len(times) + 1) / len(tasks)
            style = "-" if run.preset == "default" else "--"
            color = "tab:blue" if run.skills == "learned" else "tab:orange"
            axis.step(
                [*times, 100],
                [*share, share[-1] if len(share) else 0],
                style,
                color=color,
                where="post",
                label=f"{run.skills}, {run.preset}",
            )
        for skills, color in (("learned", "tab:blue"), ("oracle", "tab:orange")):
            solved, seconds, _ = PAPER[environment, skills]
            axis.plot([seconds], [solved], "o", color=color, label=f"{skills}, the paper's mean")
        axis.set(xscale="log", xlim=(5e-4, 100), ylim=(0, 102), title=environment, xlabel="planning time, s")
        axis.grid(alpha=0.3)
    axes[0].set_ylabel("tasks solved, %")
    axes[-1].legend(fontsize="x-small", loc="lower right")
    figure.savefig(path, dpi=110)


def unsolved(found: dict[Run, list[dict[str, Any]]]) -> str:
    """Return a line for each task that was not solved with the default preset."""
    lines = [
        f"* {run.title()}, {run.skills} skills, seed {task['seed']}, task {task['task']}: {task['fault']}\n"
        for run, seeds in found.items()
        if run.preset == "default"
        for one in seeds
        for task in one["tasks"]
        if not task["executed"]
    ]
    return "".join(lines) or "None.\n"


def main() -> None:
    """Run what is not there yet; write the tables and the plot."""
    parser = argparse.ArgumentParser(description=__doc__)
    names = sorted({environment for environment, _ in PAPER})
    parser.add_argument(
        "environments", nargs="*", choices=[*names, []], metavar="ENVIRONMENT", help="(default: all)"
    )
    parser.add_argument("--out", type=Path, default=Path("runs/benchmark"), help="what was run is kept here")
    parser.add_argument("--presets", nargs="+", choices=["default", "paper"], default=["default", "paper"])
    parser.add_argument(
        "--parts",
        nargs="+",
        choices=PARTS,
        default=PARTS,
        help="the environments' own tasks; with ten buttons or cups; with 50 demonstrations",
    )
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2, 3, 4])
    parser.add_argument(
        "--paper-seeds", type=int, nargs="+", default=[0], help="for its learned skills: minutes each"
    )
    parser.add_argument("--docs", type=Path, default=Path("docs"), help="where benchmark.md and .png go")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    found: dict[Run, list[dict[str, Any]]] = {}
    for run in runs(arguments.environments or names, arguments.presets, arguments.parts):
        slow = run.preset == "paper" and run.skills == "learned"
        seeds = arguments.paper_seeds if slow else arguments.seeds
        found[run] = [results(arguments.out, run, seed) for seed in seeds]
        print(" | ".join(row(run, found[run])), flush=True)
    made = f"Made by `{' '.join(['python', *sys.argv])}` at commit {commit()}"
    text = f"# Benchmark\n\n{made}, {TASKS} tasks a seed.\n"
    for preset in arguments.presets:
        lines = [row(run, seeds) for run, seeds in found.items() if run.preset == preset]
        text += f"\n## Preset {preset}\n\n{markdown([HEADER, *lines])}"
    text += "\n![Success over planning time](benchmark.png)\n\n"
    text += f"## Tasks that were not solved with the default preset\n\n{unsolved(found)}"
    plot(found, arguments.docs / "benchmark.png")
    write_text(arguments.docs / "benchmark.md", text)


if __name__ == "__main__":
    main()
