"""What several subcommands share: options, loading what they name, progress."""

import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from math import inf
from pathlib import Path
from typing import Literal

import click
from click.core import ParameterSource
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

import bpns
from bpns.model import Model
from bpns.symbolic.bilevel.settings import SearchSettings
from bpns.symbolic.errors import InputError

MAX_SEED = 2**31 - 1
NO_PLAN, NOT_REFINED, PLANNER_FAILED = 11, 12, 32  # exit codes; as in Fast Downward where it has them

planner_option = click.option(
    "--planner", default="astar", show_default=True, help="See 'bpns planners'; options after colons."
)
plans_option = click.option(
    "--plans",
    type=click.IntRange(1),
    help="Abstract plans to try (default: no limit; exhaustive: the environment's).",
)
samples_option = click.option(
    "--samples",
    type=click.IntRange(1),
    help="Subgoals to try per step (default: no limit; exhaustive: the environment's). Give --timeout, too.",
)
per_plan_option = click.option(
    "--samples-per-plan",
    "per_plan",
    type=click.IntRange(1),
    help="With --strategy exhaustive: samples after which a plan is given up (default: the environment's).",
)
preset_option = click.option(
    "--preset",
    type=click.Choice(["default", "paper"]),
    default="default",
    show_default=True,
    help="Our search or the paper's; see --strategy.",
)
strategy_option = click.option(
    "--strategy",
    type=click.Choice(["adaptive", "exhaustive"]),
    help="How abstract plans are refined (default: adaptive; with --preset paper exhaustive, one by one).",
)


def _seconds(_: click.Context, __: click.Parameter, value: float | None) -> float | None:
    if value is not None and not 0 < value < inf:
        raise click.BadParameter("give a positive number of seconds")
    return value


timeout_option = click.option("--timeout", type=float, callback=_seconds, help="Seconds per task.")
oracle_option = click.option(
    "--oracle", metavar="ENVIRONMENT", help="Use this environment's own skills, no model."
)
environment_option = click.option(
    "--environment",
    metavar="NAME",
    help="Instead of the model's own: a variant such as stick_button:test_buttons=10.",
)
overwrite_option = click.option("--overwrite", is_flag=True, help="Replace what is there.")
json_option = click.option("--json", "as_json", is_flag=True, help="Print JSON.")
workers_option = click.option(
    "--workers",
    type=click.IntRange(1),
    default=os.cpu_count() or 1,
    show_default="all cores",
    help="Processes; they change the time, not the result.",
)


PLANNING = ("planner", "plans", "samples", "per_plan", "preset", "strategy", "compare", "no_loops")


def check_unused(names: Iterable[str], why: str) -> None:
    """Raise UsageError where an option was given that means nothing here."""
    context = click.get_current_context()
    options = {option.name: option.opts[0] for option in context.command.params}
    for name in names:
        if context.get_parameter_source(name) is ParameterSource.COMMANDLINE:
            raise click.UsageError(f"{why}: leave {options[name]} out")


def load_subject(folder: Path | None, oracle: str | None, variant: str | None = None) -> Model:
    """Return the model in a folder, or an environment's own skills; exactly one must be named.

    ``variant`` is an environment for the model in place of the one that it was learned in.
    """
    if oracle is not None and variant is not None:
        raise click.UsageError("--environment goes with a MODEL: give --oracle the variant itself")
    if (folder is None) == (oracle is None):
        raise click.UsageError("give a MODEL folder or --oracle ENVIRONMENT (one of them)")
    if folder is not None:
        return bpns.load_model(folder, variant)
    assert oracle is not None
    return bpns.oracle(bpns.load_environment(oracle))


def search_settings(
    preset: Literal["default", "paper"],
    strategy: Literal["adaptive", "exhaustive"] | None,
    plans: int | None,
    samples: int | None,
    per_plan: int | None,
) -> SearchSettings:
    """Return how to search; raise UsageError where options contradict each other."""
    try:
        return SearchSettings(preset, strategy, plans, samples, per_plan)
    except InputError as error:
        raise click.UsageError(str(error)) from error


@contextmanager
def progress_bar(what: str) -> Iterator[Callable[[int, int], None]]:
    """Show a bar on standard error where that is a terminal; give a function of (done, total)."""
    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as progress:
        task = progress.add_task(what, total=None)
        yield lambda done, total: progress.update(task, completed=done, total=total)
