"""A wheel carries everything, and nothing that would overwrite other people's packages."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


@pytest.mark.slow
def test_the_wheel_runs_without_the_checkout(tmp_path: Path) -> None:
    build = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", tmp_path]
    subprocess.run(build, cwd=ROOT, check=True, capture_output=True)
    (wheel,) = tmp_path.glob("*.whl")
    target = tmp_path / "site"
    install = [sys.executable, "-m", "pip", "install", "-q", "--no-deps", "--target", target, wheel]
    subprocess.run(install, check=True, capture_output=True)
    assert sorted(p.name for p in target.iterdir() if p.suffix != ".dist-info") == ["bin", "bpns"]
    code = (
        f"import sys; sys.path.insert(0, {str(target)!r})\n"
        "import bpns, symbolic, envs, learning, cli\n"
        "assert all('site' in m.__file__ for m in (bpns, symbolic, envs, learning, cli))\n"
        "import gymnasium; assert gymnasium.make('bpns.gymnasium:bpns/Cover-v0').reset(seed=0)\n"
        "sys.argv = ['bpns', 'plan', '--oracle', 'cover']; bpns.main()\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, check=True, capture_output=True, text=True
    )
    assert "executed: yes" in done.stdout
