"""What foreign planners' plans go through before anybody uses them, and the end of a planner that fails."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field

from bpns.symbolic.grounding.ground import GroundProblem
from bpns.symbolic.operators import GroundOperator
from bpns.symbolic.pddl.plan_fault import first_fault
from bpns.symbolic.pddl.rewriting.portable import Rewritten, portable
from bpns.symbolic.planners.protocol import About, AbstractPlan, SearchRecord

# A step as a planner writes it, in lower case: the operator's name, the objects' names.
Words = tuple[str, ...]
LONGEST_FAULT = 400  # characters


class PlannerFailed(Exception):
    """A planner broke its promise: it crashed, or wrote something that is no plan. The text is one line."""


class DeadlinePassed(Exception):
    """The deadline passed while a planner was at work."""


@contextmanager
def recorded(record: SearchRecord) -> Iterator[None]:
    """Turn the end of a planner into an entry of the record."""
    try:
        yield
    except PlannerFailed as failure:
        record.stopped_by, record.fault = "planner failed", one_line(str(failure))
    except DeadlinePassed:
        record.stopped_by = "time limit"


def one_line(text: str) -> str:
    """Return a text of foreign origin as one line that a terminal can show."""
    line = "".join(c for c in " ".join(text.split()) if c.isprintable())
    return line if len(line) <= LONGEST_FAULT else f"{line[:LONGEST_FAULT]} ..."


def prepared(problem: GroundProblem, about: About) -> Rewritten:
    """Return a task that a planner can read. Operators without effects are left out: some refuse them."""
    operators = (o for o in problem.domain.operators if o.add_effects or o.delete_effects)
    domain = problem.domain.with_operators(operators)
    return portable(domain, problem.problem, about.negation, about.equality, about.typing)


def original_words(rewritten: Rewritten, words: Words) -> Words:
    """Return a step of a rewritten task as one of the original; raise PlannerFailed where there is none."""
    if not words:
        raise PlannerFailed("invalid plan: a step without a name")
    try:
        name, objects = rewritten.original(words[0], words[1:])
    except ValueError as error:
        raise PlannerFailed(f"invalid plan: {error}") from error
    return tuple(word.lower() for word in (name, *objects))


@dataclass(slots=True)
class PlanFilter:
    """Lets a foreign planner's plans through once each, as abstract plans of ours.

    Names are mapped to our ground operators, and these are applied again: a plan ends at its first goal
    state, and steps that change nothing are dropped. What is wrong goes to the record's remarks.
    """

    problem: GroundProblem
    record: SearchRecord
    in_order: bool  # whether the planner promises plans in order of length
    seen: dict[tuple[GroundOperator, ...], None] = field(default_factory=dict)  # in order, as a set has none
    longest: int = 0
    by_words: dict[Words, GroundOperator] = field(init=False)

    def __post_init__(self) -> None:
        self.by_words = {tuple(o.call[1:-1].split()): o for o in self.problem.operators}

    def steps(self, plan: Sequence[Words]) -> list[GroundOperator]:
        """Return a plan's steps up to its first goal state; raise PlannerFailed unless it is valid."""
        problem = self.problem.problem
        steps: list[GroundOperator] = []
        atoms = problem.init
        for words in plan:
            if problem.satisfied(atoms):
                return steps
            if words not in self.by_words:
                raise PlannerFailed(
                    f"invalid plan: step {len(steps) + 1} ({' '.join(words)}) can never be taken"
                )
            steps.append(self.by_words[words])
            atoms = steps[-1].apply(atoms)
        if fault := first_fault(problem, steps):
            raise PlannerFailed(f"invalid plan: {fault}")
        return steps

    def accept(self, plan: Sequence[Words]) -> AbstractPlan | None:
        """Return the plan; None where it was there before. Raises PlannerFailed where it is invalid."""
        steps = self.steps(plan)
        followed = AbstractPlan.follow(self.problem, steps)
        changing = tuple(
            step
            for step, before, after in zip(steps, followed.atoms, followed.atoms[1:], strict=False)
            if before != after
        )
        if self.in_order and len(plan) < self.longest:
            self.remark(f"plans are out of order: {len(plan)} steps after {self.longest}")
        self.longest = max(self.longest, len(plan))
        if changing in self.seen:
            return None
        self.seen[changing] = None
        return AbstractPlan.follow(self.problem, changing)

    def remark(self, text: str) -> None:
        """Note something once."""
        if text not in self.record.remarks:
            self.record.remarks.append(text)
