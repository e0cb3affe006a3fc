"""Rename a model's operators, add skills of your own, remove some."""

from pathlib import Path

import click

import bpns
from bpns.cli._options import overwrite_option
from bpns.learning.models.files import check_model_output


def _pairs(_: click.Context, __: click.Parameter, values: tuple[str, ...]) -> dict[str, str]:
    pairs = [value.partition("=") for value in values]
    if not all(old and new for old, _, new in pairs):
        raise click.BadParameter("write it as Op0=Pick")
    return {old: new for old, _, new in pairs}


@click.command()
@click.argument("model", type=click.Path(path_type=Path))
@click.option("--rename", multiple=True, callback=_pairs, metavar="OLD=NEW", help="An operator; repeat.")
@click.option("--add", multiple=True, metavar="MODULE:ATTRIBUTE", help="A skill of your own; repeat.")
@click.option("--remove", multiple=True, metavar="OPERATOR", help="A skill; repeat.")
@click.option("--out", type=click.Path(path_type=Path), help="Another model folder (default: MODEL itself).")
@overwrite_option
def command(
    model: Path,
    rename: dict[str, str],
    add: tuple[str, ...],
    remove: tuple[str, ...],
    out: Path | None,
    overwrite: bool,
) -> None:
    """Rename operators of MODEL everywhere at once, add skills of your own beside learned ones, remove some.

    Preconditions and effects are edited in MODEL/domain.pddl, with any editor. Comments that were added there
    are lost here, those of the learner stay.
    """
    if not (rename or add or remove):
        raise click.UsageError("nothing to do: give --rename, --add or --remove")
    target = out or model
    check_model_output(target, overwrite or out is None)
    changed = bpns.load_model(model)
    for name in remove:
        changed = changed.without(name)
    for name in add:
        changed = changed.with_skill(name)
    changed = changed.renamed(rename)
    changed.save(target, overwrite=True)
    click.echo(f"{', '.join(changed.operators)}: {target}")
