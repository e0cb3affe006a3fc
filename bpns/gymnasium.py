"""Our environments for Gymnasium users: importing this module registers ``bpns/Cover-v0`` and the others.

Gymnasium 1.0 gave up entry points, so the import is needed: ``import bpns.gymnasium``, or the module's name
before the id, as in ``gymnasium.make("bpns.gymnasium:bpns/Cover-v0")``. Only this file imports gymnasium.
"""

from collections.abc import Mapping
from typing import Any, TypeAlias, cast, get_args

import numpy as np
from numpy.typing import NDArray

from bpns import envs
from bpns.symbolic.skills.environment import (
    Environment,
    EnvironmentFailure,
    Split,
    abstract,
    holds,
    sample_tasks,
)
from bpns.symbolic.state import Array, State, Task
from bpns.symbolic.structs import GroundAtom, sort_atoms

try:
    import gymnasium
    from gymnasium import spaces
except ModuleNotFoundError as missing:
    raise ModuleNotFoundError(
        "bpns.gymnasium needs Gymnasium: pip install 'bpns[gymnasium]'", name="gymnasium"
    ) from missing

Observation: TypeAlias = dict[str, dict[str, NDArray[Any]]]

MOST_OBJECTS = 2**31 - 1  # of a type: a bound only because spaces of whole numbers must have one


class TaskEnvironment(gymnasium.Env[Observation, Array]):
    """An environment and one of its tasks: each episode tries to reach a goal.

    Tasks differ in their objects and their goals, so an observation has a table for each type and each goal
    predicate: ``observation["objects"]["block"]`` is (number of blocks, features) float64, in canonical
    order, and ``observation["goal"]["Covers"]`` is (number of goal atoms, arguments) int64, where a number
    counts the objects that fit the argument's type, so that it is a row of that type's table.

    The reward is 1 when the goal is reached, else 0. An episode terminates at the goal and at an environment
    failure, and is truncated at the environment's horizon. ``state`` and ``task`` of the unwrapped
    environment give what planners need; ``info`` cannot, as Gymnasium compares infos and states have no
    equality.

    ``options`` are the environment's own, such as ``test_buttons`` of Stick Button. ``atoms=False`` leaves
    the abstract state out of the infos; in Doors it takes most of a step's time.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 10}  # noqa: RUF012 - Gymnasium's own name and type

    environment: Environment
    task: Task
    state: State

    def __init__(
        self,
        environment: str | Environment,
        render_mode: str | None = None,
        atoms: bool = True,
        **options: object,
    ) -> None:
        loaded = envs.load(environment) if isinstance(environment, str) else environment
        name = loaded.name
        self.environment = cast(Environment, envs.with_options(loaded, options, name)) if options else loaded
        self.render_mode = render_mode
        self._atoms = atoms
        if render_mode not in (None, "rgb_array"):
            raise ValueError(f"unknown render mode '{render_mode}' (have: rgb_array)")
        self.action_space = spaces.Box(self.environment.action_low, self.environment.action_high)
        self.observation_space = cast(spaces.Space[Observation], _observation_space(self.environment))
        self._drawn = 0  # tasks since the last seed
        self._left = 0  # actions before the episode ends; 0 where it has ended

    def reset(
        self, *, seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin a task.

        Without options, tasks come in the order of ``bpns demos --seed SEED``. The option ``task`` gives a
        certain one: a Task, or the number of an evaluation task as ``bpns evaluate --seeds SEED`` counts
        them. The option ``split``, "train" or "test", says of which kind; without a number both kinds come
        from the generator of ``seed``.
        """
        super().reset(seed=seed)
        if seed is not None:
            self._drawn = 0
        self.task = self._choose(**(options or {}))
        self.state = self.task.init
        self._left = self.environment.horizon
        return self._observe(), self._info("")

    def _choose(self, task: Task | int | None = None, split: Split | None = None) -> Task:
        if split not in (None, *get_args(Split)):
            raise ValueError(f"unknown split '{split}' (have: {', '.join(get_args(Split))})")
        if isinstance(task, Task):
            return task
        if task is not None:
            if task < 0:
                raise ValueError(f"task {task}: tasks are counted from 0")
            return sample_tasks(self.environment, split or "test", task + 1, int(self.np_random_seed or 0))[
                -1
            ]
        self._drawn += 1
        return self.environment.sample_task(split or "train", self._drawn - 1, self.np_random)

    def step(self, action: Array) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Take an action, (A,) inside the action space; raise ValueError where it is not."""
        if not self._left:
            raise gymnasium.error.ResetNeeded("the episode has ended: call reset first")
        action = np.asarray(action, np.float32)
        if action.shape != self.action_space.shape or not self.action_space.contains(action):
            raise ValueError(f"action {action.tolist()} is not in {self.action_space}: clip it")
        failure = ""
        try:
            self.state = self.environment.simulate(self.state, action)
        except EnvironmentFailure as stop:  # there is no next state: the last one is observed again
            failure = str(stop) or "environment failure"
        info = self._info(failure)
        self._left -= 1
        terminated = info["is_success"] or bool(failure)
        truncated = not terminated and not self._left
        if terminated:
            self._left = 0
        return self._observe(), float(info["is_success"]), terminated, truncated, info

    def render(self) -> NDArray[np.uint8] | None:
        """Return a picture, (height, width, 3)."""
        if self.render_mode is None:
            return None
        if not hasattr(self, "state"):
            raise gymnasium.error.ResetNeeded("there is nothing to see yet: call reset first")
        return np.array(self.environment.draw(self.state, "", self.task.goal).convert("RGB"), np.uint8)

    def _observe(self) -> Observation:
        rows = self.state.by_type
        objects = {
            t.name: np.array([self.state[o] for o in rows.get(t.name, ())], np.float64).reshape(
                -1, len(t.features)
            )
            for t in self.environment.types
        }
        goal = {
            predicate.name: np.array(
                [self._places(a) for a in sort_atoms(self.task.goal) if a.predicate == predicate], np.int64
            ).reshape(-1, len(predicate.types))
            for predicate in self.environment.goal_predicates
        }
        return {"objects": objects, "goal": goal}

    def _places(self, atom: GroundAtom) -> list[int]:
        """Give the numbers of an atom's objects, each among those that fit the argument's type."""
        return [
            [o for o in self.state.objects if o.type.is_a(kind)].index(obj)
            for kind, obj in zip(atom.predicate.types, atom.objects, strict=True)
        ]

    def _info(self, failure: str) -> dict[str, Any]:
        reached = not failure and all(holds(self.environment, a, self.state) for a in self.task.goal)
        info = {
            "is_success": reached,
            "failure": failure,
            "goal": tuple(map(str, sort_atoms(self.task.goal))),
        }
        if self._atoms:
            info["atoms"] = tuple(map(str, sort_atoms(abstract(self.environment, self.state))))
        return info


def _observation_space(environment: Environment) -> spaces.Dict:
    """Return a space of tables with any number of rows."""
    tables = {t.name: spaces.Box(-np.inf, np.inf, (len(t.features),), np.float64) for t in environment.types}
    goals = {
        p.name: spaces.Box(0, MOST_OBJECTS, (len(p.types),), np.int64) for p in environment.goal_predicates
    }
    return spaces.Dict(
        {
            "objects": spaces.Dict({n: spaces.Sequence(row, stack=True) for n, row in tables.items()}),
            "goal": spaces.Dict({n: spaces.Sequence(row, stack=True) for n, row in goals.items()}),
        }
    )


def _register() -> None:
    """Register every shipped environment; none is imported before it is made."""
    for name in envs.names():
        camel = "".join(word.capitalize() for word in name.split("_"))
        gymnasium.register(
            id=f"bpns/{camel}-v0",
            entry_point="bpns.gymnasium:TaskEnvironment",
            kwargs={"environment": name},
        )


_register()
