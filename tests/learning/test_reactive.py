"""Acting without a planner, with networks that say what the test wants."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest

from bpns.learning.approaches import Learned, Learning
from bpns.learning.data.demonstrations import collect
from bpns.learning.graphs import learning as _graphs
from bpns.learning.graphs.graph import Graph, Schema
from bpns.learning.graphs.reactive import GraphModel, choose, react
from bpns.learning.graphs.training import (
    GraphExample,
    GraphFitted,
    GraphTraining,
    choice_loss,
    fit_graph_network,
)
from bpns.learning.models.learn import learn_skills
from bpns.learning.models.settings import SkillConfig
from bpns.learning.networks.settings import Training
from bpns.symbolic.operators import Operator
from bpns.symbolic.skills.environment import abstract, holds, sample_tasks
from bpns.symbolic.skills.skill import NoSampler, Skill
from bpns.symbolic.state import Array, State
from bpns.symbolic.structs import Object, Type, Variable
from tests.toy import DOOR, DOOR_0, HAND, HAND_0, SKILLS, Repeat, Toy

SCHEMA = Schema.of([HAND, DOOR], set())
WORLD = Toy()
TASK = sample_tasks(WORLD, "test", 1, 0)[0]


@dataclass
class Says:
    """A network that gives one answer after the other: a skill's number, and its arguments' scores."""

    skills: list[int]
    scores: Any = field(default_factory=lambda: np.zeros((2, 2)))

    def __call__(self, graph: Graph) -> tuple[Any, Any]:
        number = self.skills.pop(0) if len(self.skills) > 1 else self.skills[0]
        return self.scores, np.eye(2)[number]


def model(*numbers: int, scores: Any = None) -> GraphModel:
    network: Any = Says(list(numbers), np.zeros((2, 2)) if scores is None else scores)
    return GraphModel(SCHEMA, network, ("search", "unlock"))


@dataclass
class CountedSampler:
    """Gives a key that fits at one of its draws only."""

    good: int
    drawn: int = 0
    dimension: int = 1

    def sample(self, state: State, objects: tuple[Object, ...], rng: np.random.Generator) -> Array:
        self.drawn += 1
        return np.array([0.9 if self.drawn == self.good else 0.0], np.float32)


def with_sampler(sampler: CountedSampler) -> dict[str, Skill]:
    return {**SKILLS, "search": replace(SKILLS["search"], sampler=sampler)}


def test_arguments_are_the_best_of_their_type() -> None:
    assert TASK.init.objects == (DOOR_0, HAND_0)
    # The door has the highest score everywhere, but a hand is wanted.
    found = choose(
        model(0, scores=np.array([[9.0, 9.0], [0.0, 0.0]])), SKILLS, TASK.init, frozenset(), TASK.goal
    )
    assert not isinstance(found, str)
    assert str(found.operator) == "search(hand0)"


def test_one_object_may_be_chosen_twice_and_the_column_is_the_place() -> None:
    one, two = Variable("?a", HAND), Variable("?b", HAND)
    both = Operator("both", (one, two), frozenset(), SKILLS["search"].operator.add_effects, frozenset())
    hands = [Object("hand0", HAND), Object("hand1", HAND)]
    state = State.of({hand: [0, 0] for hand in hands})
    skills = {
        "search": Skill(replace(both, add_effects=frozenset()), Repeat(0), NoSampler()),
        "unlock": SKILLS["unlock"],
    }
    for scores, wanted in (([[1, 1], [0, 0]], "hand0, hand0"), ([[0, 1], [1, 0]], "hand1, hand0")):
        found = choose(model(0, scores=np.array(scores)), skills, state, frozenset(), frozenset())
        assert not isinstance(found, str)
        assert str(found.operator) == f"both({wanted})"


def test_no_object_of_a_type_is_why() -> None:
    ghost = Variable("?ghost", Type("ghost"))
    skill = Skill(
        replace(SKILLS["search"].operator, parameters=(ghost,), add_effects=frozenset()),
        Repeat(0),
        NoSampler(),
    )
    found = choose(model(0), {**SKILLS, "search": skill}, TASK.init, frozenset(), TASK.goal)
    assert found == "search was chosen, but there is no ghost"


def test_a_hundred_subgoals_are_tried_and_no_more() -> None:
    for good, works in ((1, True), (100, True), (101, False)):
        sampler = CountedSampler(good)
        execution, acted = react(WORLD, TASK, model(0, 1), with_sampler(sampler), 0)
        assert sampler.drawn == min(good, 100)
        assert (len(acted.steps) == 2) == works
        assert execution.success == works
        if not works:
            assert execution.fault.startswith("step 1 search(hand0): ")


def test_what_is_not_initiable_ends_it() -> None:
    execution, acted = react(WORLD, TASK, model(1), SKILLS, 0)
    assert execution.fault == "step 1 unlock(door0, hand0): not initiable"
    assert not execution.trajectory.actions
    assert acted.steps == ["unlock(door0, hand0)"]


def test_effects_must_come_about() -> None:
    """A skill that runs but predicts what does not happen is no success."""
    wrong = replace(
        SKILLS["search"].operator,
        add_effects=SKILLS["unlock"].operator.add_effects,
        parameters=SKILLS["unlock"].operator.parameters,
        preconditions=frozenset(),
    )
    skills = {**SKILLS, "search": Skill(wrong, Repeat(0), NoSampler(), max_actions=2)}
    execution, _ = react(WORLD, TASK, model(0), skills, 0)
    assert "its effects did not come about" in execution.fault


def test_acting_ends_at_the_goal_and_at_the_horizon() -> None:
    sampler = CountedSampler(1)
    execution, _ = react(WORLD, TASK, model(0, 1), with_sampler(sampler), 0)
    states = execution.trajectory.states
    reached = [all(holds(WORLD, atom, state) for atom in TASK.goal) for state in states]
    assert reached == [False] * (len(states) - 1) + [True]
    idle: Any = Says([0])  # as an action: search, with a key that never fits
    execution, _ = react(WORLD, TASK, GraphModel(SCHEMA, idle), {}, 0)
    assert execution.fault == "horizon"
    assert len(execution.trajectory.actions) == WORLD.horizon


def test_examples_are_the_segments_and_what_was_done() -> None:
    """Which node is which argument, which skill, and the goal. Source: spec, baselines.md section 3."""
    data = collect(WORLD, 12, seed=0)
    once = Training(1)
    config = SkillConfig(policy=once, generator=once, discriminator=once)
    skills = learn_skills(WORLD, data, config, 0)
    found: list[GraphExample] = []

    def keep(examples: list[GraphExample], *_: object) -> GraphFitted:
        found.extend(examples)
        return fit_graph_network(examples, choice_loss, GraphTraining(epochs=1), 0, "cpu")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(_graphs, "fit_graph_network", keep)
        learned = _graphs.metacontroller(data, Learned(skills), Learning(config, GraphTraining(), 0))
    assert learned.graph is not None
    assert learned.graph.skills == ("Op0", "Op1")
    assert len(found) == 2 * len(data.demonstrations)  # search, unlock, search, unlock, ...
    for number, example in enumerate(found):
        demonstration = data.demonstrations[number // 2]
        skill = skills[number % 2]
        segment = skill.data.members[number // 2].segment
        state = segment.trajectory.states[0]
        assert segment.init_atoms == abstract(WORLD, state)
        wanted = learned.graph.schema.encode(state, segment.init_atoms, demonstration.task.goal)
        assert (example.graph.nodes == wanted.nodes).all()
        assert (example.graph.edges == wanted.edges).all()
        assert example.whole.tolist() == [1 - number % 2, number % 2]
        objects = [str(o) for o in skill.data.members[number // 2].objects]
        rows = {o.name: row for row, o in enumerate(state.objects)}
        for name, row in rows.items():
            assert example.nodes[row].tolist() == [
                float(place < len(objects) and objects[place] == name) for place in range(2)
            ]
