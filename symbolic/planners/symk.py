"""SymK (Speck, Mattmüller and Nebel 2020): symbolic top-k search, which streams plans in order of cost.

SymK is GPL-3.0; it is run as a program, from the package up-symk.
"""

import sys
from collections.abc import Generator
from functools import partial
from importlib.util import find_spec
from pathlib import Path

from bpns.symbolic.pddl.rewriting.portable import Rewritten
from bpns.symbolic.planners.foreign.alternatives import TopK
from bpns.symbolic.planners.foreign.exchange import Words
from bpns.symbolic.planners.foreign.program import GAVE_UP, read_plans, running, task_folder
from bpns.symbolic.planners.protocol import About, Limit

ABOUT = (
    About(
        "symk",
        "stream",
        optimal=True,
        proves=True,
        negation=True,
        equality=True,
        package="up-symk",
        extra="symk",
        licence="GPL-3.0-only",
    ),
)
FIRST = 1000  # plans come as they are found, so there is no harm in asking for many


def _ask(driver: Path, task: Rewritten, number: int, limit: Limit) -> Generator[list[Words], None, bool]:
    """Run SymK's forward search once; see AskMany.

    The bidirectional one measures time to choose its direction, so that the order of equal plans changes.
    """
    with task_folder(task) as folder:
        selection = f"top_k(num_plans={number},dump_plans=false)"
        search = f"symk_fw(simple=false,plan_selection={selection},bound=infinity)"
        files = ["--plan-file", "plan", "domain.pddl", "problem.pddl"]
        command = [sys.executable, str(driver), *files, "--search", search]
        with running("symk", command, folder) as program:
            proven = yield from read_plans(program, folder, ("plan",), limit)
            return proven or program.ended() in GAVE_UP  # it misses none


def create() -> TopK:
    """Return the planner; raise MissingPackage without SymK."""
    ABOUT[0].check_installed()
    spec = find_spec("up_symk")
    assert spec is not None
    assert spec.origin is not None
    driver = Path(spec.origin).parent / "symk" / "fast-downward.py"
    return TopK(ABOUT[0], partial(_ask, driver), FIRST)
