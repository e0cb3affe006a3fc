"""``bpns planners`` and ``bpns plan`` with several planners, as a user meets them."""

import json
import sys
from collections.abc import Callable
from importlib.metadata import PackageNotFoundError
from pathlib import Path

import pytest

from bpns.symbolic import planners
from bpns.symbolic.grounding.ground import GroundProblem, ground
from bpns.symbolic.pddl.read import read_domain, read_problem
from bpns.symbolic.planners.protocol import Limit
from bpns.symbolic.planners.streams import first_plans

Run = Callable[..., tuple[int, str, str]]
ROOT = Path(__file__).parents[2]
DOMAIN, PROBLEM = ROOT / "pddl_out/cover/domain.pddl", ROOT / "pddl_out/cover/p03.pddl"
COVER = (DOMAIN, "--problem", PROBLEM)
UNSOLVABLE = """(define (domain walk) (:requirements :strips) (:predicates (home) (away))
  (:action go :precondition (home) :effect (and (away) (not (home))))
  (:action back :precondition (away) :effect (and (home) (not (away)))))"""
BOTH = "(define (problem both) (:domain walk) (:init (home)) (:goal (and (home) (away))))"


def test_planners_are_listed_with_what_they_can_do(bpns: Run) -> None:
    code, out, err = bpns("planners")
    assert (code, err) == (0, "")
    table = out.partition("\nastar: ")[0].splitlines()
    rows = {line.split()[0]: line for line in table if line.strip()}
    for about in planners.about():
        assert about.gives in rows[about.name]
        assert about.licence in rows[about.name]
        if not about.package:
            assert "built in" in rows[about.name]
        elif about.version is None:
            assert f"missing: [{about.extra}]" in rows[about.name]
        else:
            assert about.version in rows[about.name]
    assert max(map(len, table)) <= 125


def test_planners_as_json(bpns: Run) -> None:
    code, out, _ = bpns("planners", "--json")
    assert code == 0
    rows = {row["name"]: row for row in json.loads(out)}
    assert set(rows) == {about.name for about in planners.about()}
    assert rows["astar"]["optimal"]
    assert rows["astar"]["costs"]
    assert not rows["kairos"]["optimal"]
    assert not rows["pyperplan"]["negation"]
    assert rows["kstar"]["package"] == "kstar-planner"


def test_what_is_missing_can_be_installed_by_one_line(bpns: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def version(package: str) -> str:
        if package == "bpns":
            return "1"
        raise PackageNotFoundError(package)

    monkeypatch.setattr("bpns.symbolic.planners.protocol.metadata.version", version)
    code, out, _ = bpns("planners")
    assert code == 0
    assert "missing: [kstar]" in out
    last = out.rstrip().splitlines()[-1]
    assert last.startswith("To install what is missing: pip install 'bpns[")
    extras = {about.extra for about in planners.about() if about.package} - {"tamer"}
    assert "pip install 'bpns[tamer]'" in out
    assert set(last.split("bpns[")[1].rstrip("]'").split(",")) == extras
    code, _, err = bpns("plan", *COVER, "--planner", "kstar")
    assert code == 36
    assert err.count("\n") == 1
    assert "pip install 'bpns[kstar]'" in err


def test_comparing_planners_on_a_problem(bpns: Run) -> None:
    code, out, _ = bpns("plan", *COVER, "--compare", "astar,kairos", "--plans", 5)
    assert code == 0
    rows = {line.split()[0]: line for line in out.splitlines() if line.strip()}
    assert {"planner", "astar", "kairos"} <= set(rows)
    code, out, err = bpns("plan", *COVER, "--compare", "astar,no-such-planner")
    assert (code, out) == (36, "")
    assert "unknown planner 'no-such-planner'" in err
    code, out, _ = bpns("plan", *COVER, "--compare", "astar,astar:hff,pyperplan", "--plans", 5, "--json")
    assert code == 0
    found = {row["planner"]: row for row in json.loads(out)}
    assert list(found) == ["astar", "astar:hff", "pyperplan"]
    for row in found.values():
        assert row["plans"] == 5
        assert row["first"] == 4
        assert 0 < row["first plan s"] <= row["all s"]
        assert row["remark"] == ""


def test_comparing_where_there_is_no_plan(bpns: Run, tmp_path: Path) -> None:
    (tmp_path / "domain.pddl").write_text(UNSOLVABLE)
    (tmp_path / "p.pddl").write_text(BOTH)
    words = ("plan", tmp_path / "domain.pddl", "--problem", tmp_path / "p.pddl")
    code, out, _ = bpns(*words, "--compare", "astar,kairos", "--json")
    assert code == 0
    assert [(row["plans"], row["remark"]) for row in json.loads(out)] == [(0, "there is no plan")] * 2
    code, out, err = bpns(*words, "--planner", "kairos")
    assert (code, out, err) == (11, "", "no plan exists: the whole state space was searched\n")


def test_comparing_planners_on_a_task(bpns: Run) -> None:
    words = ("plan", "--oracle", "cover", "--task", 1, "--compare", "astar,kairos", "--plans", 3)
    code, out, _ = bpns(*words, "--json")
    assert code == 0
    for row in json.loads(out):
        assert (row["plans"], row["refined"], row["executed"]) == (3, True, True)
        assert row["tried"] >= 1
    code, out, _ = bpns(*words)
    assert code == 0
    assert "refined" in out
    assert out.count("yes") == 4


def test_comparison_goes_without_pictures(bpns: Run) -> None:
    code, _, err = bpns("plan", "--oracle", "cover", "--compare", "astar", "--show", "x.gif")
    assert code == 2
    assert "--compare goes with none of --planner, --show and --no-loops" in err


def test_plans_without_loops(bpns: Run) -> None:
    """Many plans put a block down and pick it up again; one that does so at another target has no loop."""
    domain = read_domain(DOMAIN)
    problem = ground(domain, read_problem(PROBLEM, domain))
    assert isinstance(problem, GroundProblem)
    found = first_plans(planners.load("astar"), problem, 100, 0, Limit(100_000)).plans
    expected = [[s.call for s in plan.steps] for plan in found if len(set(plan.atoms)) == len(plan.atoms)]
    assert 5 < len(expected) < 100
    code, out, _ = bpns("plan", *COVER, "--plans", 5, "--no-loops", "--json")
    assert code == 0
    assert json.loads(out)["plans"] == expected[:5]


@pytest.mark.parametrize("planner", ["kairos", pytest.param("kstar", marks=pytest.mark.slow)])
def test_another_planner_solves_a_task(bpns: Run, planner: str) -> None:
    code, out, _ = bpns("plan", "--oracle", "cover", "--planner", planner)
    assert code == 0
    assert "executed: yes" in out


@pytest.mark.slow
@pytest.mark.parametrize("task", [0, 9])
@pytest.mark.parametrize("planner", ["pyperplan", "kstar", "symk", "up:fast-downward", "up:symk", "command"])
def test_planning_goes_on_where_the_first_abstract_plan_cannot_be_refined(
    bpns: Run, planner: str, task: int
) -> None:
    """In these tasks a button is out of the hand's reach, which no predicate says."""
    if planner == "command":
        spec = pytest.importorskip("up_fast_downward").__file__
        program = Path(spec).parent / "downward" / "fast-downward.py"
        arguments = "--plan-file {plan} {domain} {problem} --search 'astar(lmcut())'"
        planner = f"command:{sys.executable} {program} {arguments}"
    words = ("--oracle", "stick_button", "--task", task, "--seed", 50000, "--planner", planner, "--json")
    code, out, err = bpns("plan", *words)
    assert code == 0, err
    found = json.loads(out)
    assert found["abstract_plans"] > 1
    assert found["refined"]
    assert found["executed"]
