"""What users import: all that is public is there, is documented with examples that run, and opens fast."""

import doctest
import inspect
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

import bpns

WITHOUT_EXAMPLE = {  # what they are is said; what makes or takes them has the example
    *("AbstractPlan", "AbstractPlans", "Comparison", "Evaluation", "Limit", "NoPlan", "SearchRecord"),
    *("Environment", "EnvironmentFailure", "Planner", "Policy", "SkillFailure", "Validation"),
    *("InputError", "MissingPackage", "replay"),
}
WITH_EXAMPLES = sorted({sys.modules[getattr(bpns, name).__module__] for name in bpns.__all__}, key=str)


@pytest.mark.parametrize("name", bpns.__all__)
def test_what_is_public_is_documented(name: str) -> None:
    thing = getattr(bpns, name)
    assert (">>> " in (inspect.getdoc(thing) or "")) != (name in WITHOUT_EXAMPLE)
    assert inspect.getdoc(thing)
    for attribute, value in vars(thing).items() if inspect.isclass(thing) else ():
        if not attribute.startswith("_") and (inspect.isfunction(value) or isinstance(value, property)):
            assert inspect.getdoc(value) or getattr(thing, "_is_protocol", False), attribute


@pytest.mark.parametrize("module", WITH_EXAMPLES, ids=lambda module: module.__name__)
def test_examples_run(module: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert not doctest.testmod(module).failed


def test_the_door_opens_fast() -> None:
    """Importing it takes no numpy and no torch, and planning no torch."""
    code = (
        "import sys, bpns\n"
        "assert not {'numpy', 'torch', 'click', 'pydantic'} & set(sys.modules)\n"
        "model = bpns.oracle(bpns.load_environment('cover'))\n"
        "assert model.plan(model.world.task()).executed\n"
        "assert not {'torch', 'unified_planning', 'matplotlib'} & set(sys.modules)\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
