"""Solve evaluation tasks and print a table."""

import json
from collections import Counter
from collections.abc import Callable
from dataclasses import asdict
from functools import partial
from math import isnan
from pathlib import Path

import click
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from cli._options import (
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
    strategy_and_budget,
    strategy_option,
    timeout_option,
)
from learning.evaluation import Result, Solver, Summary, evaluate, summarize
from symbolic import planners


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
    preset: str,
    strategy: str | None,
    timeout: float | None,
    workers: int,
    as_json: bool,
) -> None:
    """Evaluate MODELS of one environment on its evaluation tasks: planned, refined, executed.

    Means over models and seeds with the population standard deviation. Times are wall clock per solved
    task: for figures that you report, use one worker, which is the default.
    """
    if bool(models) == (oracle is not None):
        raise click.UsageError("give MODEL folders or --oracle ENVIRONMENT (one of them)")
    chosen: list[Path | None] = [*models]
    subjects = [load_subject(model, oracle, environment) for model in chosen or [None]]
    if len({subject.environment.name for subject in subjects}) > 1:
        raise click.UsageError("the models are of several environments: evaluate them one by one")
    work = [(subject, seeds or [subject.seed]) for subject in subjects]
    labels = [subject.label for subject in subjects]
    if len(set(labels)) < len(labels):
        labels = [str(model) for model in models]
    results: list[tuple[int, Result]] = []  # with the number of the subject
    total = tasks * sum(len(own) for _, own in work)
    with progress_bar("evaluating") as progress:
        for index, (subject, own) in enumerate(work):
            world = subject.environment
            name, refine, budget = strategy_and_budget(world, preset, strategy, plans, samples, per_plan)
            solver = Solver(world, subject.skills, planners.load(planner), budget, timeout, refine)
            note = partial(_note, progress, len(results), total)
            found = evaluate(solver, own, tasks, workers, note)
            results += [(index, result) for result in found]
    summary = summarize(_runs(results))
    if as_json:
        rows = [{"model": labels[index], **asdict(result)} for index, result in results]
        means = {
            key: None if isnan(mean) else {"mean": mean, "std": std}  # nan: no task to average over
            for key, (mean, std) in asdict(summary).items()
        }
        how = {"preset": preset, "strategy": name}
        click.echo(json.dumps({**how, "summary": means, "tasks": rows}, indent=2, allow_nan=False))
    else:
        click.echo(f"search: preset {preset}, strategy {name}, planner {solver.planner.name}")
        _print(results, labels, summary)


def _note(progress: Callable[[int, int], None], before: int, total: int, done: int) -> None:
    progress(before + done, total)


def _runs(results: list[tuple[int, Result]]) -> dict[tuple[int, int], list[Result]]:
    """Group results by model (its number on the command line) and seed."""
    runs: dict[tuple[int, int], list[Result]] = {}
    for index, result in results:
        runs.setdefault((index, result.seed), []).append(result)
    return runs


def _print(results: list[tuple[int, Result]], labels: list[str], summary: Summary) -> None:
    """Print one row per model and seed, their mean, and why tasks were not solved."""
    table = Table(box=SIMPLE_HEAD)
    table.add_column("model", no_wrap=True)
    for column in (
        "seed",
        "tasks",
        "planned %",
        "refined %",
        "solved %",
        "nodes",
        "plans",
        "samples",
        "time s",
    ):
        table.add_column(column, justify="right", no_wrap=True)
    runs = _runs(results)
    for (index, seed), rows in runs.items():
        cells = [_number(mean, d) for (mean, _), d in _columns(summarize({0: rows}))]
        table.add_row(labels[index], str(seed), str(len(rows)), *cells)
    if len(runs) > 1:
        cells = [f"{_number(mean, d)} ({_number(std, d)})" for (mean, std), d in _columns(summary)]
        table.add_section()
        table.add_row("mean (std)", "", str(len(results)), *cells)
    Console(width=max(160, Console().width), highlight=False, markup=False, emoji=False).print(table)
    for remark, count in Counter(remark for _, result in results for remark in result.remarks).most_common():
        click.echo(f"the planner in {count} tasks: {remark}")
    for index, result in results:
        if not result.executed:
            click.echo(f"not solved: {labels[index]}, seed {result.seed}, task {result.task}: {result.fault}")
            for end, count in result.dead_ends[:3]:
                click.echo(f"  {count} x plan {end.plan}, step {end.step} {end.operator}: {end.reason}")


def _number(value: float, decimals: int) -> str:
    """Write a number; a dash where there was no task to average over."""
    return "-" if isnan(value) else f"{value:.{decimals}f}"


def _columns(summary: Summary) -> list[tuple[tuple[float, float], int]]:
    """Return the numbers of a row with their decimals."""
    return [
        (summary.planned, 1),
        (summary.refined, 1),
        (summary.solved, 1),
        (summary.nodes_created, 2),
        (summary.abstract_plans, 2),
        (summary.samples, 1),
        (summary.seconds, 4),
    ]
