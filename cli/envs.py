"""List the environments, or check one."""

import json
import sys
from collections import Counter
from dataclasses import asdict, fields, is_dataclass

import click

from bpns import envs
from bpns.cli._options import MAX_SEED, json_option
from bpns.symbolic.environment_check import check


@click.group(invoke_without_command=True)
@click.pass_context
def command(context: click.Context) -> None:
    """List the environments: types, predicates, budgets."""
    if context.invoked_subcommand is not None:
        return
    for name in envs.names():
        environment = envs.load(name)
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
    for finding in check(envs.find(name), tasks, seed):
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
