"""What ``bpns plan`` prints, and its exit codes."""

import json
import sys
from collections.abc import Iterator
from itertools import groupby, islice
from typing import Any

import click

import bpns
from bpns.cli._options import NO_PLAN, NOT_REFINED, PLANNER_FAILED
from bpns.learning.models.solver import Outcome
from bpns.symbolic.bilevel.solve import NoPlan
from bpns.symbolic.structs import sort_atoms

EXIT_CODES = {"unreachable": NO_PLAN, "no plan": NO_PLAN, "planner failed": PLANNER_FAILED}


def exit_code(outcome: Outcome) -> int:
    """Return the exit code for what came of a task."""
    if isinstance(outcome.found, NoPlan):
        return EXIT_CODES.get(outcome.found.reason, NOT_REFINED)
    return 0 if outcome.executed else NOT_REFINED


def outcome_text(outcome: Outcome, title: str, approach: str) -> str:
    """Say what came of a task."""
    goal = ", ".join(map(str, sort_atoms(outcome.task.goal)))
    lines = _acted(outcome, approach) if outcome.planned is None else _planned(outcome)
    return "\n".join([f"{title}: {goal}", *lines])


def _planned(outcome: Outcome) -> Iterator[str]:
    effort = outcome.effort
    if outcome.plan is not None:
        yield from (f"  {number}. {step}" for number, step in enumerate(outcome.plan.steps, 1))
    else:
        yield outcome.why
    yield f"planned:  {_yes(outcome.planned)} ({effort.abstract_plans} abstract plans tried)"
    yield f"refined:  {_yes(outcome.refined)} ({effort.samples} samples)"
    yield _executed(outcome)
    yield from (f"planner:  {remark}" for remark in effort.remarks)
    parts = ", ".join(f"{part} {seconds * 1000:.1f} ms" for part, seconds in effort.seconds.items())
    yield f"nodes:    {effort.nodes_created} created, {effort.nodes_expanded} expanded; {parts}"
    if outcome.dead_ends:
        yield "dead ends on the way, the most frequent (stuck: the state no longer changed):"
        for end, count in outcome.dead_ends[:5]:
            yield f"  {count} x plan {end.plan}, step {end.step} {end.operator}: {end.reason}"


def _acted(outcome: Outcome, approach: str) -> Iterator[str]:
    assert outcome.execution is not None
    for number, actions in groupby(outcome.execution.steps):
        step = outcome.steps[number] if outcome.steps else "actions"
        yield f"  {number + 1}. {step}  ({len(list(actions))} actions)"
    yield f"planned:  - (a graph network acts in place of a planner: {approach})"
    yield _executed(outcome)
    yield f"samples:  {outcome.samples}; acting {outcome.execution.policy_seconds * 1000:.1f} ms"


def _executed(outcome: Outcome) -> str:
    fault = outcome.execution.fault if outcome.execution is not None else ""
    return f"executed: {_yes(outcome.executed)}{f' ({fault})' if fault else ''}"


def _yes(value: bool | None) -> str:
    return "yes" if value else "no"


def outcome_json(outcome: Outcome) -> dict[str, Any]:
    """Return what came of a task as JSON values."""
    effort, execution = outcome.effort, outcome.execution
    found = {
        "goal": ", ".join(map(str, sort_atoms(outcome.task.goal))),
        "planned": outcome.planned,
        "refined": outcome.refined,
        "executed": outcome.executed,
        "fault": outcome.why,
        "plan": list(outcome.steps) or None,
        "actions": None if execution is None else [action.tolist() for action in outcome.actions],
    }
    if outcome.planned is None:
        assert execution is not None
        return {**found, "samples": outcome.samples, "seconds": {"acting": execution.policy_seconds}}
    return {
        **found,
        "plan": None if outcome.plan is None else list(outcome.steps),
        "nodes_created": effort.nodes_created,
        "nodes_expanded": effort.nodes_expanded,
        "abstract_plans": effort.abstract_plans,
        "samples": effort.samples,
        "seconds": dict(effort.seconds),
        "remarks": list(effort.remarks),
        "dead_ends": [
            {"plan": e.plan, "step": e.step, "operator": e.operator, "reason": e.reason, "count": n}
            for e, n in sorted(outcome.dead_ends)
        ],
    }


def print_plans(plans: bpns.AbstractPlans, count: int, as_json: bool) -> None:
    """Print abstract plans in the format of the planning competitions; exit with what came of it."""
    found = [[step.call for step in plan.steps] for plan in islice(plans, count)]
    record = plans.record
    ended = plans.why or (
        f"there are no other plans than these {len(found)}"
        if found
        else "no plan exists: the whole state space was searched"
    )
    ended = ended if len(found) < count else ""
    own = len(found) if record.own is None else min(record.own, len(found))
    if as_json:
        said = {
            "planner": plans.planner,
            "plans": found,
            "its_own": own,
            "ended": ended,
            "remarks": record.remarks,
        }
        click.echo(json.dumps(said, indent=2))
    else:
        for number, steps in enumerate(found, 1):
            click.echo(f"; plan {number}, {len(steps)} steps, {plans.planner if number <= own else 'astar'}")
            click.echo("\n".join(steps), nl=bool(steps))
        for line in (*record.remarks, ended):
            if line:
                # A comment, so that this is a plan file; and where there is no plan, nothing is in the file.
                click.echo(f"; {line}" if found else line, err=not found)
    if record.fault:
        sys.exit(PLANNER_FAILED)
    if not found:
        sys.exit(NOT_REFINED if record.stopped_by else NO_PLAN)
