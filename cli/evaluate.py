"""Solve evaluation tasks and print a table."""

import json
from collections import Counter
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import asdict, replace
from itertools import count
from pathlib import Path

import click

from bpns import __version__
from bpns.cli._options import (
    MAX_SEED,
    PLANNING,
    Subject,
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
    strategy_and_budget,
    strategy_option,
    timeout_option,
)
from bpns.cli._summary import cells, new_table, print_table, summary_json
from bpns.learning.experiments.evaluation import Result, Solver, evaluate, summarize
from bpns.learning.experiments.results import Run, Store, add_result, open_results, read_results
from bpns.learning.models.origin import ORACLE, read_origin
from bpns.symbolic import planners


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
    preset: str,
    strategy: str | None,
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
    chosen: list[Path | None] = [*models]
    subjects = [load_subject(model, oracle, environment) for model in chosen or [None]]
    if len({subject.environment.name for subject in subjects}) > 1:
        raise click.UsageError("the models are of several environments: evaluate them one by one")
    if all(subject.graph is not None for subject in subjects):
        check_unused(PLANNING, f"{subjects[0].label} ({subjects[0].approach}) acts without a planner")
    labels = [subject.label for subject in subjects]
    if len(set(labels)) < len(labels):
        labels = [str(model) for model in models]
    jobs = []
    for model, subject in zip(chosen or [None], subjects, strict=True):
        world = subject.environment
        name, refine, budget = strategy_and_budget(world, preset, strategy, plans, samples, per_plan)
        own = planners.load(planner)
        solver = Solver(world, subject.skills, own, budget, timeout, refine, subject.graph)
        run = _run(subject, model, solver, preset, name, plans, samples)
        jobs.append((solver, run, seeds or [subject.seed]))
    results, found = _evaluate(jobs, tasks, workers, out)
    if as_json:
        rows = [{"model": labels[index], **asdict(result)} for index, result in results]
        how = {"preset": preset, "strategy": name} | ({"found": found} if out else {})
        means = summary_json(summarize(_runs(results)))
        click.echo(json.dumps({**how, "summary": means, "tasks": rows}, indent=2, allow_nan=False))
    else:
        if any(subject.graph is None for subject in subjects):
            click.echo(f"search: preset {preset}, strategy {name}, planner {solver.planner.name}")
        if out:
            click.echo(f"{found} of {len(results)} tasks were in {out} already")
        _print(results, labels)


def _run(
    subject: Subject,
    model: Path | None,
    solver: Solver,
    preset: str,
    strategy: str,
    plans: int | None,
    samples: int | None,
) -> Run:
    """Describe a run for the file: all that decides its results."""
    budget = solver.budget
    exhaustive = strategy == "exhaustive"  # the adaptive search has no limits unless it is given some
    run = Run(
        environment=subject.asked,
        origin=ORACLE if model is None else read_origin(model),
        preset=preset,
        strategy=strategy,
        planner=solver.planner.name,
        plans=budget.abstract_plans if exhaustive else plans,
        samples_per_step=budget.samples_per_step if exhaustive else samples,
        samples_per_plan=budget.samples_per_plan if exhaustive else None,
        sample_limit=budget.samples,
        node_limit=budget.nodes,
        timeout=solver.timeout,
        version=__version__,
    )
    if subject.graph is None:
        return run
    nothing = replace(run, preset="default", strategy=None, planner=None, plans=None)
    return replace(nothing, samples_per_step=None, samples_per_plan=None, sample_limit=None, node_limit=None)


def _evaluate(
    jobs: list[tuple[Solver, Run, list[int]]], tasks: int, workers: int, out: Path | None
) -> tuple[list[tuple[int, Result]], int]:
    """Return the results of each job on its seeds, with the job's number, and how many the file had."""
    results: list[tuple[int, Result]] = []
    found = 0
    total = tasks * sum(len(seeds) for _, _, seeds in jobs)
    with progress_bar("evaluating") as progress, open_results(out, True) if out else nullcontext() as store:
        for index, (solver, run, seeds) in enumerate(jobs):
            known = _known(store, run, seeds, tasks)
            note = _note(store, run, progress, len(results) + len(known), total)
            results += [(index, result) for result in evaluate(solver, seeds, tasks, workers, note, known)]
            found += len(known)
    return results, found


def _known(store: Store | None, run: Run, seeds: list[int], tasks: int) -> dict[tuple[int, int], Result]:
    """Return what the file has of what is asked for, by seed and task."""
    known = {} if store is None else read_results(store, run)
    return {(s, t): result for (s, t), result in known.items() if s in seeds and t < tasks}


def _note(
    store: Store | None, run: Run, progress: Callable[[int, int], None], before: int, total: int
) -> Callable[[Result], None]:
    """Return what is to be done with each new result."""
    numbers = count(before + 1)

    def note(result: Result) -> None:
        if store is not None:
            add_result(store, run, result)
        progress(next(numbers), total)

    return note


def _runs(results: list[tuple[int, Result]]) -> dict[tuple[int, int], list[Result]]:
    """Group results by model (its number on the command line) and seed."""
    runs: dict[tuple[int, int], list[Result]] = {}
    for index, result in results:
        runs.setdefault((index, result.seed), []).append(result)
    return runs


def _print(results: list[tuple[int, Result]], labels: list[str]) -> None:
    """Print one row per model and seed, their mean, and why tasks were not solved."""
    table = new_table(("model",), ("seed", "tasks"))
    runs = _runs(results)
    for (index, seed), rows in runs.items():
        table.add_row(
            labels[index], str(seed), str(len(rows)), *cells(summarize({0: rows}), deviations=False)
        )
    if len(runs) > 1:
        table.add_section()
        table.add_row("mean (std)", "", str(len(results)), *cells(summarize(runs), deviations=True))
    print_table(table)
    for remark, times in Counter(remark for _, result in results for remark in result.remarks).most_common():
        click.echo(f"the planner in {times} tasks: {remark}")
    for index, result in results:
        if not result.executed:
            click.echo(f"not solved: {labels[index]}, seed {result.seed}, task {result.task}: {result.fault}")
            for end, times in result.dead_ends[:3]:
                click.echo(f"  {times} x plan {end.plan}, step {end.step} {end.operator}: {end.reason}")
