"""Do two checkouts give the same bytes, and at what cost? Demonstrations, models, PDDL, plans, evaluations.

    git worktree add ../before COMMIT
    python benchmarks/compare_checkouts.py ../before .

Each command runs in both checkouts, one after the other, several times in turns; what differs from run to run
(seconds, versions, paths) is taken out before anything is compared. CPU seconds are the least of the runs.
"""

import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import click

ENVIRONMENTS = ("cover", "doors", "stick_button", "coffee")
TIMES = re.compile(r'"[^"]*seconds": (\{[^}]*\}|[^,}\n]+)')
# An editable installation would find its own checkout, whatever the path says.
START = """
import sys
sys.meta_path = [f for f in sys.meta_path if "editable" not in getattr(f, "__module__", type(f).__module__)]
sys.path.insert(0, sys.argv.pop(1))
import bpns
assert bpns.__file__.startswith(sys.path[0]), bpns.__file__
try:
    from bpns.cli.main import main
except ImportError:  # before the packages had one name
    from bpns import main
main()
"""


def commands(count: int, tasks: int) -> Iterator[tuple[str, list[str]]]:
    """Yield what is run: a name and the words of a command."""
    for name in ENVIRONMENTS:
        yield f"demos {name}", ["demos", name, "--count", str(count), "--seed", "1", "--out", f"{name}.h5"]
        yield f"learn {name}", ["learn", f"{name}.h5", "--out", name]
        yield f"export {name}", ["export", name, "--out", f"{name}-pddl", "--problems", "3"]
        yield f"plan {name}", ["plan", name, "--task", "2", "--json"]
        problem = [f"{name}-pddl/domain.pddl", "--problem", f"{name}-pddl/p01.pddl", "--plans", "50"]
        yield f"abstract plans {name}", ["plan", *problem]
        yield f"evaluate {name}", ["evaluate", name, "--tasks", str(tasks), "--json"]


def run(checkout: Path, folder: Path, words: list[str]) -> tuple[str, float]:
    """Run a command in a folder of its own; return what it printed and its CPU seconds."""
    before = os.times()
    environment = {**os.environ, "PYTHONPATH": "", "PYTHONHASHSEED": "0"}
    done = subprocess.run(
        [sys.executable, "-c", START, str(checkout), *words],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    after = os.times()
    seconds = after.children_user + after.children_system - before.children_user - before.children_system
    if done.returncode not in (0, 12):
        raise click.ClickException(f"{checkout}: bpns {' '.join(words)}: {done.stderr}")
    return TIMES.sub("", re.sub(r"in [0-9.]+ s:", "in s:", done.stdout)), seconds


def contents(folder: Path) -> dict[str, bytes]:
    """Return all files; of run.json only what stays the same."""
    found = {}
    for path in sorted(folder.rglob("*")):
        if path.is_file():
            data = path.read_bytes()
            if path.name == "run.json":
                kept = {k: v for k, v in json.loads(data).items() if "seconds" not in k and k != "command"}
                data = json.dumps(kept).encode()
            found[str(path.relative_to(folder))] = data
    return found


@click.command()
@click.argument("before", type=click.Path(path_type=Path, exists=True))
@click.argument("after", type=click.Path(path_type=Path, exists=True))
@click.option("--count", default=100, show_default=True, help="Demonstrations.")
@click.option("--tasks", default=20, show_default=True, help="Evaluation tasks.")
@click.option("--repeat", default=3, show_default=True)
def main(before: Path, after: Path, count: int, tasks: int, repeat: int) -> None:
    """Compare the checkouts BEFORE and AFTER; exit with 1 where anything differs."""
    different = 0
    totals: dict[str, list[float]] = {}
    click.echo(f"{'':28}{'before':>10}{'after':>10}   CPU seconds, the least of {repeat}")
    with TemporaryDirectory() as one, TemporaryDirectory() as two:
        for name, words in commands(count, tasks):
            printed, seconds = ["", ""], [float("inf")] * 2
            for turn in range(repeat):
                again = (
                    [*words, "--overwrite"] if turn and words[0] in ("demos", "learn", "export") else words
                )
                sides = list(enumerate(((before, one), (after, two))))
                for side, (checkout, folder) in sides[:: 1 if turn % 2 else -1]:
                    printed[side], spent = run(checkout.resolve(), Path(folder), again)
                    seconds[side] = min(seconds[side], spent)
            same = printed[0] == printed[1] and contents(Path(one)) == contents(Path(two))
            different += not same
            for side in range(2):
                totals.setdefault(words[0], [0.0, 0.0])[side] += seconds[side]
            click.echo(f"{name:28}{seconds[0]:10.2f}{seconds[1]:10.2f}   {'same' if same else 'DIFFERENT'}")
    for name, (first, second) in totals.items():
        click.echo(f"all {name:24}{first:10.2f}{second:10.2f}   {100 * (second / first - 1):+.1f} %")
    click.echo(f"{different} differences")
    sys.exit(1 if different else 0)


if __name__ == "__main__":
    main()
