"""``--preset`` and ``--strategy`` as a user meets them."""

import json
from collections.abc import Callable

import pytest

Run = Callable[..., tuple[int, str, str]]
TASKS = ("--tasks", 2, "--seeds", 50_100)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ((), "search: preset default, strategy adaptive, planner astar:lmcut"),
        (("--preset", "paper"), "search: preset paper, strategy exhaustive, planner astar:lmcut"),
        (("--strategy", "exhaustive"), "search: preset default, strategy exhaustive, planner astar:lmcut"),
    ],
)
def test_evaluate_says_how(bpns: Run, words: tuple[str, ...], told: str) -> None:
    code, out, _ = bpns("evaluate", "--oracle", "cover", *TASKS, *words)
    assert code == 0
    assert out.splitlines()[0] == told
    _, out, _ = bpns("evaluate", "--oracle", "cover", *TASKS, *words, "--json")
    said = json.loads(out)
    assert f"search: preset {said['preset']}, strategy {said['strategy']}, planner astar:lmcut" == told


def test_strategies_differ_where_it_matters(bpns: Run) -> None:
    tried = {}
    for strategy in ("adaptive", "exhaustive"):
        _, out, _ = bpns(
            "evaluate", "--oracle", "stick_button:test_buttons=6", "--seeds", 50_100, "--tasks", 3, "--json",
            "--strategy", strategy,
        )  # fmt: skip
        tried[strategy] = sum(task["abstract_plans"] for task in json.loads(out)["tasks"])
    assert 4 * tried["adaptive"] < tried["exhaustive"]


@pytest.mark.parametrize("command", ["plan", "evaluate"])
def test_samples_of_a_plan_are_counted_by_the_exhaustive_strategy_only(bpns: Run, command: str) -> None:
    code, _, err = bpns(command, "--oracle", "cover", "--samples-per-plan", 3)
    assert code == 2
    assert "samples per plan are for strategy 'exhaustive'" in err


@pytest.mark.parametrize("strategy", ["adaptive", "exhaustive"])
def test_samples_of_a_step_limit_both_strategies(bpns: Run, strategy: str) -> None:
    """Two steps with one sample each: solved at once or by no plan of two steps."""
    limits = ("--samples", 1, "--plans", 1, "--strategy", strategy)
    _, out, _ = bpns("evaluate", "--oracle", "cover", "--seeds", 50_100, "--tasks", 10, *limits, "--json")
    tasks = json.loads(out)["tasks"]
    assert all(task["samples"] <= 2 * max(2, task["plan_length"]) for task in tasks)
    assert {task["executed"] for task in tasks} == {True, False}


def test_the_papers_search_is_not_ours(bpns: Run) -> None:
    code, _, err = bpns("evaluate", "--oracle", "cover", "--preset", "paper", "--strategy", "adaptive")
    assert code == 2
    assert "preset 'paper' searches exhaustively" in err


def test_plans_limit_both_strategies(bpns: Run) -> None:
    for strategy in ("adaptive", "exhaustive"):
        code, out, _ = bpns(
            "plan", "--oracle", "stick_button:test_buttons=6", "--seed", 50_100, "--task", 0, "--plans", 2,
            "--timeout", 5, "--strategy", strategy,
        )  # fmt: skip
        assert code == 12
        assert "(2 abstract plans tried)" in out
