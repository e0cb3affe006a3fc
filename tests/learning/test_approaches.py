"""The approaches: what each learns, that it is the same after loading, and that it acts."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bpns import envs
from bpns.learning import approaches
from bpns.learning.approaches import Learned, Learning
from bpns.learning.data.demonstrations import Demonstrations
from bpns.learning.experiments.evaluation import evaluate, summarize
from bpns.learning.graphs.reactive import GraphModel, choose, react
from bpns.learning.graphs.saved import graph_entry
from bpns.learning.graphs.training import GraphTraining
from bpns.learning.models.files import SavedModel
from bpns.learning.models.load import read_model
from bpns.learning.models.save import entry_of, write_model
from bpns.learning.models.settings import SkillConfig
from bpns.learning.models.solver import Solver
from bpns.learning.networks.policies import LearnedPolicy, PassThrough
from bpns.learning.networks.samplers import LearnedSampler
from bpns.learning.networks.settings import Training
from bpns.symbolic import planners
from bpns.symbolic.bilevel.exhaustive import exhaustive
from bpns.symbolic.errors import InputError
from bpns.symbolic.skills.environment import abstract, sample_tasks
from bpns.symbolic.skills.skill import Skill

COVER = envs.load("cover")
SHORT = Training(300)
HOW = Learning(
    SkillConfig(policy=SHORT, generator=SHORT, discriminator=SHORT),
    GraphTraining(epochs=10, check_every=5),
    0,
)
Save = Callable[[Learned, str], SavedModel]


@pytest.fixture
def save(tmp_path: Path) -> Save:
    """Writes a model and reads it again."""

    def through_files(learned: Learned, approach: str) -> SavedModel:
        pairs = [(o.skill, entry_of(o.skill, o.segments, o.demonstrations, o.fits)) for o in learned.skills]
        graph = learned.graph and (learned.graph, graph_entry(learned.graph, learned.fit))
        write_model(tmp_path / "model", COVER, "cover", 0, pairs, {}, "", approach, graph)
        return read_model(tmp_path / "model", COVER)

    return through_files


def learn(name: str, data: Demonstrations, how: Learning = HOW) -> Learned:
    found = approaches.load(name).learn
    assert found is not None
    return found(COVER, data, how)


def solver(skills: dict[str, Skill], graph: GraphModel | None = None) -> Solver:
    return Solver(COVER, skills, planners.load("astar"), COVER.budget, strategy=exhaustive, graph=graph)


def test_every_approach_says_what_it_is() -> None:
    found = [approaches.load(name) for name in approaches.names()]
    assert len({one.title for one in found}) == len(found)
    assert all(one.summary for one in found)
    assert [one.title for one in found if one.learn is None] == ["Oracle"]
    assert approaches.load("gnn-meta") == approaches.load("gnn_meta")
    with pytest.raises(InputError, match=r"unknown approach 'gnn' \(have: bpns, gnn-bc"):
        approaches.load("gnn")


def test_without_subgoals_policies_see_the_state_alone(demonstrations: Demonstrations, save: Save) -> None:
    learned = learn("no_subgoal", demonstrations)
    bpns = learn("bpns", demonstrations)
    assert [o.skill.operator for o in learned.skills] == [o.skill.operator for o in bpns.skills]
    for skill in save(learned, "no_subgoal").skills.values():
        assert skill.sampler.dimension == 0
        assert isinstance(skill.policy, LearnedPolicy)
        features = sum(len(v.type.features) for v in skill.operator.parameters)
        assert len(skill.policy.network.inputs.shift) == 1 + features
    results = evaluate(solver({o.skill.operator.name: o.skill for o in learned.skills}), [0], 3)
    assert all(result.planned for result in results)


def test_their_policies_are_trained_as_long_as_policy_and_sampler(demonstrations: Demonstrations) -> None:
    """Spec, baselines.md section 1: 60,000 iterations with the paper's settings."""
    paper = SkillConfig.paper()
    total = paper.policy.iterations + paper.generator.iterations
    assert total == 60_000
    how = replace(HOW, skills=replace(HOW.skills, policy_iterations=None))
    one = learn("no_subgoal", demonstrations, how).skills[0]
    assert one.fits == {"policy": (pytest.approx(one.fits["policy"][0]), 601)}


def test_a_metacontroller_is_the_same_from_a_file(demonstrations: Demonstrations, save: Save) -> None:
    learned = learn("gnn_meta", demonstrations)
    assert learned.graph is not None
    assert learned.graph.skills == ("Op0", "Op1")
    saved = save(learned, "gnn_meta")
    assert saved.approach == "gnn_meta"
    assert saved.graph is not None
    assert saved.graph.schema == learned.graph.schema
    skills = {one.skill.operator.name: one.skill for one in learned.skills}
    for task in sample_tasks(COVER, "test", 5, 0):
        atoms = abstract(COVER, task.init)
        one = choose(learned.graph, skills, task.init, atoms, task.goal)
        two = choose(saved.graph, saved.skills, task.init, atoms, task.goal)
        assert not isinstance(one, str)
        assert not isinstance(two, str)
        assert one.operator == two.operator
        types = [v.type for v in one.operator.operator.parameters]
        assert [o.type for o in one.operator.objects] == types


def test_a_trained_metacontroller_picks_first(demonstrations: Demonstrations) -> None:
    graphs = GraphTraining(epochs=300, learning_rate=1e-2, check_every=10)
    learned = learn("gnn_meta", demonstrations, replace(HOW, graphs=graphs))
    assert learned.graph is not None
    skills = {one.skill.operator.name: one.skill for one in learned.skills}
    for task in sample_tasks(COVER, "test", 10, 0):
        chosen = choose(learned.graph, skills, task.init, abstract(COVER, task.init), task.goal)
        assert not isinstance(chosen, str)
        assert chosen.initiable(COVER, task.init)


def test_acting_is_counted_and_nothing_is_planned(demonstrations: Demonstrations) -> None:
    learned = learn("gnn_meta", demonstrations)
    skills = {one.skill.operator.name: one.skill for one in learned.skills}
    results = evaluate(solver(skills, learned.graph), [0], 4)
    assert all(result.planned is None and result.refined is None for result in results)
    assert all(result.executed == (not result.fault) for result in results)
    summary = summarize({0: results})
    assert np.isnan(summary.planned[0])
    assert summary.solved[0] == 100 * np.mean([result.executed for result in results])
    again = evaluate(solver(skills, learned.graph), [0], 4)
    assert [(r.executed, r.samples, r.fault) for r in again] == [
        (r.executed, r.samples, r.fault) for r in results
    ]


def test_what_a_metacontroller_did_is_what_the_simulator_does(demonstrations: Demonstrations) -> None:
    learned = learn("gnn_meta", demonstrations)
    assert learned.graph is not None
    skills = {one.skill.operator.name: one.skill for one in learned.skills}
    for number, task in enumerate(sample_tasks(COVER, "test", 10, 0)):
        execution, acted = react(COVER, task, learned.graph, skills, number)
        states = execution.trajectory.states
        for before, action, after in zip(states, execution.trajectory.actions, states[1:], strict=False):
            assert COVER.simulate(before, action).features == after.features
        assert len(execution.steps) == len(execution.trajectory.actions) <= COVER.horizon
        assert set(execution.steps) <= set(range(len(acted.steps)))


def test_cloning_acts_inside_the_box_until_the_horizon(demonstrations: Demonstrations, save: Save) -> None:
    saved = save(learn("gnn_bc", demonstrations), "gnn_bc")
    assert saved.graph is not None
    assert not saved.skills
    task = sample_tasks(COVER, "test", 1, 0)[0]
    execution, _ = react(COVER, task, saved.graph, {}, 0)
    assert execution.success or len(execution.trajectory.actions) == COVER.horizon
    for action in execution.trajectory.actions:
        assert (COVER.action_low <= action).all()
        assert (action <= COVER.action_high).all()


def test_pass_through_has_an_operator_without_effects(demonstrations: Demonstrations, save: Save) -> None:
    """Source: spec, baselines.md section 5."""
    learned = learn("pass_through", demonstrations)
    operators = [one.skill.operator for one in learned.skills]
    idle = [o for o in operators if not o.add_effects and not o.delete_effects]
    assert len(operators) == 3
    assert len(idle) == 1
    assert not idle[0].parameters
    assert not idle[0].preconditions
    actions = sum(len(d.trajectory.actions) for d in demonstrations.demonstrations)
    assert sum(one.segments for one in learned.skills) == actions
    saved = save(learned, "pass_through")
    for skill in saved.skills.values():
        assert isinstance(skill.policy, PassThrough)
        assert isinstance(skill.sampler, LearnedSampler)
        assert skill.sampler.dimension == len(COVER.action_low)
        # Other operators' actions are negatives, too; the one without effects is of no wrong action.
        assert (skill.sampler.discriminator is None) == (skill.operator.name == idle[0].name)
    results = evaluate(solver(dict(saved.skills)), [0], 2)
    assert all(result.planned for result in results)


def test_damaged_graphs_are_one_clear_message(demonstrations: Demonstrations, tmp_path: Path) -> None:
    learned = learn("gnn_bc", demonstrations)
    assert learned.graph is not None
    entry = graph_entry(learned.graph, learned.fit)
    wider = entry.model_copy(update={"types": [*entry.types, "another"]})
    write_model(tmp_path / "model", COVER, "cover", 0, [], {}, "", "gnn_bc", (learned.graph, wider))
    with pytest.raises(InputError, match=r"skills.safetensors: \(graph\).encode.nodes.0.weights is of shape"):
        read_model(tmp_path / "model", COVER)
    chooses = entry.model_copy(update={"skills": ["Op7"]})
    write_model(tmp_path / "model", COVER, "cover", 0, [], {}, "", "gnn_meta", (learned.graph, chooses))
    with pytest.raises(InputError, match="chooses 'Op7', which domain"):
        read_model(tmp_path / "model", COVER)


@pytest.mark.parametrize("name", ["bpns", "gnn_meta", "gnn_bc", "pass_through"])
def test_nothing_to_learn_from(name: str) -> None:
    with pytest.raises(InputError, match="nothing to learn"):
        learn(name, Demonstrations("cover", 0, 3, (), ()))
