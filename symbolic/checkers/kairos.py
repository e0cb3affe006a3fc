"""Kairos' check of PDDL, its warnings as errors, and its plan validator (Apache-2.0)."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from bpns.symbolic.checkers.reports import Inputs, PlanSource, Source, Verdict
from bpns.symbolic.errors import MissingPackage

if TYPE_CHECKING:
    import kairos

_DOMAIN, _PROBLEM = "domain", "problem"  # names that tell the two files' diagnostics apart


def version() -> str:
    """Return the version; raise MissingPackage."""
    try:
        import kairos
    except ImportError as error:
        raise MissingPackage("pip install 'bpns[validators]'") from error
    return str(kairos.version())


def verdicts(inputs: Inputs) -> Iterator[Verdict]:
    """Yield a verdict for each item; see the package."""
    import kairos

    report = kairos.check_domain(inputs.domain.text, _DOMAIN)
    yield _file(report.diagnostics, inputs.domain, inputs.domain)
    if inputs.problem is None or not report.valid:
        return
    report = kairos.check_problem(inputs.problem.text, inputs.domain.text, _PROBLEM, _DOMAIN)
    about = [d for d in report.diagnostics if d.location is None or d.location.file != _DOMAIN]
    yield _file(about, inputs.problem, inputs.domain)
    if report.valid:
        for plan in inputs.plans:
            yield _plan(inputs.domain, inputs.problem, plan)


def _file(found: "list[kairos.Diagnostic]", source: Source, domain: Source) -> Verdict:
    from kairos import Severity

    serious = [d for d in found if d.severity != Severity.NOTE and not _false_alarm(d, domain)]
    for diagnostic in serious:
        if not diagnostic.code.startswith("unsupported."):
            return Verdict("fault", _text(diagnostic, source.path))
    return Verdict("unsupported", _text(serious[0], source.path)) if serious else Verdict("ok")


def _false_alarm(diagnostic: "kairos.Diagnostic", domain: Source) -> bool:
    """Say whether it asks for :numeric-fluents where :action-costs is declared, which is enough for costs."""
    asks = diagnostic.code == "semantic.undeclared_requirement" and ":numeric-fluents" in diagnostic.message
    return asks and ":action-costs" in domain.text.lower()


def _text(diagnostic: "kairos.Diagnostic", path: str) -> str:
    where = diagnostic.location
    return (
        f"{path}:{where.line}:{where.column}: {diagnostic.message}"
        if where
        else f"{path}: {diagnostic.message}"
    )


def _plan(domain: Source, problem: Source, plan: PlanSource) -> Verdict:
    import kairos

    if plan.fault:
        return Verdict("skipped", "the steps cannot be read")
    report = kairos.validate_plan(domain.text, problem.text, kairos.parse_plan(plan.text))
    if report.valid:
        return Verdict("ok")
    said = report.diagnostics[0].message if report.diagnostics else str(report.status)
    where = (
        plan.name
        if report.failed_step is None
        else f"{plan.name}: line {plan.steps[report.failed_step].line}"
    )
    if report.status == kairos.ValidationStatus.UNSUPPORTED:
        return Verdict("unsupported", f"{where}: {said}")
    if report.status == kairos.ValidationStatus.BAD_INPUT:
        return Verdict("failed", f"{where}: {said}")
    return Verdict("fault", f"{where}: {said}")
