"""Approaches: one module is one way from demonstrations to what solves tasks; its file name is its name.

Read ``bpns``, ours; ``no_subgoal``, ``pass_through`` and the ``gnn_...`` are those that the paper compares it
with, and ``oracle`` stands for skills written by hand.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

from bpns.learning.data.demonstrations import Demonstrations
from bpns.learning.graphs.reactive import GraphModel
from bpns.learning.models.settings import SkillConfig
from bpns.symbolic.errors import InputError
from bpns.symbolic.plugins import PlugIns
from bpns.symbolic.skills.environment import Environment

if TYPE_CHECKING:  # torch is slow to import, and a list of approaches needs none
    from bpns.learning.graphs.training import GraphTraining
    from bpns.learning.models.learn import LearnedSkill


@dataclass(frozen=True, slots=True, eq=False)
class Learning:
    """How to learn: settings, seed, processes, and a device for graph networks."""

    skills: SkillConfig
    graphs: "GraphTraining"
    seed: int
    workers: int = 1
    device: str = "cpu"
    progress: Callable[[int, int], None] = lambda done, total: None


@dataclass(frozen=True, slots=True, eq=False)
class Learned:
    """Skills, and a graph network where it chooses among them or acts in their place."""

    skills: "tuple[LearnedSkill, ...]" = ()
    graph: GraphModel | None = None
    fit: tuple[float, int] = (0.0, 0)  # of the graph network: best loss, epochs


Learn: TypeAlias = Callable[[Environment, Demonstrations, Learning], Learned]


@dataclass(frozen=True, slots=True)
class Approach:
    """What a module offers as ``APPROACH``: a name for tables, one line on it, and how it learns."""

    title: str
    summary: str
    learn: Learn | None = None  # None: there is nothing to learn
    skills: bool = True  # whether it learns operators


APPROACHES = PlugIns("approach", "bpns.learning.approaches", "APPROACH", dash="-")


def names() -> list[str]:
    """Return the approaches' names, without importing them."""
    return APPROACHES.names()


def load(name: str) -> Approach:
    """Return an approach by name, with ``-`` for ``_`` too, or as ``module:attribute``.

    Raises InputError where there is none.
    """
    found = APPROACHES.load(name)
    if not isinstance(found, Approach):
        raise InputError(f"'{name}' is no approach: give an Approach, as in bpns.learning.approaches")
    return found
