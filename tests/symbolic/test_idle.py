"""Idle steps: all ways to put what changes nothing into abstract plans, and no others."""

from itertools import islice, product

import numpy as np

from symbolic import planners
from symbolic.bilevel import Plan, solve
from symbolic.environment import domain_of, problem_of, sample_tasks
from symbolic.exhaustive import exhaustive
from symbolic.grounding import GroundProblem, ground
from symbolic.planners import Limit, SearchRecord
from symbolic.planners._idle import WithIdleSteps
from symbolic.skills import NoSampler, Skill
from symbolic.structs import Operator
from tests.toy import HAND, SKILLS, Repeat, Toy, Variable

HERE = Variable("?hand", HAND)
WAIT = Operator("wait", (), frozenset(), frozenset(), frozenset())
REST = Operator(
    "rest", (HERE,), frozenset(SKILLS["search"].operator.add_effects), frozenset(), frozenset()
)  # needs the key


def toy_problem(*operators: Operator) -> GroundProblem:
    world = Toy()
    task = sample_tasks(world, "test", 1, 0)[0]
    found = ground(domain_of(world, operators), problem_of(world, task))
    assert isinstance(found, GroundProblem)
    return found


def brute_force(problem: GroundProblem, length: int) -> set[tuple[str, ...]]:
    """Return all sequences of a length that reach the goal with their last step."""
    found = set()
    for steps in product(problem.operators, repeat=length):
        atoms = problem.problem.init
        for number, step in enumerate(steps):
            if not step.preconditions <= atoms or problem.problem.goal <= atoms:
                break
            if step.apply(atoms) == atoms and (step.add_effects or step.delete_effects):
                break  # planners leave these out, as ever
            atoms = step.apply(atoms)
            if number == length - 1 and problem.problem.goal <= atoms:
                found.add(tuple(map(str, steps)))
    return found


def test_all_sequences_come_once_and_the_short_ones_first() -> None:
    operators = [skill.operator for skill in SKILLS.values()]
    problem = toy_problem(*operators, WAIT, REST)
    wanted = [brute_force(problem, length) for length in range(6)]
    planner = WithIdleSteps(planners.load("astar"))
    stream = planner.plans(problem, np.random.default_rng(0), Limit(100_000), SearchRecord())
    plans = [tuple(map(str, p.steps)) for p in islice(stream, sum(map(len, wanted)))]
    assert [len(p) for p in plans] == sorted(len(p) for p in plans)
    assert len(set(plans)) == len(plans)
    assert set(plans) == set().union(*wanted)


def test_without_idle_operators_nothing_changes() -> None:
    problem = toy_problem(*(skill.operator for skill in SKILLS.values()))
    given = planners.load("astar")
    one, two = (
        [str(p) for p in planner.plans(problem, np.random.default_rng(0), Limit(10_000), SearchRecord())]
        for planner in (given, WithIdleSteps(given))
    )
    assert one == two


def test_solving_with_an_idle_skill() -> None:
    world = Toy()
    task = sample_tasks(world, "test", 1, 0)[0]
    idle = {**SKILLS, "wait": Skill(WAIT, Repeat(2), NoSampler())}
    outcome = solve(world, task, idle, planners.load("astar"), world.budget, 1, strategy=exhaustive)
    assert isinstance(outcome, Plan)
