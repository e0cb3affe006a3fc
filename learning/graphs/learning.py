"""What the approaches with a graph network share: examples and training. Source: spec, baselines.md."""

from collections.abc import Iterable

import numpy as np

from bpns.learning.approaches import Learned, Learning
from bpns.learning.data.demonstrations import Demonstrations
from bpns.learning.data.tracking import Tracker
from bpns.learning.graphs.graph import Schema
from bpns.learning.graphs.reactive import GraphModel
from bpns.learning.graphs.training import (
    GraphExample,
    action_loss,
    choice_loss,
    fit_graph_network,
    pointer_loss,
)
from bpns.learning.networks.network import Array32
from bpns.symbolic.errors import InputError
from bpns.symbolic.skills.environment import Environment
from bpns.symbolic.state import State
from bpns.symbolic.structs import GroundAtom


def schema_of(data: Demonstrations, atoms: Iterable[GroundAtom]) -> Schema:
    """Return the columns for all types of the demonstrations, and all predicates of atoms and goals."""
    tasks = [demonstration.task for demonstration in data.demonstrations]
    predicates = {atom.predicate for atom in atoms} | {a.predicate for task in tasks for a in task.goal}
    return Schema.of({o.type for task in tasks for o in task.init.objects}, predicates)


def metacontroller(data: Demonstrations, learned: Learned, how: Learning) -> Learned:
    """Train a graph network to choose the next skill and its objects; one example per segment."""
    skills = sorted(learned.skills, key=lambda one: one.skill.operator.name)
    places = max((len(one.skill.operator.parameters) for one in skills), default=0)
    uses = sorted(
        (place, number, member_number)
        for number, one in enumerate(skills)
        for member_number, place in enumerate(one.places)
    )
    members = [skills[number].data.members[i] for _, number, i in uses]
    if not members:
        raise InputError("nothing to learn: no segment has a skill")
    schema = schema_of(data, {atom for member in members for atom in member.segment.init_atoms})
    kinds = np.eye(len(skills), dtype=np.float32)
    examples = []
    for ((demonstration, _), number, _), member in zip(uses, members, strict=True):
        state = member.segment.trajectory.states[0]
        goal = data.demonstrations[demonstration].task.goal
        graph = schema.encode(state, member.segment.init_atoms, goal)
        rows = [state.objects.index(obj) for obj in member.objects]
        arguments = np.zeros((len(state.objects), places), np.float32)
        arguments[rows, range(len(rows))] = 1
        examples.append(GraphExample(graph, arguments, kinds[number]))
    loss = pointer_loss if how.graphs.pointers else choice_loss
    fitted = fit_graph_network(examples, loss, how.graphs, how.seed, how.device, how.progress)
    model = GraphModel(schema, fitted.network, tuple(one.skill.operator.name for one in skills))
    return Learned(learned.skills, model, (fitted.loss, fitted.epochs))


def cloning(environment: Environment, data: Demonstrations, how: Learning) -> Learned:
    """Train a graph network to give the next action; one example per action."""
    tracker = Tracker(environment)
    rows: list[tuple[State, frozenset[GroundAtom], frozenset[GroundAtom], Array32]] = []
    for one in data.demonstrations:
        for state, action in zip(one.trajectory.states, one.trajectory.actions, strict=False):
            rows.append((state, tracker.move_to(state), one.task.goal, action))
    if not rows:
        raise InputError(f"nothing to learn: {len(data.demonstrations)} demonstrations hold no action")
    schema = schema_of(data, {atom for _, atoms, _, _ in rows for atom in atoms})
    examples = [
        GraphExample(
            schema.encode(state, atoms, goal),
            np.zeros((len(state.objects), 0), np.float32),
            np.asarray(action, np.float32),
        )
        for state, atoms, goal, action in rows
    ]
    fitted = fit_graph_network(examples, action_loss, how.graphs, how.seed, how.device, how.progress)
    return Learned((), GraphModel(schema, fitted.network), (fitted.loss, fitted.epochs))
