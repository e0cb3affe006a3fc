"""Exact distances over all reachable abstract states, against a search of our tests' own."""

from collections import defaultdict
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bpns.symbolic.grounding.ground import Unreachable, ground
from bpns.symbolic.grounding.masks import compile_problem
from bpns.symbolic.operators import Domain, Problem
from bpns.symbolic.planners.astar import space as _space
from bpns.symbolic.planners.astar.space import explore
from tests.symbolic._planning import grounded
from tests.symbolic._problems import COVER, Graph, cover_problem, searchable_tasks


@given(searchable_tasks(), st.integers(0, 2**32 - 1))
def test_distances_are_exact_under_any_costs(task: tuple[Domain, Problem, Graph], seed: int) -> None:
    found = ground(*task[:2])
    if isinstance(found, Unreachable):
        return
    problem, rng = compile_problem(found), Random(seed)
    costs = [rng.choice([1.0, 1.0, 1.5, 3.0]) for _ in problem.operators]
    space = explore(problem)
    assert space is not None
    space.measure(costs)

    def distance(state: int) -> float:
        return float(space.distances[space.number(state)])

    steps: dict[int, list[tuple[float, int]]] = defaultdict(list)
    waiting, states = [problem.init], {problem.init}
    while waiting:
        state = waiting.pop()
        for cost, operator in zip(costs, problem.operators, strict=True):
            if not problem.is_goal(state) and operator.applicable(state):
                after = operator.apply(state)
                steps[state].append((cost, after))
                if after not in states:
                    states.add(after)
                    waiting.append(after)
    assert len(space.index) == len(states)
    for state in states:  # each distance is what the best step leaves, and only goals are at zero
        best = min(
            (cost + space.distances[space.number(after)] for cost, after in steps[state]),
            default=float("inf"),
        )
        assert space.distances[space.number(state)] == (0 if problem.is_goal(state) else best)


def test_large_spaces_are_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = compile_problem(grounded(COVER, cover_problem(2)))
    assert explore(problem) is not None
    monkeypatch.setattr(_space, "MOST_PAIRS", 10)
    assert explore(problem) is None
    monkeypatch.setattr(_space, "MOST_PAIRS", 10**9)
    monkeypatch.setattr(_space, "MOST_STEPS", 10)
    assert explore(problem) is None
