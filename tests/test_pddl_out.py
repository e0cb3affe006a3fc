"""The committed PDDL files: read by three independent readers, planned for by each, with equal lengths."""

import shutil
import subprocess
import sys
from pathlib import Path

import kairos
import numpy as np
import pytest
import up_kairos
from unified_planning.environment import get_environment
from unified_planning.io import PDDLReader
from unified_planning.shortcuts import OneshotPlanner

from bpns import envs
from bpns.symbolic import planners
from bpns.symbolic.grounding.ground import GroundProblem, ground
from bpns.symbolic.pddl.read import read_domain, read_problem
from bpns.symbolic.pddl.write import write_domain, write_problem
from bpns.symbolic.planners.protocol import Limit, SearchRecord
from bpns.symbolic.skills.environment import problem_of, sample_tasks

FOLDERS = sorted((Path(__file__).parents[1] / "pddl_out").iterdir())
PROBLEMS = sorted(path for folder in FOLDERS for path in folder.glob("p*.pddl"))


def our_length(path: Path, planner: str) -> int:
    domain = read_domain(path.parent / "domain.pddl")
    problem = ground(domain, read_problem(path, domain))
    assert isinstance(problem, GroundProblem)
    stream = planners.load(planner).plans(problem, np.random.default_rng(0), Limit(100_000), SearchRecord())
    return len(next(stream).steps)


def test_ten_problems_each() -> None:
    assert {folder.name for folder in FOLDERS} == set(envs.names())
    assert len(PROBLEMS) == 10 * len(FOLDERS)


@pytest.mark.parametrize("path", PROBLEMS, ids=lambda p: f"{p.parent.name}-{p.stem}")
def test_three_readers_find_plans_of_the_same_length(path: Path, tmp_path: Path) -> None:
    length = our_length(path, "astar")
    assert our_length(path, "pyperplan") == length

    for name in ("domain.pddl", path.name):  # pyperplan writes its plan beside the problem
        shutil.copy(path.parent / name, tmp_path)
    command = [Path(sys.executable).with_name("pyperplan"), "-H", "lmcut", "-s", "astar"]
    subprocess.run([*command, "domain.pddl", path.name], cwd=tmp_path, check=True, capture_output=True)
    assert len((tmp_path / f"{path.name}.soln").read_text().split("\n(")) == length

    up_kairos.register()
    get_environment().credits_stream = None
    problem = PDDLReader().parse_problem(str(path.parent / "domain.pddl"), str(path))
    with OneshotPlanner(name="kairos") as engine:
        assert len(engine.solve(problem).plan.actions) == length


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda p: p.name)
def test_files_are_strictly_correct(folder: Path) -> None:
    report = kairos.check_domain((folder / "domain.pddl").read_text())
    assert report.diagnostics == []


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda p: p.name)
def test_files_are_as_we_write_them(folder: Path) -> None:
    """Problems are the evaluation tasks of seed 0; the domain's text is stable."""
    environment = envs.load(folder.name)
    domain = read_domain(folder / "domain.pddl")
    text = (folder / "domain.pddl").read_text()
    bare = "".join(line for line in text.splitlines(True) if not line.lstrip().startswith(";"))
    assert write_domain(domain) == bare
    for number, task in enumerate(sample_tasks(environment, "test", 10, 0), 1):
        path = folder / f"p{number:02}.pddl"
        assert read_problem(path, domain).goal
        problem = problem_of(environment, task, path.stem)
        written = write_problem(
            problem, domain, f"evaluation task {number - 1} of seed 0, environment {folder.name}"
        )
        assert path.read_text() == written
