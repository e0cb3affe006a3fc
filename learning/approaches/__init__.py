"""Approaches: one module is one way from demonstrations to what solves tasks; its file name is its name."""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from learning.demonstrations import Demonstrations
from learning.reactive import GraphModel
from symbolic.environment import Environment
from symbolic.errors import InputError

if TYPE_CHECKING:  # torch is slow to import, and a list of approaches needs none
    from learning.graph_training import GraphTraining
    from learning.skills import LearnedSkill, SkillConfig


@dataclass(frozen=True, slots=True, eq=False)
class Learning:
    """How to learn: settings, seed, processes, and a device for graph networks."""

    skills: "SkillConfig"
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


def names() -> list[str]:
    """Return the approaches' names, without importing them."""
    return sorted(file.stem for file in Path(__file__).parent.glob("[!_]*.py"))


def load(name: str) -> Approach:
    """Return an approach by name, with ``-`` for ``_`` too; raise InputError where there is none."""
    module = name.replace("-", "_")
    if module not in names():
        have = ", ".join(one.replace("_", "-") for one in names())
        raise InputError(f"unknown approach '{name}' (have: {have})")
    found: Approach = import_module(f"learning.approaches.{module}").APPROACH
    return found
