"""Actions as plain numbers."""

from collections.abc import Sequence
from math import inf

from bpns.symbolic.state import Array


def checked(action: Array, most: Sequence[float], meaning: str) -> list[float]:
    """Return an action as Python floats: all that follows is computed in double precision.

    ``most`` is the largest absolute value of each entry; inf means any finite number. Raises ValueError
    where the action is outside this box, of another shape, or not finite. ``meaning`` names the entries.
    """
    values: list[float] = action.tolist()
    if action.shape != (len(most),) or not all(
        -bound <= value <= bound and abs(value) != inf for value, bound in zip(values, most, strict=True)
    ):
        raise ValueError(f"action {values} is not in the box ({meaning})")
    return values
