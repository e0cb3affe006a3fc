"""Every engine of unified-planning: ``up:fast-downward``, ``up:symk-opt``, ``up:enhsp``, ...

Unified-planning takes seconds to import, and engines run programs and threads of their own: all that happens
in a process apart, which is kept from problem to problem.
"""

from collections.abc import Generator, Iterator
from dataclasses import dataclass
from difflib import get_close_matches
from time import monotonic
from typing import Any

import numpy as np

from bpns.symbolic.errors import InputError
from bpns.symbolic.grounding.ground import GroundProblem
from bpns.symbolic.pddl.rewriting.portable import Rewritten
from bpns.symbolic.planners.foreign.alternatives import more_and_more, one_by_one
from bpns.symbolic.planners.foreign.apart import Apart
from bpns.symbolic.planners.foreign.exchange import DeadlinePassed, PlannerFailed, Words
from bpns.symbolic.planners.protocol import About, AbstractPlan, Limit, SearchRecord


def _engine(name: str, package: str, licence: str, **abilities: Any) -> About:
    common = {"gives": "one plan", "extra": "up", "negation": True, "equality": True}
    return About(f"up:{name}", package=package, licence=licence, **{**common, **abilities})


ABOUT = (
    _engine("fast-downward", "up-fast-downward", "GPL-3.0", proves=True),
    _engine("fast-downward-opt", "up-fast-downward", "GPL-3.0", optimal=True, proves=True),
    _engine("symk", "up-symk", "GPL-3.0", gives="stream", optimal=True, proves=True),
    _engine("symk-opt", "up-symk", "GPL-3.0", gives="stream", optimal=True, note="shortest plans only"),
    _engine("enhsp", "up-enhsp", "GPL", extra="planners", proves=True, note="needs Java 17"),
    _engine(
        "enhsp-opt", "up-enhsp", "GPL", extra="planners", optimal=True, proves=True, note="needs Java 17"
    ),
    _engine("aries", "up-aries", "MIT", extra="planners", note="searches on for ever where nothing is left"),
    _engine(
        "tamer", "up-tamer", "free for education", extra="tamer", typing=False, note="knows no time limit"
    ),
    _engine("kairos", "up-kairos", "Apache-2.0", proves=True),
    _engine("pyperplan", "up-pyperplan", "GPL-3.0", extra="planners", negation=False, equality=False),
    _engine(
        "pyperplan-opt",
        "up-pyperplan",
        "GPL-3.0",
        extra="planners",
        optimal=True,
        negation=False,
        equality=False,
    ),
)
FIRST = 100  # plans; unified-planning reads on for all of them, even when nobody waits for them any more


@dataclass(frozen=True, slots=True)
class UnifiedPlanning:
    """One of unified-planning's engines; to be used within Apart."""

    engine: str
    about: About

    @property
    def name(self) -> str:
        """How to ask for this planner."""
        return f"up:{self.engine}"

    def plans(
        self, problem: GroundProblem, rng: np.random.Generator, limit: Limit, record: SearchRecord
    ) -> Iterator[AbstractPlan]:
        """Yield the engine's plans, then others; see Planner."""
        if self.about.gives == "stream":
            return more_and_more(self.about, self.ask_for, FIRST, problem, rng, limit, record)
        return one_by_one(self.about, self.ask, problem, rng, limit, record)

    def ask(self, task: Rewritten, limit: Limit) -> Generator[list[Words], None, bool]:
        """Let the engine plan once; see Ask."""
        from unified_planning.engines import PlanGenerationResultStatus as Status
        from unified_planning.shortcuts import OneshotPlanner

        built = _built(task, self.engine)
        with OneshotPlanner(name=self.engine) as engine:
            result = engine.solve(built, timeout=_seconds(limit))
        if result.plan is not None:
            yield _words(result.plan)
        elif result.status == Status.TIMEOUT:
            raise DeadlinePassed
        elif result.status not in (Status.UNSOLVABLE_PROVEN, Status.UNSOLVABLE_INCOMPLETELY):
            said = " ".join(m.message for m in result.log_messages or [])[-200:]
            raise PlannerFailed(f"{self.name}: {result.status.name}: {said}")
        return bool(result.status == Status.UNSOLVABLE_PROVEN)

    def ask_for(self, task: Rewritten, number: int, limit: Limit) -> Generator[list[Words], None, bool]:
        """Let the engine give many plans as it finds them; see AskMany."""
        from unified_planning.engines import PlanGenerationResultStatus as Status
        from unified_planning.shortcuts import AnytimePlanner

        built, status = _built(task, self.engine), Status.INTERMEDIATE
        with AnytimePlanner(name=self.engine, params={"number_of_plans": number}) as engine:
            for result in engine.get_solutions(built, timeout=_seconds(limit)):
                status = result.status
                if status == Status.INTERMEDIATE:
                    yield _words(result.plan)
        nothing = (Status.UNSOLVABLE_PROVEN, Status.UNSOLVABLE_INCOMPLETELY)
        if status == Status.TIMEOUT:
            raise DeadlinePassed
        if status not in (Status.SOLVED_SATISFICING, Status.SOLVED_OPTIMALLY, *nothing):
            raise PlannerFailed(f"{self.name}: {status.name}")
        return self.about.proves and status in nothing


def _built(task: Rewritten, engine: str) -> Any:
    from unified_planning.environment import get_environment

    from bpns.symbolic.planners.foreign.up_problem import up_problem

    environment = get_environment()
    environment.credits_stream = None
    if "kairos" not in environment.factory.engines:
        try:
            import up_kairos
        except ImportError:
            pass
        else:
            up_kairos.register()
    if engine not in environment.factory.engines:
        have = ", ".join(environment.factory.engines)
        raise PlannerFailed(f"unified-planning has no engine '{engine}' (have: {have})")
    return up_problem(task)


def _seconds(limit: Limit) -> float | None:
    if limit.late:
        raise DeadlinePassed
    return None if limit.deadline is None else limit.deadline - monotonic()


def _words(plan: Any) -> list[Words]:
    """Return a plan's steps."""
    from unified_planning.plans import PlanKind

    if plan.kind == PlanKind.SEQUENTIAL_PLAN:
        actions = plan.actions
    elif plan.kind == PlanKind.TIME_TRIGGERED_PLAN:  # aries' where there is nothing to do
        actions = [action for _, action, _ in sorted(plan.timed_actions, key=lambda timed: timed[0])]
    else:
        actions = next(iter(plan.all_sequential_plans())).actions
    return [(a.action.name.lower(), *(str(p).lower() for p in a.actual_parameters)) for a in actions]


def create(engine: str) -> Apart:
    """Return the planner; raise MissingPackage where unified-planning or a package of the engine is missing.

    Engines that are not listed here are tried too: users can register their own in unified-planning.
    """
    if not engine:
        raise InputError("planner 'up:' names no engine: see 'bpns planners'")
    known = {about.name: about for about in ABOUT}
    about = known.get(f"up:{engine}")
    if about is None:
        if close := get_close_matches(f"up:{engine}", known, 1, 0.8):
            raise InputError(f"unknown planner 'up:{engine}' (did you mean '{close[0]}'?)")
        about = About(f"up:{engine}", "one plan", package="unified-planning", extra="up", licence="?")
    About(about.name, "", package="unified-planning", extra=about.extra).check_installed()
    about.check_installed()
    return Apart(UnifiedPlanning(engine, about), about)
