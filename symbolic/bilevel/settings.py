"""How to search, as a user says it, and what that means in an environment."""

from dataclasses import dataclass, replace
from typing import Literal

from bpns.symbolic.bilevel.adaptive import adaptive
from bpns.symbolic.bilevel.exhaustive import exhaustive
from bpns.symbolic.bilevel.strategy import Strategy
from bpns.symbolic.errors import InputError
from bpns.symbolic.skills.environment import Budget, Environment


@dataclass(frozen=True, slots=True)
class SearchSettings:
    """How abstract plans are refined, and how much is tried. Source: spec, algorithm.md sections 8 and 9.

    ``strategy`` is "adaptive" (learns from failed refinements) or "exhaustive" (the paper's: one plan after
    the other); None chooses by ``preset``, "default" or "paper". ``plans`` and ``samples`` bound the abstract
    plans and the subgoals per step, ``samples_per_plan`` a plan's samples in the exhaustive search; None
    means no bound there, and in the exhaustive search the environment's. Raises InputError for settings that
    contradict each other.

    >>> SearchSettings(preset="paper").name
    'exhaustive'
    """

    preset: Literal["default", "paper"] = "default"
    strategy: Literal["adaptive", "exhaustive"] | None = None
    plans: int | None = None
    samples: int | None = None
    samples_per_plan: int | None = None

    def __post_init__(self) -> None:
        if self.preset not in ("default", "paper"):
            raise InputError(f"no preset '{self.preset}' (have: default, paper)")
        if self.strategy not in (None, "adaptive", "exhaustive"):
            raise InputError(f"no strategy '{self.strategy}' (have: adaptive, exhaustive)")
        if self.preset == "paper" and self.strategy == "adaptive":
            raise InputError("preset 'paper' searches exhaustively: leave it or strategy 'adaptive' out")
        if self.name == "adaptive" and self.samples_per_plan is not None:
            raise InputError("samples per plan are for strategy 'exhaustive'")
        for bound in (self.plans, self.samples, self.samples_per_plan):
            if bound is not None and bound < 1:
                raise InputError(f"a bound of {bound} plans or samples is none: give 1 or more")

    @property
    def name(self) -> Literal["adaptive", "exhaustive"]:
        """The strategy that they come to."""
        return self.strategy or ("adaptive" if self.preset == "default" else "exhaustive")

    def within(self, environment: Environment) -> tuple[Strategy, Budget]:
        """Return the strategy and the budget that it has in an environment."""
        budget = environment.budget
        if self.name == "adaptive":
            return replace(adaptive, plans=self.plans, samples=self.samples), budget
        own = replace(
            budget,
            abstract_plans=self.plans or budget.abstract_plans,
            samples_per_step=self.samples or budget.samples_per_step,
            samples_per_plan=self.samples_per_plan or budget.samples_per_plan,
        )
        return exhaustive, own
