"""What several subcommands share: options, loading what they name, progress."""

import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from math import inf
from pathlib import Path

import click
from click.core import ParameterSource
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from bpns import envs
from bpns.learning.graphs.reactive import GraphModel
from bpns.learning.models.saved import read_model, read_model_file
from bpns.symbolic.bilevel.adaptive import adaptive
from bpns.symbolic.bilevel.exhaustive import exhaustive
from bpns.symbolic.bilevel.strategy import Strategy
from bpns.symbolic.skills.environment import Budget, Environment
from bpns.symbolic.skills.skill import Skill

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


@dataclass(frozen=True, slots=True)
class Subject:
    """Skills to plan with, and where they are from."""

    label: str
    approach: str  # 'oracle', or what a model's skills.json says
    asked: str  # how the environment was asked for: its name, with options, or MODULE:ATTRIBUTE
    environment: Environment
    skills: Mapping[str, Skill]
    seed: int
    graph: GraphModel | None = None  # acts in place of a planner


def load_subject(model: Path | None, oracle: str | None, variant: str | None = None) -> Subject:
    """Return a model's skills or an environment's own; exactly one must be named.

    ``variant`` is an environment for the model in place of the one that it was learned in.
    """
    if oracle is not None and variant is not None:
        raise click.UsageError("--environment goes with a MODEL: give --oracle the variant itself")
    if (model is None) == (oracle is None):
        raise click.UsageError("give a MODEL folder or --oracle ENVIRONMENT (one of them)")
    if model is None:
        assert oracle is not None
        environment = envs.load(oracle)
        skills = {skill.operator.name: skill for skill in environment.oracle_skills}
        return Subject(f"oracle:{oracle}", "oracle", oracle, environment, skills, 0)
    file = read_model_file(model)
    asked = variant or file.load
    environment = envs.load(asked)
    saved = read_model(model, environment)
    label = model.name or str(model)
    label = f"{label} in {variant}" if variant else label
    return Subject(label, file.approach, asked, environment, saved.skills, saved.seed, saved.graph)


def strategy_and_budget(
    environment: Environment,
    preset: str,
    strategy: str | None,
    plans: int | None,
    samples: int | None,
    per_plan: int | None,
) -> tuple[str, Strategy, Budget]:
    """Return how to search, by name and in fact, and how much, with the user's numbers in it."""
    budget = environment.budget
    if preset == "paper" and strategy == "adaptive":
        raise click.UsageError("--preset paper searches exhaustively: leave it or --strategy adaptive out")
    name = strategy or ("adaptive" if preset == "default" else "exhaustive")
    if name == "adaptive":
        if per_plan:
            raise click.UsageError("--samples-per-plan goes with --strategy exhaustive")
        return name, replace(adaptive, plans=plans, samples=samples), budget
    own = replace(
        budget,
        abstract_plans=plans or budget.abstract_plans,
        samples_per_step=samples or budget.samples_per_step,
        samples_per_plan=per_plan or budget.samples_per_plan,
    )
    return name, exhaustive, own


@contextmanager
def progress_bar(what: str) -> Iterator[Callable[[int, int], None]]:
    """Show a bar on standard error where that is a terminal; give a function of (done, total)."""
    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as progress:
        task = progress.add_task(what, total=None)
        yield lambda done, total: progress.update(task, completed=done, total=total)
