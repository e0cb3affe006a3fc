"""List the approaches."""

import click
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from bpns.learning import approaches

SETTINGS = (  # of 'bpns evaluate' and 'bpns learn', as the paper's tables call them
    ("Samples=1", "evaluate --samples 1", "BPNS with one subgoal per step"),
    ("Abstract Plans=1", "evaluate --plans 1", "BPNS with the first abstract plan alone"),
    ("No filter", "learn --min-share 0", "BPNS with all operators, however rare"),
)


@click.command()
def command() -> None:
    """List the approaches: what each learns, and how it solves tasks; and the paper's other settings."""
    table = Table(box=SIMPLE_HEAD)
    table.add_column("learn --approach", no_wrap=True)
    table.add_column("in tables", no_wrap=True)
    table.add_column("what it is")
    for name in approaches.names():
        approach = approaches.load(name)
        table.add_row(name.replace("_", "-") if approach.learn else "", approach.title, approach.summary)
    table.add_section()
    for title, how, summary in SETTINGS:
        table.add_row("", title, f"{summary}: bpns {how}")
    Console(width=max(120, Console().width), highlight=False, markup=False, emoji=False).print(table)
