"""More plans: what a planner found is forbidden in the PDDL and it is asked again, or asked for more."""

from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass, field
from time import monotonic

import numpy as np

from bpns.symbolic.grounding.ground import GroundProblem
from bpns.symbolic.operators import GroundOperator
from bpns.symbolic.pddl.rewriting.forbid import forbid
from bpns.symbolic.pddl.rewriting.portable import Rewritten
from bpns.symbolic.planners.astar import AStar
from bpns.symbolic.planners.foreign.exchange import (
    DeadlinePassed,
    PlanFilter,
    PlannerFailed,
    Words,
    original_words,
    prepared,
    recorded,
)
from bpns.symbolic.planners.foreign.program import PATIENCE
from bpns.symbolic.planners.protocol import About, AbstractPlan, Limit, SearchRecord

ALTERNATIVES = 20  # the PDDL grows with every plan that it forbids; then our own search is faster


# Yields plans for a task; returns whether it is certain that there are no others
# (of interest only where fewer came than asked for). Raises PlannerFailed and DeadlinePassed.
Ask = Callable[[Rewritten, Limit], Generator[list[Words], None, bool]]


def one_by_one(
    about: About,
    ask: Ask,
    problem: GroundProblem,
    rng: np.random.Generator,
    limit: Limit,
    record: SearchRecord,
) -> Iterator[AbstractPlan]:
    """Yield plan after plan of a planner that gives one, or some; see Planner.

    Exactly the sequences found so far are forbidden, not their reorderings, so that the plans of an optimal
    planner stay in order of length. After ALTERNATIVES plans, or where the planner finds none and proves
    nothing, ``astar`` goes on with what is left.
    """
    passing = PlanFilter(problem, record, about.optimal)
    forbidden: list[tuple[GroundOperator, ...]] = []  # in the order in which they came
    with recorded(record):
        original = prepared(problem, about)
        while len(forbidden) < ALTERNATIVES:
            rewritten = forbid(
                original,
                [[(s.operator.name, tuple(o.name for o in s.objects)) for s in steps] for steps in forbidden],
            )
            if rewritten is None:
                return
            before = len(passing.seen)
            _, proven = yield from _useful(about, ask(rewritten, limit), rewritten, passing, limit)
            forbidden = list(passing.seen)
            if len(forbidden) == before and proven:
                return
            if len(forbidden) == before:
                break
    if not record.stopped_by:
        yield from goes_on(about, passing, rng, limit, record)


def _useful(
    about: About,
    answers: Generator[list[Words], None, bool],
    rewritten: Rewritten,
    passing: PlanFilter,
    limit: Limit,
) -> Generator[AbstractPlan, None, tuple[int, bool]]:
    """Yield those of a planner's answers that pass; return how many came, and what the planner returned."""
    number, since = 0, monotonic()
    while True:
        try:
            plan = next(answers)
        except StopIteration as end:
            return number, end.value
        number += 1
        found = passing.accept([original_words(rewritten, step) for step in plan])
        if found is not None:
            yield found
            since = monotonic()
        elif limit.late:
            raise DeadlinePassed
        elif limit.deadline is None and monotonic() > since + PATIENCE:
            raise PlannerFailed(
                f"{about.name} gave no new plan within {PATIENCE:.0f} s (--timeout changes that)"
            )


def goes_on(
    about: About, passing: PlanFilter, rng: np.random.Generator, limit: Limit, record: SearchRecord
) -> Iterator[AbstractPlan]:
    """Yield the plans that did not pass yet, found by our own search."""
    count = record.own = len(passing.seen)
    what = (
        f"only the first {count} plan(s) came from {about.name}" if count else f"{about.name} found no plan"
    )
    passing.remark(f"{what}, without a proof that there are no others: astar goes on")
    for plan in AStar().plans(passing.problem, rng, limit, record):
        if plan.steps not in passing.seen:
            passing.seen[plan.steps] = None
            yield plan


AskMany = Callable[[Rewritten, int, Limit], Generator[list[Words], None, bool]]  # the same, for so many plans
MOST_ASKED_FOR = 1_000_000


def more_and_more(
    about: About,
    ask: AskMany,
    first: int,
    problem: GroundProblem,
    rng: np.random.Generator,
    limit: Limit,
    record: SearchRecord,
) -> Iterator[AbstractPlan]:
    """Yield the plans of a top-k planner: ``first`` ones, then ten times as many, and so on; see Planner.

    Many of its plans are of no use, as they go on behind the goal or have steps that change nothing. After
    MOST_ASKED_FOR plans, or where more bring nothing new, or fewer than asked for prove nothing, ``astar``
    goes on.
    """
    passing = PlanFilter(problem, record, about.optimal)
    with recorded(record):
        rewritten = prepared(problem, about)
        number = first
        while number <= MOST_ASKED_FOR:
            before, answers = len(passing.seen), ask(rewritten, number, limit)
            given, proven = yield from _useful(about, answers, rewritten, passing, limit)
            if given < number and proven:
                return
            if given < number or len(passing.seen) == before:
                break
            number *= 10
            passing.longest = 0
    if not record.stopped_by:
        yield from goes_on(about, passing, rng, limit, record)


@dataclass(frozen=True, slots=True)
class TopK:
    """A program that gives as many plans as it is asked for."""

    about: About
    ask: AskMany = field(compare=False)
    first: int  # how many it is asked for at first

    @property
    def name(self) -> str:
        """How to ask for this planner."""
        return self.about.name

    def plans(
        self, problem: GroundProblem, rng: np.random.Generator, limit: Limit, record: SearchRecord
    ) -> Iterator[AbstractPlan]:
        """Yield the program's plans in order of length; see Planner."""
        return more_and_more(self.about, self.ask, self.first, problem, rng, limit, record)
