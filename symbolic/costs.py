"""Costs of ground operators that can change while plans are taken from a planner."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import isfinite
from typing import TypeAlias, TypeVar

from symbolic.structs import GroundOperator

_GRAIN = 2.0**-16  # sums of multiples of it are exact, whatever their order
_MOST = 2.0**30

Prefix: TypeAlias = tuple[GroundOperator, ...]
_Key = TypeVar("_Key", GroundOperator, Prefix)


@dataclass(slots=True)
class _Branching:
    """The penalty of a prefix, and the longer ones."""

    penalty: float = 0.0
    next: dict[GroundOperator, "_Branching"] = field(default_factory=dict)


class Costs:
    """Every ground operator costs one plus its penalty, which is 0 until it is set.

    A prefix, the first steps of plans, can have a penalty too: all plans that begin so and go on cost that
    much more.
    A search that is asked for its next plan looks at ``version`` and at what changed since.
    """

    def __init__(self) -> None:
        self._penalties: dict[GroundOperator, float] = {}
        self._prefixes: dict[Prefix, float] = {}
        self._tree = _Branching()
        self._changes: list[GroundOperator | Prefix] = []

    @property
    def version(self) -> int:
        """A number that grows with every change."""
        return len(self._changes)

    def of(self, operator: GroundOperator) -> float:
        """Return what a ground operator costs now, prefixes aside."""
        return 1 + self._penalties.get(operator, 0.0)

    def of_prefix(self, steps: Prefix) -> float:
        """Return the penalty of exactly this prefix."""
        return self._prefixes.get(steps, 0.0)

    def of_plan(self, steps: Sequence[GroundOperator]) -> float:
        """Return what a plan costs now."""
        total = sum(map(self.of, steps))
        node = self._tree
        for step in steps[:-1]:
            following = node.next.get(step)
            if following is None:
                break
            node = following
            total += node.penalty
        return total

    def set_penalty(self, operator: GroundOperator, value: float) -> None:
        """Set a penalty, rounded to a multiple of 1/65536, so that equal plans cost exactly the same.

        Raises ValueError unless it is between 0 and 2^30.
        """
        self._set(self._penalties, operator, value)

    def set_prefix_penalty(self, steps: Prefix, value: float) -> None:
        """Set the penalty of all longer plans that begin with these steps, as ``set_penalty`` does."""
        if not steps:
            raise ValueError("a prefix has at least one step")
        self._set(self._prefixes, steps, value)
        node = self._tree
        for step in steps:
            node = node.next.setdefault(step, _Branching())
        node.penalty = self._prefixes.get(steps, 0.0)

    def _set(self, penalties: dict[_Key, float], key: _Key, value: float) -> None:
        if not (isfinite(value) and 0 <= value <= _MOST):
            raise ValueError(f"penalty of {_text(key)}: {value} is not a number from 0 to 2^30")
        rounded = round(value / _GRAIN) * _GRAIN
        if rounded != penalties.get(key, 0.0):
            penalties[key] = rounded
            self._changes.append(key)

    def changed_since(self, version: int) -> Sequence[GroundOperator]:
        """Return the operators that were changed after a version, in order; some more than once."""
        return [one for one in self._changes[version:] if not isinstance(one, tuple)]

    def prefixes_changed_since(self, version: int) -> Sequence[Prefix]:
        """Return the prefixes that were changed after a version, in order; some more than once."""
        return [one for one in self._changes[version:] if isinstance(one, tuple)]


def _text(key: GroundOperator | Prefix) -> str:
    return " ".join(map(str, key)) if isinstance(key, tuple) else str(key)
