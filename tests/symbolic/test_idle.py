"""Idle steps: all ways to put what changes nothing into abstract plans, and no others."""

from itertools import islice, product
from time import monotonic

import numpy as np

from bpns.symbolic import planners
from bpns.symbolic.bilevel.exhaustive import exhaustive
from bpns.symbolic.bilevel.solve import NoPlan, Plan, solve
from bpns.symbolic.grounding.ground import GroundProblem, ground
from bpns.symbolic.operators import Operator
from bpns.symbolic.planners.protocol import Limit, SearchRecord
from bpns.symbolic.planners.streams import WithIdleSteps, loopless, with_idle_steps
from bpns.symbolic.skills.environment import domain_of, problem_of, sample_tasks
from bpns.symbolic.skills.skill import NoSampler, Skill
from tests.toy import DOOR, HAND, IS_OPEN, SKILLS, Repeat, Toy, Variable

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


def test_idle_steps_that_never_can_be_end_at_a_limit() -> None:
    """There is one plan and no way to fill it: the search must not go on for ever."""
    door = Variable("?door", DOOR)
    never = Operator("never", (door,), frozenset({IS_OPEN.lifted(door)}), frozenset(), frozenset())
    problem = toy_problem(*(skill.operator for skill in SKILLS.values()), never)
    for limit, why in ((Limit(2_000), "node limit"), (Limit(10**9, monotonic() + 0.3), "time limit")):
        record = SearchRecord()
        planner = WithIdleSteps(planners.load("astar"))
        plans = list(planner.plans(problem, np.random.default_rng(0), limit, record))
        assert len(plans) == 1
        assert record.stopped_by == why


def test_loopless_plans_have_no_idle_steps() -> None:
    world = Toy(fails_below=2.0)
    task = sample_tasks(world, "test", 1, 0)[0]
    idle = {**SKILLS, "wait": Skill(WAIT, Repeat(0), NoSampler())}
    planner = with_idle_steps(loopless(planners.load("astar")), [WAIT])
    outcome = solve(world, task, idle, planner, world.budget, 1, strategy=exhaustive)
    assert isinstance(outcome, NoPlan)
    assert outcome.effort.abstract_plans == 1


def test_solving_with_an_idle_skill() -> None:
    world = Toy()
    task = sample_tasks(world, "test", 1, 0)[0]
    idle = {**SKILLS, "wait": Skill(WAIT, Repeat(2), NoSampler())}
    planner = with_idle_steps(planners.load("astar"), [skill.operator for skill in idle.values()])
    outcome = solve(world, task, idle, planner, world.budget, 1, strategy=exhaustive)
    assert isinstance(outcome, Plan)
