"""Costs of ground operators that can change while plans are taken from a planner."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import inf, isfinite
from typing import TypeAlias, TypeVar

from bpns.symbolic.operators import GroundOperator

_GRAIN = 2.0**-16  # sums of multiples of it are exact, whatever their order
_MOST = 2.0**30

Prefix: TypeAlias = tuple[GroundOperator, ...]
_Key = TypeVar("_Key", GroundOperator, Prefix)


@dataclass(slots=True)
class _Branching:
    """The penalty of a prefix, whether no plan may begin so, and the longer ones."""

    penalty: float = 0.0
    closed: bool = False
    next: dict[GroundOperator, "_Branching"] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class _Closed:
    """That no plan may begin with these steps any more."""

    steps: Prefix


class Costs:
    """Every ground operator costs one plus its penalty, which is 0 until it is set.

    A prefix, the first steps of plans, can have a penalty too: all plans that begin so and go on cost that
    much more. Or it can be closed, for good: then no plan begins so.
    A search that is asked for its next plan looks at ``version`` and at what changed since.
    """

    def __init__(self) -> None:
        self._penalties: dict[GroundOperator, float] = {}
        self._prefixes: dict[Prefix, float] = {}
        self._tree = _Branching()
        self._changes: list[GroundOperator | Prefix | _Closed] = []

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
        for number, step in enumerate(steps, 1):
            following = node.next.get(step)
            if following is None:
                break
            node = following
            if node.closed:
                return inf
            total += node.penalty if number < len(steps) else 0.0
        return total

    def is_closed(self, steps: Prefix) -> bool:
        """Say whether no plan may begin with these steps."""
        node = self._tree
        for step in steps:
            following = node.next.get(step)
            if following is None:
                return False
            node = following
            if node.closed:
                return True
        return False

    def close(self, steps: Prefix) -> None:
        """Let no plan begin with these steps any more."""
        if not steps:
            raise ValueError("a prefix has at least one step")
        if not self.is_closed(steps):
            self._node(steps).closed = True
            self._changes.append(_Closed(steps))

    def set_penalty(self, operator: GroundOperator, value: float) -> None:
        """Set a penalty, rounded to a multiple of 1/65536, so that equal plans cost exactly the same.

        Raises ValueError unless it is between 0 and 2^30.
        """
        self._set(self._penalties, operator, value)

    def set_prefix_penalty(self, steps: Prefix, value: float) -> None:
        """Set the penalty of all longer plans that begin with these steps, as ``set_penalty`` does.

        Where none may, nothing changes.
        """
        if not steps:
            raise ValueError("a prefix has at least one step")
        if not self.is_closed(steps):
            self._set(self._prefixes, steps, value)
            self._node(steps).penalty = self._prefixes.get(steps, 0.0)

    def _node(self, steps: Prefix) -> _Branching:
        node = self._tree
        for step in steps:
            node = node.next.setdefault(step, _Branching())
        return node

    def _set(self, penalties: dict[_Key, float], key: _Key, value: float) -> None:
        if not (isfinite(value) and 0 <= value <= _MOST):
            raise ValueError(f"penalty of {_text(key)}: {value} is not a number from 0 to 2^30")
        rounded = round(value / _GRAIN) * _GRAIN
        if rounded != penalties.get(key, 0.0):
            penalties[key] = rounded
            self._changes.append(key)

    def changed_since(self, version: int) -> Sequence[GroundOperator]:
        """Return the operators that were changed after a version, in order; some more than once."""
        return [one for one in self._changes[version:] if isinstance(one, GroundOperator)]

    def prefixes_changed_since(self, version: int) -> Sequence[Prefix]:
        """Return the prefixes that were changed after a version, in order; some more than once."""
        return [one for one in self._changes[version:] if isinstance(one, tuple)]

    def closed_since(self, version: int) -> Sequence[Prefix]:
        """Return the prefixes that were closed after a version, in order."""
        return [one.steps for one in self._changes[version:] if isinstance(one, _Closed)]


def _text(key: GroundOperator | Prefix) -> str:
    return " ".join(map(str, key)) if isinstance(key, tuple) else str(key)
