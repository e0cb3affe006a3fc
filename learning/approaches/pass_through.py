"""Samplers that propose actions, with no policies to learn: the ablation of the paper's appendix C.3.

Every action is a segment of its own, and all are of one skill, whose subgoal is the action. Most change no
atom, so that there is an operator without effects. Source: spec, baselines.md section 5.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from bpns.learning.approaches import Approach, Learned, Learning
from bpns.learning.data.demonstrations import Demonstration, Demonstrations
from bpns.learning.data.segmentation import Segment
from bpns.learning.data.tracking import Tracker
from bpns.learning.models.settings import SkillConfig, shared_out
from bpns.learning.networks.network import Array32
from bpns.learning.networks.policies import PassThrough
from bpns.learning.networks.samplers import discriminator_examples
from bpns.learning.operators.clustering import Member
from bpns.learning.operators.learn import OperatorData
from bpns.symbolic.errors import InputError
from bpns.symbolic.skills.environment import Environment
from bpns.symbolic.skills.skill import Label, Skill, never
from bpns.symbolic.state import Trajectory

if TYPE_CHECKING:  # torch is slow to import, and a list of approaches needs none
    from bpns.learning.models.jobs import Job

ANY_ACTION = Label("any action", ())


def learn(environment: Environment, data: Demonstrations, how: Learning) -> Learned:
    """Learn operators and samplers of actions; raises InputError where there is nothing to learn."""
    from bpns.learning.models.jobs import fits_of, sampler_of, train
    from bpns.learning.models.learn import LearnedSkill, frequent_operators

    tracker = Tracker(environment)
    by_demonstration = [_segments(tracker, one) for one in data.demonstrations]
    segments = [one for found in by_demonstration for one in found]
    if not segments:
        raise InputError(f"nothing to learn: {len(data.demonstrations)} demonstrations hold no action")
    place = {id(s): (i, j) for i, found in enumerate(by_demonstration) for j, s in enumerate(found)}
    operators = frequent_operators(segments, how.skills.min_share)
    config = shared_out(how.skills, len(operators))
    rng = np.random.default_rng(how.seed)
    jobs = [job for number in range(len(operators)) for job in _jobs(operators, number, config, rng)]
    fitted = train(jobs, len(operators), how.seed, how.workers, how.progress)
    policy = PassThrough(environment.action_low, environment.action_high)
    dimension = len(environment.action_low)
    return Learned(
        tuple(
            LearnedSkill(
                Skill(operator.operator, policy, sampler_of(dimension, own), never),
                operator,
                tuple(place[id(member.segment)] for member in operator.members),
                fits_of(own),
            )
            for operator, own in zip(operators, fitted, strict=True)
        )
    )


def _segments(tracker: Tracker, demonstration: Demonstration) -> list[Segment]:
    """Cut after every action."""
    states, actions = demonstration.trajectory.states, demonstration.trajectory.actions
    atoms = [tracker.move_to(state) for state in states]
    return [
        Segment(Trajectory(states[i : i + 2], actions[i : i + 1]), atoms[i], atoms[i + 1], ANY_ACTION)
        for i in range(len(actions))
    ]


def _jobs(
    operators: Sequence[OperatorData], number: int, config: SkillConfig, rng: np.random.Generator
) -> "list[Job]":
    """Return the networks of an operator's sampler; any other operator's actions may be negatives."""
    from bpns.learning.models.jobs import sampler_jobs

    own = operators[number]
    others = [member for other in operators if other is not own for member in other.members]
    inputs = [[1.0, *m.segment.trajectory.states[0].vector(m.objects)] for m in own.members]
    examples = discriminator_examples(own, (*own.members, *others), _actions([*own.members, *others]), rng)
    rows = np.array(inputs, np.float32), _actions(own.members)
    return list(sampler_jobs(number, rows, examples, config))


def _actions(members: Sequence[Member]) -> Array32:
    """Return the segments' actions, (B, A)."""
    return np.array([member.segment.trajectory.actions[0] for member in members], np.float32)


APPROACH = Approach(
    "Pass-through", "plans; samplers propose single actions, and no policy is learned (appendix C.3)", learn
)
