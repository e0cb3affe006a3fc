"""Samplers: a generator proposes subgoals, a discriminator rejects. Source: spec, algorithm.md section 7."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from bpns.learning.data.segmentation import Segment
from bpns.learning.networks.network import Array32, Folded, Network, Scaling
from bpns.learning.networks.policies import Changing, changing_values
from bpns.learning.operators.clustering import Member
from bpns.learning.operators.learn import OperatorData
from bpns.symbolic.state import Array, State
from bpns.symbolic.structs import Object, Variable, sort_atoms

MAX_NEGATIVES = 100_000
MAX_DRAWS = 101  # the last one is returned even if it is rejected


def subgoal_of(member: Member, changing: Changing) -> NDArray[np.float64]:
    """Return the change that a segment brought about, (D,)."""
    states = member.segment.trajectory.states
    first, last = (changing_values(s, member.objects, changing) for s in (states[0], states[-1]))
    change: NDArray[np.float64] = last - first
    return change


def generator_examples(data: OperatorData, changing: Changing) -> tuple[Array32, Array32]:
    """Return inputs (B, 1 + features) of the segments' first states and subgoals (B, D)."""
    inputs = [[1.0, *m.segment.trajectory.states[0].vector(m.objects)] for m in data.members]
    subgoals = [subgoal_of(m, changing) for m in data.members]
    return np.array(inputs, np.float32), np.array(subgoals, np.float32)


def discriminator_examples(
    data: OperatorData, members: Sequence[Member], subgoals: Array32, rng: np.random.Generator
) -> tuple[Array32, Array32] | None:
    """Return inputs (B, 1 + features + D) and labels (B, 1); None where there are no negatives.

    ``subgoals`` (M, D) are those of ``members``, of which the operator's own come first. Negatives are these
    subgoals with all objects in the operator's parameters for which the segments are no examples; where there
    are more of them than positives, a random subset of equal size is kept.
    """
    own = [m.segment.trajectory.states[0].vector(m.objects) for m in data.members]
    positives = np.hstack(
        [np.ones((len(own), 1), np.float32), np.array(own, np.float32), subgoals[: len(own)]]
    )
    others: list[tuple[int, tuple[Object, ...]]] = []  # which member, and objects that are not its own
    for number, member in enumerate(members):
        if len(others) < MAX_NEGATIVES:
            others += [(number, objects) for objects in _other_bindings(data, member.segment)]
    del others[MAX_NEGATIVES:]
    if not others:
        return None
    if len(positives) < (len(positives) + len(others)) // 2:  # rows are built only for those that are kept
        others = [others[i] for i in np.sort(rng.choice(len(others), len(positives), replace=False))]
    firsts = [member.segment.trajectory.states[0] for member in members]
    rows = [[1.0, *firsts[number].vector(objects), *subgoals[number].tolist()] for number, objects in others]
    negatives = np.array(rows, np.float32)
    labels = np.repeat(np.array([1, 0], np.float32), [len(positives), len(negatives)])
    return np.vstack([positives, negatives]), labels[:, None]


def _other_bindings(data: OperatorData, segment: Segment) -> list[tuple[Object, ...]]:
    """Return the assignments of objects to the parameters for which a segment is no example.

    That is where it lacks some of the operator's effects; its own assignment is never among them.
    """
    objects = segment.trajectory.states[0].objects
    place = {variable: number for number, variable in enumerate(data.operator.parameters)}
    wanted: list[tuple[list[int], set[tuple[Object, ...]]]] = []  # an effect's parameters, what it may be of
    for effects, happened in (
        (data.operator.add_effects, segment.add_effects),
        (data.operator.delete_effects, segment.delete_effects),
    ):
        for effect in sort_atoms(effects):
            places = [
                place[term] for term in effect.terms if isinstance(term, Variable)
            ]  # there are no others
            wanted.append((places, {a.objects for a in happened if a.predicate == effect.predicate}))
    # Compared by objects alone: grounding an operator for each of thousands of bindings takes far longer.
    return [
        binding
        for binding in product(*([o for o in objects if o.type.is_a(v.type)] for v in place))
        if not all(tuple([binding[i] for i in places]) in found for places, found in wanted)
    ]


@dataclass(frozen=True, slots=True, eq=False)
class LearnedSampler:
    """Draws from a random generator's Gaussian until the discriminator, if there is one, accepts.

    Several generators, trained from different initial weights, agree where demonstrations are dense and
    differ where they are scarce: together they admit what each alone does not know.
    """

    dimension: int  # the length D of a subgoal
    generators: tuple[Network, ...]  # last layer: D scaled means, D raw variances; empty where D is 0
    subgoals: Scaling
    discriminator: Network | None  # last layer: one logit
    folded_generators: tuple[Folded, ...]
    folded_discriminator: Folded | None

    @classmethod
    def of(
        cls,
        dimension: int,
        generators: tuple[Network, ...],
        subgoals: Scaling,
        discriminator: Network | None,
    ) -> "LearnedSampler":
        """Prepare trained networks for use."""
        folded = tuple(Folded.of(network) for network in generators)
        accepts = Folded.of(discriminator) if discriminator else None
        return cls(dimension, generators, subgoals, discriminator, folded, accepts)

    def sample(self, state: State, objects: tuple[Object, ...], rng: np.random.Generator) -> Array:
        """Return a subgoal, (D,) float32."""
        if not self.folded_generators:
            return np.zeros(0, np.float32)
        row = np.array([1.0, *state.vector(objects)])
        draws = 0
        while True:
            count = 1 if draws == 0 else MAX_DRAWS - draws  # the first is mostly good
            subgoals = self._draw(row, count, rng)
            draws += count
            if self.folded_discriminator is None:
                return np.asarray(subgoals[0])
            rows = np.hstack([np.broadcast_to(row, (count, len(row))), subgoals])
            accepted = np.flatnonzero(self.folded_discriminator(rows)[:, 0] > 0)
            if len(accepted) or draws == MAX_DRAWS:
                return np.asarray(subgoals[accepted[0] if len(accepted) else -1])

    def _draw(self, row: NDArray[np.float64], count: int, rng: np.random.Generator) -> Array:
        """Return subgoals of one generator, (count, D) float32."""
        chosen = rng.integers(len(self.folded_generators))
        output = self.folded_generators[chosen](row)
        mean, raw = output[: self.dimension], output[self.dimension :]
        variance = np.where(raw > 0, raw + 1, np.exp(np.minimum(raw, 0)))  # ELU(raw) + 1
        center = mean * self.subgoals.scale + self.subgoals.shift
        spread = np.sqrt(variance) * self.subgoals.scale
        noise = rng.standard_normal((count, self.dimension))
        return np.asarray(center + spread * noise, np.float32)
