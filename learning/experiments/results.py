"""Results in a file: an SQLite database with one row for each task of each run, written as each is done.

A row is one transaction, so that a process that is killed loses the tasks that it was at, no more, and
several may write at once. The journal is SQLite's usual one, not the write-ahead log: that one keeps rows in
a second file beside, which is easily left behind, and does not work on network drives.
"""

import json
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

from bpns.learning.experiments.evaluation import Result
from bpns.learning.models.origin import Origin
from bpns.symbolic.bilevel.refinement import DeadEnd
from bpns.symbolic.errors import InputError
from bpns.symbolic.files import check_output

APPLICATION = 0x62706E73  # "bpns": marks the file as ours
FORMAT = 1
PATIENCE = 60.0  # seconds to wait for other processes that write
Store = sqlite3.Connection


@dataclass(frozen=True, slots=True)
class Run:
    """How tasks were solved: skills, search, limits. None: no limit, or the approach has no such thing."""

    environment: str  # as it was asked for, with options
    origin: Origin
    preset: str
    strategy: str | None
    planner: str | None
    plans: int | None  # limits on a task: abstract plans, ...
    samples_per_step: int | None
    samples_per_plan: int | None
    sample_limit: int | None
    node_limit: int | None
    timeout: float | None
    version: str  # of bpns


# What decides the result, and so which rows are the same; the rest of a row is for those who read it.
KEY = (
    "environment",
    "model",
    "approach",
    "preset",
    "strategy",
    "planner",
    "plans",
    "samples_per_step",
    "samples_per_plan",
    "sample_limit",
    "node_limit",
    "timeout",
    "seed",
    "task",
)
TABLE = """
CREATE TABLE results (
    environment TEXT NOT NULL,
    approach TEXT NOT NULL,
    model TEXT NOT NULL,
    learning_preset TEXT,
    min_share REAL,
    demonstrations INTEGER,
    learning_seed INTEGER,
    cpu_seconds REAL,
    preset TEXT NOT NULL,
    strategy TEXT,
    planner TEXT,
    plans INTEGER,
    samples_per_step INTEGER,
    samples_per_plan INTEGER,
    sample_limit INTEGER,
    node_limit INTEGER,
    timeout REAL,
    seed INTEGER NOT NULL,
    task INTEGER NOT NULL,
    planned INTEGER,
    refined INTEGER,
    executed INTEGER NOT NULL,
    fault TEXT NOT NULL,
    nodes_created INTEGER NOT NULL,
    nodes_expanded INTEGER NOT NULL,
    abstract_plans INTEGER NOT NULL,
    samples INTEGER NOT NULL,
    plan_length INTEGER NOT NULL,
    planning_seconds REAL NOT NULL,
    policy_seconds REAL NOT NULL,
    dead_ends TEXT NOT NULL,
    remarks TEXT NOT NULL,
    version TEXT NOT NULL
)"""
# To SQLite no NULL equals another: without ifnull, rows without a limit would never count as the same.
INDEX = f"CREATE UNIQUE INDEX one_row_a_task ON results ({', '.join(f'ifnull({name}, -1)' for name in KEY)})"


@contextmanager
def open_results(path: Path, create: bool = False) -> Iterator[Store]:
    """Open a file of results, or make one; raise InputError where it is none, then and for faults while open.

    A file with anything else in it stays as it is.
    """
    if create:
        check_output(path, overwrite=True)  # it is added to, not replaced
        path.parent.mkdir(parents=True, exist_ok=True)
    _check_file(path, create)
    uri = f"{path.absolute().as_uri()}?mode={'rwc' if create else 'rw'}"
    try:
        with closing(sqlite3.connect(uri, PATIENCE, isolation_level=None, uri=True)) as connection:
            _check_format(connection, path, create)
            yield connection
    except sqlite3.Error as error:
        raise InputError(f"{path}: {error}") from error


def _check_file(path: Path, create: bool) -> None:
    try:
        with path.open("rb") as file:
            start = file.read(16)
    except FileNotFoundError as error:
        if not create:
            raise InputError(f"no results {path}: make them with 'bpns evaluate --out'") from error
        return
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror or error}") from error
    if start not in (b"", b"SQLite format 3\0"):  # empty: killed before the table was there
        raise InputError(f"{path}: not a file of results: give another one")


def _check_format(store: Store, path: Path, create: bool) -> None:
    """Check whose database it is and, where it is empty, make our table; one process at a time."""
    store.execute("BEGIN IMMEDIATE" if create else "BEGIN")
    empty = store.execute("SELECT count(*) FROM sqlite_master").fetchone()[0] == 0
    if empty and create:
        store.execute(TABLE)
        store.execute(INDEX)
        store.execute(f"PRAGMA application_id = {APPLICATION}")
        store.execute(f"PRAGMA user_version = {FORMAT}")
    application = store.execute("PRAGMA application_id").fetchone()[0]
    version = store.execute("PRAGMA user_version").fetchone()[0]
    store.execute("COMMIT")
    if empty and not create:
        raise InputError(f"{path} holds no results yet")
    if application != APPLICATION:
        raise InputError(f"{path}: a database, but not of results: give another one")
    if version != FORMAT:
        raise InputError(f"{path}: results of format {version}, not {FORMAT}: give another file")


def add_result(store: Store, run: Run, result: Result) -> None:
    """Store a result; one that is there already stays."""
    values = _run_values(run) | _result_values(result)
    names, places = ", ".join(values), ", ".join(f":{name}" for name in values)
    store.execute(f"INSERT OR IGNORE INTO results ({names}) VALUES ({places})", values)


def read_results(store: Store, run: Run) -> dict[tuple[int, int], Result]:
    """Return what is there of a run, by seed and task."""
    values = _run_values(run)
    same = " AND ".join(f"ifnull({name}, -1) = ifnull(:{name}, -1)" for name in KEY if name in values)
    names = [field.name for field in fields(Result)]
    rows = store.execute(f"SELECT {', '.join(names)} FROM results WHERE {same}", values)
    results = (_result(dict(zip(names, row, strict=True))) for row in rows)
    return {(result.seed, result.task): result for result in results}


def read_all_results(store: Store) -> dict[Run, list[Result]]:
    """Return all results by run; runs in the order in which they came, results by seed and task."""
    names = [row[1] for row in store.execute("PRAGMA table_info(results)")]
    found: dict[Run, list[Result]] = {}
    for row in store.execute(f"SELECT {', '.join(names)} FROM results ORDER BY rowid"):
        values = dict(zip(names, row, strict=True))
        found.setdefault(_run(values), []).append(_result(values))
    return {run: sorted(results, key=lambda r: (r.seed, r.task)) for run, results in found.items()}


def _run_values(run: Run) -> dict[str, Any]:
    values = asdict(run)
    return {**values.pop("origin"), **values}


def _run(values: Mapping[str, Any]) -> Run:
    origin = Origin(**{field.name: values[field.name] for field in fields(Origin)})
    own = {field.name: values[field.name] for field in fields(Run) if field.name != "origin"}
    return Run(origin=origin, **own)


def _result_values(result: Result) -> dict[str, Any]:
    ends = [[*asdict(end).values(), count] for end, count in result.dead_ends]
    return asdict(result) | {"dead_ends": json.dumps(ends), "remarks": json.dumps(result.remarks)}


def _result(values: Mapping[str, Any]) -> Result:
    own = {field.name: values[field.name] for field in fields(Result)}
    own |= {name: None if own[name] is None else bool(own[name]) for name in ("planned", "refined")}
    own["executed"] = bool(own["executed"])
    own["dead_ends"] = tuple((DeadEnd(*end), count) for *end, count in json.loads(own["dead_ends"]))
    own["remarks"] = tuple(json.loads(own["remarks"]))
    return Result(**own)
