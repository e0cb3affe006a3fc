"""``bpns operators``: its notations, and the picture."""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from PIL import Image

from bpns.symbolic.pddl.read import parse_domain, read_domain

Run = Callable[..., tuple[int, str, str]]
ROOT = Path(__file__).parents[2]
COVER = ROOT / "pddl_out/cover/domain.pddl"


def test_notations_of_a_domain_file(bpns: Run) -> None:
    assert bpns("operators", COVER)[1].startswith("op0:\n  Parameters: [?x0:block, ?x1:gripper]\n")
    assert bpns("operators", COVER, "--format", "paper") == bpns("operators", COVER)
    code, out, _ = bpns("operators", COVER, "--format", "markdown")
    assert code == 0
    assert out.startswith("### op0\n\n| parameters | `?x0 - block`, `?x1 - gripper` |\n|---|---|\n")
    assert [o["name"] for o in json.loads(bpns("operators", COVER, "--json")[1])] == ["op0", "op1"]
    assert parse_domain(bpns("operators", COVER, "--format", "pddl")[1]) == read_domain(COVER)


def test_pddl_of_an_environments_own_skills(bpns: Run) -> None:
    domain = parse_domain(bpns("operators", "--oracle", "coffee", "--format", "pddl")[1])
    assert len(domain.operators) == 8
    code, out, _ = bpns("operators", "--oracle", "cover", "--format", "markdown")
    assert (code, out.count("### ")) == (0, 2)


@pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
def test_pictures_are_the_same_bytes_each_time(bpns: Run, tmp_path: Path, suffix: str) -> None:
    first, second = tmp_path / f"first.{suffix}", tmp_path / f"second.{suffix}"
    assert bpns("operators", COVER, "--picture", first) == (0, "", "")
    if suffix == "svg":  # from another process; one format is enough, as they share all but the last step
        words = [sys.executable, "-m", "bpns", "operators", str(COVER), "--picture", str(second)]
        subprocess.run(words, cwd=ROOT, env=os.environ | {"PYTHONHASHSEED": "7"}, check=True)
    else:
        bpns("operators", COVER, "--picture", second)
    assert first.read_bytes() == second.read_bytes()
    assert sorted(p.name for p in tmp_path.iterdir()) == [first.name, second.name]
    if suffix == "png":
        with Image.open(first) as picture:
            assert picture.width > 800


def test_pictures_that_cannot_be_made(bpns: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "mine.png").write_text("mine")
    empty = tmp_path / "empty.pddl"
    empty.write_text("(define (domain empty) (:predicates (p)))")
    for domain, picture, message in (
        (COVER, "mine.png", "exists: give --overwrite"),
        (COVER, "film.gif", "cannot draw a picture as 'film.gif': use .pdf, .png, .svg"),
        (empty, "empty.png", "there are no operators to draw"),
    ):
        code, out, err = bpns("operators", domain, "--picture", tmp_path / picture)
        assert (code, out, err.count("\n")) == (36, "", 1)
        assert message in err
    assert (tmp_path / "mine.png").read_text() == "mine"
    assert bpns("operators", COVER, "--picture", tmp_path / "mine.png", "--overwrite")[0] == 0
    monkeypatch.delitem(sys.modules, "bpns.symbolic.compare.drawing")
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    code, _, err = bpns("operators", COVER, "--picture", tmp_path / "b.png")
    assert (code, err) == (36, "error: pictures need matplotlib: pip install 'bpns[plots]'\n")


def test_one_output_at_a_time(bpns: Run) -> None:
    assert bpns("operators", COVER, "--json", "--format", "pddl")[0] == 2
    assert bpns("operators")[0] == 2
    assert bpns("operators", COVER, "--oracle", "cover")[0] == 2


def test_text_does_not_wait_for_the_drawing_packages() -> None:
    code = (
        f"import sys, bpns.cli.main\nsys.argv = ['bpns', 'operators', {str(COVER)!r}]\n"
        "bpns.cli.main.program(standalone_mode=False)\n"
        "assert not {'matplotlib', 'networkx', 'torch'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True, capture_output=True)
