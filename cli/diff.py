"""Compare two PDDL domains, whatever their operators are called."""

import json
import sys
from pathlib import Path

import click

import bpns
from bpns.cli._options import json_option
from bpns.symbolic.compare.difference_text import difference_json, difference_text


@click.command()
@click.argument("before", type=click.Path(path_type=Path))
@click.argument("after", type=click.Path(path_type=Path))
@json_option
def command(before: Path, after: Path, as_json: bool) -> None:
    """Say what differs between the domains BEFORE and AFTER: files, or folders (of a model, or exported).

    Operators and parameters are matched by what they say: neither their names nor their order count.
    Types, predicates and constants count as they are called; PDDL ignores case. What '-' marks is only in
    BEFORE and in its words, what '+' marks only in AFTER. Exits with 1 where anything differs.
    """
    difference = bpns.diff(before, after)
    if as_json:
        click.echo(json.dumps(difference_json(difference), indent=2))
    else:
        click.echo(difference_text(difference))
    sys.exit(0 if difference.same else 1)
