"""What an environment offers: the only view of a world that planners and learners have."""

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Literal, Protocol, TypeAlias

import numpy as np

from bpns.symbolic.operators import Domain, Operator, Problem
from bpns.symbolic.skills.skill import GivenSkill, Skill
from bpns.symbolic.state import Array, State, Task
from bpns.symbolic.structs import GroundAtom, Object, Predicate, Type

if TYPE_CHECKING:  # planning needs no pictures
    from PIL.Image import Image

Classifier: TypeAlias = Callable[[State, tuple[Object, ...]], bool]
Split: TypeAlias = Literal["train", "test"]

TEST_SEED_OFFSET = 10_000  # evaluation tasks come from seed + this (spec: common.md, section 4)


class EnvironmentFailure(Exception):
    """A step without a next state: the task has failed. Its text says why."""


@dataclass(frozen=True, slots=True)
class Budget:
    """How much a search may try on one task: counted, not timed, so that results repeat anywhere.

    The first two are the paper's (N_abstract, N_samples). The others stand in for its wall-clock limit:
    backtracking through a plan of n steps can take samples_per_step to the power of n samples.

    >>> Budget(abstract_plans=8, samples_per_step=10).samples
    20000
    """

    abstract_plans: int
    samples_per_step: int
    samples_per_plan: int = 1000  # this and those before: of the exhaustive strategy
    samples: int = 20_000
    nodes: int = 500_000


class Environment(Protocol):
    """A deterministic world with symbols on top. Source: spec, common.md.

    ``simulate`` is pure; it raises EnvironmentFailure where no next state exists. Actions are float32
    vectors of shape (A,) inside the box ``action_low``..``action_high`` (both (A,) float32).
    """

    @property
    def name(self) -> str: ...
    @property
    def types(self) -> tuple[Type, ...]: ...
    @property
    def classifiers(self) -> Mapping[Predicate, Classifier]: ...
    @property
    def goal_predicates(self) -> frozenset[Predicate]: ...
    @property
    def contact_predicates(self) -> frozenset[Predicate]: ...
    @property
    def oracle_skills(self) -> tuple[Skill, ...]: ...
    @property
    def given_skills(self) -> tuple[GivenSkill, ...]: ...  # the learner knows these; mostly none
    @property
    def action_low(self) -> Array: ...
    @property
    def action_high(self) -> Array: ...
    @property
    def horizon(self) -> int: ...
    @property
    def rollout_limit(self) -> int: ...
    @property
    def budget(self) -> Budget: ...
    def simulate(self, state: State, action: Array) -> State: ...
    def sample_task(self, split: Split, index: int, rng: np.random.Generator) -> Task: ...
    def draw(self, state: State, caption: str = "", goal: frozenset[GroundAtom] = frozenset()) -> "Image": ...


def holds(environment: Environment, atom: GroundAtom, state: State) -> bool:
    """Say whether an atom is true in a state."""
    return environment.classifiers[atom.predicate](state, atom.objects)


def abstract(
    environment: Environment, state: State, predicates: Collection[Predicate] | None = None
) -> frozenset[GroundAtom]:
    """Return all ground atoms that hold, over all argument tuples of fitting types; or of some predicates.

    Source: spec, algorithm.md section 2.
    """
    atoms: list[GroundAtom] = []
    for predicate, classifier in environment.classifiers.items():
        if predicates is not None and predicate not in predicates:
            continue
        places = [state.of_type(t) for t in predicate.types]
        atoms += [
            GroundAtom(predicate, objects) for objects in product(*places) if classifier(state, objects)
        ]
    return frozenset(atoms)


def domain_of(environment: Environment, operators: Iterable[Operator]) -> Domain:
    """Return the PDDL domain that operators over an environment's symbols form."""
    types: list[Type] = []
    for leaf in environment.types:
        chain: list[Type] = []
        step: Type | None = leaf
        while step is not None and step not in types:
            chain.insert(0, step)
            step = step.parent
        types += chain
    return Domain(environment.name, tuple(types), tuple(environment.classifiers), tuple(operators))


def problem_of(environment: Environment, task: Task, name: str = "task") -> Problem:
    """Return the symbolic view of a task."""
    return Problem(name, task.init.objects, abstract(environment, task.init), task.goal)


def sample_tasks(environment: Environment, split: Split, count: int, seed: int) -> list[Task]:
    """Draw the first ``count`` tasks of a split: all from one generator, in sequence."""
    rng = np.random.default_rng(seed + (TEST_SEED_OFFSET if split == "test" else 0))
    return [environment.sample_task(split, index, rng) for index in range(count)]
