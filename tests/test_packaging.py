"""A wheel carries all of it under one name, and takes no name that belongs to users."""

import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
THEIRS = ("symbolic", "envs", "learning", "cli")  # names that belong to users
SCRIPT = """
import bpns, bpns.symbolic, bpns.envs, bpns.learning, bpns.cli
import symbolic, envs, learning, cli
assert {envs.MINE, cli.MINE, learning.MINE, symbolic.MINE} == {"mine"}
from bpns.envs import load, names
assert names() == ["coffee", "cover", "doors", "stick_button"]
import gymnasium
assert gymnasium.make("bpns.gymnasium:bpns/Cover-v0").reset(seed=0)
import sys
from bpns.cli.main import main
sys.argv = ["bpns", "plan", "--oracle", "cover"]
main()
"""


@pytest.fixture
def beside(tmp_path: Path) -> Path:
    """Makes a folder where a user's own packages have the names of our folders."""
    for name in THEIRS:
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text('MINE = "mine"\n')
    return tmp_path


def run(*words: str | Path, folder: Path, check: bool = True) -> str:
    done = subprocess.run([sys.executable, *words], cwd=folder, capture_output=True, text=True, check=False)
    assert not check or done.returncode == 0, done.stderr
    return done.stdout


def test_a_checkout_leaves_users_their_names(beside: Path) -> None:
    assert "executed: yes" in run("-c", SCRIPT, folder=beside)
    assert str(ROOT) not in run("-c", "import sys; print(*sys.path, sep='\\n')", folder=beside).split("\n")


@pytest.mark.slow
def test_the_wheel_runs_without_the_checkout(beside: Path, tmp_path: Path) -> None:
    built = tmp_path / "built"
    run("-m", "build", "--no-isolation", "--outdir", built, folder=ROOT)  # the wheel out of the sdist
    (wheel,) = built.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        tops = {name.split("/")[0] for name in archive.namelist()}
        assert {"bpns/py.typed", "bpns/envs/doors/world.py"} <= set(archive.namelist())
    assert {top for top in tops if not top.endswith(".dist-info")} == {"bpns"}
    target = tmp_path / "site"
    run("-m", "pip", "install", "-q", "--no-deps", "--target", target, wheel, folder=tmp_path)
    path = f"import sys; sys.path.insert(1, {str(target)!r})\n"
    place = "import bpns.envs; assert 'site' in bpns.__file__ and 'site' in bpns.envs.__file__\n"
    assert "executed: yes" in run("-c", path + place + SCRIPT, folder=beside)
