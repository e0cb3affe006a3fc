"""Competition files and what people write: read, refused by name, read by others, solved like others."""

import warnings
from pathlib import Path
from random import Random

import numpy as np
import pytest

from bpns.symbolic import planners
from bpns.symbolic.errors import PddlError, UnsupportedPddl
from bpns.symbolic.grounding.ground import GroundProblem, ground
from bpns.symbolic.operators import Domain, GroundOperator, Operator, Problem
from bpns.symbolic.pddl.read import PddlWarning, parse_domain, parse_problem, read_domain
from bpns.symbolic.pddl.write import write_domain, write_problem
from bpns.symbolic.planners.protocol import Limit, SearchRecord
from bpns.symbolic.structs import EQUAL, Object, Type
from tests.symbolic._problems import competition_task
from tests.symbolic._texts import DOMAIN, marked, read_back, read_case, replaced


def domain_with(
    types: str = "a b - object c",
    predicates: str = "(p ?x - (either a b)) (q ?x)",
    action: str = ":parameters (?x - a ?y - b) :precondition (and (p ?x) (not (= ?x ?y))) :effect (q ?x)",
    extra: str = "",
) -> str:
    flags = ":equality :strips :negative-preconditions :typing"
    return (
        f"(define (domain d) {extra} (:action m {action})\n"
        f"(:predicates {predicates}) (:types {types}) (:requirements {flags}))"
    )


def problem_with(
    objects: str = "x - a y - b z - c", init: str = "(p x)", goal: str = "(q x)", extra: str = ""
) -> str:
    return f"(define (problem t) (:domain d) (:objects {objects}) (:init {init}) (:goal {goal}) {extra})"


def read_both(domain: str, problem: str) -> tuple[Domain, Problem]:
    read = parse_domain(domain)
    return read, parse_problem(problem, read)


# ---------------------------------------------------------------------------------------- either


def test_either_is_read_written_and_checked() -> None:
    domain, problem = read_both(domain_with(), problem_with())
    kind = domain.predicates[0].types[0]
    assert kind.name == "(either a b)"
    assert kind.either == (Type("a"), Type("b"))
    assert "(p ?x0 - (either a b))" in write_domain(domain)
    assert read_back(domain, problem) == (domain, problem)
    with pytest.raises(PddlError, match=r"p: argument 1 is of type c, not \(either a b\)"):
        read_both(domain_with(), problem_with(init="(p z)"))


def test_parameter_of_either_takes_objects_of_both_types_and_no_other() -> None:
    action = ":parameters (?x - (either a b)) :precondition (p ?x) :effect (q ?x)"
    domain, problem = read_both(domain_with(action=action), problem_with(init="(p x) (p y)"))
    found = ground(domain, problem)
    assert isinstance(found, GroundProblem)
    assert [str(o) for o in found.operators] == ["m(x)", "m(y)"]


@pytest.mark.parametrize(
    ("number", "length"),
    [(1, 1), (2, 6), (3, 6)],  # of pyperplan's A* with LM-cut
)
def test_zenotravel_is_solved(data: Path, number: int, length: int) -> None:
    found = ground(*competition_task(data, "zenotravel", number))
    assert isinstance(found, GroundProblem)
    limit = Limit(10**6, float("inf"))
    plan = next(planners.load("astar").plans(found, np.random.default_rng(0), limit, SearchRecord()))
    assert len(plan.steps) == length


# -------------------------------------------------------------------------------------- equality

EQUALITIES = ("(= ?x ?y)", "(not (= ?x ?y))", "(= ?x x1)", "(not (= x1 ?y))", "(= x1 x1)", "(not (= ?x ?x))")
LINKS = ("(r ?x ?y)", "(r ?y ?z)", "(s ?z)", "(not (r ?z ?x))")


@pytest.mark.parametrize("seed", range(60))
def test_grounding_with_equality_equals_the_filtered_cross_product(seed: int) -> None:
    rng = Random(seed)
    atoms = [a.replace("?y", rng.choice(("?y", "?z"))) for a in rng.sample(EQUALITIES, rng.randint(1, 3))]
    condition = " ".join(atoms + rng.sample(LINKS, rng.randint(0, 3)))
    domain = parse_domain(
        "(define (domain d) (:requirements :adl) (:types a b - c) (:constants x1 - a)"
        "(:predicates (r ?x ?y) (s ?x) (done ?x ?y ?z))"
        "(:action grow :parameters (?x ?y) :precondition (r ?x ?y) :effect (s ?y))"
        f"(:action act :parameters (?x - {rng.choice('abc')} ?y - {rng.choice('abc')} ?z)"
        f" :precondition (and {condition}) :effect (and (done ?x ?y ?z) (s ?x))))"
    )
    names = ["x1", "x2", "y1", "y2"]
    init = " ".join(f"(r {rng.choice(names)} {rng.choice(names)})" for _ in range(6))
    text = f"(define (problem p) (:domain d) (:objects x2 - a y1 y2 - b) (:init (s y1) {init}) (:goal (and)))"
    problem = parse_problem(text, domain)
    found = ground(domain, problem)
    assert isinstance(found, GroundProblem)
    assert read_back(domain, problem) == (domain, problem)
    assert set(map(str, found.operators)) == _reachable(domain, problem)
    for operator in found.operators:
        assert all(a.predicate != EQUAL for a in operator.preconditions | operator.negative_preconditions)


def _reachable(domain: Domain, problem: Problem) -> set[str]:
    """Return the ground operators of a delete relaxation, by trying all tuples of objects again and again."""
    objects = (*domain.constants, *problem.objects)
    atoms, used = set(problem.init), set()
    while True:
        before = len(atoms), len(used)
        for operator in domain.operators:
            for chosen in np.ndindex(*[len(objects)] * len(operator.parameters)):
                step = _step(operator, tuple(objects[i] for i in chosen))
                permanent = step and step.negative_preconditions & problem.init  # nothing deletes here
                if step and step.preconditions <= atoms and not permanent:
                    used.add(str(step))
                    atoms |= step.add_effects
        if before == (len(atoms), len(used)):
            return used


def _step(operator: Operator, objects: tuple[Object, ...]) -> GroundOperator | None:
    try:
        return operator.ground(objects)
    except ValueError:
        return None


def test_operator_with_equality_says_what_is_violated() -> None:
    domain, problem = read_both(
        domain_with(action=":parameters (?x ?y) :precondition (not (= ?x ?y)) :effect (q ?x)"), problem_with()
    )
    x, y, _ = problem.objects
    assert domain.operators[0].ground((x, y)).negative_preconditions == frozenset()
    with pytest.raises(ValueError, match=r"^m: x and x must differ$"):
        domain.operators[0].ground((x, x))
    same = parse_domain(domain_with(action=":parameters (?x ?y) :precondition (= ?x ?y) :effect (q ?x)"))
    with pytest.raises(ValueError, match=r"^m: x and y must be one object$"):
        same.operators[0].ground((x, y))
    assert "(= ?x ?y)" in write_domain(same)
    assert ":equality" in write_domain(same)


def test_equality_binds_what_nothing_else_binds() -> None:
    names = " ".join(f"?v{i}" for i in range(8))
    equal = " ".join(f"(= ?v{i} ?v{i + 1})" for i in range(7))
    action = f":parameters ({names}) :precondition (and {equal}) :effect (q ?v0)"
    objects = " ".join(f"o{i}" for i in range(40))  # 40 ** 8 tuples, 40 of them with one object
    domain, problem = read_both(domain_with(action=action), problem_with(objects, "", "(q o7)"))
    found = ground(domain, problem)
    assert isinstance(found, GroundProblem)
    assert len(found.operators) == 40


def test_equality_in_a_goal_is_decided_when_it_is_read() -> None:
    _, problem = read_both(domain_with(), problem_with(goal="(and (q x) (= x x) (not (= x y)))"))
    assert [str(a) for a in problem.goal] == ["q(x)"]
    assert not problem.negative_goal


# -------------------------------------------------------------------- what people write: read


@pytest.mark.parametrize(
    ("domain", "problem", "warning"),
    [
        ({"types": "area - object a b - object area - a c"}, {}, "type 'area' is declared twice"),
        ({"types": "object a b - object c - object"}, {}, ""),
        ({"types": "a - thing c b - object"}, {}, ""),  # a parent that is not declared, another order
        ({"extra": "(:constants x - a)"}, {}, "'x' is a constant of the domain already"),
        ({"predicates": "(= ?x ?y) (p ?x - (either a b)) (q ?x)"}, {}, "'=' is built in"),
        ({}, {"extra": "(:length (:serial 4))"}, ":length is ignored"),
        ({}, {"extra": "(:metric minimize (total-time))"}, ":metric is ignored"),
        ({"action": ":effect (and)"}, {"goal": "()"}, ""),
        ({"action": ":parameters () :precondition () :effect ()"}, {"goal": "(and (and) (and (q x)))"}, ""),
        ({"predicates": "(p ?x - (either a)) (q ?x)"}, {}, ""),
    ],
)
def test_odd_but_clear_files_are_read(domain: dict[str, str], problem: dict[str, str], warning: str) -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        task = read_both(domain_with(**domain), problem_with(**problem))
    assert [str(w.message).partition(": ")[2][: len(warning)] for w in caught] == (
        [warning] if warning else []
    )
    assert all(w.category is PddlWarning for w in caught)
    assert read_back(*task) == task


def test_titles_mean_nothing_and_may_begin_with_a_digit() -> None:
    with pytest.warns(PddlWarning, match=r"'2d\.1' is no name for a domain: it is called domain-2d-1"):
        domain = parse_domain(replaced(domain_with(), "(domain d)", "(domain 2d.1)"))
    text = replaced(
        replaced(problem_with(), "(problem t)", "(problem 5-4-3)"), "(:domain d)", "(:domain 2d.1)"
    )
    with pytest.warns(PddlWarning, match="'5-4-3' is no name for a problem: it is called problem-5-4-3"):
        problem = parse_problem(text, domain)
    assert read_back(domain, problem) == (domain, problem)


@pytest.mark.parametrize("end", ["; the end", " ;", "\n\n", "\t", "\r\n; (a ( comment\r\n"])
def test_what_follows_a_definition_is_no_fault(end: str) -> None:
    assert parse_domain(DOMAIN + end) == parse_domain(DOMAIN)


def test_marks_of_editors_are_no_fault(tmp_path: Path) -> None:
    (tmp_path / "d.pddl").write_bytes(b"\xef\xbb\xbf" + DOMAIN.replace("\n", "\r\n").encode())
    assert read_domain(tmp_path / "d.pddl") == parse_domain(DOMAIN)


# ----------------------------------------------------------------- what people write: refused


@pytest.mark.parametrize(
    ("domain", "problem", "feature"),
    [
        (
            {"types": "a b - object c - a c - b"},
            {},
            "a type with several parents ('c' specialises both a and b",
        ),
        ({"types": "a b c - (either a b)"}, {}, "either as the parent of a type"),
        ({}, {"objects": "x - (either a b)"}, "either as the type of an object"),
        ({}, {"objects": "x a - a"}, "an object that is called like a type"),
        ({}, {"extra": "(:metric minimize (total-cost))"}, ":metric (numbers and costs"),
        ({}, {"init": "(= (total-cost) 0)"}, "= between numbers"),
        ({"action": ":parameters (?x) :precondition (= (f ?x) 3) :effect (q ?x)"}, {}, "= between numbers"),
        ({"action": ":parameters (?x) :effect (increase (total-cost) 1)"}, {}, "increase (numbers and costs"),
        (
            {"action": ":parameters (?x) :vars (?y) :effect (q ?x)"},
            {},
            ":vars (variables beside the parameters",
        ),
        ({"extra": "(:timeless (q x))"}, {}, ":timeless (atoms that always hold"),
        ({"extra": "(:derived (q ?x) (p ?x))"}, {}, ":derived (derived predicates"),
        ({}, {"goal": "(= x y)"}, "a goal that never holds (x and y are two objects"),
        ({}, {"goal": "(not (= x x))"}, "a goal that never holds (x and x are one object"),
        ({}, {"goal": "(forall (?x) (q ?x))"}, "forall (a quantifier"),
        ({}, {"goal": "(or (q x) (q y))"}, "or (a disjunction"),
    ],
)
def test_features_that_we_lack_are_named(
    domain: dict[str, str], problem: dict[str, str], feature: str
) -> None:
    with pytest.raises(UnsupportedPddl) as caught:
        read_both(domain_with(**domain), problem_with(**problem))
    assert caught.value.message.startswith(f"unsupported PDDL: {feature}")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("(filled ?c) (done)", "(filled ?c) @(= ?c ?c)", "an effect cannot change what '=' says: remove it"),
        ("(holding robby ?c)", "@(= ?c)", "= takes 2 argument(s), not 1"),
        ("(holding robby ?c)", "(= ?c @?d)", "unknown variable '?d' (have: ?c)"),
        ("(filled ?c - cup)", "(filled ?c - (either cup @mug))", "unknown type 'mug'"),
        ("(filled ?c - cup)", "(filled ?c - @(either))", "expected a type, or (either a b), found a list"),
        ("cup jug - item", "cup jug - item @cup", "a second type 'cup': remove it"),
        ("cup jug - item", "cup jug - item @object - cup", "'object' is the root of all types"),
        (":parameters (?c - cup)", ":parameters (?c - cup) @:name x", "unknown part ':name' of action fill"),
    ],
)
def test_faults_have_their_place(old: str, new: str, message: str) -> None:
    text, place = marked(DOMAIN, old, new)
    with pytest.raises(PddlError) as caught:
        parse_domain(text, "kitchen.pddl")
    assert not isinstance(caught.value, UnsupportedPddl)
    assert str(caught.value).startswith(f"kitchen.pddl:{place}: {message}")


@pytest.mark.parametrize("word", ["x" * 10_000, "\x1b[31m", "a\0b", "\udc80"])
def test_messages_are_short_and_printable(word: str) -> None:
    with pytest.raises(PddlError) as caught:
        parse_domain(replaced(DOMAIN, "(holding robby ?c)", f"({word} ?c)"))
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 300


# --------------------------------------------------------------------------------- other readers


@pytest.mark.parametrize("number", ["v10", "v09", "v19", "v07"])
def test_kairos_reads_equality_and_either_as_we_write_them(data: Path, number: str) -> None:
    kairos = pytest.importorskip("kairos")
    domain, problem = read_case(data, number)
    checked = kairos.check_problem(write_problem(problem, domain), write_domain(domain))
    assert checked.diagnostics == []


def test_unified_planning_reads_equality_as_we_write_it(data: Path) -> None:
    io = pytest.importorskip("unified_planning.io")
    domain, problem = read_case(data, "v10")
    read = io.PDDLReader().parse_problem_string(write_domain(domain), write_problem(problem, domain))
    assert "not (a == b)" in str(read.action("pour")).replace("(not", "not")
