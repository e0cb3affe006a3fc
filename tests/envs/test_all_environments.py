"""What every environment promises; the promises are in symbolic/contract."""

import pytest

from bpns import envs
from bpns.symbolic.environment_check import check
from bpns.symbolic.errors import InputError
from tests.toy import HAND


@pytest.mark.parametrize("name", envs.names())
def test_the_checker_finds_nothing_wrong(name: str) -> None:
    found = [f"{f.check}: {f.text}" for f in check(envs.load(name), 4, seed=3) if f.level != "ok"]
    assert not found


def test_unknown_and_foreign_environments() -> None:
    with pytest.raises(InputError, match=r"unknown environment 'nowhere' \(have: "):
        envs.load("nowhere")
    with pytest.raises(InputError, match="no_such_module"):
        envs.load("no_such_module:Thing")
    for name in ("os:name", "json:dumps", ":x", "json:JSONDecoder", "tests.toy:HAND"):
        with pytest.raises(InputError, match=r"cannot load environment|is no environment"):
            envs.load(name)
    assert envs.load("tests.toy:Toy").name == "toy"
    assert envs.find("tests.toy:HAND") is HAND  # so that the checker can say what it lacks
