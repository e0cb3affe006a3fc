"""Reading PDDL: hand-made cases, competition files, places of faults, damaged texts."""

import json
import re
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bpns.symbolic.errors import InputError, PddlError, UnsupportedPddl
from bpns.symbolic.pddl.read import PddlWarning, parse_domain, parse_problem, read_domain, read_problem
from bpns.symbolic.structs import Object, Predicate, Type, Variable
from tests.symbolic._problems import competition_files
from tests.symbolic._texts import DOMAIN, PROBLEM, marked, read_back, read_case, replaced

UNSUPPORTED = {
    "v11": "or (a disjunction: write one action for each case)",
    "v12": ":functions (numbers and costs: leave them out, every step costs one)",
    "v13": "when (a conditional effect: write one action for each case)",
    "v14": "forall (a quantifier: write the atoms out)",
    "v15": "forall (a quantifier: write the atoms out)",
}
WARNED = {
    "i12": r"domain\.pddl:3:3: :typing is used but missing in :requirements",
    "i13": r"domain\.pddl:9:19: :negative-preconditions is used but missing in :requirements",
}


# ------------------------------------------------------------------------------- the shared cases


def test_no_shared_case_is_left_out(data: Path) -> None:
    listed = json.loads((data / "pddl-cases" / "cases.json").read_text())
    assert {name[:3] for name in listed} == {f"{kind}{n:02}" for kind in "iv" for n in range(1, 31)}


@pytest.mark.parametrize("number", [n for n in (f"i{i:02}" for i in range(1, 31)) if n not in WARNED])
def test_invalid_case_is_refused_with_its_place(data: Path, number: str) -> None:
    with pytest.raises(PddlError, match=r"/(domain|problem)\.pddl:[1-9]\d*:[1-9]\d*: \w*") as caught:
        read_case(data, number)
    assert not isinstance(caught.value, UnsupportedPddl)


@pytest.mark.parametrize("number", WARNED)
def test_missing_requirement_is_a_warning_with_its_place(data: Path, number: str) -> None:
    with pytest.warns(PddlWarning, match=WARNED[number]):
        domain, problem = read_case(data, number)
    assert read_back(domain, problem) == (domain, problem)


@pytest.mark.parametrize("number", [n for n in (f"v{i:02}" for i in range(1, 31)) if n not in UNSUPPORTED])
def test_valid_case_is_read_and_written_back(data: Path, number: str) -> None:
    domain, problem = read_case(data, number)
    assert read_back(domain, problem) == (domain, problem)


@pytest.mark.parametrize(("number", "feature"), UNSUPPORTED.items())
def test_valid_case_with_more_than_we_read_is_refused_by_the_name_of_the_feature(
    data: Path, number: str, feature: str
) -> None:
    with pytest.raises(UnsupportedPddl, match=rf"\.pddl:\d+:\d+: unsupported PDDL: {re.escape(feature)}$"):
        read_case(data, number)


COMPETITION = (
    "airport blocks depot elevators freecell gripper logistics miconic movie openstacks parcprinter pegsol "
    "psr-small rovers satellite scanalyzer sokoban tpp transport woodworking zenotravel"
)


@pytest.mark.filterwarnings("ignore::bpns.symbolic.pddl.read.PddlWarning")  # miconic forgot :typing
@pytest.mark.parametrize("folder", COMPETITION.split())
def test_competition_tasks_are_read_and_written_back(data: Path, folder: str) -> None:
    for number in (1, 2, 3):
        domain_file, problem_file = competition_files(data, folder, number)
        domain = read_domain(domain_file)
        problem = read_problem(problem_file, domain)
        assert read_back(domain, problem) == (domain, problem)


# ---------------------------------------------------------------------------------------- reading


def test_reading_finds_everything_that_the_text_says() -> None:
    domain = parse_domain(DOMAIN)
    problem = parse_problem(PROBLEM, domain)
    robot, item = Type("robot"), Type("item")
    cup = Type("cup", (), item)
    robby = Object("robby", robot)
    filled, holding = Predicate("filled", (cup,)), Predicate("holding", (robot, item))
    pick, fill = domain.operators
    assert domain.types == (robot, item, cup, Type("jug", (), item))
    assert domain.constants == (robby,)
    assert [p.signature for p in domain.predicates] == [
        "hand-empty(robot)",
        "holding(robot, item)",
        "filled(cup)",
        "done()",
    ]
    assert pick.parameters == (Variable("?r", robot), Variable("?x", item))
    assert {str(a) for a in pick.preconditions} == {"hand-empty(?r:robot)"}
    assert {str(a) for a in pick.negative_preconditions} == {"done()"}
    assert {str(a) for a in pick.add_effects} == {"holding(?r:robot, ?x:item)"}
    assert {str(a) for a in pick.delete_effects} == {"hand-empty(?r:robot)"}
    assert fill.preconditions == {holding.lifted(robby, Variable("?c", cup))}
    c1, c2 = Object("c1", cup), Object("c2", cup)
    assert problem.objects == (c1, c2, Object("j1", Type("jug", (), item)))
    assert problem.init == {Predicate("hand-empty", (robot,))(robby)}
    assert problem.goal == {filled(c1)}
    assert problem.negative_goal == {filled(c2)}


def test_case_does_not_matter_and_names_give_the_spelling() -> None:
    upper = parse_domain(DOMAIN.upper(), names={"pick": "Pick", "hand-empty": "HandEmpty", "robby": "Robby"})
    assert upper.operators[0].name == "Pick"
    assert str(next(iter(upper.operators[0].preconditions))) == "HandEmpty(?r:robot)"
    assert [str(o) for o in upper.constants] == ["Robby"]
    assert parse_domain(DOMAIN.upper()) == parse_domain(DOMAIN)


@pytest.mark.parametrize("ending", ["\r\n", "\r", "\t\n"])
def test_line_endings_do_not_matter(ending: str) -> None:
    without_comment = DOMAIN.replace("  ; a comment (with a parenthesis\n", "")
    assert parse_domain(without_comment.replace("\n", ending)) == parse_domain(DOMAIN)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("hand-empty ?r) (not", "@hand-emty ?r) (not", "unknown predicate 'hand-emty' (have: done, filled,"),
        ("(holding robby ?c)", "@(holding robby)", "holding takes 2 argument(s), not 1"),
        ("(holding robby ?c)", "(holding @robin ?c)", "unknown object 'robin' (have: robby)"),
        ("(holding robby ?c)", "(holding robby @?d)", "unknown variable '?d' (have: ?c)"),
        ("(holding robby ?c)", "@(filled robby)", "filled: argument 1 is of type robot, not cup"),
        (":parameters (?c - cup)", ":parameters (?c - @mug)", "unknown type 'mug' (have: cup, item, jug,"),
        (":action fill", ":action @pick", "a second operator 'pick': rename one"),
        (":action fill", ":action @2fill", "'2fill' is no name for an action"),
        ("(:action fill", "@(:aktion fill", "unknown section ':aktion' (have: :requirements, :types,"),
        ("(:types", "(:constants) @(:constants", "a second :constants section: merge it with the first"),
        (":strips", "@:stripes", "unknown requirement ':stripes' (have: :action-costs, :action-expa"),
        ("cup jug - item", "cup jug @-", "'-' must stand between a type and a type"),
        ("cup) (done))", "cup) @done)", "expected a predicate such as (on ?x ?y)"),
        ("(domain kitchen)", "@(problem kitchen)", "expected (domain NAME), found (problem ...)"),
        ("(done))))\n", "(done)))\n@", "the file ends inside a list: a ')' is missing"),
        ("(done))))\n", "(done))))@)\n", "')' without its '(': remove it"),
        ("(done))))\n", "(done)))) @oops\n", "'oops' outside the definition: remove it"),
    ],
)
def test_fault_in_a_domain_has_its_line_column_and_reason(old: str, new: str, message: str) -> None:
    text, place = marked(DOMAIN, old, new)
    with pytest.raises(PddlError) as caught:
        parse_domain(text, "kitchen.pddl")
    assert str(caught.value).startswith(f"kitchen.pddl:{place}: {message}")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("(:domain kitchen)", "@(:domain garage)", "this problem is not of domain 'kitchen'"),
        ("j1 - jug", "@c1 - jug", "a second object 'c1': rename one"),
        ("j1 - jug", "@robby - jug", "a second object 'robby': rename one"),
        ("(hand-empty robby)", "@(hand-empty c1)", "hand-empty: argument 1 is of type cup, not robot"),
        ("(hand-empty robby)", "@(not (done))", "(not ...) in :init: leave it out"),
        ("(filled c1)", "(filled @?c)", "unknown variable '?c' (have: none)"),
        ("(define (problem", "@(define (problem", "the problem has no :init section"),
    ],
)
def test_fault_in_a_problem_has_its_line_column_and_reason(old: str, new: str, message: str) -> None:
    text, place = marked(PROBLEM, old, new)
    if "no :init" in message:
        text = replaced(text, "  (:init (hand-empty robby))\n", "")
    with pytest.raises(PddlError) as caught:
        parse_problem(text, parse_domain(DOMAIN), "breakfast.pddl")
    assert str(caught.value).startswith(f"breakfast.pddl:{place}: {message}")


@pytest.mark.parametrize(
    ("old", "new", "feature"),
    [
        ("(holding robby ?c)", "@(or (done))", "or (a disjunction: write one action for each case)"),
        (
            "robby - robot",
            "@cup - robot",
            "an object that is called like a type ('cup' is already a type: rename the object)",
        ),
        (
            "(holding robby ?c)",
            "(not @(and (done)))",
            "(and ...) inside (not ...) (put a (not ...) on each atom)",
        ),
        (
            "(filled ?c) (done)",
            "@(when (done) (filled ?c))",
            "when (a conditional effect: write one action for each case)",
        ),
        (
            "(:constants",
            "@(:functions (total-cost)) (:constants",
            ":functions (numbers and costs: leave them out, every step costs one)",
        ),
    ],
)
def test_unsupported_feature_is_named_with_its_place(old: str, new: str, feature: str) -> None:
    text, place = marked(DOMAIN, old, new)
    with pytest.raises(UnsupportedPddl) as caught:
        parse_domain(text, "kitchen.pddl")
    assert str(caught.value) == f"kitchen.pddl:{place}: unsupported PDDL: {feature}"


def test_first_fault_of_a_formula_is_the_one_reported() -> None:
    with pytest.raises(PddlError, match="unknown predicate 'first'"):
        parse_domain(replaced(DOMAIN, "(filled ?c) (done)", "(first) (second)"))


@pytest.mark.parametrize("keyword", ["and", "not", "or", "when", "forall"])
def test_predicate_declared_with_the_name_of_a_keyword_is_refused(keyword: str) -> None:
    text, place = marked(DOMAIN, "(filled ?c - cup)", f"(@{keyword} ?c - cup)")
    with pytest.raises(PddlError, match=f"^<text>:{place}: .*'{keyword}'"):
        parse_domain(text)


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("", "1:1"),
        ("\n \n", "3:1"),
        ("; a comment", "1:12"),
        ("(" * 10_000, "1:10001"),
        (")" * 10_000, "1:1"),
    ],
)
def test_nothing_to_read_is_a_fault_with_its_place(text: str, place: str) -> None:
    with pytest.raises(PddlError, match=f"^<text>:{place}: "):
        parse_domain(text)


def test_deep_nesting_is_no_trouble() -> None:
    depth = 10_000
    deep = replaced(DOMAIN, "(holding robby ?c)", "(and " * depth + "(holding robby ?c)" + ")" * depth)
    assert parse_domain(deep) == parse_domain(DOMAIN)
    with pytest.raises(PddlError, match=r"^<text>:1:1: expected \(define"):
        parse_domain("(" * depth + ")" * depth)
    with pytest.raises(UnsupportedPddl, match=r"^<text>:11:24: .* inside \(not"):
        parse_domain(deep.replace("(and (and", "(not (and"))


def test_type_is_no_descendant_of_itself_however_long_the_chain() -> None:
    chain = " ".join(f"t{i} - t{i + 1}" for i in range(500))
    domain = parse_domain(f"(define (domain d) (:requirements :typing) (:types {chain}))")
    assert domain.types[0].is_a(domain.types[-1])
    with pytest.raises(PddlError, match="own ancestor"):
        parse_domain(f"(define (domain d) (:requirements :typing) (:types {chain} t500 - t7))")


def test_files_that_cannot_be_read_give_one_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"^cannot read .*none\.pddl: No such file or directory$"):
        read_domain(tmp_path / "none.pddl")
    with pytest.raises(InputError, match=r"^cannot read "):
        read_domain(tmp_path)
    (tmp_path / "image.pddl").write_bytes(b"(define \xff)")
    with pytest.raises(InputError, match=r"image\.pddl:1:9: expected \(domain NAME\), found '\\udcff'"):
        read_domain(tmp_path / "image.pddl")


PIECES = (
    "(",
    ")",
    "-",
    "and",
    "not",
    "?x",
    ":action",
    ":parameters",
    "either",
    "cup",
    "object",
    ";",
    "\0",
    "é",
    "",
)


@st.composite
def damaged(draw: st.DrawFn, text: str) -> str:
    """Delete, double or replace a few characters or words."""
    parts = re.findall(r"\s+|[()]|[^\s()]+", text) if draw(st.booleans()) else list(text)
    for _ in range(draw(st.integers(1, 4))):
        place = draw(st.integers(0, len(parts) - 1))
        other = draw(st.sampled_from(PIECES) | st.sampled_from(parts))
        parts[place] = draw(st.sampled_from(["", parts[place] * 2, other, f" {other} "]))
    return "".join(parts)


def check_place(error: InputError, text: str) -> None:
    assert isinstance(error, PddlError)
    assert 1 <= error.line <= text.count("\n") + 1
    assert 1 <= error.column <= len(text.split("\n")[error.line - 1]) + 1


@pytest.mark.filterwarnings("ignore::bpns.symbolic.pddl.read.PddlWarning")
@settings(deadline=None, max_examples=250)
@given(damaged(DOMAIN))
def test_damaged_domain_is_read_or_refused(text: str) -> None:
    try:
        domain = parse_domain(text)
    except InputError as error:
        check_place(error, text)
    else:
        assert read_back(domain) == (domain, None)


@settings(deadline=None, max_examples=150)
@given(damaged(PROBLEM))
def test_damaged_problem_is_read_or_refused(text: str) -> None:
    domain = parse_domain(DOMAIN)
    try:
        problem = parse_problem(text, domain)
    except InputError as error:
        check_place(error, text)
    else:
        assert read_back(domain, problem) == (domain, problem)
