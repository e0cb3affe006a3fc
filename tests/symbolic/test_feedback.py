"""Chances and penalties: what outcomes mean for ground operators alike and unlike."""

from hypothesis import given
from hypothesis import strategies as st

from bpns.symbolic.bilevel.feedback import Feedback, Sharing
from bpns.symbolic.operators import GroundOperator
from bpns.symbolic.planners.costs import Costs
from tests.symbolic._planning import grounded
from tests.symbolic._problems import COVER, cover_problem

OPERATORS = grounded(COVER, cover_problem(3)).operators
OUTCOMES = st.lists(st.tuples(st.sampled_from(range(len(OPERATORS))), st.booleans()), max_size=40)


def counted(outcomes: list[tuple[int, bool]], sharing: Sharing | None = None) -> Feedback:
    feedback = Feedback(OPERATORS, Costs(), sharing or Sharing())
    for number, success in outcomes:
        feedback.count((OPERATORS[number],), success)
    feedback.update([(OPERATORS[number],) for number, _ in outcomes])
    return feedback


@given(OUTCOMES, st.sampled_from(OPERATORS))
def test_chances_follow_outcomes(outcomes: list[tuple[int, bool]], operator: GroundOperator) -> None:
    feedback = counted(outcomes)
    before = feedback.chance(operator)
    assert 0 < before <= 1
    assert feedback.costs.of(operator) >= 1
    feedback.count((operator,), success=False)
    assert feedback.chance(operator) < before
    lower = feedback.chance(operator)
    feedback.count((operator,), success=True)
    assert feedback.chance(operator) > lower


@given(OUTCOMES, st.sampled_from(OPERATORS))
def test_penalties_are_those_of_the_chances(
    outcomes: list[tuple[int, bool]], operator: GroundOperator
) -> None:
    """Without outcomes of its own or of others alike there is no penalty; else it grows as chances fall."""
    feedback = counted(outcomes)
    told = [n for n, _ in outcomes if OPERATORS[n].add_effects == operator.add_effects]
    failed = [n for n, success in outcomes if n in told and not success]
    assert (feedback.costs.of(operator) > 1) == bool(failed)


def test_others_that_do_the_same_share_the_blame() -> None:
    """Two operators with equal add effects, and one that differs."""
    first = OPERATORS[0]
    twin = GroundOperator(
        first.operator,
        first.objects[::-1],
        first.preconditions,
        first.add_effects,
        first.delete_effects,
        first.negative_preconditions,
    )
    other = next(o for o in OPERATORS if o.add_effects != first.add_effects)
    feedback = Feedback([first, twin, other], Costs())
    for _ in range(3):
        feedback.count((first,), success=False)
    feedback.update([(first,)])
    assert feedback.chance(first) < feedback.chance(twin) < feedback.chance(other) == 1
    assert feedback.costs.of(first) > feedback.costs.of(twin) > feedback.costs.of(other) == 1
    feedback.count((twin,), success=True)
    feedback.count((twin,), success=True)
    assert feedback.chance(twin) > 0.7 > 0.3 > feedback.chance(first)


def test_a_step_that_fails_only_after_others_is_not_blamed_elsewhere() -> None:
    first, second = OPERATORS[0], OPERATORS[-1]
    feedback = Feedback(OPERATORS, Costs())
    for _ in range(4):
        feedback.count((first, second), success=False)
        feedback.count((second,), success=True)
    feedback.update([(first, second), (second,)])
    assert feedback.costs.of_prefix((first, second)) > 0 == feedback.costs.of_prefix((second,))
    assert feedback.costs.of_plan([first, second, first]) > feedback.costs.of_plan([second, first, first])
