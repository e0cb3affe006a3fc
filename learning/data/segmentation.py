"""Cutting demonstrations where contacts change. Source: spec, algorithm.md sections 2 and 3."""

from collections.abc import Sequence
from dataclasses import dataclass

from bpns.learning.data.tracking import Tracker
from bpns.symbolic.skills.environment import Environment, abstract
from bpns.symbolic.skills.skill import Label
from bpns.symbolic.state import Trajectory
from bpns.symbolic.structs import GroundAtom


@dataclass(frozen=True, slots=True, eq=False)
class Segment:
    """The slice of a demonstration during which one operator happens."""

    trajectory: Trajectory
    init_atoms: frozenset[GroundAtom]
    final_atoms: frozenset[GroundAtom]
    label: Label | None = None  # of its last action: the given skill, if it was one

    @property
    def add_effects(self) -> frozenset[GroundAtom]:
        """The atoms that became true."""
        return self.final_atoms - self.init_atoms

    @property
    def delete_effects(self) -> frozenset[GroundAtom]:
        """The atoms that became false."""
        return self.init_atoms - self.final_atoms


def segment(
    environment: Environment, trajectory: Trajectory, labels: Sequence[Label | None]
) -> list[Segment]:
    """Cut after each action that changes the contact atoms; what follows the last change is dropped.

    ``labels`` has one entry per action. Other atoms are asked for only where a segment begins or ends.
    """
    contacts = [abstract(environment, s, environment.contact_predicates) for s in trajectory.states]
    segments = []
    tracker = Tracker(environment)
    start, atoms = 0, tracker.move_to(trajectory.states[0])
    for end in range(1, len(contacts)):
        if contacts[end] != contacts[end - 1]:
            piece = Trajectory(trajectory.states[start : end + 1], trajectory.actions[start:end])
            final = tracker.move_to(trajectory.states[end])
            segments.append(Segment(piece, atoms, final, labels[end - 1]))
            start, atoms = end, final
    return segments
