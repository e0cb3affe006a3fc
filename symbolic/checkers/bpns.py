"""Our own reader and validator; a missing requirement flag is a fault here, as strict readers refuse it."""

import warnings
from collections.abc import Callable, Iterator
from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as installed
from typing import TypeVar

from bpns.symbolic.checkers.reports import Inputs, PlanSource, Verdict
from bpns.symbolic.errors import PddlError, UnsupportedPddl
from bpns.symbolic.operators import Domain, Problem
from bpns.symbolic.pddl.plan_fault import first_fault
from bpns.symbolic.pddl.plan_file import ground_steps
from bpns.symbolic.pddl.read import MissingRequirement, PddlWarning, parse_domain, parse_problem

Value = TypeVar("Value")


def version() -> str:
    """Return our version, or nothing where we are not installed but run from a checkout."""
    try:
        return installed("bpns")
    except PackageNotFoundError:
        return ""


def verdicts(inputs: Inputs) -> Iterator[Verdict]:
    """Yield a verdict for each item; see the package."""
    source = inputs.domain
    domain, verdict = _read(lambda: parse_domain(source.text, source.path))
    yield verdict
    if domain is None or inputs.problem is None:
        return
    of_problem, known = inputs.problem, domain
    problem, verdict = _read(lambda: parse_problem(of_problem.text, known, of_problem.path))
    yield verdict
    if problem is not None:
        for plan in inputs.plans:
            yield _plan(domain, problem, plan)


def _read(parse: Callable[[], Value]) -> tuple[Value | None, Verdict]:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", PddlWarning)
        try:
            value = parse()
        except UnsupportedPddl as error:
            return None, Verdict("unsupported", str(error))
        except PddlError as error:
            return None, Verdict("fault", str(error))
    found = [str(w.message) for w in caught if issubclass(w.category, MissingRequirement)]
    return value, Verdict("fault", found[0]) if found else Verdict("ok")


def _plan(domain: Domain, problem: Problem, plan: PlanSource) -> Verdict:
    if plan.fault:
        return Verdict("fault", plan.fault)
    try:
        steps = ground_steps(plan.steps, domain, problem, plan.name)
    except PddlError as error:
        return Verdict("fault", str(error))
    fault = first_fault(problem, steps)
    return Verdict("fault", f"{plan.name}: {fault}") if fault else Verdict("ok")
