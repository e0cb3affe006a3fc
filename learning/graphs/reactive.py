"""Acting without a planner: a graph network chooses skills or actions, state by state.

Source: spec, baselines.md sections 3 and 4.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from time import monotonic, perf_counter

import numpy as np

from bpns.learning.graphs.graph import Schema, of_type
from bpns.learning.graphs.network import GraphNetwork
from bpns.symbolic.bilevel.execution import Execution
from bpns.symbolic.skills.environment import Environment, EnvironmentFailure, abstract, holds
from bpns.symbolic.skills.rollout import Failed, GroundSkill, NotInitiable, Rollout
from bpns.symbolic.skills.skill import Skill
from bpns.symbolic.state import Array, State, Task, Trajectory
from bpns.symbolic.structs import GroundAtom, Object

TRIES = 100  # subgoals for a skill that was chosen


@dataclass(frozen=True, slots=True, eq=False)
class GraphModel:
    """A graph network and what it answers: which of ``skills`` to use next or, without any, an action."""

    schema: Schema
    network: GraphNetwork
    skills: tuple[str, ...] = ()


@dataclass(slots=True, eq=False)
class Acted:
    """What a graph network has done so far, in place of a plan."""

    states: list[State]
    actions: list[Array] = field(default_factory=list)
    owners: list[int] = field(default_factory=list)  # for each action, the number of its step
    steps: list[str] = field(default_factory=list)  # the ground operators that were chosen
    samples: int = 0
    seconds: float = 0.0  # for choosing and trying out, as the paper counts test time

    def execution(self, fault: str) -> Execution:
        """Return what was done, with why it failed, if it did."""
        trajectory = Trajectory(tuple(self.states), tuple(self.actions))
        return Execution(trajectory, tuple(self.owners), fault, self.seconds)


def react(
    environment: Environment,
    task: Task,
    model: GraphModel,
    skills: Mapping[str, Skill],
    seed: int,
    deadline: float | None = None,
) -> tuple[Execution, Acted]:
    """Act until the goal holds, the horizon is reached, or nothing can be done; ``deadline`` is monotonic."""
    rng = np.random.default_rng(seed)
    acted = Acted([task.init])
    fault = ""
    while not fault and not _reached(environment, task, acted):
        if len(acted.actions) >= environment.horizon:
            fault = "horizon"
        elif deadline is not None and monotonic() > deadline:
            fault = "time limit reached while acting"
        elif model.skills:
            fault = _use_skill(environment, task, model, skills, acted, rng)
        else:
            fault = _act(environment, task, model, acted)
    return acted.execution(fault), acted


def _reached(environment: Environment, task: Task, acted: Acted) -> bool:
    return all(holds(environment, atom, acted.states[-1]) for atom in task.goal)


def _act(environment: Environment, task: Task, model: GraphModel, acted: Acted) -> str:
    """Take the action that the network gives, clipped into the box; return what went wrong."""
    state = acted.states[-1]
    start = perf_counter()
    _, action = model.network(model.schema.encode(state, abstract(environment, state), task.goal))
    if not np.isfinite(action).all():
        return "the network's action is not a number"
    clipped = np.clip(action, environment.action_low, environment.action_high).astype(np.float32)
    acted.seconds += perf_counter() - start
    try:
        acted.states.append(environment.simulate(state, clipped))
    except EnvironmentFailure as failure:
        return f"failure: {failure}"
    acted.actions.append(clipped)
    acted.owners.append(0)
    return ""


def _use_skill(
    environment: Environment,
    task: Task,
    model: GraphModel,
    skills: Mapping[str, Skill],
    acted: Acted,
    rng: np.random.Generator,
) -> str:
    """Choose a skill and run it, if its effects come about in the simulator; return what went wrong.

    The simulator is deterministic: what it did is what the environment does, up to where the goal holds.
    """
    state = acted.states[-1]
    start = perf_counter()
    atoms = abstract(environment, state)
    chosen = choose(model, skills, state, atoms, task.goal)
    if isinstance(chosen, str):
        return chosen
    number = len(acted.steps)
    acted.steps.append(str(chosen.operator))
    found = _successful(environment, chosen, state, atoms, acted, rng)
    acted.seconds += perf_counter() - start
    if isinstance(found, str):
        return f"step {number + 1} {chosen.operator}: {found}"
    for action, after in zip(found.trajectory.actions, found.trajectory.states[1:], strict=True):
        acted.actions.append(action)
        acted.owners.append(number)
        acted.states.append(after)
        if len(acted.actions) >= environment.horizon or _reached(environment, task, acted):
            break
    return ""


def choose(
    model: GraphModel,
    skills: Mapping[str, Skill],
    state: State,
    atoms: frozenset[GroundAtom],
    goal: frozenset[GroundAtom],
) -> GroundSkill | str:
    """Return the skill with the highest score, each parameter with the highest object of its type.

    Or why there is none. Preconditions are not looked at, and one object may be chosen twice.
    """
    scores, kinds = model.network(model.schema.encode(state, atoms, goal))
    skill = skills[model.skills[int(kinds.argmax())]]
    objects: list[Object] = []
    for place, variable in enumerate(skill.operator.parameters):
        rows = of_type(state.objects, variable.type)
        if not rows:
            return f"{skill.operator.name} was chosen, but there is no {variable.type.name}"
        objects.append(state.objects[rows[int(scores[rows, place].argmax())]])
    try:
        return GroundSkill(skill, skill.operator.ground(tuple(objects)))
    except ValueError as error:  # of an operator with (=), written by a user
        return str(error)


def _successful(
    environment: Environment,
    chosen: GroundSkill,
    state: State,
    atoms: frozenset[GroundAtom],
    acted: Acted,
    rng: np.random.Generator,
) -> Rollout | str:
    """Return a roll-out after which all predicted atoms hold, or why the last try gave none.

    Unlike in the spec, one without actions is none: the same would be chosen again without end.
    """
    expected = chosen.operator.apply(atoms)
    why = ""
    for _ in range(TRIES if chosen.skill.sampler.dimension else 1):
        subgoal = chosen.skill.sampler.sample(state, chosen.operator.objects, rng)
        acted.samples += 1
        rollout = chosen.roll_out(environment, state, subgoal, environment.rollout_limit)
        if isinstance(rollout, NotInitiable):
            return "not initiable"  # whatever the subgoal
        if isinstance(rollout, Failed):
            why = f"failure: {rollout.reason}"
        elif not rollout.trajectory.actions:
            why = "over before it began"
        elif all(holds(environment, atom, rollout.trajectory.states[-1]) for atom in expected):
            return rollout
        else:
            why = "its effects did not come about"
    return why
