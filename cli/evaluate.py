"""Solve evaluation tasks and print a table."""

import json
from pathlib import Path
from typing import Literal

import click

import bpns
from bpns.cli._options import (
    MAX_SEED,
    PLANNING,
    check_unused,
    environment_option,
    json_option,
    load_subject,
    oracle_option,
    per_plan_option,
    planner_option,
    plans_option,
    preset_option,
    progress_bar,
    samples_option,
    search_settings,
    strategy_option,
    timeout_option,
)
from bpns.learning.experiments.summary_text import summary_json


def _seeds(_: click.Context, __: click.Parameter, value: str | None) -> list[int] | None:
    """Read ``0-4`` or ``0,2,5-7``."""
    if value is None:
        return None
    try:
        parts = [part.partition("-") for part in value.split(",")]
        seeds = [s for low, dash, high in parts for s in range(int(low), int(high if dash else low) + 1)]
    except ValueError as error:
        raise click.BadParameter("give numbers and ranges such as 0-4 or 0,2,5-7") from error
    if not seeds:
        raise click.BadParameter("no seed in this range")
    if not 0 <= min(seeds) <= max(seeds) <= MAX_SEED:
        raise click.BadParameter(f"seeds are from 0 to {MAX_SEED}")
    return sorted(set(seeds))


@click.command()
@click.argument("models", nargs=-1, type=click.Path(path_type=Path))
@oracle_option
@environment_option
@click.option("--tasks", type=click.IntRange(1), default=50, show_default=True, help="Per seed.")
@click.option("--seeds", callback=_seeds, help="Such as 0-4 (default: each model on its own seed).")
@planner_option
@plans_option
@samples_option
@per_plan_option
@preset_option
@strategy_option
@timeout_option
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    help="Add each result to this file (SQLite) when it is there; do not run again what it has.",
)
@click.option("--workers", type=click.IntRange(1), default=1, show_default=True, help="Processes.")
@json_option
def command(
    models: tuple[Path, ...],
    oracle: str | None,
    environment: str | None,
    tasks: int,
    seeds: list[int] | None,
    planner: str,
    plans: int | None,
    samples: int | None,
    per_plan: int | None,
    preset: Literal["default", "paper"],
    strategy: Literal["adaptive", "exhaustive"] | None,
    timeout: float | None,
    out: Path | None,
    workers: int,
    as_json: bool,
) -> None:
    """Evaluate MODELS of one environment on its evaluation tasks: planned, refined, executed.

    Means over models and seeds with the population standard deviation. Times are wall clock per solved
    task: for figures that you report, use one worker, which is the default. 'bpns results' prints tables of
    what one or many evaluations added to one file.
    """
    if bool(models) == (oracle is not None):
        raise click.UsageError("give MODEL folders or --oracle ENVIRONMENT (one of them)")
    subjects = [load_subject(folder, oracle, environment) for folder in models or (None,)]
    if len({subject.world.name for subject in subjects}) > 1:
        raise click.UsageError("the models are of several environments: evaluate them one by one")
    if all(subject.graph is not None for subject in subjects):
        check_unused(PLANNING, f"{subjects[0].label} ({subjects[0].approach}) acts without a planner")
    search = search_settings(preset, strategy, plans, samples, per_plan)
    with progress_bar("evaluating") as progress:
        table = bpns.evaluate(subjects, tasks, seeds, planner, timeout, search, out, workers, progress)
    if as_json:
        how = {"preset": preset, "strategy": search.name} | ({"found": table.found} if out else {})
        said = {**how, "summary": summary_json(table.summary), "tasks": table.rows}
        click.echo(json.dumps(said, indent=2, allow_nan=False))
        return
    if any(subject.graph is None for subject in subjects):
        click.echo(f"search: preset {preset}, strategy {search.name}, planner {table.planner}")
    if out:
        click.echo(f"{table.found} of {len(table)} tasks were in {out} already")
    click.echo(table)
