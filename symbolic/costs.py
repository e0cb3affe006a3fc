"""Costs of ground operators that can change while plans are taken from a planner."""

from collections.abc import Iterable, Sequence
from math import isfinite

from symbolic.structs import GroundOperator

_GRAIN = 2.0**-16  # sums of multiples of it are exact, whatever their order
_MOST = 2.0**30


class Costs:
    """Every ground operator costs one plus its penalty, which is 0 until it is set.

    A search that is asked for its next plan looks at ``version`` and ``changed_since``.
    """

    def __init__(self) -> None:
        self._penalties: dict[GroundOperator, float] = {}
        self._changes: list[GroundOperator] = []

    @property
    def version(self) -> int:
        """A number that grows with every change."""
        return len(self._changes)

    def of(self, operator: GroundOperator) -> float:
        """Return what a ground operator costs now."""
        return 1 + self._penalties.get(operator, 0.0)

    def of_plan(self, steps: Iterable[GroundOperator]) -> float:
        """Return what a sequence of ground operators costs now."""
        return sum(self.of(step) for step in steps)

    def set_penalty(self, operator: GroundOperator, value: float) -> None:
        """Set a penalty, rounded to a multiple of 1/65536, so that equal plans cost exactly the same.

        Raises ValueError unless it is between 0 and 2^30.
        """
        if not (isfinite(value) and 0 <= value <= _MOST):
            raise ValueError(f"penalty of {operator}: {value} is not a number from 0 to 2^30")
        rounded = round(value / _GRAIN) * _GRAIN
        if rounded != self._penalties.get(operator, 0.0):
            self._penalties[operator] = rounded
            self._changes.append(operator)

    def changed_since(self, version: int) -> Sequence[GroundOperator]:
        """Return the operators that were changed after a version, in order; some more than once."""
        return self._changes[version:]
