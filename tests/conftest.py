import os
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import settings

from bpns import envs
from bpns.cli.main import main
from bpns.learning.data.demonstrations import Demonstrations, collect
from bpns.learning.models.learn import LearnedSkill, learn_skills
from bpns.learning.models.settings import SkillConfig
from bpns.learning.networks.settings import Training

# No deadline, since machines differ; in CI the same examples each time, elsewhere new ones.
settings.register_profile("bpns", deadline=None, derandomize="CI" in os.environ)
settings.load_profile("bpns")

FEW = SkillConfig(policy=Training(300), generator=Training(300), discriminator=Training(300))


@pytest.fixture(scope="session")
def demonstrations() -> Demonstrations:
    return collect(envs.load("cover"), 40, seed=0)


@pytest.fixture(scope="session")
def learned(demonstrations: Demonstrations) -> tuple[LearnedSkill, ...]:
    """Cover's skills, trained too little to be good at anything."""
    return learn_skills(envs.load("cover"), demonstrations, FEW, seed=0)


@pytest.fixture(scope="session")
def data() -> Path:
    """The folder of recordings and PDDL files: ours, or the one beside where that has all too."""
    own, beside = Path(__file__).parent / "data", Path(__file__).parents[2] / "shared"
    has_all = all((beside / folder.name).is_dir() for folder in own.iterdir() if folder.is_dir())
    return beside if has_all else own


@pytest.fixture
def bpns(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., tuple[int, str, str]]:
    """Runs the program in this process; gives exit code, standard output, standard error."""

    def run(*words: str | Path) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["bpns", *map(str, words)])
        try:
            main()
            code = 0
        except SystemExit as stop:
            code = int(stop.code or 0)
        captured = capsys.readouterr()
        return code, captured.out, captured.err

    return run


@pytest.fixture
def bpns_program(bpns: Callable[..., tuple[int, str, str]]) -> Callable[..., tuple[int, str, str]]:
    """The same, where ``bpns`` is the package."""
    return bpns
