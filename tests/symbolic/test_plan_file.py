"""Reading plan files: what planners write, and one clear error for what is no plan."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bpns.symbolic.errors import PddlError
from bpns.symbolic.pddl.plan_file import Step, ground_steps, parse_plan, parse_plans
from tests.symbolic._problems import COVER, all_ground_operators, cover_problem

PLAN = [("pick", "block0", "robby"), ("place", "block0", "target0", "robby")]


@pytest.mark.parametrize(
    "text",
    [
        "(pick block0 robby)\n(place block0 target0 robby)\n; cost = 2 (unit cost)\n",  # Fast Downward
        "; a plan\n\n  ( PICK Block0\trobby )  \r\n\r\n(PLACE BLOCK0 TARGET0 ROBBY) ; done",
        "0.000: (pick block0 robby)  [1.000]\n0.001: (place block0 target0 robby)  [1.000]\n",
        "0: (PICK BLOCK0 ROBBY) [1]\n1: (PLACE BLOCK0 TARGET0 ROBBY) [1]",
        ".5:(pick block0 robby)[1.0]\n2.:(place block0 target0 robby)[1.0]",
        "10.0: (place block0 target0 robby)\n9.0: (pick block0 robby)\n",  # times count, not lines
        "; plan 1, 2 steps, astar:lmcut\n(pick block0 robby)\n(place block0 target0 robby)\n",
    ],
)
def test_plan_as_planners_write_it(text: str) -> None:
    assert [step.words for step in parse_plan(text)] == PLAN
    assert [[step.words for step in plan] for plan in parse_plans(text)] == [PLAN]


def test_steps_know_their_lines() -> None:
    assert parse_plan("; first\n(a)\n\n(b c)\n") == [Step(("a",), 2), Step(("b", "c"), 4)]


@pytest.mark.parametrize("text", ["", "\n \n", "; cost = 0 (unit cost)\n", "; plan 1, 0 steps, astar\n"])
def test_plan_without_steps(text: str) -> None:
    assert parse_plans(text) == [[]]


def test_several_plans_as_we_print_them() -> None:
    text = "; plan 1, 1 steps, astar\n(a)\n; plan 2, 0 steps, astar\n; plan 3, 2 steps, astar\n(b)\n(c)\n"
    assert [[s.words[0] for s in plan] for plan in parse_plans(text)] == [["a"], [], ["b", "c"]]
    assert [[s.line for s in plan] for plan in parse_plans(text)] == [[2], [], [5, 6]]


def test_steps_before_the_first_title_are_a_plan() -> None:
    assert [len(plan) for plan in parse_plans("(a)\n(b)\n; plan 1\n(c)\n")] == [2, 1]


@pytest.mark.parametrize(
    ("line", "column"),
    [
        ("no plan exists: the goal is out of reach", 1),
        ("  (pick block0 robby", 3),
        ("pick block0 robby", 1),
        ("(a) (b)", 1),
        ("(a (b))", 1),
        ("()", 1),
        ("0.0 (a)", 1),
        ("-1: (a)", 1),
        ("(a) [1", 1),
        ("\x00\x1b[2J", 1),
    ],
)
def test_line_that_is_no_step_is_named(line: str, column: int) -> None:
    for parse in (parse_plan, parse_plans):
        with pytest.raises(PddlError, match=rf"^p\.txt:3:{column}: expected one step such as") as caught:
            parse(f"; comment\n(a)\n{line}\n(b)\n", "p.txt")
        assert str(caught.value).isprintable()


@given(st.text())
def test_any_text_is_read_or_refused_with_a_line(text: str) -> None:
    try:
        plans = parse_plans(text)
    except PddlError as error:
        line = error.line
    else:
        line = max((step.line for plan in plans for step in plan), default=1)
    assert 1 <= line <= text.count("\n") + 1


@given(st.lists(st.sampled_from(all_ground_operators(COVER, cover_problem(3))), max_size=5))
def test_what_we_write_is_read_and_grounded(steps: list[object]) -> None:
    problem = cover_problem(3)
    text = "".join(f"{step.call}\n" for step in steps)  # type: ignore[attr-defined]
    assert ground_steps(parse_plan(text), COVER, problem) == steps


@pytest.mark.parametrize(
    ("step", "fault"),
    [
        ("(grab block0 robby)", "unknown operator 'grab' (have: pick, place)"),
        (
            "(pick block9 robby)",
            "(pick block9 robby): unknown object 'block9' (have: block0, block1, robby, target0, target1)",
        ),
        ("(pick block0)", "(pick block0): Pick takes 2 objects, not 1"),
        ("(pick robby block0)", "(pick robby block0): Pick: robby is no block"),
    ],
)
def test_step_that_fits_no_operator_is_named(step: str, fault: str) -> None:
    with pytest.raises(PddlError) as caught:
        ground_steps(parse_plan(f"(pick block0 robby)\n{step}\n"), COVER, cover_problem(2), "plan.txt")
    assert str(caught.value) == f"plan.txt:2:1: {fault}"


def test_names_in_a_message_are_not_a_flood() -> None:
    with pytest.raises(PddlError, match=r"have: block0, block1, .*, and 31 more\)$"):
        ground_steps(parse_plan("(pick block99 robby)"), COVER, cover_problem(20))


def test_domain_with_mixed_case(data: Path) -> None:
    from bpns.symbolic.pddl.read import parse_domain, parse_problem

    folder = data / "pddl-cases" / "v06-mixed-case-mismatch"
    domain = parse_domain((folder / "domain.pddl").read_text())
    problem = parse_problem((folder / "problem.pddl").read_text(), domain)
    some = all_ground_operators(domain, problem)[0]
    assert ground_steps(parse_plan(some.call.upper()), domain, problem) == [some]
