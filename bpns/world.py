"""Worlds: an environment, how it is asked for, and its tasks."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bpns import envs
from bpns.symbolic.errors import InputError
from bpns.symbolic.files import check_output, write_text
from bpns.symbolic.skills.environment import Environment, Split, abstract, sample_tasks
from bpns.symbolic.skills.own_task import parse_goal, read_state, state_of
from bpns.symbolic.state import State, Task
from bpns.symbolic.structs import GroundAtom, Predicate, Type

if TYPE_CHECKING:
    from PIL.Image import Image


@dataclass(frozen=True, slots=True, eq=False)
class World:
    """An environment with its tasks. ``load_environment`` makes one.

    ``asked`` is how it is asked for in commands and files: "cover", "stick_button:test_buttons=5" or
    "module:attribute". ``environment`` is the thing itself: simulator, classifiers, skills.

    >>> world = load_environment("cover")
    >>> sorted(world.predicates)
    ['Covers', 'HandEmpty', 'Holding', 'IsBlock', 'IsTarget']
    """

    environment: Environment
    asked: str
    folder: Path | None = None  # where the module of "module:attribute" is, unless it is installed

    @property
    def name(self) -> str:
        """The environment's name, which is its PDDL domain's too."""
        return self.environment.name

    @property
    def types(self) -> dict[str, Type]:
        """The types of objects by name; each has its ``features`` in order."""
        return {t.name: t for t in self.environment.types}

    @property
    def predicates(self) -> dict[str, Predicate]:
        """The predicates by name. Applied to objects they give a ground atom."""
        return {p.name: p for p in self.environment.classifiers}

    def task(self, split: Split = "test", number: int = 0, seed: int = 0) -> Task:
        """Return the task of this number, counting from 0, as every command counts them.

        ``split`` is "train" (of demonstrations) or "test" (of evaluations). Raises InputError for others.

        >>> load_environment("cover").task("test", 3)
        <task: Covers(block0, target0); 9 objects>
        """
        if number < 0:
            raise InputError(f"task {number}: tasks are counted from 0")
        return self.tasks(split, number + 1, seed)[-1]

    def tasks(self, split: Split = "test", count: int = 50, seed: int = 0) -> list[Task]:
        """Return the first ``count`` tasks of a split. Source: spec, common.md section 4."""
        if split not in ("train", "test"):
            raise InputError(f"unknown split '{split}' (have: train, test)")
        return sample_tasks(self.environment, split, count, seed)

    def own_task(
        self, goal: str | frozenset[GroundAtom], init: State | Path | str | Mapping[str, Mapping[str, Any]]
    ) -> Task:
        """Return a task of one's own: a goal, and an initial state or the JSON file of one.

        The goal is text such as "Covers(block0, target1), HandEmpty()", or ground atoms. Raises InputError
        for predicates, objects, types and features that there are not.

        >>> world = load_environment("cover")
        >>> world.own_task("Covers(block0, target1)", world.task().init)
        <task: Covers(block0, target1); 9 objects>
        """
        if isinstance(init, State):
            state = init
        elif isinstance(init, Mapping):
            state = state_of(self.environment, init)
        else:
            state = read_state(Path(init), self.environment)
        return Task(state, parse_goal(self.environment, state, goal) if isinstance(goal, str) else goal)

    def abstract(self, state: State) -> frozenset[GroundAtom]:
        """Return the abstract state: all ground atoms that hold. Source: spec, algorithm.md section 2."""
        return abstract(self.environment, state)

    def draw(self, state: State, goal: frozenset[GroundAtom] = frozenset(), caption: str = "") -> "Image":
        """Return a picture of a state; a notebook shows it."""
        return self.environment.draw(state, caption, goal)

    def __repr__(self) -> str:
        predicates = ", ".join(p.signature for p in self.predicates.values())
        return f"<environment {self.asked}: {predicates}>"


def load_environment(environment: "str | Environment | World", folders: Iterable[Path] = ()) -> World:
    """Return a world: one that ships by its name, or one's own.

    One's own is "module:attribute", where the module is looked for in the current folder last of all, and
    then in ``folders``; or the object itself, which has the fields of ``Environment``. Fields of environments
    that are dataclasses may follow a name. Raises InputError where there is no such environment, or where it
    lacks something.

    >>> load_environment("stick_button:test_buttons=5").environment.test_buttons
    (5,)
    """
    if isinstance(environment, World):
        return environment
    if isinstance(environment, str):
        return World(envs.load(environment, folders), environment, envs.folder(environment))
    return World(envs.complete(environment, type(environment).__name__), environment.name)


def environments() -> list[str]:
    """Return the names of the environments that ship with bpns.

    >>> environments()
    ['coffee', 'cover', 'doors', 'stick_button']
    """
    return envs.names()


def new_environment(name: str, path: Path | str, overwrite: bool = False) -> None:
    """Write a commented environment to begin with: a small world that works, under a name of your own.

    Raises InputError where the name is none of a Python class and of a PDDL domain, or the file exists.

    >>> new_environment("kitchen", "kitchen.py")
    >>> load_environment("kitchen:ENVIRONMENT").name
    'kitchen'
    """
    path = Path(path)
    words = name.split("_")
    if not all(word.isascii() and word.isalnum() for word in words) or not name[0].isalpha():
        raise InputError(
            f"'{name}' cannot be an environment's name: use letters, digits and _, as in my_robot"
        )
    if not path.with_suffix("").name.isidentifier() or path.suffix != ".py":
        raise InputError(f"{path}: not the name of a Python module: call it {name}.py, for instance")
    check_output(path, overwrite)
    text = resources.files("bpns").joinpath("skeleton.py").read_text(encoding="utf-8")
    text = text.replace("FILE:", f"{path.with_suffix('').name}:").replace('"sorting"', f'"{name}"')
    write_text(path, text.replace("Sorting", "".join(word.capitalize() for word in words)))
