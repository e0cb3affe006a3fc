"""Means and deviations as tables of text and as JSON."""

from dataclasses import asdict
from io import StringIO
from math import isnan

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from bpns.learning.experiments.evaluation import Summary

COLUMNS = ("planned %", "refined %", "solved %", "nodes", "plans", "samples", "time s")


def new_table(words: tuple[str, ...], numbers: tuple[str, ...]) -> Table:
    """Return an empty table: columns of words, of numbers, and those of a summary."""
    table = Table(box=SIMPLE_HEAD)
    for column in words:
        table.add_column(column, no_wrap=True)
    for column in (*numbers, *COLUMNS):
        table.add_column(column, justify="right", no_wrap=True)
    return table


def table_text(table: Table) -> str:
    """Return a table as text, as wide as it is: numbers that are cut off mislead."""
    text = StringIO()
    Console(file=text, width=1000, highlight=False, markup=False, emoji=False).print(table)
    return text.getvalue().rstrip("\n")


def cells(summary: Summary, deviations: bool) -> list[str]:
    """Return a summary's means, with the standard deviations behind them where they are wanted."""
    return [
        f"{_number(mean, decimals)} ({_number(std, decimals)})"
        if deviations and not isnan(mean)
        else _number(mean, decimals)
        for (mean, std), decimals in _columns(summary)
    ]


def summary_json(summary: Summary) -> dict[str, dict[str, float] | None]:
    """Return a summary for JSON; null where there was nothing to average over."""
    return {
        key: None if isnan(mean) else {"mean": mean, "std": std}
        for key, (mean, std) in asdict(summary).items()
    }


def _number(value: float, decimals: int) -> str:
    """Write a number; a dash where there was no task to average over."""
    return "-" if isnan(value) else f"{value:.{decimals}f}"


def _columns(summary: Summary) -> list[tuple[tuple[float, float], int]]:
    """Return the numbers of a row with their decimals, in the order of ``COLUMNS``."""
    return [
        (summary.planned, 1),
        (summary.refined, 1),
        (summary.solved, 1),
        (summary.nodes_created, 2),
        (summary.abstract_plans, 2),
        (summary.samples, 1),
        (summary.seconds, 4),
    ]
