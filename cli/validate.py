"""Check PDDL files and plans with several checkers; say where they disagree."""

import json
import sys
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from math import isfinite
from pathlib import Path

import click
from rich.console import Console
from rich.table import Table

import bpns
from bpns.cli._options import json_option
from bpns.symbolic.checkers.reports import Inputs, Report

EXIT_CODES = {"valid": 0, "invalid": 1, "failed": 1, "unsupported": 37}
SUMMARIES = {
    "valid": "valid",
    "invalid": "INVALID",
    "failed": "no fault found, but a check FAILED",
    "unsupported": "unsupported: no checker could look at everything",
}
MANY_PLANS = 3  # more get one column together


@click.command()
@click.argument("domain", type=click.Path(path_type=Path))
@click.argument("problem", type=click.Path(path_type=Path), required=False)
@click.argument("plans", metavar="[PLAN]...", type=click.Path(path_type=Path), nargs=-1)
@click.option(
    "--checker",
    "chosen",
    multiple=True,
    type=click.Choice(bpns.checkers()),
    help="Only this one; can be given several times (default: all that are installed).",
)
@click.option(
    "--timeout",
    type=click.FloatRange(0, min_open=True),
    default=60.0,
    show_default=True,
    help="Seconds for each checker.",
)
@json_option
def command(
    domain: Path,
    problem: Path | None,
    plans: tuple[Path, ...],
    chosen: tuple[str, ...],
    timeout: float,
    as_json: bool,
) -> None:
    """Check DOMAIN, with PROBLEM and PLANs where given: our reader and all other checkers installed.

    A file with several plans, as 'bpns plan --plans' prints them, has each checked. Exits with 0 if all is
    valid, 1 if a checker finds a fault or fails, 37 if no checker supports what the files use.
    """
    if not isfinite(timeout):
        raise click.UsageError("--timeout: give a positive number of seconds")
    found = bpns.validate(domain, problem, plans, chosen, timeout)
    inputs, reports, differ, result = found.inputs, found.reports, found.disagreements, found.outcome
    if as_json:
        said = {"outcome": result, "disagreements": list(differ), "checkers": _json(inputs, reports)}
        click.echo(json.dumps(said, indent=2))
    else:
        _print(inputs, reports)
        for line in differ:
            click.echo(f"DISAGREE on {line}")
        click.echo(SUMMARIES[result] + ("" if differ else _agreed(reports, result)))
    sys.exit(EXIT_CODES[result])


def _agreed(reports: Sequence[Report], result: str) -> str:
    """Name those that came to the result themselves."""
    level = "fault" if result == "invalid" else "ok"
    judged = [r.checker for r in reports if any(v.level == level for v in r.verdicts)]
    return f": {', '.join(judged)} agree" if len(judged) > 1 else f": {', '.join(judged)} alone says so"


def _json(inputs: Inputs, reports: Sequence[Report]) -> list[dict[str, object]]:
    return [
        {
            "checker": report.checker,
            "version": report.version,
            "missing": report.missing,
            "verdicts": [
                {"item": item, **asdict(verdict)}
                for item, verdict in zip(inputs.items, report.verdicts, strict=bool(report.verdicts))
            ],
        }
        for report in reports
    ]


def _print(inputs: Inputs, reports: Sequence[Report]) -> None:
    """Print a table of verdicts, then what is behind each that is not 'ok'."""
    files = len(inputs.items) - len(inputs.plans)
    many = len(inputs.plans) > MANY_PLANS
    table = Table(box=None, pad_edge=False)
    for column in ("checker", "version", *inputs.items[:files]):
        table.add_column(column)
    for column in [f"{len(inputs.plans)} plans"] if many else inputs.items[files:]:
        table.add_column(column, overflow="fold")
    for report in reports:
        levels = [v.level.upper() if v.level in ("fault", "failed") else v.level for v in report.verdicts]
        if many and levels:
            counts = Counter(levels[files:])
            levels[files:] = [", ".join(f"{count} {level}" for level, count in counts.items())]
        table.add_row(report.checker, "-" if report.missing else report.version, *levels)
    width = None if sys.stdout.isatty() else 200
    Console(width=width, highlight=False, markup=False).print(table)
    for report in reports:
        if report.missing:
            click.echo(f"{report.checker}: not installed: {report.missing}")
        for item, verdict in zip(inputs.items, report.verdicts, strict=False):
            if verdict.text:
                what = f"{item}: failed" if verdict.level == "failed" else verdict.level
                click.echo(f"{report.checker}: {what}: {verdict.text}")
