"""What every environment promises."""

import pickle

import numpy as np
import pytest

import envs
from symbolic.environment import Environment, abstract, domain_of, sample_tasks
from symbolic.errors import InputError
from symbolic.pddl.write import model_names


@pytest.fixture(params=envs.names())
def environment(request: pytest.FixtureRequest) -> Environment:
    return envs.load(request.param)


def test_names_are_fit_for_pddl(environment: Environment) -> None:
    domain = domain_of(environment, (skill.operator for skill in environment.oracle_skills))
    model_names(domain)
    assert environment.goal_predicates <= set(environment.classifiers)
    assert environment.contact_predicates <= set(environment.classifiers)
    assert len(environment.action_low) == len(environment.action_high)


def test_tasks_repeat_and_do_not_start_at_their_goal(environment: Environment) -> None:
    for split in ("train", "test"):
        first, second = (sample_tasks(environment, split, 6, 3) for _ in range(2))  # type: ignore[arg-type]
        for task, again in zip(first, second, strict=True):
            assert task.init.features == again.init.features
            assert task.goal
            assert not task.goal <= abstract(environment, task.init)
            assert {a.predicate for a in task.goal} <= environment.goal_predicates


def test_simulate_is_deterministic_and_pure(environment: Environment) -> None:
    rng = np.random.default_rng(0)
    state = sample_tasks(environment, "train", 1, 0)[0].init
    low, high = np.maximum(environment.action_low, -1), np.minimum(environment.action_high, 1)
    for _ in range(20):
        action = rng.uniform(low, high).astype(np.float32)
        before = dict(state.features)
        one, two = environment.simulate(state, action), environment.simulate(state, action)
        assert one.features == two.features
        assert state.features == before
        state = one


def test_it_travels_to_worker_processes(environment: Environment) -> None:
    again = pickle.loads(pickle.dumps(environment))
    state = sample_tasks(again, "test", 1, 0)[0].init
    assert {str(a) for a in abstract(again, state)} == {str(a) for a in abstract(environment, state)}


def test_unknown_and_foreign_environments() -> None:
    with pytest.raises(InputError, match=r"unknown environment 'nowhere' \(have: cover"):
        envs.load("nowhere")
    with pytest.raises(InputError, match="no_such_module"):
        envs.load("no_such_module:Thing")
    for name in ("os:name", "json:dumps", ":x", "json:JSONDecoder", "tests.toy:HAND"):
        with pytest.raises(InputError, match=r"cannot load environment|is no environment"):
            envs.load(name)
    assert envs.load("tests.toy:Toy").name == "toy"
