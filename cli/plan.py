"""Plan for one task or PDDL problem; show the result."""

import json
import sys
import time
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

from bpns.cli._abstract_plans import MAX_NODES, plan_problem, read_any_domain
from bpns.cli._comparison import planner_names, print_comparison
from bpns.cli._options import (
    MAX_SEED,
    NO_PLAN,
    NOT_REFINED,
    PLANNER_FAILED,
    PLANNING,
    Subject,
    check_unused,
    environment_option,
    json_option,
    load_subject,
    oracle_option,
    per_plan_option,
    planner_option,
    plans_option,
    preset_option,
    samples_option,
    strategy_and_budget,
    strategy_option,
    timeout_option,
)
from bpns.cli._reactive import act
from bpns.envs.animation import animation_format, write_animation
from bpns.symbolic import planners
from bpns.symbolic.bilevel.execution import Execution, execute
from bpns.symbolic.bilevel.refinement import DeadEnd
from bpns.symbolic.bilevel.solve import NoPlan, Plan, solve
from bpns.symbolic.files import check_output
from bpns.symbolic.grounding.ground import GroundProblem, OutOfTime, Unreachable, ground
from bpns.symbolic.pddl.read import read_problem
from bpns.symbolic.pddl.write import model_names
from bpns.symbolic.planners.protocol import Planner
from bpns.symbolic.planners.streams import loopless
from bpns.symbolic.skills.environment import abstract, domain_of, problem_of, sample_tasks
from bpns.symbolic.state import Task
from bpns.symbolic.structs import Domain, GroundAtom, Problem, sort_atoms

COMPARED_PLANS = 10
EXIT_CODES = {"unreachable": NO_PLAN, "no plan": NO_PLAN, "planner failed": PLANNER_FAILED}


@click.command()
@click.argument("model", type=click.Path(path_type=Path), required=False)
@oracle_option
@environment_option
@click.option("--task", type=click.IntRange(0), help="Number of the evaluation task (default: 0).")
@click.option("--problem", type=click.Path(path_type=Path), help="A PDDL problem: abstract plans only.")
@click.option("--seed", type=click.IntRange(0, MAX_SEED), help="Of tasks and planner (default: the model's).")
@planner_option
@click.option(
    "--compare",
    multiple=True,
    metavar="NAMES",
    help="A table of several planners, with commas between (or 'all'), instead of --planner.",
)
@click.option("--no-loops", is_flag=True, help="Only abstract plans that visit no abstract state twice.")
@plans_option
@samples_option
@per_plan_option
@preset_option
@strategy_option
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
    compare: tuple[str, ...],
    no_loops: bool,
    plans: int | None,
    samples: int | None,
    per_plan: int | None,
    preset: str,
    strategy: str | None,
    timeout: float | None,
    show: Path | None,
    as_json: bool,
) -> None:
    """Plan with MODEL (a model folder, or with --problem also a domain.pddl).

    With --task the plan is refined in the simulator and carried out. With --problem up to --plans abstract
    plans (default 1) are printed, as a plan file. --compare prints seconds to the first plan and to --plans
    plans (default 10) of several planners. Exits with 11 if no plan exists, 12 if none was refined within the
    limits, 32 if the planner failed.
    """
    refining = samples or per_plan or strategy or preset != "default"
    if problem is not None and (task is not None or show is not None or refining):
        raise click.UsageError(
            "--task, --show, --preset, --strategy, --samples and --samples-per-plan need a task: "
            "leave --problem out"
        )
    if problem is None and model is not None and model.suffix == ".pddl":
        raise click.UsageError("a domain file has no skills: give --problem too, or a model folder")
    chosen = click.get_current_context().get_parameter_source("planner") is ParameterSource.COMMANDLINE
    if compare and (show is not None or no_loops or chosen):
        raise click.UsageError("--compare goes with none of --planner, --show and --no-loops")
    if problem is not None:
        domain = read_any_domain(model, oracle, environment)
        if compare:
            grounded = _grounded(domain, read_problem(problem, domain, model_names(domain)), timeout)
            names = planner_names(compare)
            print_comparison(
                names, grounded, plans or COMPARED_PLANS, seed or 0, MAX_NODES, timeout, None, as_json
            )
        else:
            plan_problem(
                domain, problem, _planner(planner, no_loops), plans or 1, seed or 0, timeout, as_json
            )
        return
    subject = load_subject(model, oracle, environment)
    world = subject.environment
    _, refine, budget = strategy_and_budget(world, preset, strategy, plans, samples, per_plan)
    number, seed = task or 0, subject.seed if seed is None else seed
    if show is not None:
        animation_format(show)
        check_output(show, overwrite=True)
    drawn = sample_tasks(world, "test", number + 1, seed)[number]
    deadline = None if timeout is None else time.monotonic() + timeout
    title = f"task {number} of seed {seed} in {subject.asked}"
    if subject.graph is not None:
        check_unused(PLANNING, f"{subject.label} ({subject.approach}) acts without a planner")
        act(subject, drawn, seed + number + 1, deadline, title, show, as_json)
        return
    if compare:
        domain = domain_of(world, (skill.operator for skill in subject.skills.values()))
        print_comparison(
            planner_names(compare),
            _grounded(domain, problem_of(world, drawn), timeout),
            plans or COMPARED_PLANS,
            seed + number + 1,
            budget.nodes,
            timeout,
            (subject, drawn, *strategy_and_budget(world, preset, strategy, None, samples, per_plan)[1:]),
            as_json,
        )
        return
    own = _planner(planner, no_loops)
    outcome = solve(world, drawn, subject.skills, own, budget, seed + number + 1, deadline, refine)
    _report(outcome, subject, drawn, title, show, as_json)


def _planner(name: str, no_loops: bool) -> Planner:
    planner = planners.load(name)
    return loopless(planner) if no_loops else planner


def _grounded(domain: Domain, problem: Problem, timeout: float | None) -> GroundProblem:
    """Ground a problem; where there is no plan, or no time, say so and exit."""
    grounded = ground(domain, problem, None if timeout is None else time.monotonic() + timeout)
    if isinstance(grounded, OutOfTime):
        click.echo("stopped by the time limit while grounding")
        sys.exit(NOT_REFINED)
    if isinstance(grounded, Unreachable):
        click.echo(str(grounded))
        sys.exit(NO_PLAN)
    return grounded


def _report(
    outcome: Plan | NoPlan, subject: Subject, task: Task, title: str, show: Path | None, as_json: bool
) -> None:
    """Carry a plan out and print what came of it; exit with it too."""
    execution = execute(subject.environment, task, outcome) if isinstance(outcome, Plan) else None
    goal = ", ".join(map(str, sort_atoms(task.goal)))
    if as_json:
        click.echo(json.dumps(_as_json(outcome, execution, goal), indent=2))
    else:
        click.echo(f"{title}: {goal}")
        _print_outcome(outcome, execution)
    if show is not None and isinstance(outcome, Plan) and execution is not None:
        _show(show, subject, outcome, execution, task.goal)
        click.echo(f"animation: {show}", err=as_json)
    if show is not None and isinstance(outcome, NoPlan):
        click.echo(f"no animation, as there is no plan: {show} is not written", err=True)
    if isinstance(outcome, NoPlan):
        sys.exit(EXIT_CODES.get(outcome.reason, NOT_REFINED))
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
    for remark in effort.remarks:
        click.echo(f"planner:  {remark}")
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
        "remarks": list(effort.remarks),
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
