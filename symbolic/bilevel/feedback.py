"""What refinement teaches the search: how likely it is that a ground operator can be refined.

Source: the direction of issue 5; variants are compared by ``benchmarks/strategies.py``.
"""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from math import inf, log

from bpns.symbolic.operators import GroundOperator
from bpns.symbolic.planners.costs import Costs, Prefix
from bpns.symbolic.structs import GroundAtom


@dataclass(slots=True)
class _Count:
    """Successes and failures of one group of ground operators."""

    successes: int = 0
    failures: int = 0

    def share(self, evidence: float, expected: float) -> float:
        """Return the share of successes, as if there had been some more attempts with the expected share."""
        if evidence == inf:
            return expected
        return (self.successes + evidence * expected) / (self.successes + self.failures + evidence)


@dataclass(frozen=True, slots=True)
class Sharing:
    """How widely an outcome counts, in pseudo-counts: what evidence of its own outweighs that of others."""

    prefix: float = 1.0  # of a step after certain others, against that step anywhere
    own: float = 1.0  # of a ground operator, against all that have the same add effects
    effects: float = 1.0  # of those, against the optimism that everything can be refined
    weight: float = 2.0  # of minus log probability against the cost of a step


@dataclass(slots=True)
class Feedback:
    """Smoothed estimates of ground operators' success, kept as penalties in ``costs``.

    An outcome counts for the ground operator after the same steps, less for it after others, and still less
    for all that do the same to the same objects (add the same atoms): what is out of reach is so wherever
    the hand comes from. What succeeds after some steps makes it no cheaper there than it is elsewhere.
    """

    operators: Sequence[GroundOperator]
    costs: Costs
    sharing: Sharing = Sharing()
    _counts: dict[Prefix | GroundOperator | frozenset[GroundAtom], _Count] = field(
        default_factory=lambda: defaultdict(_Count)
    )
    _alike: dict[frozenset[GroundAtom], list[GroundOperator]] = field(
        default_factory=lambda: defaultdict(list)
    )

    def __post_init__(self) -> None:
        for operator in self.operators:
            self._alike[_does(operator)].append(operator)

    def count(self, steps: Prefix, success: bool) -> None:
        """Count an outcome of the last of these steps; ``update`` makes it matter."""
        for group in (steps, steps[-1], _does(steps[-1])):
            count = self._counts[group]
            if success:
                count.successes += 1
            else:
                count.failures += 1

    def chance(self, operator: GroundOperator) -> float:
        """Return the estimated probability that an attempt succeeds, wherever it is made."""
        general = self._counts[_does(operator)].share(self.sharing.effects, 1.0)
        return self._counts[operator].share(self.sharing.own, general)

    def chance_after(self, steps: Prefix) -> float:
        """Return the estimated probability that the last of these steps succeeds after the others."""
        return self._counts[steps].share(self.sharing.prefix, self.chance(steps[-1]))

    def update(self, tried: Iterable[Prefix]) -> None:
        """Set the penalties of all ground operators and prefixes that the outcomes tell something about."""
        tried = list(tried)
        weight = self.sharing.weight
        for effects in dict.fromkeys(_does(steps[-1]) for steps in tried):
            for operator in self._alike[effects]:
                self.costs.set_penalty(operator, -weight * log(self.chance(operator)))
        for steps in tried:
            less = log(self.chance(steps[-1])) - log(self.chance_after(steps))
            self.costs.set_prefix_penalty(steps, max(0.0, weight * less))


def _does(operator: GroundOperator) -> frozenset[GroundAtom]:
    """Return what ground operators have in common that do the same: what they add, or else delete."""
    return operator.add_effects or operator.delete_effects
