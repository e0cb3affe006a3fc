"""Skills: an operator, a policy that pursues subgoals and a sampler that proposes them."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, TypeAlias

import numpy as np

from bpns.symbolic.operators import Operator
from bpns.symbolic.state import Array, State
from bpns.symbolic.structs import Object, Type, Variable

Controller: TypeAlias = Callable[[State], Array | None]  # None: done, as far as the policy knows
Terminal: TypeAlias = Callable[[State, tuple[Object, ...]], bool]


class SkillFailure(Exception):
    """A policy that cannot act. Its text says why."""


class Policy(Protocol):
    """Turns a subgoal into actions: see ``Skill`` for a small one. Source: paper, section 3."""

    def begin(self, state: State, objects: tuple[Object, ...], subgoal: Array) -> Controller:
        """Fix the target at the skill's first state; the result maps each following state to an action.

        ``subgoal`` is (D,) float32; actions are (A,) float32 inside the environment's box.
        """
        ...


class Sampler(Protocol):
    """Proposes subgoals: numbers that say how a skill's effects are to come about.

    >>> class AnyGrip:
    ...     dimension = 1
    ...     def sample(self, state, objects, rng):
    ...         return rng.uniform(-1, 1, 1).astype(np.float32)
    >>> AnyGrip().sample(None, (), np.random.default_rng(0)).shape
    (1,)

    Source: paper, section 3.
    """

    @property
    def dimension(self) -> int:
        """The length D of a subgoal; 0 where there is nothing to choose."""
        ...

    def sample(self, state: State, objects: tuple[Object, ...], rng: np.random.Generator) -> Array:
        """Return a subgoal, (D,) float32."""
        ...


def never(_: State, __: tuple[Object, ...]) -> bool:
    """Say that a skill is not over: for those whose controller says so itself."""
    return False


@dataclass(frozen=True, slots=True)
class NoSampler:
    """For skills without anything to choose.

    >>> NoSampler().dimension
    0
    """

    dimension: int = 0

    def sample(self, state: State, objects: tuple[Object, ...], rng: np.random.Generator) -> Array:
        """Return the empty subgoal, (0,) float32."""
        return np.zeros(0, np.float32)


@dataclass(frozen=True, slots=True)
class GivenSkill:
    """A policy that comes with an environment: operators are learned around it, the policy is not.

    ``types`` are those of its own objects. It gets an empty subgoal, and is over when its controller gives
    None. Demonstrations label the actions that it produced. Source: spec, doors.md section 7.

    >>> import bpns
    >>> bpns.load_environment("doors").environment.given_skills
    (<given skill MoveToDoor(robot, door)>, <given skill MoveThroughDoor(robot, door)>)
    """

    name: str
    types: tuple[Type, ...]
    policy: Policy

    def __repr__(self) -> str:
        return f"<given skill {self.name}({', '.join(t.name for t in self.types)})>"


@dataclass(frozen=True, slots=True)
class Label:
    """Which given skill produced an action, and with which objects."""

    skill: str
    objects: tuple[Object, ...]


@dataclass(frozen=True, slots=True)
class GivenPolicy:
    """A given skill as an operator's policy; ``places`` says which of the operator's objects it gets."""

    given: GivenSkill
    places: tuple[int, ...]

    def label(self, objects: tuple[Object, ...]) -> Label:
        """Return how demonstrations call the skill, from the operator's objects."""
        return Label(self.given.name, tuple(objects[place] for place in self.places))

    def begin(self, state: State, objects: tuple[Object, ...], subgoal: Array) -> Controller:
        """Start the given skill; see Policy."""
        return self.given.policy.begin(state, self.label(objects).objects, subgoal)


@dataclass(frozen=True, slots=True)
class Skill:
    """An operator and how to make it happen. Source: paper, section 3.

    The policy and the sampler get the operator's objects in the order of its parameters.

    >>> from dataclasses import dataclass
    >>> @dataclass(frozen=True)
    ... class Stay:
    ...     def begin(self, state, objects, subgoal):
    ...         return lambda state: np.zeros(2, np.float32)
    >>> wait = Operator("wait", (), frozenset(), frozenset(), frozenset())
    >>> Skill(wait, Stay(), NoSampler(), max_actions=1)
    <skill <wait()>, 0 numbers in a subgoal>

    ``terminal`` says when the skill is over; without it, that is when all effects have happened. Either way
    it is over, too, when its controller gives None.
    ``max_actions`` bounds a roll-out, beside the environment's limit.
    """

    operator: Operator
    policy: Policy
    sampler: Sampler
    terminal: Terminal | None = None
    max_actions: int | None = None

    def __repr__(self) -> str:
        return f"<skill {self.operator!r}, {self.sampler.dimension} numbers in a subgoal>"

    @classmethod
    def of_given(cls, operator: Operator, given: GivenSkill, arguments: tuple[Variable, ...]) -> "Skill":
        """Make a given skill happen as an operator; ``arguments`` are the parameters that it gets."""
        policy = GivenPolicy(given, tuple(operator.parameters.index(v) for v in arguments))
        return cls(operator, policy, NoSampler(), never)
