"""K* (Lee, Katz and Sohrabi 2023): top-k search with LM-cut, which delivers its plans at the end.

kstar-planner is GPL-3.0; it is run as a program.
"""

import json
import sys
from collections.abc import Generator, Iterator
from functools import partial
from importlib.util import find_spec
from pathlib import Path

from bpns.symbolic.pddl.rewriting.portable import Rewritten
from bpns.symbolic.planners.foreign.alternatives import TopK
from bpns.symbolic.planners.foreign.exchange import PlannerFailed, Words
from bpns.symbolic.planners.foreign.program import GAVE_UP, read_plans, running, task_folder
from bpns.symbolic.planners.protocol import About, Limit

ABOUT = (
    About(
        "kstar",
        "top-k",
        optimal=True,
        proves=True,
        negation=True,
        equality=True,
        package="kstar-planner",
        extra="kstar",
        licence="GPL-3.0",
    ),
)
FIRST = 10
SYMMETRIES = (
    "sym=structural_symmetries(time_bound=0,search_symmetries=oss,"
    "stabilize_initial_state=false,keep_operator_symmetries=true)"
)


def _ask(binaries: Path, task: Rewritten, number: int, limit: Limit) -> Generator[list[Words], None, bool]:
    """Run K* once, with LM-cut and symmetries; see AskMany."""
    with task_folder(task) as folder:
        options = f"k={number},dump_plan_files=false,json_file_to_dump=plans.json,symmetries=sym"
        search = f"kstar(lmcut(transform=undo_to_origin()),find_unordered_plans=false,{options})"
        driver = [sys.executable, "-B", "-m", "kstar_planner.driver.main", "--build", str(binaries)]
        files = ["domain.pddl", "problem.pddl", "--symmetries", SYMMETRIES, "--search", search]
        with running("kstar", [*driver, *files], folder) as program:
            proven = yield from read_plans(program, folder, (), limit)
            proven = proven or program.ended() in GAVE_UP  # it misses none
        if (folder / "plans.json").exists():
            yield from _plans(folder / "plans.json")
        return proven


def _plans(path: Path) -> Iterator[list[Words]]:
    try:
        plans = json.loads(path.read_text(encoding="utf-8"))["plans"]
        yield from ([tuple(action.lower().split()) for action in plan["actions"]] for plan in plans)
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise PlannerFailed(f"kstar wrote no plans: {type(error).__name__}: {error}") from error


def create() -> TopK:
    """Return the planner; raise MissingPackage without kstar-planner."""
    ABOUT[0].check_installed()
    spec = find_spec("kstar_planner")
    assert spec is not None
    assert spec.origin is not None
    binaries = Path(spec.origin).parent / "builds" / "release" / "bin"
    return TopK(ABOUT[0], partial(_ask, binaries), FIRST)
