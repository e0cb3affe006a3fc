import warnings
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from bpns.symbolic.errors import Unsupported
from bpns.symbolic.operators import Domain, Operator, Problem
from bpns.symbolic.pddl.read import parse_domain, parse_problem, read_domain, read_problem
from bpns.symbolic.pddl.rewriting.portable import Rewritten, portable
from bpns.symbolic.pddl.vocabulary import NAME
from bpns.symbolic.pddl.write import write_domain, write_problem
from bpns.symbolic.structs import Object, Predicate, Type, Variable
from tests.symbolic._problems import COVER, cover_problem, tasks
from tests.symbolic._rewriting import plain_plans, rewritten_plans, rich_task, rich_tasks

ROOT = Path(__file__).parents[2]


def texts(task: Rewritten) -> tuple[str, str]:
    return write_domain(task.domain), write_problem(task.problem, task.domain)


# ----------------------------------------------------------------------------------------- meaning


@settings(max_examples=150)
@given(rich_tasks(), st.booleans(), st.booleans(), st.booleans())
def test_a_rewritten_task_has_the_same_plans(
    task: tuple[Domain, Problem], negation: bool, equality: bool, typing: bool
) -> None:
    before = plain_plans(*task)
    assume(before is not None)
    rewritten = portable(*task, negation, equality, typing)
    assert rewritten_plans(rewritten) == before
    read = parse_domain(write_domain(rewritten.domain))  # and what is written says the same
    assert parse_problem(texts(rewritten)[1], read) == replace(
        rewritten.problem, name=rewritten.problem.name.lower()
    )


@settings(max_examples=60)
@given(rich_tasks(), st.booleans())
def test_what_a_planner_lacks_is_gone(task: tuple[Domain, Problem], typing: bool) -> None:
    rewritten = portable(*task, False, False, typing)
    domain, problem = rewritten.domain, rewritten.problem
    assert not problem.negative_goal
    assert not any(o.negative_preconditions for o in domain.operators)
    assert not any(a.predicate.name == "=" for o in domain.operators for a in o.preconditions)
    assert not any(t.either for t in domain.types)
    assert typing or not domain.types


def test_complements_are_listed_only_where_they_can_matter() -> None:
    place = Type("place")
    x, y = Variable("?x", place), Variable("?y", place)
    road, blocked = Predicate("road", (place, place)), Predicate("blocked", (place, place))
    at = Predicate("at", (place,))
    go = Operator(
        "go",
        (x, y),
        frozenset({at.lifted(x), road.lifted(x, y)}),
        frozenset({at.lifted(y)}),
        frozenset({at.lifted(x)}),
        frozenset({blocked.lifted(x, y)}),
    )
    places = tuple(Object(f"p{i}", place) for i in range(30))
    roads = {road(a, b) for a, b in pairwise(places)}
    problem = Problem("trip", places, frozenset({at(places[0]), *roads}), frozenset({at(places[-1])}))
    task = portable(Domain("roads", (place,), (road, blocked, at), (go,)), problem, False, False)
    assert sum(a.predicate.name == "not-blocked" for a in task.problem.init) == 29  # of 900


def test_an_atom_that_is_deleted_and_added_holds_whatever_its_complement() -> None:
    thing = Type("thing")
    x, y = Variable("?x", thing), Variable("?y", thing)
    lit = Predicate("lit", (thing,))
    done = Predicate("done", ())
    swap = Operator("swap", (x, y), frozenset(), frozenset({lit.lifted(x)}), frozenset({lit.lifted(y)}))
    end = Operator(
        "end", (x,), frozenset(), frozenset({done.lifted()}), frozenset(), frozenset({lit.lifted(x)})
    )
    lamp = Object("lamp", thing)
    domain = Domain("lamps", (thing,), (lit, done), (swap, end))
    problem = Problem("one", (lamp,), frozenset({lit(lamp)}), frozenset({done()}))
    assert rewritten_plans(portable(domain, problem, False, False)) == plain_plans(domain, problem)


# ------------------------------------------------------------------------------------------- names


@settings(max_examples=60)
@given(tasks(), st.booleans())
def test_names_are_legal_unique_and_lead_back(task: tuple[Domain, Problem], typing: bool) -> None:
    domain, problem = task
    rewritten = portable(domain, problem, False, False, typing)
    new, told = rewritten.domain, rewritten.problem
    names = [t.name for t in new.types] + [p.name for p in new.predicates]
    names += [o.name for o in new.operators] + [o.name for o in (*new.constants, *told.objects)]
    assert len(set(names)) == len(names)
    assert all(NAME.match(name) for name in names)
    old = {o.name for o in (*domain.constants, *problem.objects)}
    assert set(rewritten.objects.values()) == old
    assert {origin.operator for origin in rewritten.operators.values()} == {o.name for o in domain.operators}


def test_names_that_are_fine_stay_and_others_say_what_they_were() -> None:
    cup, jug = Type("cup"), Type("Jug")
    x = Variable("?x", cup)
    predicates = Predicate("cup", (cup,)), Predicate("Full", (cup,)), Predicate("full", (jug,))
    add = frozenset({predicates[0].lifted(x)})
    operators = tuple(Operator(n, (x,), frozenset(), add, frozenset()) for n in ("when", "pick up", "2nd"))
    domain = Domain("Kitchen", (cup, jug), predicates, operators)
    objects = Object("red", cup), Object("Red", jug), Object("jug", jug)
    rewritten = portable(domain, Problem("p", objects, frozenset(), frozenset()), True, True)
    assert [t.name for t in rewritten.domain.types] == ["cup", "jug-type"]
    assert [p.name for p in rewritten.domain.predicates][:3] == ["cup-predicate", "full-predicate", "full"]
    assert [o.name for o in rewritten.domain.operators] == ["when-operator", "pick-up", "operator-2nd"]
    assert [o.name for o in rewritten.problem.objects] == ["red", "red-object", "jug"]
    assert rewritten.original("WHEN-Operator", ["Red-Object"]) == ("when", ("Red",))


@pytest.mark.parametrize(
    ("name", "arguments", "text"),
    [
        ("throw", [], "unknown operator 'throw'"),
        ("pick", ["block0"], "'pick' takes 2 object(s), not 1"),
        ("pick", ["block0", "moon"], "unknown object 'moon' in a step of 'pick'"),
    ],
)
def test_a_step_that_does_not_exist_is_named(name: str, arguments: list[str], text: str) -> None:
    rewritten = portable(COVER, cover_problem(1), True, True)
    with pytest.raises(ValueError) as error:  # noqa: PT011 - the text is compared below
        rewritten.original(name, arguments)
    assert text in str(error.value)


def test_an_empty_goal_becomes_an_atom_that_holds() -> None:
    rewritten = portable(COVER, replace(cover_problem(1), goal=frozenset()), False, False)
    assert len(rewritten.problem.goal) == 1
    assert rewritten.problem.goal <= rewritten.problem.init


# ----------------------------------------------------------------------------------- other readers


def accept(task: Rewritten, folder: Path) -> None:
    """Let kairos, unified-planning and pyperplan read a task; the last needs it free of extras."""
    kairos = pytest.importorskip("kairos")
    io = pytest.importorskip("unified_planning.io")
    parser = pytest.importorskip("pyperplan.pddl.parser")
    domain_text, problem_text = texts(task)
    assert kairos.check_domain(domain_text).diagnostics == []
    assert kairos.check_problem(problem_text, domain_text).diagnostics == []
    io.PDDLReader().parse_problem_string(domain_text, problem_text)
    domain, problem = task.domain, task.problem
    atoms = [a for o in domain.operators for a in o.preconditions | o.negative_preconditions]
    if problem.negative_goal or any(o.negative_preconditions for o in domain.operators):
        return
    if any(a.predicate.name == "=" for a in atoms):
        return
    (folder / "domain.pddl").write_text(domain_text)
    (folder / "problem.pddl").write_text(problem_text)
    reader = parser.Parser(str(folder / "domain.pddl"), str(folder / "problem.pddl"))
    known = reader.parse_domain()
    assert len(known.actions) == len(domain.operators)
    assert len(reader.parse_problem(known).initial_state) == len(problem.init)


@settings(max_examples=12)  # unified-planning reads slowly
@given(tasks(), st.booleans(), st.booleans())
@example((COVER, cover_problem(3)), False, True)
def test_every_reader_takes_random_tasks(
    tmp_path_factory: pytest.TempPathFactory,
    task: tuple[Domain, Problem],
    negation: bool,
    typing: bool,
) -> None:
    accept(portable(*task, negation, negation, typing), tmp_path_factory.mktemp("task"))


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("lacking", [False, True])
def test_every_reader_takes_tasks_with_equality_and_either(tmp_path: Path, seed: int, lacking: bool) -> None:
    accept(portable(*rich_task(seed), not lacking, not lacking), tmp_path)


def collections(data: Path) -> dict[str, list[tuple[Path, Path]]]:
    """Return domain and problem files by collection."""
    bench, competition = data / "pddl-bench", data / "pddl"
    found = {
        "bench": [
            (bench / f"{p.stem.split('-')[0].replace('unsolv', 'cover')}-domain.pddl", p)
            for p in sorted(bench.glob("*.pddl"))
            if not p.stem.endswith("-domain")
        ],
        "cases": [(p / "domain.pddl", p / "problem.pddl") for p in sorted((data / "pddl-cases").glob("v*"))],
        "learned": [(p.parent / "domain.pddl", p) for p in sorted(ROOT.glob("pddl_out/*/p*.pddl"))],
        "competitions": [],
    }
    for task in sorted(competition.glob("*/task*.pddl")):
        own = task.with_name(task.name.replace("task", "domain"))
        found["competitions"].append((own if own.exists() else task.with_name("domain.pddl"), task))
    return found


@pytest.mark.slow
@pytest.mark.parametrize("lacking", [False, True])
@pytest.mark.parametrize(
    ("collection", "least"), [("bench", 12), ("cases", 24), ("learned", 40), ("competitions", 63)]
)
def test_every_reader_takes_all_files(
    data: Path, tmp_path: Path, collection: str, least: int, lacking: bool
) -> None:
    read = 0
    for domain_file, problem_file in collections(data)[collection]:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                domain = read_domain(domain_file)
                problem = read_problem(problem_file, domain)
            except Unsupported:
                continue
        accept(portable(domain, problem, not lacking, not lacking), tmp_path)
        read += 1
    assert read >= least
