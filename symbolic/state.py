"""The continuous side: states, tasks and trajectories."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from bpns.symbolic.structs import GroundAtom, Object, Type, canonical_order, sort_atoms

Array: TypeAlias = NDArray[np.floating]
Features: TypeAlias = tuple[float, ...]


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """Every object's features as Python floats. No equality: ask ``close`` with a tolerance.

    >>> block = Object("block0", Type("block", ("x", "width")))
    >>> state = State.of({block: (0.5, 0.1)})
    >>> state[block], state.changed({"block0": (0.6, 0.1)})[block]
    ((0.5, 0.1), (0.6, 0.1))

    Features are kept by object name in tuples, not in arrays: simulators read single numbers, which is
    slow from numpy arrays.
    """

    objects: tuple[Object, ...]  # canonical order
    features: Mapping[str, Features]  # object name -> one float per feature of its type
    by_type: Mapping[str, tuple[Object, ...]]  # type name -> its objects, canonical order

    def __repr__(self) -> str:
        return f"<state of {', '.join(o.name for o in self.objects)}>"

    def __str__(self) -> str:
        """One line for each object: its name, its type and its features."""
        return "\n".join(
            f"{o.name}:{o.type.name}  "
            + "  ".join(f"{name} {value:g}" for name, value in zip(o.type.features, self[o], strict=True))
            for o in self.objects
        )

    @classmethod
    def of(cls, features: Mapping[Object, Iterable[float]]) -> "State":
        """Build a state, checking the number of features; raise ValueError where it is wrong."""
        objects = canonical_order(features)
        values = {o.name: tuple(float(v) for v in features[o]) for o in objects}
        for obj in objects:
            if len(values[obj.name]) != len(obj.type.features):
                raise ValueError(
                    f"{obj.name} has {len(values[obj.name])} features, "
                    f"but a {obj.type.name} has {len(obj.type.features)}"
                )
        types = {o.type.name for o in objects}
        return cls(objects, values, {t: tuple(o for o in objects if o.type.name == t) for t in types})

    def __getitem__(self, obj: Object) -> Features:
        return self.features[obj.name]

    def of_type(self, type_: Type) -> tuple[Object, ...]:
        """Return the objects of a type or one derived from it, in canonical order."""
        found = [objects for objects in self.by_type.values() if objects[0].type.is_a(type_)]
        return found[0] if len(found) == 1 else canonical_order(o for objects in found for o in objects)

    def changed(self, changes: Mapping[str, Features]) -> "State":
        """Return a copy in which the named objects have other features."""
        return State(self.objects, {**self.features, **changes}, self.by_type)

    def vector(self, objects: Iterable[Object]) -> list[float]:
        """Return the features of the objects, one after the other."""
        return [value for obj in objects for value in self.features[obj.name]]

    def close(self, other: "State") -> bool:
        """Say whether all features agree within 1e-3 plus 1e-5 of the other's value (the stuck test)."""
        for name, values in self.features.items():
            others = other.features[name]
            if values is not others:  # what a step leaves alone is the same tuple
                for a, b in zip(values, others, strict=True):
                    if not abs(a - b) <= 1e-3 + 1e-5 * abs(b):
                        return False
        return True


@dataclass(frozen=True, slots=True, eq=False)
class Task:
    """An initial state and the ground atoms that must hold in the end.

    ``World.task`` draws one, ``World.own_task`` makes one of text.

    >>> Task(State.of({Object("block0", Type("block", ("x",))): (0.5,)}), frozenset())
    <task: ; 1 objects>
    """

    init: State
    goal: frozenset[GroundAtom]

    def __repr__(self) -> str:
        return f"<task: {', '.join(map(str, sort_atoms(self.goal)))}; {len(self.init.objects)} objects>"


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """States and the actions between them: one more state than actions.

    Raises ValueError where the numbers do not fit.

    >>> Trajectory((State.of({}),), ())
    <trajectory of 0 actions>
    """

    states: tuple[State, ...]
    actions: tuple[Array, ...]  # each (A,) float32

    def __post_init__(self) -> None:
        if len(self.states) != len(self.actions) + 1:
            raise ValueError(f"{len(self.states)} states do not fit {len(self.actions)} actions")

    def __repr__(self) -> str:
        return f"<trajectory of {len(self.actions)} actions>"
