"""Rows of a file of results and the tables made from them."""

import json
import sqlite3
from dataclasses import replace
from math import isnan
from pathlib import Path

import numpy as np
import pytest

from bpns import envs
from bpns.learning.experiments.evaluation import Result, evaluate, summarize
from bpns.learning.experiments.results import (
    KEY,
    Run,
    add_result,
    open_results,
    read_all_results,
    read_results,
)
from bpns.learning.experiments.tables import RunName, remarks, tables
from bpns.learning.models.learn import LearnedSkill
from bpns.learning.models.origin import ORACLE, Origin, read_origin
from bpns.learning.models.save import entry_of, write_model
from bpns.learning.models.solver import Solver
from bpns.symbolic import planners
from bpns.symbolic.bilevel.refinement import DeadEnd
from bpns.symbolic.errors import InputError

RUN = Run(
    "cover", ORACLE, "default", "adaptive", "astar:lmcut", None, None, None, 20_000, 500_000, None, "0.1.0"
)
LEARNED = replace(RUN, origin=Origin("bpns", "aa", "default", 0.01, 1000, 0, 4.0))
RESULT = Result(
    seed=3,
    task=7,
    planned=True,
    refined=False,
    executed=False,
    fault="none of 2 abstract plans could be refined",
    dead_ends=(
        (DeadEnd(1, 2, "(op1 block0 'x' \"y\")", "not reached: größer\n"), 4),
        (DeadEnd(2, 1, "a", ""), 1),
    ),
    nodes_created=12,
    nodes_expanded=9,
    abstract_plans=2,
    samples=20,
    plan_length=0,
    planning_seconds=0.1 + 0.2,
    policy_seconds=1e-9 / 3,
    remarks=("one", "two, with, commas"),
)


def solved(seed: int, task: int, **others: object) -> Result:
    plain = Result(seed, task, True, True, True, "", (), 10, 5, 1, 4, 2, 0.5, 0.5)
    return replace(plain, **others)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "result", [RESULT, replace(RESULT, planned=None, refined=None, dead_ends=(), remarks=())]
)
@pytest.mark.parametrize(
    "run", [RUN, LEARNED, replace(RUN, plans=1, timeout=0.1, strategy=None, planner=None)]
)
def test_a_row_comes_back_as_it_was(tmp_path: Path, run: Run, result: Result) -> None:
    with open_results(tmp_path / "below" / "results.sqlite", create=True) as store:
        add_result(store, run, result)
    with open_results(tmp_path / "below" / "results.sqlite") as store:
        assert read_results(store, run) == {(3, 7): result}
        assert read_all_results(store) == {run: [result]}


def test_what_is_there_stays_and_is_there_once(tmp_path: Path) -> None:
    """Also with NULLs in the key, which SQLite would take for different ones."""
    with open_results(tmp_path / "results.sqlite", create=True) as store:
        add_result(store, RUN, RESULT)
        add_result(store, replace(RUN, version="9"), replace(RESULT, fault="later"))
        assert read_all_results(store) == {RUN: [RESULT]}


def test_every_setting_that_decides_results_makes_another_run(tmp_path: Path) -> None:
    others = [
        replace(RUN, environment="cover:x=1"),
        replace(RUN, origin=replace(ORACLE, model="ab")),
        replace(RUN, origin=replace(ORACLE, approach="bpns")),
        replace(RUN, preset="paper"),
        replace(RUN, strategy="exhaustive"),
        replace(RUN, planner="pyperplan"),
        replace(RUN, plans=1),
        replace(RUN, samples_per_step=1),
        replace(RUN, samples_per_plan=1),
        replace(RUN, sample_limit=1),
        replace(RUN, node_limit=1),
        replace(RUN, timeout=1.5),
    ]
    assert len(others) == len(KEY) - 2  # without seed and task
    with open_results(tmp_path / "results.sqlite", create=True) as store:
        for number, run in enumerate([RUN, *others]):
            assert read_results(store, run) == {}
            add_result(store, run, replace(RESULT, samples=number))
        assert [r.samples for results in read_all_results(store).values() for r in results] == [*range(13)]
        assert read_results(store, others[4]) == {(3, 7): replace(RESULT, samples=5)}


def test_known_tasks_are_not_run_again() -> None:
    cover = envs.load("cover")
    skills = {skill.operator.name: skill for skill in cover.oracle_skills}
    solver = Solver(cover, skills, planners.load("astar"), cover.budget)
    noted: list[Result] = []
    first = evaluate(solver, [0], 3, 1, noted.append)
    assert noted == first
    known = {(r.seed, r.task): r for r in first[:2]}
    noted.clear()
    both = evaluate(solver, [1, 0], 3, 1, noted.append, known)
    assert [(r.seed, r.task) for r in noted] == [(1, 0), (1, 1), (1, 2), (0, 2)]
    assert [(r.seed, r.task) for r in both] == [(s, t) for s in (1, 0) for t in range(3)]
    assert both[3:5] == first[:2]
    assert replace(both[5], planning_seconds=0, policy_seconds=0) == replace(
        first[2], planning_seconds=0, policy_seconds=0
    )


def test_where_a_model_is_from(learned: tuple[LearnedSkill, ...], tmp_path: Path) -> None:
    skills = [(one.skill, entry_of(one.skill, one.segments, one.demonstrations, one.fits)) for one in learned]
    run = {
        "preset": "paper",
        "cpu_seconds": 1.5,
        "settings": {"min_share": 0.0},
        "demonstrations": {"asked": 40},
    }
    for name, details in (("a", run), ("b", {})):
        write_model(tmp_path / name, envs.load("cover"), "cover", 6, skills, details, "")
    first, second = read_origin(tmp_path / "a"), read_origin(tmp_path / "b")
    assert first == Origin("bpns", first.model, "paper", 0.0, 40, 6, 1.5)
    assert second == Origin("bpns", second.model, learning_seed=6)
    assert second.model != first.model  # a row's title comes from run.json, so its rows must not mix
    domain = tmp_path / "b" / "domain.pddl"
    domain.write_text(domain.read_text() + "; edited\n")
    assert read_origin(tmp_path / "b").model not in (first.model, second.model)
    (tmp_path / "b" / "run.json").write_text(json.dumps({"cpu_seconds": "long"}))
    with pytest.raises(InputError, match=r"run.json: cpu_seconds: .* put it right"):
        read_origin(tmp_path / "b")


def test_means_and_deviations_by_hand() -> None:
    """Two models with a seed each: 50 and 100 % solved; seconds over solved, nodes over refined tasks."""
    first = [
        solved(0, 0, nodes_created=10),
        solved(0, 1, executed=False, nodes_created=30, planning_seconds=9.0),
    ]
    second = [solved(1, 0, planning_seconds=1.5), solved(1, 1, planning_seconds=3.5)]
    other = replace(LEARNED, origin=replace(LEARNED.origin, model="bb", learning_seed=1, cpu_seconds=5.0))
    [row] = tables({LEARNED: first, other: second})["cover"]
    assert row.label == "BPNS"
    assert row.runs == {RunName(0, 0, "aa"): first, RunName(1, 1, "bb"): second}
    assert (row.tasks, remarks(row, [row])) == ("2", [])
    assert row.summary.solved == (75.0, 25.0)  # population: divided by 2, not by 1
    assert row.summary.refined == (100.0, 0.0)
    assert row.summary.seconds == (2.0, 1.0)  # 1.0 and 3.0
    assert row.summary.nodes_created == (15.0, 5.0)  # 20 and 10


def test_an_approach_that_does_not_plan_has_dashes_only_there() -> None:
    rows = [
        solved(0, 0, planned=None, refined=None),
        solved(0, 1, planned=None, refined=None, executed=False),
    ]
    summary = summarize({0: rows})
    assert summary.solved == (50.0, 0.0)
    assert summary.seconds == (1.0, 0.0)
    assert all(
        isnan(x[0]) for x in (summary.planned, summary.refined, summary.nodes_created, summary.samples)
    )


def test_titles_and_what_differs_between_rows() -> None:
    paper = replace(LEARNED.origin, learning_preset="paper")
    runs = [
        replace(LEARNED, origin=replace(LEARNED.origin, approach="gnn_bc"), strategy=None, planner=None),
        LEARNED,
        replace(LEARNED, timeout=10.0),
        replace(LEARNED, origin=replace(LEARNED.origin, demonstrations=50)),
        replace(LEARNED, origin=paper, preset="paper", strategy="exhaustive"),
        replace(LEARNED, preset="paper", strategy="exhaustive", samples_per_step=1),
        replace(LEARNED, plans=1, strategy="exhaustive"),
        replace(LEARNED, origin=replace(paper, min_share=0.0)),
        replace(LEARNED, origin=replace(LEARNED.origin, approach="mine")),
        RUN,
    ]
    rows = tables({run: [solved(0, 0)] for run in runs})["cover"]
    assert [(row.title, row.run.origin.demonstrations, row.differences) for row in rows] == [
        ("BPNS", 50, "adaptive, timeout none"),
        ("BPNS", 1000, "adaptive, timeout 10.0"),
        ("BPNS", 1000, "adaptive, timeout none"),
        ("Abstract Plans=1", 1000, "exhaustive"),
        ("BPNS, paper preset", 1000, ""),
        ("No filter, paper's learning", 1000, "adaptive"),
        ("Samples=1, paper's search", 1000, ""),
        ("GNN BC", 1000, ""),
        ("Oracle", None, "adaptive"),
        ("mine", 1000, "adaptive"),
    ]


def test_runs_that_a_mean_should_not_hide_are_named() -> None:
    again = replace(LEARNED, origin=replace(LEARNED.origin, model="bb"))
    [row] = tables({LEARNED: [solved(0, 0), solved(0, 1)], again: [solved(0, 0)]})["cover"]
    assert row.tasks == "1 to 2"
    assert remarks(row, [row]) == [
        "incomplete: model bb, seed 0: 1 tasks of 2",
        "2 models of learning seed 0 in one mean: aa, bb",
    ]


def test_a_file_of_another_kind_stays_as_it_is(tmp_path: Path) -> None:
    path = tmp_path / "results.sqlite"
    with open_results(path, create=True):
        pass
    with sqlite3.connect(path) as other:
        other.execute("PRAGMA user_version = 2")
    other.close()
    (tmp_path / "text").write_text("mine")
    with sqlite3.connect(tmp_path / "database") as other:
        other.execute("CREATE TABLE results (mine)")
    other.close()
    torn = tmp_path / "torn"
    torn.write_bytes(path.read_bytes()[:5000])
    for name, message in (
        ("results.sqlite", "results of format 2, not 1: give another file"),
        ("text", "not a file of results"),
        ("database", "a database, but not of results"),
        ("torn", "malformed"),
        ("", "folder|directory"),
    ):
        before = (tmp_path / name).read_bytes() if name else b""
        for create in (True, False):
            with pytest.raises(InputError, match=message), open_results(tmp_path / name, create):
                pass
        assert not name or (tmp_path / name).read_bytes() == before
    (tmp_path / "empty").touch()  # as a process leaves it that is killed at the very start
    with pytest.raises(InputError, match="holds no results yet"), open_results(tmp_path / "empty"):
        pass
    with open_results(tmp_path / "empty", create=True) as store:
        assert read_all_results(store) == {}
    with pytest.raises(InputError, match=r"no results .*: make them with"), open_results(tmp_path / "none"):
        pass
    assert not (tmp_path / "none").exists()


def test_only_what_was_measured_is_drawn() -> None:
    """A single measurement was drawn as a line from an invented (0, 0), and an oracle not at all."""
    from bpns.learning.experiments.drawing import _figure, _lines

    found = tables({RUN: [solved(0, 0)], LEARNED: [solved(0, 0)]})
    (axes,) = _figure({name: _lines(rows) for name, rows in found.items()}).axes
    drawn = {tuple(map(tuple, np.asarray(line.get_xydata()).tolist())) for line in axes.get_lines()}
    assert ((1000.0, 100.0),) in drawn
    assert ((0.0, 100.0), (1.0, 100.0)) in drawn  # a level line, in shares of the width
    assert not any((0.0, 0.0) in points for points in drawn)
