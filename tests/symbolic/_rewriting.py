"""What the tests of rewritten tasks share: richer random tasks, and their plans found by brute force."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import product
from random import Random

from hypothesis import strategies as st

from bpns.symbolic.operators import Domain, GroundOperator, Operator, Problem
from bpns.symbolic.pddl.rewriting.portable import Rewritten
from bpns.symbolic.pddl.rewriting.positive import reachable_operators
from bpns.symbolic.structs import EQUAL, LiftedAtom, Object, Predicate, Type, Variable
from tests.symbolic._problems import PlanKey, plans_by_length, searchable_task, state_graph

Step = tuple[str, tuple[str, ...]]
Plan = tuple[Step, ...]


def every_ground_operator(domain: Domain, problem: Problem) -> list[GroundOperator]:
    """Return every operator with every tuple of objects that its types and equalities allow."""
    objects = (*domain.constants, *problem.objects)
    found = []
    for operator in domain.operators:
        for chosen in product(*([o for o in objects if o.type.is_a(v.type)] for v in operator.parameters)):
            try:
                found.append(operator.ground(chosen))
            except ValueError:  # an equality is violated
                continue
    return found


def plain_plans(domain: Domain, problem: Problem) -> list[set[Plan]] | None:
    """Return all plans of length 0, 1, 2, ... without steps that change nothing; None for big tasks."""
    return _plans(problem, every_ground_operator(domain, problem), None)


def _plans(
    problem: Problem,
    operators: Sequence[GroundOperator],
    original: Callable[[str, tuple[str, ...]], Step] | None,
) -> list[set[Plan]] | None:
    graph = state_graph(problem, operators, 200)
    if graph is None:
        return None
    moving = {s: [(o, after) for o, after in moves if after != s] for s, moves in graph.items()}
    steps = {
        str(o): (o.operator.name, tuple(x.name for x in o.objects))
        for moves in graph.values()
        for o, _ in moves
    }

    def named(plan: PlanKey) -> Plan:
        return tuple(original(*steps[s]) if original else steps[s] for s in plan)

    layers = plans_by_length(problem, moving)
    mapped = [{named(plan) for plan in layer} for layer in layers]
    assert list(map(len, mapped)) == list(map(len, layers)), "two plans became one"
    return mapped


def rewritten_plans(task: Rewritten, reachable: bool = False) -> list[set[Plan]] | None:
    """Return the plans of a rewritten task in the words of the original one; see plain_plans.

    With ``reachable``, our grounder spares it most of the operators: nodes are many objects.
    """
    find = reachable_operators if reachable else every_ground_operator
    return _plans(
        task.problem,
        find(task.domain, task.problem),
        lambda name, objects: task.original(name.upper(), objects),
    )


def rich_tasks() -> st.SearchStrategy[tuple[Domain, Problem]]:
    """Random tasks with equality, ``either``, and operators that delete and add the same atom."""
    return st.integers(0, 2**32 - 1).map(rich_task)


def rich_task(seed: int) -> tuple[Domain, Problem]:
    """Add to a random task what it lacks."""
    rng = Random(seed)
    domain, problem, _ = searchable_task(seed)
    special = next(t for t in domain.types if t.name == "Special")
    other = Type("Other")
    either = Type("(either Special Other)", either=(special, other))
    another = Object("Another", other)
    marked = Predicate("holds0-marked", (either,))
    first, second = Variable("?first", either), Variable("?second", either)
    move = Operator(
        "when",
        (first, second),
        frozenset({marked.lifted(second)}) if rng.random() < 0.7 else frozenset(),
        frozenset({marked.lifted(first)}),
        frozenset({marked.lifted(second)}),
        frozenset({marked.lifted(first)}) if rng.random() < 0.5 else frozenset(),
    )
    operators = [_compared(rng, o) for o in (*domain.operators, move)]
    objects = (*problem.objects, another)
    atoms = [marked(o) for o in (*domain.constants, *objects) if o.type.is_a(either)]
    start, end = rng.choice(atoms), rng.choice(atoms)
    goal = problem.goal | {end} if rng.random() < 0.5 else frozenset({end})
    gone = problem.negative_goal | {start} if rng.random() < 0.5 else problem.negative_goal
    return Domain(
        domain.name, (*domain.types, other), (*domain.predicates, marked), tuple(operators), domain.constants
    ), Problem(problem.name, objects, problem.init | {start}, goal, gone - goal)


def _compared(rng: Random, operator: Operator) -> Operator:
    """Let an operator compare its two parameters, or not."""
    if len(operator.parameters) != 2 or rng.random() < 0.3:
        return operator
    equal = frozenset({LiftedAtom(EQUAL, operator.parameters)})
    if rng.random() < 0.3:
        return replace(operator, preconditions=operator.preconditions | equal)
    return replace(operator, negative_preconditions=operator.negative_preconditions | equal)
