"""List the planners, and what each can be asked for."""

import click

from symbolic import planners
from symbolic.errors import MissingPackage
from symbolic.heuristics import HEURISTICS


@click.command()
def command() -> None:
    """List the planners, and what each can be asked for."""
    for name in planners.names():
        try:
            default = planners.load(name).name
        except MissingPackage as error:
            click.echo(f"{name:10}  not installed: {error}")
            continue
        click.echo(f"{name:10}  default {default}")
    click.echo(f"astar:HEURISTIC, one of {', '.join(HEURISTICS)}; lmcut keeps plans in order of length")
    click.echo("pyperplan:SEARCH:HEURISTIC, see 'pyperplan --help'; astar:lmcut gives a shortest plan first")
