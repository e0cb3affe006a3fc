"""Print the paper's tables from a file of results."""

import json
from dataclasses import asdict
from pathlib import Path

import click

from bpns.cli._options import json_option, overwrite_option
from bpns.learning.experiments.results import open_results, read_all_results
from bpns.learning.experiments.summary_text import cells, new_table, summary_json, table_text
from bpns.learning.experiments.tables import Row, remarks, tables
from bpns.symbolic.errors import InputError
from bpns.symbolic.files import check_output


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--environment", "environments", metavar="NAME", multiple=True, help="Only this one; repeat.")
@click.option(
    "--plot",
    type=click.Path(path_type=Path),
    help="Also draw tasks solved over demonstrations, the paper's main figure: .png, .svg or .pdf.",
)
@overwrite_option
@json_option
def command(
    file: Path, environments: tuple[str, ...], plot: Path | None, overwrite: bool, as_json: bool
) -> None:
    """Print a table for each environment from FILE, which 'bpns evaluate --out' makes.

    Means over runs with the population standard deviation; a run is one model on one evaluation seed. Times
    are over solved tasks, nodes, plans and samples over refined ones. A dash: nothing to average, or the
    approach does not plan.
    """
    with open_results(file) as store:
        found = tables(read_all_results(store))
    if not found:
        raise InputError(f"{file} holds no results yet")
    for name in environments:
        if name not in found:
            raise InputError(f"{file} has no results of '{name}' (have: {', '.join(found)})")
    found = {name: rows for name, rows in found.items() if not environments or name in environments}
    if plot is not None:
        _plot(plot, found, overwrite)
    if as_json:
        rows = [_json(row) for table in found.values() for row in table]
        click.echo(json.dumps(rows, indent=2, allow_nan=False))
    else:
        for environment, table in found.items():
            _print(environment, table)


def _plot(path: Path, found: dict[str, list[Row]], overwrite: bool) -> None:
    from bpns.learning.experiments.drawing import (  # slow, and matplotlib is optional
        draw_results,
        picture_format,
    )

    picture_format(path)
    check_output(path, overwrite)
    draw_results(path, found)


def _print(environment: str, rows: list[Row]) -> None:
    click.echo(environment)
    settings = any(row.differences for row in rows)
    words = ("approach", "settings") if settings else ("approach",)
    table = new_table(words, ("demonstrations", "runs", "tasks"))
    for row in rows:
        demonstrations = row.run.origin.demonstrations
        table.add_row(
            row.title,
            *([row.differences] if settings else []),
            "-" if demonstrations is None else str(demonstrations),
            str(len(row.runs)),
            row.tasks,
            *cells(row.summary, deviations=True),
        )
    click.echo(table_text(table))
    for row in rows:
        for remark in remarks(row, rows):
            click.echo(f"{row.label}: {remark}")


def _json(row: Row) -> dict[str, object]:
    shared = asdict(row.run)
    origin = shared.pop("origin")
    for name in ("model", "learning_seed", "cpu_seconds"):  # of each run, not of the row
        del origin[name]
    del shared["version"]
    return {
        **shared,
        **origin,
        "title": row.title,
        "runs": [{**name._asdict(), "tasks": len(results)} for name, results in row.runs.items()],
        "summary": summary_json(row.summary),
    }
