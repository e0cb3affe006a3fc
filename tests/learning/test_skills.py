"""Learning end to end, in the toy world and in Cover."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bpns import envs
from bpns.learning.data.demonstrations import Demonstrations, collect
from bpns.learning.data.segmentation import segment
from bpns.learning.experiments.evaluation import evaluate, summarize
from bpns.learning.models.learn import LearnedSkill, learn_skills
from bpns.learning.models.load import read_model
from bpns.learning.models.save import entry_of, write_model
from bpns.learning.models.settings import SkillConfig, shared_out
from bpns.learning.models.solver import Solver
from bpns.learning.networks.policies import LearnedPolicy, changing_features, policy_examples
from bpns.learning.networks.samplers import LearnedSampler, discriminator_examples, generator_examples
from bpns.learning.networks.settings import Training
from bpns.learning.operators.learn import learn_operators
from bpns.symbolic import planners
from bpns.symbolic.bilevel.exhaustive import exhaustive
from bpns.symbolic.bilevel.solve import Plan, solve
from bpns.symbolic.errors import InputError
from bpns.symbolic.skills.environment import Budget, sample_tasks
from tests.toy import Toy

FEW = SkillConfig(policy=Training(200), generator=Training(2000), discriminator=Training(200))
COVER = envs.load("cover")


@pytest.fixture(scope="module")
def toy_skills() -> tuple[LearnedSkill, ...]:
    environment = Toy()
    data = collect(environment, 20, seed=0)
    return learn_skills(environment, data, FEW, seed=0)


def test_few_rows_give_a_linear_part_and_a_mean_of_policies(toy_skills: tuple[LearnedSkill, ...]) -> None:
    """Which is saved and read again: the test of the toy task compares."""
    skill = toy_skills[0].skill
    assert isinstance(skill.policy, LearnedPolicy)
    assert isinstance(skill.sampler, LearnedSampler)
    assert all(network.linear is not None for network in skill.sampler.generators)
    assert skill.policy.network.linear is None
    widths = {len(layers[0][1]) for layers in [skill.policy.network.layers] if len(layers) > 1}
    assert widths <= {FEW.few_policies * FEW.policy.hidden[0]}


def test_toy_operators(toy_skills: tuple[LearnedSkill, ...]) -> None:
    search, unlock = (one.skill.operator for one in toy_skills)
    assert {str(a) for a in search.add_effects} == {"HasKey(?x0:hand)"}
    assert {str(a) for a in unlock.preconditions} == {"HasKey(?x1:hand)"}
    assert {str(a) for a in unlock.add_effects} == {"IsOpen(?x0:door)"}


def test_learned_skills_solve_the_toy_task(toy_skills: tuple[LearnedSkill, ...], tmp_path: Path) -> None:
    """Demonstrations hold only keys that fit, so the learned sampler does better than the given one."""
    environment = Toy()
    skills = {one.skill.operator.name: one.skill for one in toy_skills}
    task = sample_tasks(environment, "test", 1, 0)[0]
    plan = solve(environment, task, skills, planners.load("astar"), Budget(3, 10), 1)
    assert isinstance(plan, Plan)
    pairs = [
        (one.skill, entry_of(one.skill, one.segments, one.demonstrations, one.fits)) for one in toy_skills
    ]
    write_model(tmp_path / "toy", environment, "tests.toy:Toy", 0, pairs, {}, "")
    saved = read_model(tmp_path / "toy", environment)
    again = solve(environment, task, saved.skills, planners.load("astar"), Budget(3, 10), 1)
    assert isinstance(again, Plan)
    assert [s.subgoal.tolist() for s in again.steps] == [s.subgoal.tolist() for s in plan.steps]


def test_actions_that_never_vary_are_exact(toy_skills: tuple[LearnedSkill, ...]) -> None:
    unlock = toy_skills[1].skill
    state = sample_tasks(Toy(), "test", 1, 0)[0].init
    objects = tuple(next(o for o in state.objects if o.type == v.type) for v in unlock.operator.parameters)
    subgoal = unlock.sampler.sample(state, objects, np.random.default_rng(0))
    assert unlock.policy.begin(state, objects, subgoal)(state).tolist() == [1.0, 0.0]


def test_nothing_to_learn() -> None:
    with pytest.raises(InputError, match="nothing to learn"):
        learn_skills(Toy(), Demonstrations("toy", 0, 3, (), ()), FEW, seed=0)


def test_cover_examples_are_as_specified(demonstrations: Demonstrations) -> None:
    segments = [s for d in demonstrations.demonstrations for s in segment(COVER, d.trajectory, d.labels)]
    pick, place = learn_operators(segments)
    names = [
        [f"{operator.operator.parameters[p].type.name}.{operator.operator.parameters[p].type.features[f]}"
         for p, f in changing_features(operator)]
        for operator in (pick, place)
    ]  # fmt: skip
    assert names == [
        ["block.grasp", "gripper.x", "gripper.y", "gripper.grip", "gripper.holding"],
        ["block.x", "block.grasp", "gripper.x", "gripper.grip", "gripper.holding"],
    ]
    changing = changing_features(pick)
    inputs, actions = policy_examples(pick, changing)
    member = pick.members[0]
    states = member.segment.trajectory.states
    assert inputs.shape == (sum(len(m.segment.trajectory.actions) for m in pick.members), 1 + 5 + 4 + 5)
    assert inputs[0, 0] == 1
    assert inputs[0, 1:10].tolist() == np.float32(states[0].vector(member.objects)).tolist()
    robot = member.objects[1]
    assert inputs[0, 11] == np.float32(
        states[-1][robot][0] - states[0][robot][0]
    )  # what is still to come in x
    assert actions[0].tolist() == member.segment.trajectory.actions[0].tolist()
    rows, subgoals = generator_examples(pick, changing)
    assert rows.shape == (len(pick.members), 10)
    assert subgoals[0, 0] == 2  # grasp goes from -1 to 1
    placed = generator_examples(place, changing_features(place))[1]
    examples = discriminator_examples(place, place.members, placed, np.random.default_rng(0))
    assert examples is not None
    discriminator_rows, labels = examples
    assert labels.sum() == len(place.members)
    assert len(labels) == 2 * len(place.members)  # three negatives a segment, cut to the positives' number
    assert np.array_equal(
        discriminator_rows[: len(place.members), :12], generator_examples(place, changing_features(place))[0]
    )


def test_evaluation_counts(learned: tuple[LearnedSkill, ...]) -> None:
    """Skills that were hardly trained fail; the counts must say how far each task came."""
    skills = {one.skill.operator.name: one.skill for one in learned}
    budget = replace(COVER.budget, samples_per_step=2)
    solver = Solver(COVER, skills, planners.load("astar"), budget, strategy=exhaustive)
    results = evaluate(solver, [0, 1], 3)
    assert [(r.seed, r.task) for r in results] == [(s, t) for s in (0, 1) for t in range(3)]
    for result in results:
        assert result.planned
        assert result.executed <= result.refined
        assert bool(result.fault) == (not result.executed)
        assert result.refined or result.dead_ends
    summary = summarize({seed: [r for r in results if r.seed == seed] for seed in (0, 1)})
    assert summary.planned == (100.0, 0.0)
    assert summary.solved[0] == pytest.approx(100 * sum(r.executed for r in results) / 6)


@pytest.mark.slow
def test_cover_is_learned_and_solved() -> None:
    """150 demonstrations are enough for nearly every task; tasks are not those of any reported figure."""
    data = collect(COVER, 150, seed=77)
    skills = learn_skills(COVER, data, SkillConfig(), seed=77)
    assert [one.skill.operator.name for one in skills] == ["Op0", "Op1"]
    by_name = {one.skill.operator.name: one.skill for one in skills}
    solver = Solver(COVER, by_name, planners.load("astar"), COVER.budget)
    assert summarize({77: evaluate(solver, [77], 40)}).solved[0] >= 95
    summary = summarize({77: evaluate(replace(solver, strategy=exhaustive), [77], 40)})
    assert summary.solved[0] >= 95
    assert summary.nodes_created[0] < 12  # mostly, the first abstract plan can be refined


@pytest.mark.parametrize(
    ("skills", "policy", "generator"), [(0, 1500, 1200), (1, 1500, 1200), (10, 900, 700)]
)
def test_networks_share_the_iterations(skills: int, policy: int, generator: int) -> None:
    shared = shared_out(SkillConfig(), skills)
    assert (shared.policy.iterations, shared.generator.iterations) == (policy, generator)
    assert shared_out(SkillConfig.paper(), skills) == SkillConfig.paper()
