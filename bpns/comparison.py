"""Several planners side by side, on a PDDL problem or on a task."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from bpns.enumeration import MAX_NODES, read_pair
from bpns.learning.models.solver import Outcome
from bpns.model import Model
from bpns.symbolic import planners
from bpns.symbolic.bilevel.settings import SearchSettings
from bpns.symbolic.errors import InputError, MissingPackage
from bpns.symbolic.grounding.ground import OutOfTime, Unreachable, ground
from bpns.symbolic.operators import Domain, Problem
from bpns.symbolic.planners.protocol import Limit
from bpns.symbolic.planners.streams import Enumeration, first_plans
from bpns.symbolic.state import Task

SECONDS = 60.0  # for each planner, unless somebody says otherwise
COLUMNS = ("planner", "first plan s", "all s", "plans", "first", "steps")
TASK_COLUMNS = ("refined", "executed", "tried", "solve s")
LONGEST_NAME = 40  # commands are long


@dataclass(frozen=True, slots=True, eq=False)
class Comparison:
    """A row for each planner. Printed, it is a table.

    Without rows ``why`` says why nothing was compared: no plan exists, or the time was over (``late``).
    """

    rows: tuple[dict[str, Any], ...]
    why: str = ""
    late: bool = False

    def __iter__(self) -> Iterator[dict[str, Any]]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def __repr__(self) -> str:
        return f"<comparison of {', '.join(row['planner'] for row in self.rows)}>"

    def __str__(self) -> str:
        if not self.rows:
            return self.why
        on_task = any("refined" in row for row in self.rows)
        columns = COLUMNS + TASK_COLUMNS * on_task
        table = Table(box=SIMPLE_HEAD)
        for column in columns:
            table.add_column(column, justify="left" if column == "planner" else "right", no_wrap=True)
        for row in self.rows:
            table.add_row(*(_shortened(_text(row.get(column))) for column in columns))
        text = StringIO()
        Console(file=text, width=1000, highlight=False, markup=False, emoji=False).print(table)
        remarks = (f"{_shortened(row['planner'])}: {row['remark']}" for row in self.rows if row.get("remark"))
        return "\n".join([text.getvalue().rstrip("\n"), *remarks])


def compare_planners(
    names: Sequence[str],
    domain: Path | str | Domain | Model,
    problem: Path | str | Problem | Task,
    plans: int = 10,
    seed: int = 0,
    timeout: float | None = None,
    search: SearchSettings = SearchSettings(),
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Comparison:
    """Return a row for each planner: seconds to its first and to all of its plans, their steps, remarks.

    With a model and a task each planner's plans are refined and carried out too. ``timeout`` is in seconds
    for each planner (a minute by default). "all" stands for what is installed. A planner that is not
    installed has a remark. Raises InputError for unknown planners, and for faults in the files.

    >>> import bpns
    >>> model = bpns.oracle(bpns.load_environment("cover"))
    >>> [row] = bpns.compare_planners(["astar"], model, model.world.task())
    >>> row["planner"], row["plans"], row["refined"], row["executed"]
    ('astar', 10, True, True)
    """
    chosen = planner_names(names)
    known_domain, known_problem = read_pair(domain, problem)
    seconds = timeout or SECONDS
    grounded = ground(known_domain, known_problem, None if timeout is None else time.monotonic() + timeout)
    if isinstance(grounded, Unreachable):
        return Comparison((), str(grounded))
    if isinstance(grounded, OutOfTime):
        return Comparison((), "stopped by the time limit while grounding", late=True)
    on_task = isinstance(domain, Model) and isinstance(problem, Task)
    nodes = domain.world.environment.budget.nodes if isinstance(domain, Model) and on_task else MAX_NODES
    rows = []
    for number, name in enumerate(chosen):
        progress(number, len(chosen))
        try:
            planner = planners.load(name)
        except MissingPackage as error:
            rows.append({"planner": name, "remark": str(error)})
            continue
        limit = Limit(nodes, time.monotonic() + seconds)
        row = _row(name, first_plans(planner, grounded, plans, seed, limit), plans)
        if isinstance(domain, Model) and isinstance(problem, Task):
            row |= _solved(domain.plan(problem, planner, seconds, search, seed))
        rows.append(row)
    return Comparison(tuple(rows))


def planner_names(given: Sequence[str]) -> list[str]:
    """Return each planner's name once; "all" stands for what is installed. Raises InputError for none."""
    found = list(given)
    if "all" in found:
        installed = [a.name for a in planners.about() if a.version is not None and a.name != "command"]
        found = [*installed, *(name for name in found if name != "all")]
    names = list(dict.fromkeys(name.strip() for name in found if name.strip()))
    if not names:
        raise InputError("no planner to compare: name some, or all")
    return names


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


def _solved(outcome: Outcome) -> dict[str, Any]:
    return {
        "refined": outcome.refined,
        "executed": outcome.executed,
        "tried": outcome.effort.abstract_plans,
        "solve s": round(sum(outcome.effort.seconds.values()), 4),
    }


def _shortened(text: str) -> str:
    return text if len(text) <= LONGEST_NAME else f"{text[: LONGEST_NAME - 3]}..."


def _text(value: Any) -> str:
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.3f}" if isinstance(value, float) else str(value)
