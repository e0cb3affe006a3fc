"""Make demonstrations with an environment's oracle skills."""

import sys
from pathlib import Path

import click

import bpns
from bpns.cli._options import MAX_SEED, NOT_REFINED, overwrite_option, progress_bar, workers_option
from bpns.symbolic.files import check_output


@click.command()
@click.argument("environment")
@click.option("--count", type=click.IntRange(1), default=1000, show_default=True, help="Train tasks.")
@click.option("--seed", type=click.IntRange(0, MAX_SEED), default=0, show_default=True)
@click.option("--out", type=click.Path(path_type=Path), help="HDF5 file (default: ENVIRONMENT-SEED.h5).")
@workers_option
@overwrite_option
def command(environment: str, count: int, seed: int, out: Path | None, workers: int, overwrite: bool) -> None:
    """Solve train tasks of ENVIRONMENT with its oracle skills and keep the trajectories."""
    world = bpns.load_environment(environment)
    out = out or Path(f"{world.name}-{seed}.h5")
    check_output(out, overwrite)
    with progress_bar("demonstrating") as progress:
        data = bpns.collect(world, count, seed, workers, progress)
    if not data.demonstrations:
        click.echo(f"no demonstration of {count} tasks, nothing written; the first: {data.failures[0][1]}")
        sys.exit(NOT_REFINED)
    bpns.write_demonstrations(out, data, world, overwrite=True)
    actions = sum(len(d.trajectory.actions) for d in data.demonstrations)
    click.echo(f"{len(data.demonstrations)} demonstrations of {count} tasks, {actions} actions: {out}")
    reasons: dict[str, list[int]] = {}
    for index, reason in data.failures:
        reasons.setdefault(reason, []).append(index)
    for reason, tasks in reasons.items():
        shown = ", ".join(map(str, tasks[:10])) + (", ..." if len(tasks) > 10 else "")
        click.echo(f"  {len(tasks)} gave none: {reason} (tasks {shown})")
