"""Demonstrations -> skills: the whole of learning, step by step."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from bpns.learning.data.demonstrations import Demonstrations
from bpns.learning.data.segmentation import Segment, segment
from bpns.learning.models.jobs import FittedParts, fits_of, sampler_of, skill_jobs, train
from bpns.learning.models.settings import SkillConfig, shared_out
from bpns.learning.networks.network import Array32
from bpns.learning.networks.policies import Changing, LearnedPolicy, changing_features
from bpns.learning.operators.learn import OperatorData, learn_operators
from bpns.symbolic.errors import InputError
from bpns.symbolic.skills.environment import Environment
from bpns.symbolic.skills.skill import Skill
from bpns.symbolic.structs import Predicate


@dataclass(frozen=True, slots=True, eq=False)
class LearnedSkill:
    """A skill, what it was learned from, and its networks' losses and iterations."""

    skill: Skill
    data: OperatorData
    places: tuple[tuple[int, int], ...]  # of the members: the number of the demonstration, of the segment
    fits: dict[str, tuple[float, int]]  # by network

    @property
    def segments(self) -> int:
        """How many segments it was learned from."""
        return len(self.places)

    @property
    def demonstrations(self) -> int:
        """How many demonstrations these are of."""
        return len({demonstration for demonstration, _ in self.places})


def learn_skills(
    environment: Environment,
    data: Demonstrations,
    config: SkillConfig,
    seed: int,
    workers: int = 1,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> tuple[LearnedSkill, ...]:
    """Learn operators, then a policy and a sampler for each; raise InputError where nothing can be learned.

    The generators of a skill, which learn from the same rows, are trained in one computation; all else one
    after the other, or in ``workers`` processes with the same result.
    """
    by_demonstration = [segment(environment, d.trajectory, d.labels) for d in data.demonstrations]
    segments = [s for found in by_demonstration for s in found]
    if not segments:
        raise InputError(f"nothing to learn: {len(data.demonstrations)} demonstrations hold no segment")
    contacts = environment.contact_predicates if config.context else frozenset()
    operators = frequent_operators(segments, config.min_share, contacts)
    changing = [
        () if operator.given or not config.subgoals else changing_features(operator) for operator in operators
    ]
    config = shared_out(config, sum(operator.given is None for operator in operators))
    rng = np.random.default_rng(seed)
    jobs = [
        job
        for number, (operator, features) in enumerate(zip(operators, changing, strict=True))
        if operator.given is None
        for job in skill_jobs(number, operator, features, config, rng)
    ]
    fitted = train(jobs, len(operators), seed, workers, progress)
    given = {skill.name: skill for skill in environment.given_skills}
    box = environment.action_low, environment.action_high
    place = {id(s): (i, j) for i, found in enumerate(by_demonstration) for j, s in enumerate(found)}
    learned = []
    for operator, features, own in zip(operators, changing, fitted, strict=True):
        if operator.given:
            skill = Skill.of_given(operator.operator, given[operator.given], operator.arguments)
        else:
            skill = _assemble(operator, features, own, box, config.patience)
        places = tuple(place[id(member.segment)] for member in operator.members)
        learned.append(LearnedSkill(skill, operator, places, fits_of(own)))
    return tuple(learned)


def frequent_operators(
    segments: Sequence[Segment], min_share: float, contacts: frozenset[Predicate] = frozenset()
) -> list[OperatorData]:
    """Return the operators; raise InputError where the filter leaves none."""
    operators = learn_operators(segments, min_share, contacts)
    if not operators:
        raise InputError(
            f"no operator has {min_share:.0%} of the {len(segments)} segments: choose a lower --min-share"
        )
    return operators


def _assemble(
    data: OperatorData,
    changing: Changing,
    fitted: FittedParts,
    box: tuple[Array32, Array32],
    patience: int | None,
) -> Skill:
    """Put an operator and its networks together."""
    policy, actions = fitted["policy"]
    longest = max(len(member.segment.trajectory.actions) for member in data.members)
    return Skill(
        data.operator,
        LearnedPolicy.of(changing, policy.network, actions, box),
        sampler_of(len(changing), fitted),
        max_actions=None if patience is None else patience * longest,
    )
