"""Write a model as PDDL: the domain and some problems."""

from pathlib import Path

import click

import bpns
from bpns.cli._options import MAX_SEED, environment_option, load_subject, oracle_option, overwrite_option


@click.command()
@click.argument("model", type=click.Path(path_type=Path), required=False)
@oracle_option
@environment_option
@click.option("--out", type=click.Path(path_type=Path), required=True, help="Folder.")
@click.option("--problems", type=click.IntRange(0), default=10, show_default=True)
@click.option(
    "--seed", type=click.IntRange(0, MAX_SEED), help="Of the evaluation tasks (default: the model's)."
)
@click.option(
    "--positive", is_flag=True, help="Compile negative conditions away, for planners that lack them."
)
@overwrite_option
def command(
    model: Path | None,
    oracle: str | None,
    environment: str | None,
    out: Path,
    problems: int,
    seed: int | None,
    positive: bool,
    overwrite: bool,
) -> None:
    """Write domain.pddl and p01.pddl, p02.pddl, ... (the first evaluation tasks) of MODEL.

    Every name is used once, over types, predicates, operators and objects, as some planners need it.
    """
    bpns.export(load_subject(model, oracle, environment), out, problems, seed, positive, overwrite)
    click.echo(f"domain.pddl and {problems} problems: {out}")
