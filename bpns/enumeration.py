"""Abstract plans: what a planner finds on the symbolic level alone."""

import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from bpns.model import Model
from bpns.symbolic import planners
from bpns.symbolic.errors import InputError
from bpns.symbolic.grounding.ground import OutOfTime, Unreachable, ground
from bpns.symbolic.operators import Domain, Problem
from bpns.symbolic.pddl.read import read_domain, read_problem
from bpns.symbolic.pddl.write import model_names
from bpns.symbolic.planners.protocol import AbstractPlan, Limit, Planner, SearchRecord
from bpns.symbolic.planners.streams import loopless
from bpns.symbolic.skills.environment import problem_of
from bpns.symbolic.state import Task

MAX_NODES = 10_000_000  # memory ends about there


class AbstractPlans:
    """A stream of abstract plans, and afterwards why it ended. ``abstract_plans`` makes one.

    Each has ``steps``, ground operators, and ``atoms``, the abstract states before, between and after them.
    The stream goes on where the last loop over it stopped.
    """

    def __init__(self, planner: Planner, domain: Domain, problem: Problem, seed: int, timeout: float | None):
        self.planner = planner.name
        self.record = SearchRecord()  # what the search did
        self._grounding = ""
        self._limit = Limit(MAX_NODES, None if timeout is None else time.monotonic() + timeout)
        grounded = ground(domain, problem, self._limit.deadline)
        self._plans: Iterator[AbstractPlan] = iter(())
        if isinstance(grounded, Unreachable):
            self._grounding = str(grounded)
        elif isinstance(grounded, OutOfTime):
            self.record.stopped_by = "time limit"
            self._grounding = "stopped by the time limit while grounding"
        else:
            self._plans = planner.plans(grounded, np.random.default_rng(seed), self._limit, self.record)

    def __iter__(self) -> Iterator[AbstractPlan]:
        return self._plans

    @property
    def why(self) -> str:
        """Why there are no more plans, or no plan; empty where the search came to its end with some."""
        if self._grounding:
            return self._grounding
        if self.record.fault:
            return f"the planner failed: {self.record.fault}"
        return f"stopped by the {self.record.stopped_by}" if self.record.stopped_by else ""

    @property
    def remarks(self) -> list[str]:
        """What the planner's user should know, such as that astar went on for it."""
        return self.record.remarks


def abstract_plans(
    domain: Path | str | Domain | Model,
    problem: Path | str | Problem | Task,
    planner: str | Planner = "astar",
    seed: int = 0,
    timeout: float | None = None,
    loops: bool = True,
) -> AbstractPlans:
    """Return a stream of abstract plans for a PDDL problem, or for a task of a model's world.

    Plans come as they are found, none twice; take as many as you need, or give a ``timeout`` in seconds, as
    there may be infinitely many. Without ``loops`` only those that visit no abstract state twice. Raises
    InputError for faults in the files, with file, line and column, and for unknown planners.

    >>> import bpns
    >>> from itertools import islice
    >>> model = bpns.oracle(bpns.load_environment("cover"))
    >>> for plan in islice(bpns.abstract_plans(model, model.world.task("test", 0)), 2):
    ...     print(plan)
    Pick(block0, robby), Place(block0, robby, target0)
    Pick(block1, robby), Place(block1, robby, target0), Pick(block0, robby), Place(block0, robby, target0)
    """
    chosen = planners.load(planner) if isinstance(planner, str) else planner
    known_domain, known_problem = read_pair(domain, problem)
    stream = chosen if loops else loopless(chosen)
    return AbstractPlans(stream, known_domain, known_problem, seed, timeout)


def read_pair(
    domain: Path | str | Domain | Model, problem: Path | str | Problem | Task
) -> tuple[Domain, Problem]:
    """Return domain and problem as values. Internal."""
    if isinstance(domain, Model):
        known = domain.domain
    else:
        known = domain if isinstance(domain, Domain) else read_domain(Path(domain))
    if isinstance(problem, Task):
        if not isinstance(domain, Model):
            raise InputError("a task needs a model, which knows its world: give a problem, or a model")
        return known, problem_of(domain.world.environment, problem)
    if isinstance(problem, Problem):
        return known, problem
    return known, read_problem(Path(problem), known, model_names(known))
