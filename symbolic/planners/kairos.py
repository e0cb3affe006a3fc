"""kairos in this process: a plan within milliseconds, not always a shortest one."""

from collections.abc import Generator, Iterator
from dataclasses import dataclass
from time import monotonic
from typing import Any

import numpy as np

from bpns.symbolic.errors import InputError
from bpns.symbolic.grounding.ground import GroundProblem
from bpns.symbolic.pddl.plan_file import parse_plan
from bpns.symbolic.pddl.rewriting.portable import Rewritten
from bpns.symbolic.planners.foreign.alternatives import one_by_one
from bpns.symbolic.planners.foreign.exchange import DeadlinePassed, PlannerFailed, Words
from bpns.symbolic.planners.foreign.program import PATIENCE
from bpns.symbolic.planners.protocol import About, AbstractPlan, Limit, SearchRecord

ABOUT = (
    About(
        "kairos",
        "one plan",
        proves=True,
        negation=True,
        equality=True,
        package="kairos-planner",
        extra="kairos",
        licence="Apache-2.0",
        note="kairos:PRESET, in process",
    ),
)


@dataclass(frozen=True, slots=True)
class Kairos:
    """Kairos with its own choice of search, or one of its presets."""

    preset: str = ""

    @property
    def name(self) -> str:
        """How to ask for this planner."""
        return f"kairos:{self.preset}" if self.preset else "kairos"

    def plans(
        self, problem: GroundProblem, rng: np.random.Generator, limit: Limit, record: SearchRecord
    ) -> Iterator[AbstractPlan]:
        """Yield kairos' plan, then others; see Planner."""
        return one_by_one(ABOUT[0], self.ask, problem, rng, limit, record)

    def ask(self, task: Rewritten, limit: Limit) -> Generator[list[Words], None, bool]:
        """Plan once; see Ask."""
        import kairos  # optional

        seconds = PATIENCE if limit.deadline is None else limit.deadline - monotonic()
        if seconds <= 0:
            raise DeadlinePassed
        make: Any = kairos.Planner  # without type hints
        options = {"search": self.preset} if self.preset else {}
        try:
            domain, problem = task.texts
            parsed = kairos.parse_problem(problem, kairos.parse_domain(domain))
            result = make().solve(parsed, anytime=False, timeout=seconds, **options)
            plan = None if result.plan is None else parse_plan(result.plan.to_string())
        except Exception as error:  # of a library that we do not know
            raise PlannerFailed(f"kairos: {type(error).__name__}: {error}") from error
        if plan is not None:
            yield [step.words for step in plan]
        elif result.status == kairos.Status.TIMEOUT:
            raise DeadlinePassed
        elif result.status not in (kairos.Status.UNSOLVABLE, kairos.Status.NO_PLAN_FOUND):
            raise PlannerFailed(f"kairos: {result.status}")
        return bool(result.status == kairos.Status.UNSOLVABLE)


def create(preset: str = "") -> Kairos:
    """Return the planner; raise InputError for an unknown preset, MissingPackage without kairos."""
    ABOUT[0].check_installed()
    import kairos  # optional

    presets = kairos.search_presets()
    if preset and preset not in presets:
        raise InputError(f"unknown preset 'kairos:{preset}' (have: {', '.join(presets)})")
    return Kairos(preset)
