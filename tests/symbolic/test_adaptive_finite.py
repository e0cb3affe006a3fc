"""On finite worlds the adaptive search solves exactly what a brute-force refinement does."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import pytest
from PIL import Image

from bpns.symbolic import planners
from bpns.symbolic.bilevel.adaptive import adaptive
from bpns.symbolic.bilevel.solve import Plan, solve
from bpns.symbolic.operators import Operator
from bpns.symbolic.skills.environment import Budget, Classifier, EnvironmentFailure, Split
from bpns.symbolic.skills.skill import Controller, Skill
from bpns.symbolic.state import Array, State, Task
from bpns.symbolic.structs import GroundAtom, Object, Predicate, Type, Variable

STEPS, VARIANTS = 3, 2
THING = Type("thing", ("step", "code"))
ONE, X = Object("one", THING), Variable("?x", THING)
DONE = [Predicate(f"Done{step}", (THING,)) for step in range(STEPS)]
BASE = 100  # of codes: a code says which choices led here


@dataclass(frozen=True)
class Values:
    """Draws one of so many values; of no values it draws one that never works."""

    count: int
    dimension: int = 1

    def sample(self, state: State, objects: tuple[Object, ...], rng: np.random.Generator) -> Array:
        return np.array([rng.integers(max(1, self.count))], np.float32)


@dataclass(frozen=True)
class Choose:
    number: int  # of the operator among all

    def begin(self, state: State, objects: tuple[Object, ...], subgoal: Array) -> Controller:
        return lambda _: np.array([self.number, subgoal[0]], np.float32)


def classifier(step: int) -> Classifier:
    return lambda state, objects: state[objects[0]][0] > step


@dataclass(frozen=True)
class Finite:
    """Steps in a row, each by one of two operators; ``works`` holds the codes that are no dead ends."""

    works: frozenset[float]
    counts: tuple[int, ...]  # of values, for each operator
    name: str = "finite"
    horizon: int = 20
    rollout_limit: int = 5
    budget: Budget = field(default_factory=lambda: Budget(100, 100, samples=50_000))
    types = (THING,)
    classifiers: Mapping[Predicate, Classifier] = field(
        default_factory=lambda: {predicate: classifier(step) for step, predicate in enumerate(DONE)}
    )
    goal_predicates = frozenset({DONE[-1]})
    contact_predicates = frozenset(DONE)
    oracle_skills = ()
    given_skills = ()
    action_low = np.array([0, 0], np.float32)
    action_high = np.array([BASE, BASE], np.float32)

    @property
    def skills(self) -> dict[str, Skill]:
        found = {}
        for number, count in enumerate(self.counts):
            step = number // VARIANTS
            needs = frozenset({DONE[step - 1].lifted(X)} if step else ())
            operator = Operator(f"do{number}", (X,), needs, frozenset({DONE[step].lifted(X)}), frozenset())
            found[operator.name] = Skill(operator, Choose(number), Values(count))
        return found

    def simulate(self, state: State, action: Array) -> State:
        step, code = state[ONE]
        after = code_of(code, int(action[0]), int(action[1]))
        if after not in self.works:
            raise EnvironmentFailure("a dead end")
        return state.changed({"one": (step + 1, after)})

    def sample_task(self, split: Split, index: int, rng: np.random.Generator) -> Task:
        return Task(State.of({ONE: (0, 1)}), frozenset({DONE[-1](ONE)}))

    def draw(self, state: State, caption: str = "", goal: frozenset[GroundAtom] = frozenset()) -> Image.Image:
        return Image.new("RGB", (8, 8))

    def solvable(self) -> bool:
        """Look at all choices."""
        codes = [1.0]
        for step in range(STEPS):
            codes = [
                after
                for code in codes
                for number in range(step * VARIANTS, (step + 1) * VARIANTS)
                for value in range(self.counts[number])
                if (after := code_of(code, number, value)) in self.works
            ]
        return bool(codes)


def code_of(code: float, number: int, value: int) -> float:
    return code * BASE + number * 10 + value


def drawn(seed: int) -> Finite:
    """Draw a world in which few choices lead on."""
    rng = np.random.default_rng(seed)
    counts = tuple(int(count) for count in rng.integers(0, 6, STEPS * VARIANTS))
    share = rng.uniform(0.1, 0.6)
    codes, works = [1.0], set()
    for step in range(STEPS):
        following = [
            code_of(code, number, value)
            for code in codes
            for number in range(step * VARIANTS, (step + 1) * VARIANTS)
            for value in range(counts[number])
        ]
        codes = [code for code in following if rng.uniform() < share]
        works |= set(codes)
    return Finite(frozenset(works), counts)


def wrong(seeds: range) -> list[int]:
    """Return the worlds where the search and brute force differ."""
    found = []
    for seed in seeds:
        world = drawn(seed)
        task = world.sample_task("test", 0, np.random.default_rng(0))
        outcome = solve(
            world, task, world.skills, planners.load("astar"), world.budget, seed, strategy=adaptive
        )
        if isinstance(outcome, Plan) != world.solvable():
            found.append(seed)
    return found


def test_finite_worlds_are_solved_where_brute_force_solves_them() -> None:
    assert 30 < sum(drawn(seed).solvable() for seed in range(100)) < 90
    assert wrong(range(100)) == []


@pytest.mark.slow
def test_a_thousand_finite_worlds() -> None:
    assert wrong(range(1000)) == []


@pytest.mark.parametrize("counts", [(2, 5, 3), (5, 5, 5)])
def test_a_plan_is_not_given_up_before_it_is_exhausted(counts: tuple[int, int, int]) -> None:
    """One abstract plan, in which one choice of each step alone leads to the goal."""
    for seed in range(50):
        codes = [1.0]
        for step, count in enumerate(counts):
            number = step * VARIANTS
            codes.append(code_of(codes[-1], number, seed % count))
        others = {code_of(1.0, 0, value) for value in range(counts[0])}
        sizes = tuple(size for count in counts for size in (count, 0))
        world = Finite(frozenset(codes) | others, sizes)
        only = {name: skill for name, skill in world.skills.items() if int(name[2:]) % VARIANTS == 0}
        task = world.sample_task("test", 0, np.random.default_rng(0))
        outcome = solve(world, task, only, planners.load("astar"), world.budget, seed, strategy=adaptive)
        assert isinstance(outcome, Plan), seed
