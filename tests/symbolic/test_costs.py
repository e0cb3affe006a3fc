"""Costs that change while plans are taken: against all plans found by brute force."""

from itertools import islice
from random import Random
from unittest.mock import patch

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bpns.symbolic.grounding.ground import Unreachable, ground
from bpns.symbolic.operators import Domain, GroundOperator, Problem
from bpns.symbolic.planners.astar import AStar
from bpns.symbolic.planners.astar import best_first as _best_first
from bpns.symbolic.planners.costs import Costs
from bpns.symbolic.planners.protocol import Limit, SearchRecord
from tests.symbolic._planning import AMPLE, check_plan, grounded, key
from tests.symbolic._problems import (
    COVER,
    Graph,
    PlanKey,
    cover_problem,
    plans_by_length,
    searchable_tasks,
    steps_as_time,
)


def operators() -> tuple[GroundOperator, ...]:
    return grounded(COVER, cover_problem(2)).operators


def test_an_operator_costs_one_until_it_has_a_penalty() -> None:
    costs, (first, second, *_) = Costs(), operators()
    assert (costs.of(first), costs.version) == (1, 0)
    costs.set_penalty(first, 0.5)
    assert (costs.of(first), costs.of(second)) == (1.5, 1)
    assert costs.of_plan([first, second, first]) == 4
    costs.set_penalty(first, 0.25)
    assert costs.of(first) == 1.25
    costs.set_penalty(first, 0)
    assert costs.of(first) == 1


def test_version_grows_with_each_change_and_changes_are_listed() -> None:
    costs, (first, second, *_) = Costs(), operators()
    costs.set_penalty(first, 0)
    assert costs.version == 0
    costs.set_penalty(first, 2)
    before = costs.version
    costs.set_penalty(first, 2)
    assert costs.version == before
    costs.set_penalty(second, 2)
    assert costs.version > before
    assert list(costs.changed_since(before)) == [second]
    assert list(costs.changed_since(0)) == [first, second]


def test_no_plan_may_begin_with_a_closed_prefix() -> None:
    costs, (first, second, *_) = Costs(), operators()
    costs.close((first, second))
    assert costs.of_plan([first, second]) == costs.of_plan([first, second, first]) == float("inf")
    assert costs.of_plan([first]) == 1
    assert costs.of_plan([second, first]) == 2
    assert list(costs.closed_since(0)) == [(first, second)]
    version = costs.version
    costs.close((first, second, first))  # it is closed already
    costs.set_prefix_penalty((first, second), 3)
    assert costs.version == version
    assert not costs.is_closed((first,))
    with pytest.raises(ValueError, match="at least one step"):
        costs.close(())


def test_sums_do_not_depend_on_their_order() -> None:
    costs, steps = Costs(), operators()
    for number, step in enumerate(steps):
        costs.set_penalty(step, 0.1 * number)
    assert costs.of_plan(steps) == costs.of_plan(steps[::-1])


@pytest.mark.parametrize("value", [-0.1, float("inf"), float("nan"), 2.0**31])
def test_penalty_must_be_a_number_that_is_not_negative(value: float) -> None:
    with pytest.raises(ValueError, match=r"^penalty of Pick\(block0, robby\): .* is not a number from 0"):
        Costs().set_penalty(operators()[0], value)


@settings(deadline=None, max_examples=150)
@given(searchable_tasks(), st.integers(0, 2**32 - 1), st.integers(0, 5), st.sampled_from([0, 3, 1000]))
def test_next_plan_is_always_the_cheapest_by_the_costs_of_that_moment(
    task: tuple[Domain, Problem, Graph], seed: int, unchanged: int, patience: int
) -> None:
    """Also after some plans at unit costs, which another part of the search gives, and by exact distances."""
    domain, problem, graph = task
    found = ground(domain, problem)
    if isinstance(found, Unreachable):
        return
    layers = plans_by_length(problem, graph)
    costs, rng, record = Costs(), Random(seed), SearchRecord()
    steps = {str(operator): operator for operator in found.operators}
    left: set[PlanKey] = set().union(*layers)
    number = len(left)

    def cost(plan: PlanKey) -> float:
        return costs.of_plan([steps[step] for step in plan])

    with steps_as_time(), patch.object(_best_first, "EXPLORE_AFTER", patience):
        limit = Limit(20_000, deadline=50_000)
        stream = AStar().plans_at(found, np.random.default_rng(seed), limit, record, costs)
        while True:
            changes = rng.randint(0, 3) if number - len(left) >= unchanged else 0
            for name in rng.sample(sorted(steps), min(len(steps), changes)):
                costs.set_penalty(steps[name], rng.choice([0, 0, 0.3, 0.7, 1, 2.5]))
            if changes and rng.random() < 0.5:
                plan = rng.choice(sorted(set().union(*layers)) or [()])
                prefix = tuple(steps[step] for step in plan[: rng.randint(1, max(1, len(plan)))])
                if prefix:
                    costs.set_prefix_penalty(prefix, rng.choice([0, 0.3, 1, 2.5]))
                    if rng.random() < 0.3:
                        costs.close(prefix)
                        left -= {p for p in left if p[: len(prefix)] == tuple(map(str, prefix))}
            cheapest = min(map(cost, left), default=len(layers))
            if cheapest >= len(layers):  # a longer plan may cost less
                break
            plan = next(stream)
            check_plan(problem, plan)
            assert cost(key(plan)) == cheapest
            left.remove(key(plan))
    assert record.stopped_by == ""


def test_no_change_costs_a_plan_and_none_comes_twice() -> None:
    """All 24 orders of covering four targets, and nothing longer, whatever the picks cost."""
    found, costs, rng = grounded(COVER, cover_problem(4)), Costs(), Random(3)
    picks = [step for step in found.operators if step.operator.name == "Pick"]
    given = []
    for plan in islice(AStar().plans_at(found, np.random.default_rng(3), AMPLE, SearchRecord(), costs), 24):
        given.append(key(plan))
        costs.set_penalty(rng.choice(picks), rng.choice([0, 0.2, 0.4]))  # all plans need each pick once
    assert len(set(given)) == 24
    assert {len(plan) for plan in given} == {8}
