"""Any planner that a user has: ``command:"program {domain} {problem} {plan}"``.

It runs in a folder of its own, where it writes its plan files: ``plan``, or ``plan.1``, ``plan.2``, ... as it
finds them. Without {plan} in the command they may also be called ``sas_plan`` or ``problem.pddl.soln``. Exit
codes are those of Fast Downward.
"""

import re
import shlex
from collections.abc import Generator, Iterator
from dataclasses import dataclass
from itertools import count
from os.path import abspath, isfile  # unlike pathlib's, it takes words too long for a name
from pathlib import Path
from shutil import which

import numpy as np

from bpns.symbolic.errors import InputError
from bpns.symbolic.grounding.ground import GroundProblem
from bpns.symbolic.pddl.rewriting.portable import Rewritten
from bpns.symbolic.planners.foreign.alternatives import one_by_one
from bpns.symbolic.planners.foreign.exchange import PlannerFailed, Words
from bpns.symbolic.planners.foreign.program import read_plans, running, task_folder
from bpns.symbolic.planners.protocol import About, AbstractPlan, Limit, SearchRecord

PLAN_FILES = ("plan", "sas_plan", "problem.pddl.soln")  # the last: pyperplan's
WRITTEN = (*PLAN_FILES, *(f"{name}.1" for name in PLAN_FILES))
ABOUT = (
    About(
        "command", "one plan", licence="-", note='command:"PROGRAM {domain} {problem} {plan}", any planner'
    ),
)


@dataclass(frozen=True, slots=True)
class Command:
    """A program on this machine. Nothing is known of it, so negation and equality are compiled away."""

    words: tuple[str, ...]

    @property
    def name(self) -> str:
        """How to ask for this planner."""
        return f"command:{shlex.join(self.words)}"

    def plans(
        self, problem: GroundProblem, rng: np.random.Generator, limit: Limit, record: SearchRecord
    ) -> Iterator[AbstractPlan]:
        """Yield the program's plans, then others; see Planner."""
        calls = count()

        def ask(task: Rewritten, limit: Limit) -> Generator[list[Words], None, bool]:
            return self.ask(task, limit, first=next(calls) == 0)

        return one_by_one(ABOUT[0], ask, problem, rng, limit, record)

    def ask(self, task: Rewritten, limit: Limit, first: bool) -> Generator[list[Words], None, bool]:
        """Run the program once; see Ask.

        Some programs end with 0 where there is no plan. At first that is taken for a mistake in the command.
        """
        with task_folder(task) as folder:
            command = [_filled(word, folder) for word in self.words]
            with running(Path(self.words[0]).name, command, folder) as program:
                proven = yield from read_plans(program, folder, PLAN_FILES, limit)
                if first and program.ended() == 0 and not any((folder / name).exists() for name in WRITTEN):
                    raise PlannerFailed(f"{program.name} wrote no plan file; it is {{plan}} in the command")
                return proven


def _filled(word: str, folder: Path) -> str:
    """Fill a word of the command in; not with str.format, as Fast Downward's options have braces too."""
    for file in ("domain.pddl", "problem.pddl", "plan"):
        word = word.replace(f"{{{Path(file).stem}}}", str(folder / file))
    return word


def create(*pieces: str) -> Command:
    """Return the planner; raise InputError for a command that cannot be run."""
    text = ":".join(pieces)
    how = 'such as command:"my-planner {domain} {problem} {plan}"'
    try:
        words = shlex.split(text)
    except ValueError as error:
        raise InputError(f"planner 'command:{text}': {error}: give a command {how}") from error
    for unknown in [] if "{plan}" in text else re.findall(r"\{\w+\}", text):
        if unknown not in ("{domain}", "{problem}"):
            raise InputError(f"planner 'command:{text}': unknown {unknown}: give a command {how}")
    for needed in ("{domain}", "{problem}"):
        if not any(needed in word for word in words):
            raise InputError(f"planner 'command:{text}' has no {needed}: give a command {how}")
    program = which(words[0])
    if program is None and isfile(words[0]):
        raise InputError(f"planner 'command:{text}': '{words[0]}' is not executable (chmod +x makes it so)")
    if program is None:
        raise InputError(f"planner 'command:{text}': there is no program '{words[0]}' on this machine")
    # It runs in another folder, where names of files in the current one would mean nothing; an old plan
    # in the current folder must stay as it is.
    found = [abspath(word) if isfile(word) and word not in PLAN_FILES else word for word in words[1:]]
    return Command((abspath(program), *found))
