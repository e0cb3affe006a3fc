"""Several planners on one problem: how soon the first plan and the first N plans are there."""

from dataclasses import dataclass
from itertools import islice
from time import monotonic

import numpy as np

from symbolic.grounding import GroundProblem
from symbolic.planners import AbstractPlan, Limit, Planner, SearchRecord


@dataclass(frozen=True, slots=True)
class Enumeration:
    """The first plans of a planner for a problem."""

    plans: tuple[AbstractPlan, ...]
    first_seconds: float | None  # None without a plan
    seconds: float  # until the last plan, or the end
    record: SearchRecord

    @property
    def ended(self) -> str:
        """Why there are no more plans, where somebody asked for more; empty where nothing went wrong."""
        return self.record.fault or self.record.stopped_by


def first_plans(planner: Planner, problem: GroundProblem, count: int, seed: int, limit: Limit) -> Enumeration:
    """Take a planner's first plans."""
    start, record = monotonic(), SearchRecord()
    stream = planner.plans(problem, np.random.default_rng(seed), limit, record)
    found, first = [], None
    for plan in islice(stream, count):
        first = first or monotonic() - start
        found.append(plan)
    return Enumeration(tuple(found), first, monotonic() - start, record)
