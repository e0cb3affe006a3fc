"""Our strategy: try the most promising abstract plan a little, learn from what fails, and choose again.

Chances are estimated as refinements succeed and fail (``feedback``), and are the costs by which the planner
chooses its next plan. A plan that failed waits until it is the most promising again, and then it may fail
more often than before: no plan is ever given up. What was reached is kept in a tree, so that plans that begin
alike share it.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from bpns.symbolic.bilevel.candidates import Candidate, Outcomes, Reached
from bpns.symbolic.bilevel.feedback import Feedback, Sharing
from bpns.symbolic.bilevel.refinement import DeadEnd, RefinedStep, carry_out
from bpns.symbolic.bilevel.strategy import Refined, TaskSearch
from bpns.symbolic.planners.costs import Costs, Prefix
from bpns.symbolic.planners.protocol import AbstractPlan, CostPlanner

# Proposals for each known one, and once more, that are all known: then a sampler is taken to have no others.
# One of n that are alike is missed by so many with a chance of 1 in 20,000.
PROPOSALS = 10
MOST_IN_VAIN = 1000  # plans in a row of which nothing is left to sample, after which there is no hope
FRESH_TURNS = 4  # first visits for each return, where the planner takes no costs


@dataclass(frozen=True, slots=True)
class Adaptive:
    """Refines the abstract plans by turns, as their chances change.

    A planner that takes no costs gives its plans in its own order, and is waited for. Only samples, nodes and
    time of the budget count. ``benchmarks/strategies.py`` compares settings.
    """

    sharing: Sharing = field(default_factory=Sharing)
    tries: int = 2  # of a step from one state, before something that came before it is tried anew
    failures: int = 10  # in a plan's first visit; as many more each time it comes back
    return_cost: float = 1.0  # for every visit that a plan had, against others that are as promising
    plans: int | None = None  # at most so many abstract plans
    samples: int | None = None  # at most so many of an operator from one state

    def __call__(self, search: TaskSearch) -> Refined | None:
        """Return a plan and its refinement; see Strategy."""
        return _Visits(self, search).run()


adaptive = Adaptive()


class _Visits:
    """One task's candidates, what was reached, and what was learned."""

    def __init__(self, settings: Adaptive, search: TaskSearch) -> None:
        self.settings = settings
        self.search = search
        self.rng = np.random.default_rng(search.seed)
        self.costs = Costs()
        self.feedback = Feedback(search.problem.operators, self.costs, settings.sharing)
        self.by_cost = isinstance(search.planner, CostPlanner)
        self.returned = 0  # visits of plans that had come back
        self.root = Reached(search.task.init, 0, None, None)

    def run(self) -> Refined | None:
        """Visit candidates until one is refined or nothing is left."""
        search = self.search
        stream = self._stream()
        waiting: list[Candidate] = []
        fresh: AbstractPlan | None = None
        in_vain = 0
        while not search.over and in_vain < MOST_IN_VAIN:
            more = self.settings.plans is None or search.tried < self.settings.plans
            if fresh is None and stream is not None and more and (self._turn or not waiting):
                fresh = next(stream, None)
                if fresh is None:
                    stream = None
            search.watch.charge("search")
            candidate = min(waiting, key=self._cost, default=None)
            if fresh is not None and (candidate is None or self._fresh_first(fresh, candidate)):
                search.tried += 1
                candidate = Candidate(fresh, search.tried, search.ground_skills(fresh))
                waiting.append(candidate)
                fresh = None
            elif candidate is not None:
                self.returned += 1
            if candidate is None:
                break
            before = search.refining.samples
            steps = self._visit(candidate)
            in_vain = in_vain + 1 if search.refining.samples == before else 0
            search.watch.charge("refinement")
            if steps is not None:
                return candidate.plan, steps
            if candidate.spent:
                waiting.remove(candidate)
        return None

    @property
    def _turn(self) -> bool:
        """Whether it is a fresh plan's turn: always, where the planner takes costs and gives the cheapest."""
        return self.by_cost or self.search.tried <= FRESH_TURNS * self.returned

    def _fresh_first(self, fresh: AbstractPlan, candidate: Candidate) -> bool:
        """Say whether a fresh plan comes before one that waits: the cheaper one, where plans come by cost."""
        return not self.by_cost or self.costs.of_plan(fresh.steps) <= self._cost(candidate)

    def _stream(self) -> Iterator[AbstractPlan] | None:
        search = self.search
        rng = np.random.default_rng(search.seed)
        if isinstance(search.planner, CostPlanner):
            return search.planner.plans_at(search.problem, rng, search.limit, search.record, self.costs)
        return search.planner.plans(search.problem, rng, search.limit, search.record)

    def _cost(self, candidate: Candidate) -> float:
        """Return what a candidate costs now, a little more after each visit."""
        return self.costs.of_plan(candidate.plan.steps) + self.settings.return_cost * candidate.visits

    def _visit(self, candidate: Candidate) -> tuple[RefinedStep, ...] | None:
        """Try a candidate until it is refined or failed too often for this visit."""
        candidate.visits += 1
        allowed = self.settings.failures * candidate.visits
        failures = here = 0  # in this visit, and of this step from this state
        tried: dict[Prefix, None] = {}
        if not candidate.skills:
            return ()
        now, step = self._start(candidate)
        while failures < allowed and not self.search.over:
            known = not candidate.can_try(now, step)
            if known:  # it failed before, and so it does for this plan
                self.feedback.count(candidate.plan.steps[: step + 1], success=False)
                tried[candidate.plan.steps[: step + 1]] = None
            if known or here >= self.settings.tries:
                back = self._back(candidate, now, step)
                if back is None:
                    candidate.spent = True
                    self._close(candidate)
                    break
                now, step = back
                here = 0
            tried[candidate.plan.steps[: step + 1]] = None
            found = self._attempt(candidate, now, step)
            if found is None:
                failures += 1
                here += 1
                continue
            now, step, here = found, step + 1, 0
            if step == len(candidate.plan.steps):
                return tuple(one.step for one in now.path() if one.step is not None)
        self.feedback.update(tried)
        return None

    def _start(self, candidate: Candidate) -> tuple[Reached, int]:
        """Return the deepest state at which the next step was not tried enough, or else the deepest."""
        level, step = [self.root], 0
        deepest, fresh = (self.root, 0), (self.root, 0)
        while True:
            untried = [one for one in level if candidate.few_tries(one, step, self.settings.tries)]
            deepest = min(level, key=_failures), step
            if untried:
                fresh = min(untried, key=_failures), step
            if step + 1 == len(candidate.skills):
                break
            operator = candidate.plan.steps[step]
            level = [r for one in level if operator in one.next for r in one.next[operator].reached]
            if not level:
                break
            step += 1
        return fresh if candidate.few_tries(*fresh, self.settings.tries) else deepest

    def _back(self, candidate: Candidate, now: Reached, step: int) -> tuple[Reached, int] | None:
        """Choose a step to be tried anew, likely one on which this one rests; None where none can be.

        Where all on the way here are used up, any other state will do that the plan's steps ever reached.
        """
        path = now.path()
        weights = np.array(
            [candidate.weight(i, step) if candidate.can_try(one, i) else 0.0 for i, one in enumerate(path)]
        )
        if not weights.any():
            left = list(self._left(candidate))
            return left[int(self.rng.integers(len(left)))] if left else None
        earlier = int(self.rng.choice(step + 1, p=weights / weights.sum()))
        return path[earlier], earlier

    def _left(self, candidate: Candidate) -> Iterator[tuple[Reached, int]]:
        """Yield the states that a candidate's steps reached from which one more try may tell something."""
        level = [self.root]
        for step, operator in enumerate(candidate.plan.steps):
            yield from ((one, step) for one in level if candidate.can_try(one, step))
            level = [r for one in level if operator in one.next for r in one.next[operator].reached]

    def _close(self, candidate: Candidate) -> None:
        """Let no plan begin like a candidate up to where nothing can lead on, whatever is tried."""
        level = [self.root]
        for step, operator in enumerate(candidate.plan.steps):
            if any(candidate.can_try(one, step) for one in level):
                return
            level = [reached for one in level for reached in one.next[operator].reached]
            if not level:
                self.costs.close(candidate.plan.steps[: step + 1])
                return

    def _attempt(self, candidate: Candidate, now: Reached, step: int) -> Reached | None:
        """Sample a subgoal and pursue it; return what it reached, None where it is a dead end."""
        skill, refining = candidate.skills[step], self.search.refining
        outcomes = now.next.setdefault(skill.operator, Outcomes())
        for _ in range(PROPOSALS * (1 + len(outcomes.subgoals))):
            subgoal = skill.skill.sampler.sample(now.state, skill.operator.objects, self.rng)
            numbers = np.asarray(subgoal).tobytes()
            if numbers not in outcomes.subgoals:
                break
        else:
            outcomes.repeats = True
            return None
        refining.samples += 1
        outcomes.subgoals.add(numbers)
        outcomes.repeats = len(outcomes.subgoals) == self.settings.samples
        expected = candidate.plan.atoms[step + 1]
        found = carry_out(self.search.environment, skill, now.state, now.actions, subgoal, expected)
        self.feedback.count(candidate.plan.steps[: step + 1], success=isinstance(found, RefinedStep))
        if isinstance(found, RefinedStep):
            used = now.actions + len(found.trajectory.actions)
            reached = Reached(found.trajectory.states[-1], used, now, found)
            outcomes.reached.append(reached)
            return reached
        outcomes.failures += 1
        for one in now.path():
            one.failures += 1
        refining.dead_ends[DeadEnd(candidate.number, step + 1, str(skill.operator), found)] += 1
        return None


def _failures(reached: Reached) -> int:
    return reached.failures
