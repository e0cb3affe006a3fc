"""``bpns plan`` with a model that acts without a planner."""

import json
import sys
from itertools import groupby
from pathlib import Path

import click

from bpns.cli._options import NOT_REFINED, Subject
from bpns.envs.animation import write_animation
from bpns.learning.graphs.reactive import Episode, react
from bpns.symbolic.bilevel.execution import Execution
from bpns.symbolic.state import Task
from bpns.symbolic.structs import sort_atoms


def act(
    subject: Subject,
    task: Task,
    seed: int,
    deadline: float | None,
    title: str,
    show: Path | None,
    as_json: bool,
) -> None:
    """Let a model act, print what it did, and exit with 12 where the goal was not reached."""
    assert subject.graph is not None
    execution, episode = react(subject.environment, task, subject.graph, subject.skills, seed, deadline)
    goal = ", ".join(map(str, sort_atoms(task.goal)))
    if as_json:
        found = {
            "goal": goal,
            "planned": None,
            "refined": None,
            "executed": execution.success,
            "fault": execution.fault,
            "plan": episode.steps if subject.graph.skills else None,
            "actions": [action.tolist() for action in execution.trajectory.actions],
            "samples": episode.samples,
            "seconds": {"acting": execution.policy_seconds},
        }
        click.echo(json.dumps(found, indent=2))
    else:
        click.echo(f"{title}: {goal}")
        _print(subject, execution, episode)
    if show is not None:
        names = [*(f"{n + 1}. {step}" for n, step in enumerate(episode.steps))] or ["acting"]
        captions = [f"{names[owner]}\n\ngoal: {goal}" for owner in execution.steps]
        captions.append(f"{execution.fault or 'done'}\n\ngoal: {goal}")
        write_animation(show, subject.environment, execution.trajectory.states, captions, task.goal)
        click.echo(f"animation: {show}", err=as_json)
    if not execution.success:
        sys.exit(NOT_REFINED)


def _print(subject: Subject, execution: Execution, episode: Episode) -> None:
    for number, actions in groupby(execution.steps):
        step = episode.steps[number] if episode.steps else "actions"
        click.echo(f"  {number + 1}. {step}  ({len(list(actions))} actions)")
    click.echo(f"planned:  - (a graph network acts in place of a planner: {subject.approach})")
    fault = f" ({execution.fault})" if execution.fault else ""
    click.echo(f"executed: {'yes' if execution.success else 'no'}{fault}")
    click.echo(f"samples:  {episode.samples}; acting {execution.policy_seconds * 1000:.1f} ms")
