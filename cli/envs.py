"""List the environments."""

import click

import envs


@click.command()
def command() -> None:
    """List the environments: types, predicates, budgets."""
    for name in envs.names():
        environment = envs.load(name)
        click.echo(name)
        types = (f"{t.name}({', '.join(t.features)})" for t in environment.types)
        click.echo(f"  types:      {', '.join(types)}")
        click.echo(f"  predicates: {', '.join(p.signature for p in environment.classifiers)}")
        click.echo(f"  goals:      {', '.join(sorted(p.name for p in environment.goal_predicates))}")
        budget = environment.budget
        click.echo(
            f"  budget:     {budget.abstract_plans} abstract plans, "
            f"{budget.samples_per_step} samples per step, {environment.horizon} actions"
        )
