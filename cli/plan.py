"""Plan for one task or PDDL problem; show the result."""

import json
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import click
from click.core import ParameterSource

import bpns
from bpns.cli._options import (
    MAX_SEED,
    NO_PLAN,
    NOT_REFINED,
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
from bpns.cli._plan_text import exit_code, outcome_json, outcome_text, print_plans
from bpns.model import Model
from bpns.symbolic import planners
from bpns.symbolic.files import check_output
from bpns.symbolic.planners.protocol import Planner
from bpns.symbolic.planners.streams import loopless
from bpns.symbolic.state import Task
from bpns.world import World

COMPARED_PLANS = 10


@click.command()
@click.argument("model", type=click.Path(path_type=Path), required=False)
@oracle_option
@environment_option
@click.option("--task", type=click.IntRange(0), help="Number of the evaluation task (default: 0).")
@click.option("--goal", help="A goal of your own, such as 'Covers(block0, target1), HandEmpty()'.")
@click.option("--init", type=click.Path(path_type=Path), help="With --goal: a state, see 'bpns envs state'.")
@click.option("--problem", type=click.Path(path_type=Path), help="A PDDL problem: abstract plans only.")
@click.option("--seed", type=click.IntRange(0, MAX_SEED), help="Of tasks and planner (default: the model's).")
@planner_option
@click.option(
    "--compare",
    multiple=True,
    metavar="NAMES",
    help="A table of several planners, with commas between (or 'all'), instead of --planner.",
)
@click.option("--no-loops", is_flag=True, help="Only abstract plans that visit no abstract state twice.")
@plans_option
@samples_option
@per_plan_option
@preset_option
@strategy_option
@timeout_option
@click.option("--show", type=click.Path(path_type=Path), help="Write an animation: .gif, .webp or .png.")
@json_option
def command(**options: Any) -> None:
    """Plan with MODEL (a model folder, or with --problem also a domain.pddl).

    With --task, or with a --goal of your own, the plan is refined in the simulator and carried out. With
    --problem up to --plans abstract plans (default 1) are printed, as a plan file. --compare prints seconds
    to the first plan and to --plans plans (default 10) of several planners. Exits with 11 if no plan exists,
    12 if none was refined within the limits, 32 if the planner failed.
    """
    asked = _Asked(**options)
    chosen = click.get_current_context().get_parameter_source("planner") is ParameterSource.COMMANDLINE
    if asked.compare and (asked.show is not None or asked.no_loops or chosen):
        raise click.UsageError("--compare goes with none of --planner, --show and --no-loops")
    if asked.problem is not None:
        _plan_problem(asked, asked.problem)
    else:
        _plan_task(asked)


@dataclass(frozen=True, slots=True)
class _Asked:
    """The options as they were given."""

    model: Path | None
    oracle: str | None
    environment: str | None
    task: int | None
    goal: str | None
    init: Path | None
    problem: Path | None
    seed: int | None
    planner: str
    compare: tuple[str, ...]
    no_loops: bool
    plans: int | None
    samples: int | None
    per_plan: int | None
    preset: Literal["default", "paper"]
    strategy: Literal["adaptive", "exhaustive"] | None
    timeout: float | None
    show: Path | None
    as_json: bool

    @property
    def names(self) -> list[str]:
        """The planners to compare; a command may have commas in it."""
        parts = ([text] if text.startswith("command:") else text.split(",") for text in self.compare)
        return [name for part in parts for name in part]


def _plan_problem(asked: _Asked, problem: Path) -> None:
    """Print abstract plans for a PDDL problem, or compare planners on it."""
    refining = asked.samples or asked.per_plan or asked.strategy or asked.preset != "default"
    if asked.task is not None or asked.goal or asked.init or asked.show is not None or refining:
        raise click.UsageError(
            "--task, --goal, --init, --show, --preset, --strategy, --samples and --samples-per-plan need a "
            "task: leave --problem out"
        )
    domain: Path | Model
    if asked.model is not None and asked.oracle is None and not asked.model.is_dir():
        if asked.environment is not None:
            raise click.UsageError("--environment goes with a model folder, not with a domain file")
        domain = asked.model
    else:
        domain = load_subject(asked.model, asked.oracle, asked.environment)
    if asked.compare:
        _compare(asked, domain, problem, asked.seed or 0, bpns.SearchSettings())
        return
    plans = bpns.abstract_plans(
        domain, problem, asked.planner, asked.seed or 0, asked.timeout, not asked.no_loops
    )
    print_plans(plans, asked.plans or 1, asked.as_json)


def _plan_task(asked: _Asked) -> None:
    """Plan for a task and carry the plan out, or compare planners on it."""
    if asked.model is not None and asked.model.suffix == ".pddl":
        raise click.UsageError("a domain file has no skills: give --problem too, or a model folder")
    if asked.init is not None and asked.goal is None:
        raise click.UsageError("--init goes with --goal: say what is to be reached")
    if asked.init is not None and asked.task is not None:
        raise click.UsageError("--init is in place of a --task: leave one of them out")
    model = load_subject(asked.model, asked.oracle, asked.environment)
    if model.graph is not None:
        check_unused(PLANNING, f"{model.label} ({model.approach}) acts without a planner")
    if asked.show is not None:
        from bpns.envs.animation import animation_format  # Pillow is slow to import

        animation_format(asked.show)
        check_output(asked.show, overwrite=True)
    seed, number = model.seed if asked.seed is None else asked.seed, asked.task or 0
    task, title = _task(asked, model.world, number, seed)
    search = search_settings(
        asked.preset, asked.strategy, None if asked.compare else asked.plans, asked.samples, asked.per_plan
    )
    if asked.compare:
        _compare(asked, model, task, seed + number + 1, search)
        return
    planner: str | Planner = loopless(planners.load(asked.planner)) if asked.no_loops else asked.planner
    outcome = model.plan(task, planner, asked.timeout, search, seed + number + 1)
    if asked.as_json:
        click.echo(json.dumps(outcome_json(outcome), indent=2))
    else:
        click.echo(outcome_text(outcome, title, model.approach))
    if asked.show is not None and outcome.execution is None:
        click.echo(f"no animation, as there is no plan: {asked.show} is not written", err=True)
    elif asked.show is not None:
        bpns.animate(asked.show, model.world, outcome)
        click.echo(f"animation: {asked.show}", err=asked.as_json)
    sys.exit(exit_code(outcome))


def _task(asked: _Asked, world: World, number: int, seed: int) -> tuple[Task, str]:
    """Return what is to be solved, and what to call it."""
    if asked.init is not None and asked.goal is not None:
        return world.own_task(asked.goal, asked.init), f"{asked.init} in {world.asked}"
    task, title = world.task("test", number, seed), f"task {number} of seed {seed} in {world.asked}"
    if asked.goal is None:
        return task, title
    return world.own_task(asked.goal, task.init), f"initial state of {title}"


def _compare(
    asked: _Asked, domain: Path | Model, problem: Path | Task, seed: int, search: bpns.SearchSettings
) -> None:
    """Print a row for each planner."""
    with progress_bar("comparing") as progress:
        table = bpns.compare_planners(
            asked.names,
            domain,
            problem,
            asked.plans or COMPARED_PLANS,
            seed,
            asked.timeout,
            search,
            progress,
        )
    if not table.rows:
        click.echo(table.why)
        sys.exit(NOT_REFINED if table.late else NO_PLAN)
    click.echo(json.dumps(table.rows, indent=2) if asked.as_json else table)
