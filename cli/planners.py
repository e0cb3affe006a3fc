"""List the planners: what is installed, what each can do, how to install the rest."""

import json
from dataclasses import asdict

import click
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

import bpns
from bpns.cli._options import json_option
from bpns.symbolic.grounding.heuristics import HEURISTICS
from bpns.symbolic.planners.protocol import About


@click.command()
@json_option
def command(as_json: bool) -> None:
    """List the planners: what is installed, what each can do, how to install the rest."""
    listed = bpns.planners()
    if as_json:
        rows = [{**asdict(about), "version": about.version} for about in listed]
        click.echo(json.dumps(rows, indent=2))
        return
    table = Table(box=SIMPLE_HEAD, padding=(0, 2, 0, 0), pad_edge=False)
    for column in ("planner", "version", "gives", "optimal", "proves", "negation", "costs", "licence"):
        table.add_column(column, no_wrap=True)
    for about in listed:
        table.add_row(
            about.name,
            _version(about),
            about.gives,
            *map(_mark, (about.optimal, about.proves, about.negation, about.costs)),
            about.licence,
        )
    Console(width=max(125, Console().width), highlight=False, markup=False, emoji=False).print(table)
    for about in listed:
        if about.note:
            click.echo(f"{about.name}: {about.note}")
    click.echo()
    click.echo("optimal: plans in order of length.  proves: says for certain when there is no plan.")
    click.echo("negation: takes negative conditions itself; for the others they are compiled away.")
    click.echo("costs: takes costs of operators that change while it plans.")
    click.echo(
        "Every planner goes on after its first plan: what it found is forbidden, and it is asked again."
    )
    click.echo(f"astar:HEURISTIC is one of {', '.join(HEURISTICS)}.")
    missing = {about.extra for about in listed if about.version is None}
    if "tamer" in missing:
        click.echo("up:tamer, which is free for education only: pip install 'bpns[tamer]'")
    if extras := sorted(missing - {"tamer"}):
        click.echo(f"To install what is missing: pip install 'bpns[{','.join(extras)}]'")


def _version(about: About) -> str:
    if not about.package:
        return "built in"
    return about.version or f"missing: [{about.extra}]"


def _mark(value: bool) -> str:
    return "yes" if value else "-"
