"""A planner from elsewhere: its plans are checked, and its exceptions are its own fault."""

from collections.abc import Iterator
from dataclasses import dataclass
from traceback import extract_tb

import numpy as np

from bpns.symbolic.grounding.ground import GroundProblem
from bpns.symbolic.planners.foreign.exchange import PlanFilter, PlannerFailed, recorded
from bpns.symbolic.planners.protocol import AbstractPlan, Limit, Planner, SearchRecord


@dataclass(frozen=True, slots=True)
class Checked:
    """Another planner, in this process; only its own look at ``limit`` can stop it."""

    planner: Planner

    @property
    def name(self) -> str:
        """The planner's name."""
        return self.planner.name

    def plans(
        self, problem: GroundProblem, rng: np.random.Generator, limit: Limit, record: SearchRecord
    ) -> Iterator[AbstractPlan]:
        """Yield the planner's plans; see Planner."""
        passing = PlanFilter(problem, record, in_order=False)
        with recorded(record):
            stream = self._stream(problem, rng, limit, record)
            for plan in stream:
                found = passing.accept([tuple(step.call[1:-1].split()) for step in plan.steps])
                if found is not None:
                    yield found

    def _stream(
        self, problem: GroundProblem, rng: np.random.Generator, limit: Limit, record: SearchRecord
    ) -> Iterator[AbstractPlan]:
        try:
            for plan in self.planner.plans(problem, rng, limit, record):
                if not isinstance(plan, AbstractPlan):
                    raise TypeError(f"it gave a {type(plan).__name__} instead of an AbstractPlan")
                yield plan
        except Exception as error:  # whatever a stranger's module does
            place = extract_tb(error.__traceback__)[-1]
            raise PlannerFailed(
                f"{self.name}: {type(error).__name__}: {error} ({place.filename}:{place.lineno})"
            ) from error
