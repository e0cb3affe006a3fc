"""Plan for one task or PDDL problem; show the result."""

import json
import sys
import time
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import click
import numpy as np

from cli._options import (
    MAX_SEED,
    NO_PLAN,
    NOT_REFINED,
    Subject,
    budget_of,
    environment_option,
    json_option,
    load_subject,
    oracle_option,
    per_plan_option,
    planner_option,
    plans_option,
    samples_option,
    timeout_option,
)
from envs._animation import animation_format, write_animation
from symbolic import planners
from symbolic.bilevel import NoPlan, Plan, solve
from symbolic.environment import Budget, abstract, domain_of, sample_tasks
from symbolic.execution import Execution, execute
from symbolic.files import check_output
from symbolic.grounding import Unreachable, ground
from symbolic.pddl.read import read_domain, read_problem
from symbolic.pddl.write import model_names
from symbolic.planners import AbstractPlan, Limit, SearchRecord
from symbolic.refinement import DeadEnd
from symbolic.structs import Domain, GroundAtom, sort_atoms

MAX_NODES = 10_000_000  # for a PDDL problem: memory ends about there


@click.command()
@click.argument("model", type=click.Path(path_type=Path), required=False)
@oracle_option
@environment_option
@click.option("--task", type=click.IntRange(0), help="Number of the evaluation task (default: 0).")
@click.option("--problem", type=click.Path(path_type=Path), help="A PDDL problem: abstract plans only.")
@click.option("--seed", type=click.IntRange(0, MAX_SEED), help="Of tasks and planner (default: the model's).")
@planner_option
@plans_option
@samples_option
@per_plan_option
@timeout_option
@click.option("--show", type=click.Path(path_type=Path), help="Write an animation: .gif, .webp or .png.")
@json_option
def command(
    model: Path | None,
    oracle: str | None,
    environment: str | None,
    task: int | None,
    problem: Path | None,
    seed: int | None,
    planner: str,
    plans: int | None,
    samples: int | None,
    per_plan: int | None,
    timeout: float | None,
    show: Path | None,
    as_json: bool,
) -> None:
    """Plan with MODEL (a model folder, or with --problem also a domain.pddl).

    With --task the plan is refined in the simulator and carried out. With --problem up to --plans abstract
    plans (default 1) are printed. Exits with 11 if no plan exists, 12 if none was refined within the limits.
    """
    if problem is not None:
        if task is not None or show is not None or samples is not None or per_plan is not None:
            raise click.UsageError(
                "--task, --samples, --samples-per-plan and --show need a task: leave --problem out"
            )
        domain = _domain(model, oracle, environment)
        _plan_problem(domain, problem, planner, plans or 1, seed or 0, timeout, as_json)
        return
    if model is not None and model.suffix == ".pddl":
        raise click.UsageError("a domain file has no skills: give --problem too, or a model folder")
    subject = load_subject(model, oracle, environment)
    budget = budget_of(subject.environment, plans, samples, per_plan)
    _plan_task(subject, task or 0, seed, planner, budget, timeout, show, as_json)


# ----------------------------------------------------------------------------------- PDDL problems


def _domain(model: Path | None, oracle: str | None, environment: str | None) -> Domain:
    if model is not None and oracle is None and not model.is_dir():
        if environment is not None:
            raise click.UsageError("--environment goes with a model folder, not with a domain file")
        return read_domain(model)
    subject = load_subject(model, oracle, environment)
    return domain_of(subject.environment, (skill.operator for skill in subject.skills.values()))


def _plan_problem(
    domain: Domain, path: Path, planner: str, plans: int, seed: int, timeout: float | None, as_json: bool
) -> None:
    """Print abstract plans in the format of the planning competitions."""
    problem = read_problem(path, domain, model_names(domain))
    chosen = planners.load(planner)
    limit = Limit(MAX_NODES, None if timeout is None else time.monotonic() + timeout)
    record = SearchRecord()
    grounded = ground(domain, problem)
    stream: Iterator[AbstractPlan] = iter(())
    reason = "no plan exists: the whole state space was searched"
    if isinstance(grounded, Unreachable):
        reason = str(grounded)
    else:
        stream = chosen.plans(grounded, np.random.default_rng(seed), limit, record)
    found = [[step.call for step in plan.steps] for plan in islice(stream, plans)]
    if record.stopped_by:
        reason = f"stopped by the {record.stopped_by}"
    if as_json:
        ended = reason if len(found) < plans else ""
        click.echo(json.dumps({"planner": chosen.name, "plans": found, "ended": ended}, indent=2))
    else:
        for number, steps in enumerate(found, 1):
            click.echo(f"; plan {number}, {len(steps)} steps, {chosen.name}")
            for step in steps:
                click.echo(step)
        if record.stopped_by or not found:
            click.echo(reason)
    if not found:
        sys.exit(NOT_REFINED if record.stopped_by else NO_PLAN)


# ------------------------------------------------------------------------------------------- tasks


def _plan_task(
    subject: Subject,
    number: int,
    seed: int | None,
    planner: str,
    budget: Budget,
    timeout: float | None,
    show: Path | None,
    as_json: bool,
) -> None:
    if show is not None:
        animation_format(show)
        check_output(show, overwrite=True)
    environment = subject.environment
    seed = subject.seed if seed is None else seed
    task = sample_tasks(environment, "test", number + 1, seed)[number]
    deadline = None if timeout is None else time.monotonic() + timeout
    outcome = solve(
        environment,
        task,
        subject.skills,
        planners.load(planner),
        budget,
        seed + number + 1,
        deadline,
    )
    execution = execute(environment, task, outcome) if isinstance(outcome, Plan) else None
    goal = ", ".join(map(str, sort_atoms(task.goal)))
    if as_json:
        click.echo(json.dumps(_as_json(outcome, execution, goal), indent=2))
    else:
        click.echo(f"task {number} of seed {seed} in {subject.asked}: {goal}")
        _print_outcome(outcome, execution)
    if show is not None and isinstance(outcome, Plan) and execution is not None:
        _show(show, subject, outcome, execution, task.goal)
        click.echo(f"animation: {show}", err=as_json)
    if show is not None and isinstance(outcome, NoPlan):
        click.echo(f"no animation, as there is no plan: {show} is not written", err=True)
    if isinstance(outcome, NoPlan):
        sys.exit(NO_PLAN if outcome.reason in ("unreachable", "no plan") else NOT_REFINED)
    if execution is not None and not execution.success:
        sys.exit(NOT_REFINED)


def _print_outcome(outcome: Plan | NoPlan, execution: Execution | None) -> None:
    effort = outcome.effort
    if isinstance(outcome, Plan):
        for number, step in enumerate(outcome.steps, 1):
            click.echo(f"  {number}. {step.skill.operator}  ({len(step.trajectory.actions)} actions)")
    else:
        click.echo(outcome.text)
    click.echo(f"planned:  {_yes(effort.abstract_plans > 0)} ({effort.abstract_plans} abstract plans tried)")
    click.echo(f"refined:  {_yes(isinstance(outcome, Plan))} ({effort.samples} samples)")
    executed = execution is not None and execution.success
    fault = f" ({execution.fault})" if execution is not None and execution.fault else ""
    click.echo(f"executed: {_yes(executed)}{fault}")
    parts = ", ".join(f"{part} {seconds * 1000:.1f} ms" for part, seconds in effort.seconds.items())
    click.echo(f"nodes:    {effort.nodes_created} created, {effort.nodes_expanded} expanded; {parts}")
    worst = _worst(outcome)
    if worst:
        click.echo("dead ends on the way, the most frequent (stuck: the state no longer changed):")
    for end, count in worst:
        click.echo(f"  {count} x plan {end.plan}, step {end.step} {end.operator}: {end.reason}")


def _worst(outcome: Plan | NoPlan) -> list[tuple[DeadEnd, int]]:
    """Return the most frequent dead ends."""
    return sorted(outcome.dead_ends.items(), key=lambda item: (-item[1], item[0]))[:5]


def _yes(value: bool) -> str:
    return "yes" if value else "no"


def _as_json(outcome: Plan | NoPlan, execution: Execution | None, goal: str) -> dict[str, Any]:
    effort = outcome.effort
    return {
        "goal": goal,
        "planned": effort.abstract_plans > 0,
        "refined": isinstance(outcome, Plan),
        "executed": execution is not None and execution.success,
        "fault": outcome.text if isinstance(outcome, NoPlan) else execution.fault if execution else "",
        "plan": [str(s.skill.operator) for s in outcome.steps] if isinstance(outcome, Plan) else None,
        "actions": [a.tolist() for a in execution.trajectory.actions] if execution else None,
        "nodes_created": effort.nodes_created,
        "nodes_expanded": effort.nodes_expanded,
        "abstract_plans": effort.abstract_plans,
        "samples": effort.samples,
        "seconds": dict(effort.seconds),
        "dead_ends": [
            {"plan": e.plan, "step": e.step, "operator": e.operator, "reason": e.reason, "count": n}
            for e, n in sorted(outcome.dead_ends.items())
        ],
    }


def _show(
    path: Path, subject: Subject, plan: Plan, execution: Execution, goal: frozenset[GroundAtom]
) -> None:
    """Write the animation; the caption says operator, atoms and goal."""
    states = execution.trajectory.states
    owners = [*execution.steps, None]  # the step that begins in each state
    captions = []
    aim = ", ".join(map(str, sort_atoms(goal)))
    always = frozenset.intersection(*(abstract(subject.environment, state) for state in states))
    for state, owner in zip(states, owners, strict=True):
        name = "done" if owner is None else f"{owner + 1}. {plan.steps[owner].skill.operator}"
        atoms = ", ".join(map(str, sort_atoms(abstract(subject.environment, state) - always)))
        captions.append(f"{name}\n{atoms}\ngoal: {aim}")
    write_animation(path, subject.environment, states, captions, goal)
