"""pyperplan on the real PDDL text: its parser, grounder, searches and heuristics.

pyperplan is GPL-3.0-or-later and is imported only here, when asked for; it runs in a process apart. It gives
one plan; alternatives are enumerated on the task that it grounded, by its heuristic, with our path search.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from math import inf
from pathlib import Path
from shutil import which
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from bpns.symbolic.errors import InputError, MissingPackage
from bpns.symbolic.grounding.ground import GroundProblem
from bpns.symbolic.grounding.heuristics import Heuristic
from bpns.symbolic.grounding.masks import CompiledOperator, CompiledProblem, bits
from bpns.symbolic.pddl.write import write_domain, write_problem
from bpns.symbolic.planners.astar.best_first import enumerate_plans
from bpns.symbolic.planners.foreign.apart import Apart
from bpns.symbolic.planners.protocol import About, AbstractPlan, Limit, SearchRecord


class _Stopped(Exception):
    """A limit was reached inside one of pyperplan's searches."""


class _Fact(str):
    """A fact's name whose hash does not change from run to run, and with it neither do sets of facts."""

    number: int

    @classmethod
    def of(cls, number: int) -> "_Fact":
        fact = cls(f"fact{number}")
        fact.number = number
        return fact

    def __hash__(self) -> int:
        return self.number


ADMISSIBLE = ("blind", "hmax", "lmcut")
ABOUT = (
    About(
        "pyperplan",
        "one plan",
        optimal=True,
        proves=True,
        package="pyperplan",
        extra="pyperplan",
        licence="GPL-3.0-or-later",
        note="pyperplan:SEARCH:HEURISTIC, with astar, wastar, gbf, ehs, bfs, ids and lmcut, hff, hadd, hmax, "
        "hsa, landmark, blind; only astar with lmcut, hmax or blind is optimal",
    ),
)


@dataclass(frozen=True, slots=True)
class Pyperplan:
    """One of pyperplan's searches with one of its heuristics.

    It is used within Apart, which compiles away what pyperplan cannot read.
    """

    search: str
    heuristic: str

    @property
    def name(self) -> str:
        """How to ask for this planner."""
        return f"pyperplan:{self.search}:{self.heuristic}"

    def plans(
        self, problem: GroundProblem, rng: np.random.Generator, limit: Limit, record: SearchRecord
    ) -> Iterator[AbstractPlan]:
        """Yield pyperplan's own plan, then all others by length; see Planner."""
        library = _library()
        task, compiled = _ground(problem, library)
        make = library.HEURISTICS[self.heuristic]
        with _reported("search"):
            first = _search(task, library.SEARCHES[self.search], make, self.search, limit, record)
        if record.stopped_by:
            return
        if first is not None:
            yield AbstractPlan.follow(problem, [compiled.operators[i].ground for i in first])
        # Some of its searches miss plans that exist: ours then finds them, or proves that there are none.
        heuristic = _heuristic(task, make)
        for steps in enumerate_plans(compiled, heuristic, rng, limit, record):
            if steps != first:
                yield AbstractPlan.follow(problem, [compiled.operators[i].ground for i in steps])


def create(search: str = "astar", heuristic: str = "lmcut") -> Apart:
    """Return the planner; raise InputError for unknown names, MissingPackage without pyperplan."""
    library = _library()
    searches = {name: s for name, s in library.SEARCHES.items() if name != "sat" or which("minisat")}
    for kind, name, known in (
        ("search", search, searches),
        ("heuristic", heuristic, library.HEURISTICS),
    ):
        if name not in known:
            have = ", ".join(sorted(known))
            raise InputError(f"unknown {kind} '{name}' in 'pyperplan:{search}:{heuristic}' (have: {have})")
    optimal = search == "astar" and heuristic in ADMISSIBLE
    return Apart(Pyperplan(search, heuristic), replace(ABOUT[0], optimal=optimal))


def _library() -> Any:
    ABOUT[0].check_installed()
    try:
        from pyperplan import planner  # optional, GPL, slow to import
        from pyperplan.heuristics import lm_cut
    except ImportError as error:
        raise MissingPackage("pyperplan is not installed: pip install 'bpns[pyperplan]'") from error
    # LM-cut walks through sets of these, whose order and with it the plan would depend on places in memory.
    lm_cut.RelaxedOp.__hash__ = lambda op: int(op.name) if op.name.isdigit() else -1
    lm_cut.LmCutHeuristic.always_true = _Fact.of(-2)
    return planner


@contextmanager
def _reported(doing: str) -> Iterator[None]:
    """Turn pyperplan's internal exceptions into one line."""
    try:
        yield
    except (Exception, SystemExit) as error:  # its sat search exits where minisat is missing
        text = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"pyperplan failed in its {doing}: {text}: try --planner astar") from error


def _ground(problem: GroundProblem, library: Any) -> tuple[Any, CompiledProblem]:
    """Let pyperplan read and ground the PDDL text; return its task and our view of it.

    Operators that we found unreachable are left out.
    """
    with TemporaryDirectory() as folder, _reported("reading and grounding"):
        domain_file, problem_file = Path(folder, "domain.pddl"), Path(folder, "problem.pddl")
        domain_file.write_text(write_domain(problem.domain), encoding="utf-8")
        problem_file.write_text(write_problem(problem.problem, problem.domain), encoding="utf-8")
        parsed = library._parse(str(domain_file), str(problem_file))
        # Its relevance analysis strips effects, so that states would be projections.
        task = library._ground(parsed, remove_irrelevant_operators=False)
    index = {fact: number for number, fact in enumerate(sorted(task.facts))}
    grounded = {operator.name: operator for operator in task.operators}
    everything = (1 << len(index)) - 1

    def mask(facts: frozenset[str]) -> int:
        return sum(1 << index[fact] for fact in facts)

    compiled = []
    for ours in problem.operators:
        theirs = grounded.get(ours.call)
        if theirs is not None:  # it leaves out operators without any effect
            keep = everything & ~mask(theirs.del_effects - theirs.add_effects)
            compiled.append(
                CompiledOperator(ours, mask(theirs.preconditions), 0, mask(theirs.add_effects), keep)
            )
    view = CompiledProblem((), frozenset(), tuple(compiled), mask(task.initial_state), mask(task.goals), 0)
    return _renamed(view, len(index)), view


def _renamed(view: CompiledProblem, size: int) -> Any:
    """Return the compiled problem as a task of pyperplan's; its operators are named by number.

    With pyperplan's own names, the order of its sets and so its plan would change with PYTHONHASHSEED.
    """
    from pyperplan.task import Operator, Task

    facts = [_Fact.of(number) for number in range(size)]

    def chosen(mask: int) -> frozenset[_Fact]:
        return frozenset(facts[number] for number in bits(mask))

    everything = (1 << size) - 1
    operators = [
        Operator(str(number), chosen(o.preconditions), chosen(o.add), chosen(everything & ~o.keep))
        for number, o in enumerate(view.operators)
    ]
    return Task("task", set(facts), chosen(view.init), chosen(view.goal), operators)


def _search(
    task: Any, search: Any, make: Any, search_name: str, limit: Limit, record: SearchRecord
) -> list[int] | None:
    """Run one of pyperplan's searches, which know no limits: they are checked at each expansion."""
    successors: Callable[[Any], list[Any]] = task.get_successor_states

    def counted(state: Any) -> list[Any]:
        if record.nodes_created >= limit.nodes or limit.late:
            record.stopped_by = "time limit" if limit.late else "node limit"
            raise _Stopped
        found = successors(state)
        record.nodes_expanded += 1
        record.nodes_created += len(found)
        return found

    task.get_successor_states = counted
    record.nodes_created += 1
    try:
        blind = search_name in ("bfs", "ids", "sat")
        solution = search(task) if blind else search(task, make(task))
    except _Stopped:
        return None
    finally:
        del task.get_successor_states
    return None if solution is None else [int(operator.name) for operator in solution]


def _heuristic(task: Any, make: Any) -> Heuristic:
    """Return pyperplan's heuristic as a function of a mask."""
    from pyperplan.search.searchspace import make_root_node

    evaluate = make(task)
    facts = sorted(task.facts, key=lambda fact: fact.number)

    def value(state: int) -> float:
        found = evaluate(make_root_node(frozenset(facts[number] for number in bits(state))))
        return inf if found is None else float(found)

    return value
