"""Damaged files: each is read or refused with its place, and what is read comes back from what we write.

The long run is benchmarks/fuzz_pddl.py.
"""

from pathlib import Path
from random import Random

import pytest

from bpns.symbolic.pddl.read import parse_domain
from tests.symbolic._mutations import Files, corpus, judge, mutate, mutated
from tests.symbolic._texts import DOMAIN, PROBLEM

ROOT = Path(__file__).parents[2]
SLOW = 1e9  # seconds: how fast a machine is, is no property of the code


@pytest.mark.parametrize("part", range(4))
def test_damaged_files_are_read_or_refused(data: Path, part: int) -> None:
    files = corpus([data / "pddl-cases", data / "pddl-bench"])
    outcomes = []
    for number in range(100):
        damaged = mutated(Random(f"{part}:{number}"), files)
        verdict = judge(damaged, SLOW)
        assert not verdict.offence, f"{verdict.offence}\n{damaged}"
        outcomes.append(verdict.outcome)
    assert {"read", "refused"} == set(outcomes)


def test_undamaged_files_are_no_offence(data: Path) -> None:
    files = corpus([ROOT / "pddl_out", data / "pddl-cases", data / "pddl-bench"])
    assert len(files) > 100
    assert not [verdict.offence for f in files if (verdict := judge(f, SLOW)).offence]


def test_same_seed_gives_the_same_file() -> None:
    files = [Files(DOMAIN, PROBLEM)]
    assert mutated(Random("3"), files) == mutated(Random("3"), files)
    assert len({mutate(Random(str(seed)), DOMAIN, PROBLEM) for seed in range(50)}) > 40


def test_judge_finds_what_should_not_be(monkeypatch: pytest.MonkeyPatch) -> None:
    good = Files(DOMAIN, PROBLEM)
    assert judge(good, SLOW).offence == ""
    assert judge(good, -1).offence.startswith("took ")
    with monkeypatch.context() as patch:
        patch.setattr("tests.symbolic._mutations.parse_problem", lambda *_: 1 / 0)
        assert "ZeroDivisionError" in judge(good, SLOW).offence
    with monkeypatch.context() as patch:
        other = parse_domain(DOMAIN.replace("fill ", "pour "))
        patch.setattr("tests.symbolic._mutations.read_back", lambda *_: (other, None))
        assert judge(good, SLOW).offence == "what was written is read as something else"
