"""Abstract states along demonstrations, against those made from scratch."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pytest

from bpns import envs
from bpns.learning.data.demonstrations import collect
from bpns.learning.data.tracking import Tracker
from bpns.symbolic.skills.environment import Classifier, abstract
from bpns.symbolic.state import State
from bpns.symbolic.structs import Object, Predicate


@pytest.mark.parametrize("name", ["cover", "doors", "stick_button", "coffee"])
def test_the_same_atoms_as_from_scratch(name: str) -> None:
    """In order, back and forth, and from task to task."""
    environment = envs.load(name)
    rng = np.random.default_rng(5)
    tracker = Tracker(environment)
    for demonstration in collect(environment, 3, seed=50_300).demonstrations:
        states = list(demonstration.trajectory.states)
        jumps = [states[i] for i in rng.integers(len(states), size=20)]
        for state in states + jumps:
            assert tracker.move_to(state) == abstract(environment, state)


@dataclass(frozen=True)
class Counting:
    """An environment's classifiers, which note what they are asked about."""

    classifiers: Mapping[Predicate, Classifier]

    @classmethod
    def of(cls, classifiers: Mapping[Predicate, Classifier], asked: list[tuple[Object, ...]]) -> "Counting":
        def noting(classifier: Classifier) -> Classifier:
            def note(state: State, objects: tuple[Object, ...]) -> bool:
                asked.append(objects)
                return classifier(state, objects)

            return note

        return cls({predicate: noting(classifier) for predicate, classifier in classifiers.items()})


def test_classifiers_are_asked_about_what_changed_only() -> None:
    environment = envs.load("doors")
    asked: list[tuple[Object, ...]] = []
    (demonstration,) = collect(environment, 1, seed=50_300).demonstrations
    tracker = Tracker(Counting.of(environment.classifiers, asked))  # type: ignore[arg-type]
    first, second = demonstration.trajectory.states[:2]
    tracker.move_to(first)
    everything = len(asked)
    tracker.move_to(first)
    assert len(asked) == everything
    tracker.move_to(second)  # the robot moved, and nothing else
    again = asked[everything:]
    assert again
    assert all(any(o.type.name == "robot" for o in objects) for objects in again)
