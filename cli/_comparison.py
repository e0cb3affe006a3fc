"""Several planners side by side, on a PDDL problem or on a task."""

import json
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import click
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from bpns.cli._options import Subject, progress_bar
from bpns.symbolic import planners
from bpns.symbolic.bilevel.execution import execute
from bpns.symbolic.bilevel.solve import Plan, solve
from bpns.symbolic.bilevel.strategy import Strategy
from bpns.symbolic.errors import InputError, MissingPackage
from bpns.symbolic.grounding.ground import GroundProblem
from bpns.symbolic.planners.protocol import Limit
from bpns.symbolic.planners.streams import Enumeration, first_plans
from bpns.symbolic.skills.environment import Budget
from bpns.symbolic.state import Task

LONGEST_NAME = 40  # commands are long
SECONDS = 60.0  # for each planner, unless --timeout says otherwise


def planner_names(given: Sequence[str]) -> list[str]:
    """Split what --compare was given: names with commas between; ``all`` stands for what is installed."""
    found: list[str] = []
    for text in given:
        found += [text] if text.startswith("command:") else text.split(",")
    if "all" in found:
        installed = [a.name for a in planners.about() if a.version is not None and a.name != "command"]
        found = [*installed, *(name for name in found if name != "all")]
    names = list(dict.fromkeys(name.strip() for name in found if name.strip()))
    if not names:
        raise InputError("--compare names no planner: give some with commas between, or all")
    return names


def print_comparison(
    names: Sequence[str],
    problem: GroundProblem,
    plans: int,
    seed: int,
    nodes: int,
    timeout: float | None,
    on_task: tuple[Subject, Task, Strategy, Budget] | None,
    as_json: bool,
) -> None:
    """Print a row for each planner: seconds to its first and to all plans, steps, and what was refined."""
    with progress_bar("comparing") as progress:
        rows = list(_rows(names, problem, plans, seed, nodes, timeout, on_task, progress))
    if as_json:
        click.echo(json.dumps(rows, indent=2))
    else:
        _print(rows, on_task is not None)


def _rows(
    names: Sequence[str],
    problem: GroundProblem,
    plans: int,
    seed: int,
    nodes: int,
    timeout: float | None,
    on_task: tuple[Subject, Task, Strategy, Budget] | None,
    progress: Callable[[int, int], None],
) -> Iterator[dict[str, Any]]:
    for number, name in enumerate(names):
        progress(number, len(names))
        try:
            planner = planners.load(name)
        except MissingPackage as error:
            yield {"planner": name, "remark": str(error)}
            continue
        seconds = timeout or SECONDS
        limit = Limit(nodes, time.monotonic() + seconds)
        row = _row(name, first_plans(planner, problem, plans, seed, limit), plans)
        if on_task is not None:
            subject, task, strategy, budget = on_task
            started = time.monotonic()
            world = subject.environment
            outcome = solve(world, task, subject.skills, planner, budget, seed, started + seconds, strategy)
            refined = isinstance(outcome, Plan)
            row |= {
                "refined": refined,
                "executed": isinstance(outcome, Plan) and execute(world, task, outcome).success,
                "tried": outcome.effort.abstract_plans,
                "solve s": round(sum(outcome.effort.seconds.values()), 4),
            }
        yield row


def _row(name: str, found: Enumeration, wanted: int) -> dict[str, Any]:
    lengths = [len(plan.steps) for plan in found.plans]
    short = len(lengths) < wanted
    remarks = [found.ended if short else "", *found.record.remarks]
    if short and not found.ended:
        remarks.append("there are no others" if lengths else "there is no plan")
    return {
        "planner": name,
        "first plan s": None if found.first_seconds is None else round(found.first_seconds, 4),
        "all s": round(found.seconds, 4),
        "plans": len(lengths),
        "steps": f"{min(lengths)} to {max(lengths)}" if lengths else None,
        "first": lengths[0] if lengths else None,
        "remark": "; ".join(filter(None, remarks)),
    }


def _print(rows: list[dict[str, Any]], on_task: bool) -> None:
    columns = ["planner", "first plan s", "all s", "plans", "first", "steps"]
    columns += ["refined", "executed", "tried", "solve s"] if on_task else []
    table = Table(box=SIMPLE_HEAD)
    for column in columns:
        table.add_column(column, justify="left" if column == "planner" else "right", no_wrap=True)
    for row in rows:
        table.add_row(*(_shortened(_text(row.get(column))) for column in columns))
    Console(width=max(140, Console().width), highlight=False, markup=False, emoji=False).print(table)
    for row in rows:
        if row.get("remark"):
            click.echo(f"{_shortened(row['planner'])}: {row['remark']}")


def _shortened(text: str) -> str:
    return text if len(text) <= LONGEST_NAME else f"{text[: LONGEST_NAME - 3]}..."


def _text(value: Any) -> str:
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.3f}" if isinstance(value, float) else str(value)
