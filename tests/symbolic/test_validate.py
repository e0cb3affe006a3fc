"""The first fault of a plan, in words."""

import pytest

from bpns.symbolic.operators import Domain, GroundOperator, Problem
from bpns.symbolic.pddl.plan_fault import first_fault
from tests.symbolic._problems import COVER, all_ground_operators, cover_problem, switches


def steps(domain: Domain, problem: Problem, plan: str) -> list[GroundOperator]:
    """Return the ground operators that a text such as ``"Pick block0 robby, ..."`` names."""
    known = {
        " ".join([o.operator.name, *map(str, o.objects)]): o for o in all_ground_operators(domain, problem)
    }
    return [known[step] for step in plan.split(", ") if step]


COVER_BOTH = (
    "Pick block1 robby, Place block1 target1 robby, Pick block0 robby, Place block0 target0 robby, "
    "Pick block0 robby, Place block0 target1 robby"
)


@pytest.mark.parametrize(
    ("plan", "fault"),
    [
        (COVER_BOTH, ""),
        ("", "goal not reached: Covers(block0, target0), Covers(block1, target1)"),
        ("Pick block0 robby, Place block0 target0 robby", "goal not reached: Covers(block1, target1)"),
        ("Place block0 target0 robby", "step 1 Place(block0, target0, robby): needs Holding(block0, robby)"),
        ("Pick block0 robby, Pick block1 robby", "step 2 Pick(block1, robby): needs HandEmpty()"),
        (f"{COVER_BOTH}, Place block1 target1 robby", "step 7 Place(block1, target1, robby): needs Holding"),
    ],
)
def test_fault_of_a_plan_for_cover(plan: str, fault: str) -> None:
    problem = cover_problem(2)
    found = first_fault(problem, steps(COVER, problem, plan))
    assert found.startswith(fault)
    assert bool(found) == bool(fault)


MOVES = {
    "pack": ("home sober tired- late-", "packed"),
    "drive": ("packed", "away home-"),
    "drink": ("", "merry sober-"),
}


@pytest.mark.parametrize(
    ("init", "plan", "fault"),
    [
        ("home sober", "pack, drive", ""),
        ("sober late tired", "pack", "step 1 pack(): needs home(), needs not late(), needs not tired()"),
        ("home sober", "drink, pack", "step 2 pack(): needs sober()"),
        ("home sober", "pack", "goal not reached: away(), not home()"),
        ("home sober", "pack, drive, drink", "goal not reached: not merry()"),
    ],
)
def test_fault_with_negative_preconditions_and_goals(init: str, plan: str, fault: str) -> None:
    domain, problem = switches(MOVES, init, goal="away home- merry-")
    assert first_fault(problem, steps(domain, problem, plan)) == fault
