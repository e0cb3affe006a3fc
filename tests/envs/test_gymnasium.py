"""Our environments as Gymnasium users meet them."""

import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from bpns import envs
from bpns.gymnasium import TaskEnvironment
from bpns.symbolic import planners
from bpns.symbolic.bilevel.solve import Plan, solve
from bpns.symbolic.errors import InputError
from bpns.symbolic.skills.environment import Split, sample_tasks
from tests.toy import Toy

ROOT = Path(__file__).parents[2]
IDS = {name: f"bpns/{name.title().replace('_', '')}-v0" for name in envs.names()}
EXPECTED = ("For Box action spaces, we recommend", "A Box action space m")  # of boxes that are as specified


def make(name: str, **options: Any) -> gymnasium.Env[Any, Any]:
    return gymnasium.make(IDS[name], **options)


def same(one: Any, two: Any) -> bool:
    """Say whether two observations are equal."""
    if isinstance(one, dict):
        return one.keys() == two.keys() and all(same(one[key], two[key]) for key in one)
    return bool(np.array_equal(one, two))


@pytest.mark.parametrize("name", envs.names())
def test_gymnasium_finds_nothing_wrong(name: str) -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        check_env(make(name, render_mode="rgb_array").unwrapped)
    unexpected = [str(w.message) for w in caught if not any(text in str(w.message) for text in EXPECTED)]
    assert not unexpected


def test_an_id_with_its_module_needs_no_import() -> None:
    code = (
        "import gymnasium; print(gymnasium.make('bpns.gymnasium:bpns/Cover-v0').unwrapped.environment.name)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True)
    assert done.stdout == "cover\n"


def test_without_gymnasium_a_line_says_what_to_install() -> None:
    code = "import sys; sys.modules['gymnasium'] = None; import bpns; import bpns.gymnasium"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=False)
    last = done.stderr.splitlines()[-1]
    assert last.endswith("bpns.gymnasium needs Gymnasium: pip install 'bpns[gymnasium]'")


@pytest.mark.parametrize("split", ["train", "test"])
def test_tasks_are_those_of_the_program(split: Split) -> None:
    world, environment = make("cover"), envs.load("cover")
    tasks = sample_tasks(environment, split, 3, seed=7)
    for number, task in enumerate(tasks):
        world.reset(seed=7, options={"task": number, "split": split})
        assert world.unwrapped.task.init.features == task.init.features
        assert world.unwrapped.task.goal == task.goal
    _, info = world.reset(options={"task": tasks[1]})
    assert info["goal"] == ("Covers(block1, target1)",)
    assert world.unwrapped.state is tasks[1].init


def test_resets_in_sequence_draw_the_training_tasks() -> None:
    world, tasks = make("cover"), sample_tasks(envs.load("cover"), "train", 3, seed=5)
    first = [world.reset(seed=5), world.reset(), world.reset()]
    again = [world.reset(seed=5), world.reset(), world.reset()]
    for (one, info), (two, _), task in zip(first, again, tasks, strict=True):
        assert same(one, two)
        assert info["goal"] == tuple(sorted(map(str, task.goal)))
    assert not same(first[0][0], first[1][0])


def test_an_evaluation_task_is_the_default_for_a_number() -> None:
    world = make("cover")
    one, _ = world.reset(seed=3, options={"task": 2})
    two, _ = world.reset(seed=3, options={"task": 2, "split": "test"})
    three, _ = world.reset(options={"task": 2})  # the seed stays
    assert same(one, two)
    assert same(one, three)


@pytest.mark.parametrize("name", envs.names())
def test_a_plan_reaches_the_goal(name: str) -> None:
    world, environment = make(name), envs.load(name)
    skills = {skill.operator.name: skill for skill in environment.oracle_skills}
    for task in sample_tasks(environment, "train", 4, seed=0):
        plan = solve(environment, task, skills, planners.load("astar"), environment.budget, seed=0)
        if isinstance(plan, Plan):
            break
    observation, info = world.reset(options={"task": task})
    assert info["is_success"] is False
    ended = False
    for action in (action for step in plan.steps for action in step.trajectory.actions):
        assert not ended
        observation, reward, ended, truncated, info = world.step(action)
        assert observation in world.observation_space
        assert (reward, info["is_success"]) == (float(ended), ended)
        assert not truncated
        if ended:
            break
    assert ended
    assert set(info["goal"]) <= set(info["atoms"])


def test_goals_are_rows_of_the_tables() -> None:
    observation, info = make("cover").reset(seed=0, options={"task": 2})
    assert info["goal"] == ("Covers(block0, target0)", "Covers(block1, target1)")
    assert observation["goal"]["Covers"].tolist() == [[0, 0], [1, 1]]
    assert observation["objects"]["block"].shape == (2, 5)
    assert observation["objects"]["block"].dtype == np.float64


def test_a_failure_ends_the_episode() -> None:
    world = TaskEnvironment(Toy(), fails_below=0.5)
    world.reset(seed=0)
    observation, reward, terminated, truncated, info = world.step(np.array([0, 0.25], np.float32))
    assert (reward, terminated, truncated, info["failure"]) == (0.0, True, False, "the key broke")
    assert observation in world.observation_space
    with pytest.raises(gymnasium.error.ResetNeeded, match="call reset first"):
        world.step(np.array([0, 0.75], np.float32))


def test_the_horizon_truncates_and_the_goal_does_not() -> None:
    world = TaskEnvironment("tests.toy:Toy", horizon=2)
    search, unlock = np.array([0, 0.9], np.float32), np.array([1, 0], np.float32)
    world.reset(seed=0)
    assert world.step(search)[1:4] == (0.0, False, False)
    assert world.step(search)[1:4] == (0.0, False, True)
    world.reset(seed=0)
    world.step(search)
    assert world.step(unlock)[1:4] == (1.0, True, False)


def test_pictures() -> None:
    world = make("cover", render_mode="rgb_array")
    world.reset(seed=0)
    picture = world.render()
    assert isinstance(picture, np.ndarray)
    assert (picture.dtype, picture.ndim, picture.shape[2]) == (np.uint8, 3, 3)
    assert picture.std() > 1


def test_several_at_once() -> None:
    worlds = gymnasium.make_vec(IDS["cover"], num_envs=2, vectorization_mode="sync")
    observation, _ = worlds.reset(seed=0)
    assert [table.shape for table in observation["objects"]["block"]] == [(2, 5), (2, 5)]
    worlds.step(np.zeros((2, 3), np.float32))


def test_options() -> None:
    world = make("cover", train_irrelevant_blocks=3, atoms=False)
    observation, info = world.reset(seed=0)
    assert len(observation["objects"]["block"]) == 5
    assert "atoms" not in info


def test_bad_input_is_refused_in_words() -> None:
    with pytest.raises(InputError, match=r"'cover' has no option 'blocks' \(have: train_irrel"):
        make("cover", blocks=3)
    world = make("cover").unwrapped
    world.reset(seed=0)
    for action in (np.full(3, np.nan), np.zeros(2), np.full(3, 2)):
        with pytest.raises(ValueError, match="is not in Box"):
            world.step(action)
    with pytest.raises(ValueError, match="unknown split 'exam'"):
        world.reset(options={"split": "exam"})
    with pytest.raises(ValueError, match="counted from 0"):
        world.reset(options={"task": -1})
