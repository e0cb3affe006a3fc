"""Cutting demonstrations where contacts change. Source: spec, algorithm.md sections 2 and 3."""

from dataclasses import dataclass

from symbolic.environment import Environment, abstract
from symbolic.state import Trajectory
from symbolic.structs import GroundAtom


@dataclass(frozen=True, slots=True, eq=False)
class Segment:
    """The slice of a demonstration during which one operator happens."""

    trajectory: Trajectory
    init_atoms: frozenset[GroundAtom]
    final_atoms: frozenset[GroundAtom]

    @property
    def add_effects(self) -> frozenset[GroundAtom]:
        """The atoms that became true."""
        return self.final_atoms - self.init_atoms

    @property
    def delete_effects(self) -> frozenset[GroundAtom]:
        """The atoms that became false."""
        return self.init_atoms - self.final_atoms


def segment(environment: Environment, trajectory: Trajectory) -> list[Segment]:
    """Cut after each action that changes the contact atoms; what follows the last change is dropped."""
    atoms = [abstract(environment, state) for state in trajectory.states]
    contacts = [{a for a in at if a.predicate in environment.contact_predicates} for at in atoms]
    segments = []
    start = 0
    for end in range(1, len(atoms)):
        if contacts[end] != contacts[end - 1]:
            piece = Trajectory(trajectory.states[start : end + 1], trajectory.actions[start:end])
            segments.append(Segment(piece, atoms[start], atoms[end]))
            start = end
    return segments
