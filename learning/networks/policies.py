"""Policies: subgoal and state -> action. Source: spec, algorithm.md section 6."""

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from bpns.learning.networks.network import Array32, Folded, Network, Scaling
from bpns.learning.operators.learn import OperatorData
from bpns.symbolic.skills.skill import Controller, SkillFailure
from bpns.symbolic.state import Array, State
from bpns.symbolic.structs import Object

Changing: TypeAlias = tuple[tuple[int, int], ...]  # (parameter, feature), both by number, ascending


def changing_features(data: OperatorData) -> Changing:
    """Return the features that some segment changes, of objects in the effects: what subgoals talk about."""
    found: set[tuple[int, int]] = set()
    for member in data.members:
        first, last = member.segment.trajectory.states[0], member.segment.trajectory.states[-1]
        own = member.objects[: len(member.objects) - data.context]
        for parameter, obj in enumerate(own):
            before, after = np.array(first[obj]), np.array(last[obj])
            if not np.allclose(before, after):
                found |= {(parameter, int(i)) for i in np.flatnonzero(abs(before - after) > 1e-7)}
    return tuple(sorted(found))


def changing_values(state: State, objects: tuple[Object, ...], changing: Changing) -> NDArray[np.float64]:
    """Return the changing features' values, (D,)."""
    return np.array([state[objects[parameter]][feature] for parameter, feature in changing])


def policy_examples(data: OperatorData, changing: Changing) -> tuple[Array32, Array32]:
    """Return inputs (B, 1 + features + D) and actions (B, A): one row per action of every segment.

    An input is 1, all features of the parameters' objects, and the change that is still to come.
    """
    inputs, actions = [], []
    for member in data.members:
        trajectory = member.segment.trajectory
        goal = changing_values(trajectory.states[-1], member.objects, changing)
        for state, action in zip(trajectory.states, trajectory.actions, strict=False):
            remaining = goal - changing_values(state, member.objects, changing)
            inputs.append([1.0, *state.vector(member.objects), *remaining])
            actions.append(action)
    return np.array(inputs, np.float32), np.array(actions, np.float32)


@dataclass(frozen=True, slots=True, eq=False)
class LearnedPolicy:
    """A network from features and remaining change to actions, clipped into the action box."""

    changing: Changing
    network: Network
    actions: Scaling
    low: Array  # (A,)
    high: Array  # (A,)
    folded: Folded

    @classmethod
    def of(
        cls, changing: Changing, network: Network, actions: Scaling, box: tuple[Array, Array]
    ) -> "LearnedPolicy":
        """Prepare a trained network for use; ``box`` is the lowest and the highest action."""
        return cls(changing, network, actions, *box, Folded.of(network, actions))

    def begin(self, state: State, objects: tuple[Object, ...], subgoal: Array) -> Controller:
        """Fix the absolute target at the skill's first state; see Policy."""
        first = changing_values(state, objects, self.changing).astype(np.float32)
        target = (first + subgoal).tolist()
        names = [obj.name for obj in objects]
        lows, highs = self.low.tolist(), self.high.tolist()
        wanted = [(names[p], f, t) for (p, f), t in zip(self.changing, target, strict=True)]

        def act(now: State) -> Array:
            features = now.features
            row = [1.0]
            for name in names:
                row += features[name]
            row += [goal - features[name][feature] for name, feature, goal in wanted]
            action = self.folded(np.array(row)).tolist()
            if any(a != a for a in action):
                raise SkillFailure("the policy's action is not a number")
            # A handful of numbers: plain Python clips them faster than numpy.
            return np.array(
                [min(max(a, low), high) for a, low, high in zip(action, lows, highs, strict=True)], np.float32
            )

        return act


@dataclass(frozen=True, slots=True, eq=False)
class PassThrough:
    """Takes the subgoal as its one action, clipped into the box. Source: spec, baselines.md section 5."""

    low: Array  # (A,)
    high: Array  # (A,)

    def begin(self, state: State, objects: tuple[Object, ...], subgoal: Array) -> Controller:
        """Hand the subgoal, (A,), on; see Policy."""
        left = iter([np.clip(subgoal, self.low, self.high).astype(np.float32)])
        return lambda _: next(left, None)
