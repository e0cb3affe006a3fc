"""Print a model's operators as text."""

import json
from pathlib import Path

import click

from cli._options import json_option, load_subject, oracle_option
from symbolic.describe import operator_text, operators_json


@click.command()
@click.argument("model", type=click.Path(path_type=Path), required=False)
@oracle_option
@json_option
def command(model: Path | None, oracle: str | None, as_json: bool) -> None:
    """Print the operators of MODEL, in the notation of the paper's figure 10."""
    operators = [skill.operator for skill in load_subject(model, oracle).skills.values()]
    if as_json:
        click.echo(json.dumps(operators_json(operators), indent=2))
    else:
        click.echo("\n\n".join(map(operator_text, operators)))
