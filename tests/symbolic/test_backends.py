"""Every planner that is installed keeps the same promises; what is missing is said."""

import sys
import tomllib
from collections.abc import Collection, Iterator
from importlib import metadata
from importlib.util import find_spec
from itertools import islice
from pathlib import Path
from time import monotonic
from typing import Any

import pytest

from bpns.symbolic import planners
from bpns.symbolic.errors import InputError, MissingPackage, Unsupported
from bpns.symbolic.grounding.ground import GroundProblem, Unreachable, ground
from bpns.symbolic.pddl.read import read_domain, read_problem
from bpns.symbolic.planners.protocol import About, AbstractPlan, Limit
from tests.symbolic._planning import check_plan, grounded, key, plans
from tests.symbolic._problems import (
    COVER,
    Graph,
    all_ground_operators,
    cover_problem,
    plans_by_length,
    searchable_task,
    state_graph,
    switches,
)

ROOT = Path(__file__).parents[2]
ABOUT = {about.name: about for about in planners.about()}
QUICK = ("astar", "kairos", "pyperplan")  # the others start a program for each question
PYPERPLAN = f"{sys.executable} -m pyperplan -s astar -H lmcut {{domain}} {{problem}}"
VARIED = (*QUICK, "kstar", "symk", "up:fast-downward", "up:symk", "command-fast-downward")
COMMANDS = {"pyperplan": f"command:{PYPERPLAN}"}
if (_driver := find_spec("up_fast_downward")) is not None and _driver.origin is not None:
    _program = Path(_driver.origin).parent / "downward" / "fast-downward.py"
    _words = "--plan-file {plan} {domain} {problem} --search 'astar(lmcut())'"
    COMMANDS["fast-downward"] = f"command:{sys.executable} {_program} {_words}"


def listed(*also_quick: str, among: Collection[str] | None = None) -> list[Any]:
    """Return planners as parameters, those that ``dev`` installs, and two commands; most are slow tests.

    The others are looked at by benchmarks/planners.py.
    """
    quick = {*QUICK, *also_quick}
    own = {n: n for n in ABOUT if n != "command" and ABOUT[n].extra not in ("planners", "tamer")}
    own |= {f"command-{name}": command for name, command in COMMANDS.items()}
    return [
        pytest.param(command, marks=() if name in quick else pytest.mark.slow, id=name)
        for name, command in own.items()
        if among is None or name in among
    ]


def in_order(name: str) -> bool:
    return name in ABOUT and ABOUT[name].optimal


def first(name: str, problem: GroundProblem, count: int) -> list[AbstractPlan]:
    """Return a planner's first plans; each is checked."""
    stream, record = plans(problem, name)
    found = list(islice(stream, count))
    assert record.fault == ""
    for plan in found:
        check_plan(problem.problem, plan)
        assert all(before != after for before, after in zip(plan.atoms, plan.atoms[1:], strict=False))
    assert len({key(plan) for plan in found}) == len(found)
    lengths = [len(plan.steps) for plan in found]
    if in_order(name):
        assert lengths == sorted(lengths)
    return found


def without_idling(graph: Graph) -> Graph:
    return {state: [(o, after) for o, after in moves if after != state] for state, moves in graph.items()}


# --------------------------------------------------------------------------------------------- plans


@pytest.mark.parametrize("planner", listed("kstar"))
def test_thirty_distinct_valid_plans(planner: str) -> None:
    found = first(planner, grounded(COVER, cover_problem(2)), 30)
    assert len(found) == 30
    if in_order(planner):
        assert [len(plan.steps) for plan in found[:3]] == [4, 4, 6]


@pytest.mark.parametrize("planner", listed(among=VARIED))
@pytest.mark.parametrize("seed", [2, 11])
def test_plans_are_those_of_brute_force(planner: str, seed: int) -> None:
    """In order of length from those that promise it; the others give some of all plans."""
    domain, problem, graph = searchable_task(seed)
    task = ground(domain, problem)
    layers = plans_by_length(problem, without_idling(graph))
    if isinstance(task, Unreachable):
        assert not any(layers)
        return
    expected = [length for length, layer in enumerate(layers) for _ in layer][:12]
    found = first(planner, task, len(expected))
    if in_order(planner):
        assert [len(plan.steps) for plan in found] == expected
    assert len(found) == len(expected)
    for plan in found:
        assert len(plan.steps) >= len(layers) or key(plan) in layers[len(plan.steps)]


FINITE = {  # each task can be done in a few ways only
    "orders": switches({"a": ("p", "x p-"), "b": ("q", "y q-"), "c": ("r", "z r-")}, "p q r", "x y z"),
    "ways": switches(
        {"a": ("p", "m p-"), "b": ("p", "n p-"), "c": ("m", "x m-"), "d": ("n", "x n-"), "e": ("p", "x p-")},
        "p",
        "x",
    ),
    "negative": switches(
        {"a": ("x-", "x"), "b": ("y- x", "y"), "c": ("y-", "y"), "d": ("t", "t-")}, "t", "x y t-"
    ),
}


@pytest.mark.parametrize("planner", listed("kstar", among=VARIED))
@pytest.mark.parametrize("task", FINITE)
def test_all_plans_of_a_task_with_few_and_then_the_end(planner: str, task: str) -> None:
    domain, problem = FINITE[task]
    graph = state_graph(problem, all_ground_operators(domain, problem), 100)
    assert graph is not None
    expected = set().union(*plans_by_length(problem, without_idling(graph)))
    assert len(expected) > 2
    stream, record = plans(grounded(domain, problem), planner)
    found = list(stream)
    assert {key(plan) for plan in found} == expected
    assert len(found) == len(expected)
    assert (record.stopped_by, record.fault) == ("", "")


@pytest.mark.parametrize("planner", listed("kstar", among=VARIED))
def test_a_task_without_a_plan_ends_without_plan_and_without_failure(planner: str) -> None:
    """Without deletions there would be one."""
    task = switches({"walk": ("home", "away home-"), "back": ("away", "home away-")}, "home", "home away")
    stream, record = plans(grounded(*task), planner)
    assert list(stream) == []
    assert (record.stopped_by, record.fault) == ("", "")


@pytest.mark.parametrize("planner", listed("kstar", among=VARIED))
def test_nothing_to_do_is_the_only_plan(planner: str) -> None:
    stream, record = plans(grounded(*switches({"walk": ("home", "away home-")}, "home", "home")), planner)
    assert [plan.steps for plan in stream] == [()]
    assert (record.stopped_by, record.fault) == ("", "")


# ---------------------------------------------------------------------------- PDDL as people write it


@pytest.mark.parametrize("planner", listed("kstar"))
def test_names_that_other_tools_do_not_take(planner: str, data: Path) -> None:
    """An operator called when, mixed case, hyphens: the operators come back under their own names."""
    folder = data / "pddl-bench"
    domain = read_domain(folder / "names-domain.pddl")
    task = grounded(domain, read_problem(folder / "names-p.pddl", domain))
    first_two = first(planner, task, 2)
    assert {plan.steps[0].operator.name for plan in first_two} <= {o.name for o in domain.operators}
    assert {len(plan.steps) for plan in first_two} == {2, 3}


def readable_cases(data: Path) -> Iterator[tuple[str, GroundProblem]]:
    """Yield the valid cases that we read and that have plans."""
    for folder in sorted((data / "pddl-cases").glob("v*")):
        try:
            domain = read_domain(folder / "domain.pddl")
            task = ground(domain, read_problem(folder / "problem.pddl", domain))
        except Unsupported:
            continue
        if isinstance(task, GroundProblem):
            yield folder.name, task


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("planner", listed(among=set(VARIED) - {"up:symk"}))
def test_cases_of_pddl(planner: str, data: Path) -> None:
    """Constants, negative conditions and goals, equality, either, untyped, clashing names, ..."""
    count = 0
    for name, task in readable_cases(data):
        wanted = first("astar", task, 1)
        found = first(planner, task, 1)
        assert len(found) == len(wanted), name
        if found and in_order(planner):
            assert len(found[0].steps) == len(wanted[0].steps), name
        count += 1
    assert count >= 20


# --------------------------------------------------------------------------------------------- limits


@pytest.mark.parametrize("planner", listed("kstar", among=VARIED))
def test_a_deadline_in_the_past_is_one(planner: str) -> None:
    stream, record = plans(grounded(COVER, cover_problem(2)), planner, Limit(1_000_000, monotonic() - 1))
    assert list(stream) == []
    assert (record.stopped_by, record.fault) == ("time limit", "")


@pytest.mark.parametrize("planner", listed(among=VARIED))
def test_a_deadline_ends_an_endless_stream(planner: str) -> None:
    stream, record = plans(grounded(COVER, cover_problem(2)), planner, Limit(10**9, monotonic() + 0.7))
    for plan in stream:
        assert plan.steps
    assert (record.stopped_by, record.fault) == ("time limit", "")


# ------------------------------------------------------------------------------------ missing packages


@pytest.mark.parametrize("about", [a for a in ABOUT.values() if a.package], ids=lambda a: a.name)
def test_a_missing_package_names_the_extra(about: About, monkeypatch: pytest.MonkeyPatch) -> None:
    real = metadata.version

    def version(package: str) -> str:
        if package == about.package:
            raise metadata.PackageNotFoundError(package)
        return real(package)

    monkeypatch.setattr("bpns.symbolic.planners.protocol.metadata.version", version)
    assert about.version is None
    with pytest.raises(MissingPackage) as caught:
        planners.load(about.name)
    text = str(caught.value)
    if "unified-planning" not in text:  # which itself may be missing here
        assert about.package in text
        assert f"pip install 'bpns[{about.extra}]'" in text


def requirements(extra: str) -> set[str]:
    """Return the packages that an extra installs, with those of extras within it."""
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    found = set()
    for line in extras[extra]:
        package, _, inner = line.partition(">")[0].partition("[")
        found |= (
            set().union(*(requirements(name) for name in inner.rstrip("]").split(",")))
            if package == "bpns"
            else {package}
        )
    return found


@pytest.mark.parametrize("about", [a for a in ABOUT.values() if a.package], ids=lambda a: a.name)
def test_an_extra_installs_what_its_planner_needs(about: About) -> None:
    assert about.package in requirements(about.extra)
    if about.name.startswith("up:"):
        assert "unified-planning" in requirements(about.extra)
    assert (about.package in requirements("planners")) == (about.extra != "tamer")


# ----------------------------------------------------------------------------------------- strangers

STRANGER = """
from bpns.symbolic.planners.astar import AStar

def create(heuristic="hff"):
    return AStar(heuristic)

def broken(a, b):
    return None
"""


def test_a_planner_from_elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "my_planner.py").write_text(STRANGER)
    (tmp_path / "my_faulty_planner.py").write_text("import no_such_module_anywhere\n")
    monkeypatch.syspath_prepend(tmp_path)
    assert planners.load("my_planner:create").name == "astar:hff"
    assert planners.load("my_planner:create:hadd").name == "astar:hadd"
    for name, message in (
        (
            "my_planner:missing",
            r"^cannot load planner 'my_planner:missing': AttributeError: .*missing.*have: astar",
        ),
        ("my_planner:broken:1", r"^planner 'my_planner:broken:1' has too many or too few options"),
        ("my_faulty_planner:create", r"ModuleNotFoundError: No module named 'no_such_module_anywhere'"),
        ("no_such_planner:create", r"^cannot load planner 'no_such_planner:create': ModuleNotFoundError"),
        ("my_planner", r"^unknown planner 'my_planner' \(have: .*or MODULE:ATTRIBUTE\)$"),
    ):
        with pytest.raises(InputError, match=message):
            planners.load(name)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("command:", r"has no \{domain\}: give a command such as "),
        ("command:no-such-program {domain} {problem}", "there is no program 'no-such-program'"),
        ("command:cat {domain}", r"has no \{problem\}"),
        ("command:cat '{domain} {problem}", "No closing quotation"),
        ("up", "planner 'up' has too many or too few options: it is up:ENGINE"),
        ("up:fastdownward", r"unknown planner 'up:fastdownward' \(did you mean 'up:fast-downward'"),
        ("kstar:10", "planner 'kstar:10' has too many or too few options"),
        ("kairos:no-such-preset", r"unknown preset 'kairos:no-such-preset' \(have: "),
    ],
)
def test_faulty_options_are_refused(name: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        planners.load(name)


@pytest.mark.slow
def test_an_engine_that_there_is_not_is_reported_with_those_that_there_are() -> None:
    stream, record = plans(grounded(COVER, cover_problem(2)), "up:no-such-engine")
    assert list(stream) == []
    assert record.stopped_by == "planner failed"
    assert "no-such-engine" in record.fault
