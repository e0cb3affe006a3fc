"""Running planners in tests."""

from collections.abc import Iterator
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from bpns.symbolic.errors import MissingPackage
from bpns.symbolic.grounding.ground import GroundProblem, ground
from bpns.symbolic.operators import Domain, Problem
from bpns.symbolic.pddl.plan_fault import first_fault
from bpns.symbolic.planners.protocol import AbstractPlan, Limit, Planner, SearchRecord
from bpns.symbolic.planners.registry import load
from tests.symbolic._problems import (
    PlanKey,
)

AMPLE = Limit(1_000_000)


def grounded(domain: Domain, problem: Problem) -> GroundProblem:
    found = ground(domain, problem)
    assert isinstance(found, GroundProblem), str(found)
    return found


@cache
def load_or_skip(name: str) -> Planner:
    """Load a planner once, as some keep a process from problem to problem."""
    try:
        return load(name)
    except MissingPackage as error:
        pytest.skip(str(error))


def plans(
    problem: GroundProblem, planner: str = "astar", limit: Limit = AMPLE, seed: int = 0
) -> tuple[Iterator[AbstractPlan], SearchRecord]:
    record = SearchRecord()
    return load_or_skip(planner).plans(problem, np.random.default_rng(seed), limit, record), record


def key(plan: AbstractPlan) -> PlanKey:
    return tuple(map(str, plan.steps))


def check_plan(problem: Problem, plan: AbstractPlan) -> None:
    """Check that a plan is valid, ends at its first goal state and comes with the right abstract states."""
    assert first_fault(problem, plan.steps) == ""
    assert plan.atoms[0] == problem.init
    for step, (before, after) in zip(plan.steps, pairwise(plan.atoms), strict=True):
        assert step.apply(before) == after
    assert not any(problem.satisfied(atoms) for atoms in plan.atoms[:-1])
