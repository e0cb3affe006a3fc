"""Every installed planner on real PDDL: seconds to the first plan, lengths, and plans checked independently.

Problems: pddl_out/, tests/data/pddl-bench and tests/data/pddl (competition files, for astar and pyperplan
only, unless --all). Each planner gives up to --plans plans, astar 100. Planners that promise plans in order
of length must agree on the shortest length and keep the order; no plan may come twice; each plan must be
valid for us, for kairos and (as many as --validation seconds a problem allow) for unified-planning. Prints a
line for each planner and folder, then a summary; --out writes it as Markdown. Exits with 1 on any fault
except that a planner failed, which is told and ends only its own plans.
"""

import argparse
import os
import platform
import re
import sys
import warnings
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from statistics import median
from time import monotonic

from _commit import commit

from bpns.symbolic import planners
from bpns.symbolic.checkers import unified_planning
from bpns.symbolic.checkers.reports import Inputs, PlanSource, Source
from bpns.symbolic.errors import InputError
from bpns.symbolic.grounding.ground import GroundProblem, Unreachable, ground
from bpns.symbolic.pddl.plan_fault import first_fault
from bpns.symbolic.pddl.plan_file import parse_plan
from bpns.symbolic.pddl.read import read_domain, read_problem
from bpns.symbolic.planners.protocol import About, Limit, Planner
from bpns.symbolic.planners.streams import first_plans

ROOT = Path(__file__).parents[1]
DATA = ROOT / "tests" / "data"
PATIENT = ("astar", "pyperplan")  # these two get competition files too, and more time
UNMEASURED = ("command",)  # a family without a program
Text = tuple[str, ...]  # a plan, a step each


@dataclass(frozen=True, slots=True)
class Case:
    """A problem and its domain."""

    folder: str
    domain: Path
    problem: Path

    @property
    def label(self) -> str:
        """A short name."""
        return f"{self.folder}/{self.problem.stem}"


@dataclass(frozen=True, slots=True)
class Row:
    """What a planner did with a problem."""

    planner: str
    case: Case
    first: float | None  # seconds to the first plan
    plans: tuple[Text, ...] = ()
    ended: str = ""
    failed: bool = False

    @property
    def lengths(self) -> list[int]:
        """Of the plans, as they came."""
        return [len(plan) for plan in self.plans]


@dataclass(frozen=True, slots=True)
class Chunk:
    """The problems of a folder for one planner, which is loaded once."""

    planner: str
    cases: tuple[Case, ...]
    plans: int
    seconds: float


# ----------------------------------------------------------------------------------------- problems


def cases() -> Iterator[Case]:
    """Yield all problems with their domains."""
    for path in sorted(ROOT.glob("pddl_out/*/p*.pddl")):
        yield Case(path.parent.name, path.parent / "domain.pddl", path)
    domains = {
        _word(r"\(define\s*\(domain\s+([^\s)]+)", path): path
        for path in sorted((DATA / "pddl-bench").glob("*-domain.pddl"))
    }
    for path in sorted((DATA / "pddl-bench").glob("*.pddl")):
        domain = domains.get(_word(r"\(:domain\s+([^\s)]+)", path))
        if domain is not None:
            yield Case("pddl-bench", domain, path)
    for path in sorted((DATA / "pddl").glob("*/task*.pddl")):
        own = path.with_name(path.name.replace("task", "domain"))
        yield Case(f"ipc-{path.parent.name}", own if own.exists() else path.parent / "domain.pddl", path)


def _word(pattern: str, path: Path) -> str:
    found = re.search(pattern, path.read_text(encoding="utf-8"), re.IGNORECASE)
    return found[1].lower() if found else ""


def read(case: Case) -> GroundProblem | Unreachable:
    """Read and ground a problem."""
    domain = read_domain(case.domain)
    return ground(domain, read_problem(case.problem, domain))


# ---------------------------------------------------------------------------------------- measuring


def run_chunk(chunk: Chunk) -> list[Row]:
    """Let one planner plan for some problems; readers' warnings are of no interest here."""
    warnings.simplefilter("ignore")
    planner = planners.load(chunk.planner)
    found = []
    for case in chunk.cases:
        problem = read(case)
        if isinstance(problem, Unreachable):
            found.append(Row(chunk.planner, case, None, (), "no plan: shown by grounding"))
        else:
            found.append(run(planner, chunk, case, problem))
    return found


def run(planner: Planner, chunk: Chunk, case: Case, problem: GroundProblem) -> Row:
    """Take a planner's first plans."""
    limit = Limit(10**9, monotonic() + chunk.seconds)
    found = first_plans(planner, problem, chunk.plans, 0, limit)
    plans = tuple(
        tuple(_call(s.operator.name, (o.name for o in s.objects)) for s in plan.steps) for plan in found.plans
    )
    ended = "" if len(plans) == chunk.plans else found.ended or "no others"
    return Row(chunk.planner, case, found.first_seconds, plans, ended, failed=bool(found.record.fault))


def _call(name: str, objects: Iterable[str]) -> str:
    return f"({' '.join([name, *objects])})"


# ----------------------------------------------------------------------------------------- checking


@dataclass(frozen=True, slots=True)
class Checked:
    """How many of a problem's distinct plans were checked, and what was wrong with which."""

    kairos: int
    unified_planning: int
    faults: dict[Text, str]


def check(case: Case, plans: Sequence[Text], seconds: float) -> Checked:
    """Validate distinct plans for a problem with ours, kairos and, for so many seconds, unified-planning."""
    import kairos

    warnings.simplefilter("ignore")
    problem = read(case)
    assert isinstance(problem, GroundProblem)
    faults: dict[Text, str] = {}
    by_call = {_call(o.operator.name, (b.name for b in o.objects)): o for o in problem.operators}
    parsed = kairos.load_problem(case.problem, kairos.load_domain(case.domain))
    for plan in plans:
        if fault := first_fault(problem.problem, [by_call[call] for call in plan]):
            faults[plan] = f"for us: {fault}"
        elif not kairos.validate(parsed, kairos.parse_plan("".join(f"{call}\n" for call in plan))).valid:
            faults[plan] = "for kairos"
    texts = [Source(str(path), path.read_text(encoding="utf-8")) for path in (case.domain, case.problem)]
    sources = tuple(PlanSource("plan", tuple(parse_plan("\n".join(plan)))) for plan in plans)
    verdicts = unified_planning.verdicts(Inputs(texts[0], texts[1], sources))
    read_well = all(next(verdicts).level == "ok" for _ in texts)
    until, count = monotonic() + seconds, 0
    for plan, verdict in zip(plans, verdicts if read_well else (), strict=False):
        if verdict.level == "fault":
            faults[plan] = f"for unified-planning: {verdict.text}"
        count += verdict.level in ("ok", "fault")
        if monotonic() > until:
            break
    return Checked(len(plans), count, faults)


def faults_of(row: Row, about: About, checked: Checked | None, shortest: int | None) -> Iterator[str]:
    """Yield what is wrong with what a planner did."""
    if row.failed:
        yield row.ended
    if len(set(row.plans)) < len(row.plans):
        yield "a plan twice"
    if about.optimal and row.lengths != sorted(row.lengths):
        yield "not in order of length"
    if row.plans and shortest is not None:
        if about.optimal and row.lengths[0] != shortest:
            yield f"first plan has {row.lengths[0]} steps, others' {shortest}"
        elif row.lengths[0] < shortest:
            yield f"{row.lengths[0]} steps are fewer than the optimal planners' {shortest}"
    if row.ended == "no others" and not row.plans and shortest is not None:
        yield "says that there is no plan"
    if checked is not None:
        yield from (
            f"invalid plan {checked.faults[p]}: {' '.join(p)}" for p in row.plans if p in checked.faults
        )


# ---------------------------------------------------------------------------------------- reporting


def summary(rows: Sequence[Row], abouts: dict[str, About], faults: dict[Row, list[str]]) -> list[list[str]]:
    """Return the cells of a table: a line for each planner."""
    lines = [
        ["planner", "version", "optimal", "solved", "of", "first plan s", "longest s", "plans", "faults"]
    ]
    for name, about in abouts.items():
        own = [row for row in rows if row.planner == name and not row.ended.startswith("no plan:")]
        seconds = sorted(row.first for row in own if row.first is not None)
        middle, longest = (f"{median(seconds):.3f}", f"{seconds[-1]:.2f}") if seconds else ("-", "-")
        lines.append([name, about.version or "", "yes" if about.optimal else "-", str(len(seconds))])
        lines[-1] += [str(len(own)), middle, longest, str(sum(len(row.plans) for row in own))]
        lines[-1].append(str(sum(bool(faults[row]) for row in own)))
    return lines


def matrix(rows: Sequence[Row], names: Sequence[str]) -> list[list[str]]:
    """Return the cells of a table: planners by folders, each with problems solved and median seconds."""
    folders = list(dict.fromkeys(row.case.folder for row in rows))
    lines = [["folder", *names]]
    for folder in folders:
        lines.append([folder])
        for name in names:
            own = [row for row in rows if row.planner == name and row.case.folder == folder]
            own = [row for row in own if not row.ended.startswith("no plan:")]
            seconds = [row.first for row in own if row.first is not None]
            time = f", {median(seconds):.2f} s" if seconds else ""
            lines[-1].append(f"{len(seconds)}/{len(own)}{time}" if own else "-")
    return lines


def markdown(lines: Sequence[Sequence[str]]) -> str:
    """Return a Markdown table."""
    rule = ["---", *["---:"] * (len(lines[0]) - 1)]
    return "".join(f"| {' | '.join(cells)} |\n" for cells in (lines[0], rule, *lines[1:]))


def plain(lines: Sequence[Sequence[str]]) -> str:
    """Return a table for the terminal."""
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    return "\n".join(
        "  ".join(
            cell.rjust(width) if i else cell.ljust(width)
            for i, (cell, width) in enumerate(zip(line, widths, strict=True))
        )
        for line in lines
    )


def document(
    arguments: argparse.Namespace,
    tables: Sequence[Sequence[Sequence[str]]],
    notes: str,
    faults: Sequence[str],
) -> str:
    """Return the page that --out writes."""
    command = " ".join(["python benchmarks/planners.py", *sys.argv[1:]])
    first, *others = tables
    turned = [
        markdown([list(line) for line in zip(*table, strict=True)] if len(table[0]) > len(table) else table)
        for table in others
    ]
    return (
        "# Planners compared\n\n"
        f"Of commit {commit()}. Made by `{command}` on {_machine()}, {arguments.workers} problems at a time. "
        "Seconds are those to the first plan, from the grounded problem on, writing PDDL and starting the "
        "planner included; "
        "*solved* means within the time limit. *faults*: a plan that a validator refuses, a plan twice, a "
        "wrong order, another shortest length than the other optimal planners, or a planner that failed.\n\n"
        f"{markdown(first)}\n{notes}\n\n"
        "Problems solved and median seconds to the first plan:\n\n"
        + "\n".join(turned)
        + "\nFaults:\n\n"
        + ("".join(f"* {fault}\n" for fault in faults) or "none\n")
    )


def _machine() -> str:
    model = next(
        (
            line.partition(":")[2].strip()
            for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
            if line.startswith("model name")
        ),
        platform.processor() or platform.machine(),
    )
    return f"{os.cpu_count()} cores of {model}, Python {platform.python_version()}"


# --------------------------------------------------------------------------------------------- main


def parse() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--planner", action="append", help="only this one, with options (may be repeated)")
    parser.add_argument("--match", default="", help="only problems with this in their name, as in cover/p0")
    parser.add_argument("--all", action="store_true", help="competition files for every planner")
    parser.add_argument("--seconds", type=float, help="for each problem (default: 10; astar, pyperplan 30)")
    parser.add_argument("--plans", type=int, help="plans of each planner (default: 10, of astar 100)")
    parser.add_argument("--validation", type=float, default=5, help="unified-planning's seconds a problem")
    parser.add_argument("--workers", type=int, default=os.cpu_count())
    parser.add_argument("--out", type=Path, help="write the tables as Markdown")
    return parser.parse_args()


def chunks(arguments: argparse.Namespace, names: Sequence[str]) -> Iterator[Chunk]:
    """Yield what is to be done, a folder and planner at a time."""
    folders: dict[str, list[Case]] = defaultdict(list)
    for case in cases():
        if arguments.match in case.label:
            folders[case.folder].append(case)
    for name in names:
        patient = name.split(":")[0] in PATIENT
        plans = arguments.plans or (100 if name.startswith("astar") else 10)
        for folder, found in folders.items():
            if patient or arguments.all or not folder.startswith("ipc-"):
                yield Chunk(name, tuple(found), plans, arguments.seconds or (30 if patient else 10))


def installed(arguments: argparse.Namespace) -> dict[str, About]:
    """Return the planners to run, with what each promises; options may change that."""
    known = {about.name: about for about in planners.about()}
    if not arguments.planner:
        return {n: a for n, a in known.items() if a.version is not None and n not in UNMEASURED}
    found = {}
    for name in arguments.planner:
        loaded = planners.load(name)
        plain_name = name if name in known else name.split(":")[0]
        about = getattr(loaded, "about", None) or known.get(plain_name)
        found[name] = about or About(name, "one plan", licence="?")
    return found


def main() -> None:
    """Run, check, print."""
    arguments = parse()
    try:
        abouts = installed(arguments)
    except InputError as error:
        sys.exit(f"error: {error}")
    rows: list[Row] = []
    with ProcessPoolExecutor(arguments.workers, get_context("spawn")) as pool:
        for found in pool.map(run_chunk, chunks(arguments, list(abouts))):
            rows += found
            print(
                plain([[found[0].planner.ljust(20), *(f"{r.lengths[:1]} {r.first or 0:.2f}" for r in found)]])
            )
            sys.stdout.flush()
        plans: dict[Case, dict[Text, None]] = defaultdict(dict)
        for row in rows:
            plans[row.case] |= dict.fromkeys(row.plans)
        waiting = {
            case: pool.submit(check, case, list(found), arguments.validation)
            for case, found in plans.items()
            if found
        }
        checked = {case: future.result() for case, future in waiting.items()}
    report(arguments, abouts, rows, checked)


def report(
    arguments: argparse.Namespace,
    abouts: dict[str, About],
    rows: list[Row],
    checked: dict[Case, Checked],
) -> None:
    """Print the tables and faults; exit."""
    shortest: dict[Case, int] = {}
    compared: dict[Case, int] = defaultdict(int)
    for row in rows:
        if row.plans and abouts[row.planner].optimal:
            shortest[row.case] = min(row.lengths[0], shortest.get(row.case, row.lengths[0]))
            compared[row.case] += 1
    faults = {
        row: list(faults_of(row, abouts[row.planner], checked.get(row.case), shortest.get(row.case)))
        for row in rows
    }
    tables = [summary(rows, abouts, faults)]
    own, ipc = ([r for r in rows if r.case.folder.startswith("ipc-") == flag] for flag in (False, True))
    tables += [matrix(part, list(dict.fromkeys(r.planner for r in part))) for part in (own, ipc) if part]
    notes = (
        f"{sum(n > 1 for n in compared.values())} problems were solved by more than one optimal planner, "
        f"{sum(len(c.faults) for c in checked.values())} plans are invalid. Checked by us and by kairos: "
        f"{sum(c.kairos for c in checked.values())} different plans; by unified-planning: "
        f"{sum(c.unified_planning for c in checked.values())}."
    )
    print("\n\n".join([*map(plain, tables), notes]))
    told = [f"{row.planner} {row.case.label}: {'; '.join(texts)}" for row, texts in faults.items() if texts]
    for fault in told:
        print(f"FAULT {fault}")
    if arguments.out is not None:
        arguments.out.write_text(document(arguments, tables, notes, told), encoding="utf-8")
    ours = any(text != row.ended for row, texts in faults.items() for text in texts)
    sys.exit(1 if ours else 0)


if __name__ == "__main__":
    main()
