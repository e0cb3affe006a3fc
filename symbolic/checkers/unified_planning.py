"""Unified-planning's reader and its validator of sequential plans (Apache-2.0)."""

import re
import warnings
from collections.abc import Iterator
from importlib.metadata import version as installed
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from bpns.symbolic.checkers.reports import Inputs, PlanSource, Source, Verdict
from bpns.symbolic.errors import MissingPackage

if TYPE_CHECKING:
    from unified_planning.model import Problem

_EITHER = re.compile(r"^[^;\n]*\(\s*either\s", re.IGNORECASE | re.MULTILINE)


def version() -> str:
    """Return the version; raise MissingPackage. The package itself takes seconds to import."""
    if find_spec("unified_planning") is None:
        raise MissingPackage("pip install 'bpns[validators]'")
    return installed("unified-planning")


def verdicts(inputs: Inputs) -> Iterator[Verdict]:
    """Yield a verdict for each item; see the package."""
    verdict, _ = _read(inputs.domain, inputs.domain, None)
    yield verdict
    if verdict.level != "ok" or inputs.problem is None:
        return
    verdict, problem = _read(inputs.problem, inputs.domain, inputs.problem)
    yield verdict
    if problem is not None:
        for plan in inputs.plans:
            yield _plan(problem, plan)


def _read(about: Source, domain: Source, problem: Source | None) -> "tuple[Verdict, Problem | None]":
    from pyparsing import ParseBaseException
    from unified_planning.environment import get_environment
    from unified_planning.exceptions import UPException, UPUnsupportedProblemTypeError
    from unified_planning.io import PDDLReader

    environment = get_environment()  # with another one the validator does not work
    environment.error_used_name = False  # PDDL lets a type and a predicate share a name
    environment.credits_stream = None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # about such names
            read = PDDLReader(environment).parse_problem_string(
                domain.text, problem.text if problem else None
            )
    except (NotImplementedError, UPUnsupportedProblemTypeError) as error:
        return Verdict("unsupported", f"{about.path}: {_line(error)}"), None
    except (SyntaxError, ParseBaseException, UPException) as error:
        if _EITHER.search(about.text):
            return Verdict("unsupported", f"{about.path}: either"), None
        return Verdict("fault", f"{about.path}: {_line(error)}"), None
    return Verdict("ok"), read


def _line(error: Exception) -> str:
    return " ".join(str(error).split())


def _plan(problem: "Problem", plan: PlanSource) -> Verdict:
    from unified_planning.engines import SequentialPlanValidator
    from unified_planning.engines.results import ValidationResultStatus
    from unified_planning.exceptions import UPException
    from unified_planning.plans import ActionInstance, SequentialPlan

    if plan.fault:
        return Verdict("skipped", "the steps cannot be read")
    if not SequentialPlanValidator.supports(problem.kind):
        return Verdict("unsupported", f"{plan.name}: the validator does not support this kind of problem")
    steps: list[ActionInstance] = []
    for number, step in enumerate(plan.steps, 1):
        try:
            action: Any = problem.action(step.words[0])
            objects = tuple(problem.object(word) for word in step.words[1:])
            if len(objects) != len(action.parameters):
                wanted = f"takes {len(action.parameters)} objects, not {len(objects)}"
                return Verdict("fault", f"{plan.place(number)}: {wanted}")
            steps.append(ActionInstance(action, objects))
        except UPException as error:
            return Verdict("fault", f"{plan.place(number)}: {_line(error)}")
    validator = SequentialPlanValidator()
    result = validator.validate(problem, SequentialPlan(steps))
    if result.status == ValidationResultStatus.VALID:
        return Verdict("ok")
    said = result.log_messages[0].message if result.log_messages else str(result.reason)
    return Verdict("fault", f"{plan.name}: {' '.join(said.split())}")
