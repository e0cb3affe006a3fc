"""Problems for the tests of this folder, fixed and random, and searches too plain to be wrong."""

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import count, product
from pathlib import Path
from random import Random
from typing import TypeAlias, TypeVar

import pytest
from hypothesis import strategies as st

from bpns.symbolic.grounding.masks import CompiledProblem
from bpns.symbolic.operators import Domain, GroundOperator, Operator, Problem
from bpns.symbolic.pddl.read import read_domain, read_problem
from bpns.symbolic.structs import OBJECT, GroundAtom, LiftedAtom, Object, Predicate, Type, Variable

AbstractState: TypeAlias = frozenset[GroundAtom]
Graph: TypeAlias = Mapping[AbstractState, Sequence[tuple[GroundOperator, AbstractState]]]
Item = TypeVar("Item")

# ------------------------------------------------------------------------------------------- fixed

BLOCK, TARGET, GRIPPER = Type("block"), Type("target"), Type("gripper")
COVERS = Predicate("Covers", (BLOCK, TARGET))
HOLDING = Predicate("Holding", (BLOCK, GRIPPER))
HAND_EMPTY = Predicate("HandEmpty", ())
_BLOCK, _TARGET, _GRIPPER = (
    Variable("?block", BLOCK),
    Variable("?target", TARGET),
    Variable("?gripper", GRIPPER),
)
PICK = Operator(
    "Pick",
    (_BLOCK, _GRIPPER),
    frozenset({HAND_EMPTY.lifted()}),
    frozenset({HOLDING.lifted(_BLOCK, _GRIPPER)}),
    frozenset({HAND_EMPTY.lifted()}),
)
PLACE = Operator(
    "Place",
    (_BLOCK, _TARGET, _GRIPPER),
    frozenset({HOLDING.lifted(_BLOCK, _GRIPPER)}),
    frozenset({HAND_EMPTY.lifted(), COVERS.lifted(_BLOCK, _TARGET)}),
    frozenset({HOLDING.lifted(_BLOCK, _GRIPPER)}),
)
COVER = Domain("Cover", (BLOCK, TARGET, GRIPPER), (COVERS, HOLDING, HAND_EMPTY), (PICK, PLACE))


def cover_problem(size: int) -> Problem:
    """Return the problem of covering each of so many targets with its block."""
    blocks = [Object(f"block{i}", BLOCK) for i in range(size)]
    targets = [Object(f"target{i}", TARGET) for i in range(size)]
    goal = frozenset(COVERS(b, t) for b, t in zip(blocks, targets, strict=True))
    objects = (*blocks, *targets, Object("robby", GRIPPER))
    return Problem("Cover-Task", objects, frozenset({HAND_EMPTY()}), goal)


def switches(moves: Mapping[str, tuple[str, str]], init: str, goal: str) -> tuple[Domain, Problem]:
    """Return a task without objects: words are atoms; a move needs its left words and sets its right ones.

    ``{"walk": ("home tired-", "away home-")}``: a trailing minus stands for *not*.
    """
    words = " ".join([*(" ".join(sides) for sides in moves.values()), init, goal]).split()
    known = {word.rstrip("-"): Predicate(word.rstrip("-"), ()) for word in words}

    def lifted(text: str, sign: str) -> frozenset[LiftedAtom]:
        return frozenset(
            known[w.rstrip("-")].lifted() for w in text.split() if w.endswith("-") == (sign == "-")
        )

    def atoms(text: str, sign: str) -> frozenset[GroundAtom]:
        return frozenset(atom.ground({}) for atom in lifted(text, sign))

    operators = tuple(
        Operator(name, (), lifted(left, "+"), lifted(right, "+"), lifted(right, "-"), lifted(left, "-"))
        for name, (left, right) in moves.items()
    )
    domain = Domain("switches", (), tuple(known.values()), operators)
    return domain, Problem("task", (), atoms(init, "+"), atoms(goal, "+"), atoms(goal, "-"))


def competition_files(data: Path, folder: str, number: int) -> tuple[Path, Path]:
    """Return domain and problem file of a task of the International Planning Competition."""
    path = data / "pddl" / folder
    own = path / f"domain{number:02}.pddl"
    return own if own.exists() else path / "domain.pddl", path / f"task{number:02}.pddl"


def competition_task(data: Path, folder: str, number: int) -> tuple[Domain, Problem]:
    """Read a task of the International Planning Competition."""
    domain_file, problem_file = competition_files(data, folder, number)
    domain = read_domain(domain_file)
    return domain, read_problem(problem_file, domain)


# ------------------------------------------------------------------------------------------ random

_NAMES = "a B cC D- e_1 F0 g-g H_h i2 JJ k--k L-1 mM N o_o P9 qQ- R s0s T".split()


def _some(items: Sequence[Item], most: int) -> st.SearchStrategy[frozenset[Item]]:
    return st.frozensets(st.sampled_from(items), max_size=most) if items else st.just(frozenset())


def _lifted(predicates: Sequence[Predicate], terms: Sequence[Variable | Object]) -> list[LiftedAtom]:
    return [
        predicate.lifted(*chosen)
        for predicate in predicates
        for chosen in product(terms, repeat=len(predicate.types))
        if all(t.type.is_a(wanted) for t, wanted in zip(chosen, predicate.types, strict=True))
    ]


def ground_atoms(domain: Domain, problem: Problem) -> list[GroundAtom]:
    """Return every atom that the types allow."""
    return [a.ground({}) for a in _lifted(domain.predicates, (*domain.constants, *problem.objects))]


@st.composite
def tasks(draw: st.DrawFn) -> tuple[Domain, Problem]:
    """Random domains with subtypes, constants, negative preconditions and names in any case."""
    first = draw(st.integers(0, len(_NAMES) - 1))
    words = iter(_NAMES[first:] + _NAMES[:first])
    types: list[Type] = []
    for _ in range(draw(st.integers(0, 3))):
        types.append(Type(next(words), (), draw(st.sampled_from([None, *types]))))
    kind = st.sampled_from([OBJECT, *types])
    constants = [Object(next(words), draw(kind)) for _ in range(draw(st.integers(0, 2)))]
    predicates = [
        Predicate(next(words), tuple(draw(st.lists(kind, max_size=3))))
        for _ in range(draw(st.integers(1, 4)))
    ]
    operators = []
    for _ in range(draw(st.integers(0, 4))):
        kinds = draw(st.lists(kind, max_size=3))
        parameters = tuple(Variable(f"?x{i}", t) for i, t in enumerate(kinds))
        atoms = _lifted(predicates, (*parameters, *constants))
        positive, add, delete, forbidden = (draw(_some(atoms, 3)) for _ in range(4))
        operators.append(Operator(next(words), parameters, positive, add, delete, forbidden))
    order = draw(st.permutations(types))
    domain = Domain(next(words), tuple(order), tuple(predicates), tuple(operators), tuple(constants))
    objects = tuple(Object(next(words), draw(kind)) for _ in range(draw(st.integers(0, 4))))
    empty = Problem(next(words), objects, frozenset(), frozenset())
    atoms_of_task = _some(ground_atoms(domain, empty), 4)
    goal, forbidden_goal, init = draw(atoms_of_task), draw(atoms_of_task), draw(atoms_of_task)
    return domain, Problem(empty.name, objects, init, goal, forbidden_goal)


def searchable_tasks(negative: bool = True) -> st.SearchStrategy[tuple[Domain, Problem, Graph]]:
    """Random tasks with few abstract states, all of them in the graph; most have plans."""
    return st.integers(0, 2**32 - 1).map(lambda seed: searchable_task(seed, negative))


def searchable_task(seed: int, negative: bool = True) -> tuple[Domain, Problem, Graph]:
    """Throw the dice until a task has more than two and not too many states."""
    rng = Random(seed)
    while True:
        domain, problem = _dice(rng, negative)
        graph = state_graph(problem, all_ground_operators(domain, problem), 60)
        if graph is not None and len(graph) > 2:
            break
    if rng.random() < 0.2:
        return domain, problem, graph  # its goal may be out of reach
    end = rng.choice(list(graph)[len(graph) // 2 :])  # far from the start
    goal = _chosen(rng, sorted(end - problem.init, key=str), 1, 3)
    gone = _chosen(rng, sorted(problem.init - end, key=str), 0, 1) if negative else frozenset()
    return domain, Problem(problem.name, problem.objects, problem.init, goal, gone), graph


def _chosen(rng: Random, items: Sequence[Item], least: int, most: int) -> frozenset[Item]:
    return frozenset(rng.sample(items, min(len(items), rng.randint(least, most))))


def _dice(rng: Random, negative: bool) -> tuple[Domain, Problem]:
    thing = Type("thing")
    types = (thing, Type("Special", (), thing))
    constants = tuple(Object(f"fixed{i}", rng.choice(types)) for i in range(rng.randint(0, 1)))
    objects = tuple(Object(f"Free{i}", rng.choice(types)) for i in range(rng.randint(1, 2)))
    predicates = tuple(
        Predicate(f"Holds{i}", tuple(rng.choices(types, k=rng.choice((0, 1, 1, 2)))))
        for i in range(rng.randint(2, 4))
    )
    operators = []
    for i in range(rng.randint(2, 5)):
        parameters = tuple(Variable(f"?x{k}", rng.choice(types)) for k in range(rng.randint(0, 2)))
        atoms = _lifted(predicates, (*parameters, *constants))
        positive, add, delete = (
            _chosen(rng, atoms, 0, 2),
            _chosen(rng, atoms, 1, 2),
            _chosen(rng, atoms, 0, 2),
        )
        forbidden = _chosen(rng, atoms, 0, 2) - positive if negative else frozenset()
        operators.append(Operator(f"Act{i}", parameters, positive, add, delete, forbidden))
    domain = Domain("Dice", types, predicates, tuple(operators), constants)
    possible = ground_atoms(domain, Problem("Throw", objects, frozenset(), frozenset()))
    goal, forbidden_goal = _chosen(rng, possible, 1, 2), _chosen(rng, possible, 0, 1 if negative else 0)
    return domain, Problem("Throw", objects, _chosen(rng, possible, 1, 5), goal, forbidden_goal)


# -------------------------------------------------------------------------------------- plain searches


def all_ground_operators(domain: Domain, problem: Problem) -> list[GroundOperator]:
    """Return every operator with every tuple of objects of the right types."""
    objects = (*domain.constants, *problem.objects)
    found = []
    for operator in domain.operators:
        fitting = [[o for o in objects if o.type.is_a(v.type)] for v in operator.parameters]
        found += [operator.ground(chosen) for chosen in product(*fitting)]
    return found


def relaxed_fixpoint(
    start: AbstractState, operators: Sequence[GroundOperator]
) -> tuple[AbstractState, set[GroundOperator]]:
    """Return what becomes true, and which operators are used, when nothing is ever deleted or forbidden."""
    atoms = start
    while True:
        usable = {o for o in operators if o.preconditions <= atoms}
        more = atoms.union(*(o.add_effects for o in usable))
        if more == atoms:
            return atoms, usable
        atoms = more


def state_graph(problem: Problem, operators: Sequence[GroundOperator], most_states: int) -> Graph | None:
    """Return all abstract states, goals too, with their successors; None if there are too many."""
    graph: dict[AbstractState, list[tuple[GroundOperator, AbstractState]]] = {}
    queue = deque([problem.init])
    while queue:
        state = queue.popleft()
        if state in graph:
            continue
        if len(graph) == most_states:
            return None
        graph[state] = [(o, o.apply(state)) for o in operators if o.applicable(state)]
        queue.extend(after for _, after in graph[state])
    return graph


def distances(problem: Problem, graph: Graph) -> dict[AbstractState, int]:
    """Return the least number of steps to a goal state, for the states that can reach one."""
    found = {state: 0 for state in graph if problem.satisfied(state)}
    for steps in count(1):
        near = {
            s for s, moves in graph.items() if s not in found and any(after in found for _, after in moves)
        }
        if not near:
            return found
        found |= dict.fromkeys(near, steps)
    raise AssertionError


def encode(compiled: CompiledProblem, state: AbstractState) -> int:
    """Return the mask that stands for an abstract state."""
    return sum(1 << i for i, atom in enumerate(compiled.atoms) if atom in state)


PlanKey: TypeAlias = tuple[str, ...]


def plans_by_length(
    problem: Problem, graph: Graph, most_paths: int = 400, most_steps: int = 5
) -> list[set[PlanKey]]:
    """Return all plans of length 0, 1, 2, ...: paths that meet a goal state at their end and not before.

    Each of their steps changes something.
    """
    layers: list[set[PlanKey]] = []
    paths: list[tuple[PlanKey, AbstractState]] = [((), problem.init)]
    while paths and len(paths) <= most_paths and len(layers) <= most_steps:
        layers.append({steps for steps, state in paths if problem.satisfied(state)})
        paths = [
            ((*steps, str(operator)), after)
            for steps, state in paths
            if not problem.satisfied(state)
            for operator, after in graph[state]
            if after != state
        ]
    return layers


# ------------------------------------------------------------------------------------------- clock


@contextmanager
def steps_as_time() -> Iterator[None]:
    """Let time pass by one whenever a planner looks at its clock: deadlines that do not depend on speed."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("bpns.symbolic.planners.protocol.monotonic", count(1).__next__)
        yield
