"""Print a model's operators as text, or draw which enable which."""

import json
from pathlib import Path

import click

from bpns.cli._options import json_option, load_subject, oracle_option, overwrite_option
from bpns.symbolic.compare.description import operator_markdown, operators_json
from bpns.symbolic.files import check_output
from bpns.symbolic.operators import Domain
from bpns.symbolic.pddl.read import read_domain
from bpns.symbolic.pddl.write import write_domain


@click.command()
@click.argument("model", type=click.Path(path_type=Path), required=False)
@oracle_option
@click.option(
    "--format",
    "notation",
    type=click.Choice(["paper", "pddl", "markdown"]),
    help="paper: the notation of the paper's figure 10 (the default); pddl: the whole domain.",
)
@json_option
@click.option(
    "--picture",
    type=click.Path(path_type=Path),
    help="Draw which operators enable which: .png, .svg or .pdf; prints nothing.",
)
@overwrite_option
def command(
    model: Path | None,
    oracle: str | None,
    notation: str | None,
    as_json: bool,
    picture: Path | None,
    overwrite: bool,
) -> None:
    """Print the operators of MODEL, a model folder or a domain.pddl.

    In a picture an arrow leads from an operator to those that it enables: what stands beside it are the
    predicates that the one adds and the other needs. Pictures need matplotlib: pip install 'bpns[plots]'.
    """
    if (notation is not None) + as_json + (picture is not None) > 1:
        raise click.UsageError("--format, --json and --picture exclude each other")
    domain = _domain(model, oracle)
    if picture is not None:
        _draw(picture, domain, overwrite)
    elif as_json:
        click.echo(json.dumps(operators_json(domain.operators), indent=2))
    elif notation == "pddl":
        click.echo(write_domain(domain), nl=False)
    else:
        text = operator_markdown if notation == "markdown" else str
        click.echo("\n\n".join(map(text, domain.operators)))


def _domain(model: Path | None, oracle: str | None) -> Domain:
    if model is not None and oracle is None and model.is_file():
        return read_domain(model)
    return load_subject(model, oracle).domain


def _draw(path: Path, domain: Domain, overwrite: bool) -> None:
    from bpns.symbolic.compare.drawing import (  # slow, and matplotlib is optional
        draw_operators,
        picture_format,
    )
    from bpns.symbolic.compare.enabling import enabling_graph

    picture_format(path)
    check_output(path, overwrite)
    draw_operators(path, domain.operators, enabling_graph(domain.operators))
