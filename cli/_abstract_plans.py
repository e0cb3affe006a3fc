"""Planning for a PDDL problem: abstract plans only."""

import json
import sys
import time
from pathlib import Path

import click

from bpns.cli._options import NO_PLAN, NOT_REFINED, PLANNER_FAILED, load_subject
from bpns.symbolic.grounding.ground import OutOfTime, Unreachable, ground
from bpns.symbolic.pddl.read import read_domain, read_problem
from bpns.symbolic.pddl.write import model_names
from bpns.symbolic.planners.protocol import Limit, Planner, SearchRecord
from bpns.symbolic.planners.streams import first_plans
from bpns.symbolic.skills.environment import domain_of
from bpns.symbolic.structs import Domain

MAX_NODES = 10_000_000  # memory ends about there


def read_any_domain(model: Path | None, oracle: str | None, environment: str | None) -> Domain:
    """Return the domain of a domain file, a model folder or an environment's own skills."""
    if model is not None and oracle is None and not model.is_dir():
        if environment is not None:
            raise click.UsageError("--environment goes with a model folder, not with a domain file")
        return read_domain(model)
    subject = load_subject(model, oracle, environment)
    return domain_of(subject.environment, (skill.operator for skill in subject.skills.values()))


def plan_problem(
    domain: Domain, path: Path, planner: Planner, plans: int, seed: int, timeout: float | None, as_json: bool
) -> None:
    """Print abstract plans in the format of the planning competitions; exit with what came of it."""
    deadline = None if timeout is None else time.monotonic() + timeout
    problem = read_problem(path, domain, model_names(domain))
    grounded = ground(domain, problem, deadline)
    if isinstance(grounded, Unreachable):
        _print(planner.name, [], str(grounded), SearchRecord(), as_json)
        sys.exit(NO_PLAN)
    if isinstance(grounded, OutOfTime):
        _print(planner.name, [], "stopped by the time limit while grounding", SearchRecord(), as_json)
        sys.exit(NOT_REFINED)
    enumeration = first_plans(planner, grounded, plans, seed, Limit(MAX_NODES, deadline))
    found = [[step.call for step in plan.steps] for plan in enumeration.plans]
    record = enumeration.record
    reason = "no plan exists: the whole state space was searched"
    if record.fault:
        reason = f"the planner failed: {record.fault}"
    elif record.stopped_by:
        reason = f"stopped by the {record.stopped_by}"
    elif found:
        reason = f"there are no other plans than these {len(found)}"
    _print(planner.name, found, reason if len(found) < plans else "", record, as_json)
    if record.fault:
        sys.exit(PLANNER_FAILED)
    if not found:
        sys.exit(NOT_REFINED if record.stopped_by else NO_PLAN)


def _print(planner: str, found: list[list[str]], ended: str, record: SearchRecord, as_json: bool) -> None:
    own = len(found) if record.own is None else min(record.own, len(found))
    if as_json:
        said = {"planner": planner, "plans": found, "its_own": own, "ended": ended, "remarks": record.remarks}
        click.echo(json.dumps(said, indent=2))
        return
    for number, steps in enumerate(found, 1):
        click.echo(f"; plan {number}, {len(steps)} steps, {planner if number <= own else 'astar'}")
        for step in steps:
            click.echo(step)
    for line in (*record.remarks, ended):
        if line:
            # A comment, so that this is a plan file; and where there is no plan, nothing is in the file.
            click.echo(f"; {line}" if found else line, err=not found)
