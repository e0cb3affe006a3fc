"""List the environments, check one, begin one of your own."""

import json
import sys
from collections import Counter
from dataclasses import asdict, fields, is_dataclass
from pathlib import Path

import click

import bpns
from bpns.cli._options import MAX_SEED, json_option, overwrite_option
from bpns.symbolic.files import check_output, replacing
from bpns.symbolic.skills.own_task import state_json
from bpns.symbolic.structs import sort_atoms


@click.group(invoke_without_command=True)
@click.pass_context
def command(context: click.Context) -> None:
    """List the environments: types, predicates, budgets."""
    if context.invoked_subcommand is not None:
        return
    for name in bpns.environments():
        environment = bpns.load_environment(name).environment
        click.echo(name)
        types = (f"{t.name}({', '.join(t.features)})" for t in environment.types)
        click.echo(f"  types:      {', '.join(types)}")
        click.echo(f"  predicates: {', '.join(p.signature for p in environment.classifiers)}")
        click.echo(f"  goals:      {', '.join(sorted(p.name for p in environment.goal_predicates))}")
        if is_dataclass(environment):
            options = (f"{f.name}={getattr(environment, f.name)}" for f in fields(environment))
            click.echo(f"  options:    {', '.join(options)}")
        budget = environment.budget
        click.echo(
            f"  budget:     {budget.abstract_plans} abstract plans, "
            f"{budget.samples_per_step} samples per step, {budget.samples_per_plan} per plan, "
            f"{environment.horizon} actions"
        )


@command.command("check")
@click.argument("name", metavar="NAME")
@click.option("--tasks", type=click.IntRange(1), default=5, show_default=True, help="Of each split.")
@click.option("--seed", type=click.IntRange(0, MAX_SEED), default=0, show_default=True)
@json_option
def check_command(name: str, tasks: int, seed: int, as_json: bool) -> None:
    """Check an environment, a shipped one or MODULE:ATTRIBUTE, and say what is missing or wrong.

    Exits with 1 where there are faults.
    """
    levels: Counter[str] = Counter()
    found = []
    for finding in bpns.check_environment(name, tasks, seed):
        levels[finding.level] += 1
        found.append(asdict(finding))
        if not as_json:
            level = finding.level.upper() if finding.level == "fault" else finding.level
            click.echo(f"{level:9}{finding.check}: {finding.text}")
    if as_json:
        click.echo(json.dumps({"faults": levels["fault"], "findings": found}, indent=2))
    else:
        counts = (f"{levels[level]} {level}" for level in ("ok", "fault", "warning", "skipped"))
        click.echo(f"{name}: {', '.join(counts)}")
    sys.exit(1 if levels["fault"] else 0)


@command.command("new")
@click.argument("name")
@click.option("--out", type=click.Path(path_type=Path), help="Python file (default: NAME.py).")
@overwrite_option
def new_command(name: str, out: Path | None, overwrite: bool) -> None:
    """Write a commented environment to begin with: a small world that works, to be changed step by step."""
    path = out or Path(f"{name}.py")
    bpns.new_environment(name, path, overwrite)
    module = path.with_suffix("").name
    click.echo(f"{path}: now 'bpns envs check {module}:ENVIRONMENT', then 'bpns demos {module}:ENVIRONMENT'")


@command.command("state")
@click.argument("name", metavar="NAME")
@click.option("--task", type=click.IntRange(0), default=0, show_default=True, help="Evaluation task.")
@click.option("--seed", type=click.IntRange(0, MAX_SEED), default=0, show_default=True)
@click.option("--out", type=click.Path(path_type=Path), help="JSON file (default: printed).")
@click.option("--picture", type=click.Path(path_type=Path), help="Also draw it: .png.")
@overwrite_option
def state_command(
    name: str, task: int, seed: int, out: Path | None, picture: Path | None, overwrite: bool
) -> None:
    """Write the initial state of a task, to be edited and given to 'bpns plan --goal GOAL --init FILE'."""
    world = bpns.load_environment(name)
    chosen = world.task("test", task, seed)
    if picture is not None:
        check_output(picture, overwrite)
        with replacing(picture) as temporary:
            world.draw(chosen.init, chosen.goal).save(temporary, "PNG")
    if out is None:
        click.echo(json.dumps(state_json(chosen.init), indent=2))
    else:
        bpns.write_state(out, chosen.init, overwrite)
        click.echo(f"{out}: {', '.join(map(str, sort_atoms(chosen.goal)))} is the task's own goal")
