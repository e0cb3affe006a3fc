"""Demonstrations -> skills: the whole of learning, step by step."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

import numpy as np

from bpns.learning.data.demonstrations import Demonstrations
from bpns.learning.data.segmentation import Segment, segment
from bpns.learning.networks.network import Array32, Network, Scaling, mean_of
from bpns.learning.networks.policies import Changing, LearnedPolicy, changing_features, policy_examples
from bpns.learning.networks.samplers import LearnedSampler, discriminator_examples, generator_examples
from bpns.learning.networks.training import (
    Fitted,
    Loss,
    Training,
    binary_cross_entropy,
    fit_members,
    gaussian_negative_log_likelihood,
    mean_squared_error,
)
from bpns.learning.operators.clustering import OperatorData, learn_operators
from bpns.learning.parallel import parallel_map
from bpns.symbolic.errors import InputError
from bpns.symbolic.skills.environment import Environment
from bpns.symbolic.skills.skill import Skill
from bpns.symbolic.structs import Predicate

FEW_DECAY = 0.1  # weight decay of networks that have few rows
MEMBER_SEEDS = 1_000_003  # between the seeds of networks that are alike

DEFAULT_POLICY = Training(1500, 3e-2, decay=True, held_out=0.1, batch=256, scaling="deviation")
DEFAULT_GENERATOR = Training(1200, 1e-2, decay=True, held_out=0.1, batch=512, scaling="range")
DEFAULT_DISCRIMINATOR = Training(300, 1e-2, decay=True, held_out=0.1, batch=256, scaling="deviation")


@dataclass(frozen=True, slots=True)
class SkillConfig:
    """How to learn. ``paper`` gives the paper's settings (spec, hyperparameters.md).

    By default networks are trained faster: with a high learning rate that falls, and with numbers of
    iterations that all policies and all generators share, so that learning time is bounded however many
    skills there are. And a roll-out that takes far longer than any demonstration is given up.
    """

    min_share: float = 0.01  # of all segments, below which an operator is dropped
    subgoals: bool = True  # whether policies pursue subgoals that samplers propose
    context: bool = True  # whether operators take objects that are in contact with those of their effects
    patience: int | None = 5  # a roll-out may take this many times the longest segment's actions
    policy: Training = DEFAULT_POLICY
    generator: Training = DEFAULT_GENERATOR
    discriminator: Training = DEFAULT_DISCRIMINATOR
    generators: int = 3  # of one skill
    few: int = 500  # rows; a network that has fewer is trained as follows
    few_policies: int = 4  # whose mean is the policy
    policy_iterations: int | None = 9_000  # of all policies together
    generator_iterations: int | None = 7_000  # of the generators of all skills together

    @classmethod
    def paper(cls) -> "SkillConfig":
        """Return the paper's iterations and roll-out limit."""
        return cls(
            context=False,
            patience=None,
            policy=Training(10_000),
            generator=Training(50_000),
            discriminator=Training(10_000, patience=5000),
            generators=1,
            few=0,
            policy_iterations=None,
            generator_iterations=None,
        )


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


@dataclass(frozen=True, slots=True, eq=False)
class Job:
    """One network to train."""

    operator: int
    part: str  # policy, generator, discriminator
    inputs: Array32
    targets: Array32
    scaling: Scaling
    loss: Loss
    training: Training
    members: int = 1  # alike, each with its own initial weights


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
        for job in _jobs(number, operator, features, config, rng)
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


FittedParts: TypeAlias = dict[str, tuple[Fitted, Scaling]]  # by network: policy, generator-0, ...


def train(
    jobs: Sequence[Job], operators: int, seed: int, workers: int, progress: Callable[[int, int], None]
) -> list[FittedParts]:
    """Train networks and return those of each operator, by number."""
    found: list[FittedParts] = [{} for _ in range(operators)]
    results = parallel_map(partial(_train, seed), jobs, workers)
    for done, (job, fitted) in enumerate(zip(jobs, results, strict=True), 1):
        for member, result in enumerate(fitted):
            name = f"{job.part}-{member}" if job.part == "generator" else job.part
            found[job.operator][name] = result, job.scaling
        progress(done, len(jobs))
    return found


def fits_of(fitted: FittedParts) -> dict[str, tuple[float, int]]:
    """Return loss and iterations of each network."""
    return {part: (result.loss, result.iterations) for part, (result, _) in fitted.items()}


def shared_out(config: SkillConfig, skills: int) -> SkillConfig:
    """Give every network its part of the iterations that all share."""

    def limited(training: Training, total: int | None, networks: int) -> Training:
        most = training.iterations if total is None else min(training.iterations, total // max(1, networks))
        return replace(training, iterations=max(1, most))

    return replace(
        config,
        policy=limited(config.policy, config.policy_iterations, skills),
        generator=limited(config.generator, config.generator_iterations, skills),
    )


def _jobs(
    number: int, operator: OperatorData, changing: Changing, config: SkillConfig, rng: np.random.Generator
) -> Iterator[Job]:
    inputs, actions = policy_examples(operator, changing)
    scaling = Scaling.of_targets(actions, config.policy.scaling)
    training, policies = config.policy, 1
    if len(inputs) < config.few:  # each row is needed, and a handful of rows held out would choose by chance
        training, policies = replace(training, held_out=0.0, weight_decay=FEW_DECAY), config.few_policies
    yield Job(number, "policy", inputs, actions, scaling, mean_squared_error, training, policies)
    if changing:
        rows = generator_examples(operator, changing)
        examples = discriminator_examples(operator, operator.members, rows[1], rng)
        yield from sampler_jobs(number, rows, examples, config)


def sampler_jobs(
    number: int,
    rows: tuple[Array32, Array32],
    examples: tuple[Array32, Array32] | None,
    config: SkillConfig,
) -> Iterator[Job]:
    """Yield the networks of an operator's sampler; ``examples`` are the discriminator's, if there are any."""
    inputs, subgoals = rows
    scaling = Scaling.of_targets(subgoals, config.generator.scaling)
    loss, training = gaussian_negative_log_likelihood, config.generator
    if len(inputs) < config.few:  # subgoals mostly are nearly linear, which a few rows are enough to learn
        training = replace(training, linear=True, weight_decay=FEW_DECAY)
    yield Job(number, "generator", inputs, subgoals, scaling, loss, training, config.generators)
    if examples is not None:
        labels = Scaling(np.zeros(1, np.float32), np.ones(1, np.float32))
        training = config.discriminator
        yield Job(number, "discriminator", *examples, labels, binary_cross_entropy, training)


def _train(seed: int, job: Job) -> list[Fitted]:
    """Fit the columns of the targets that vary; the others are constants that need no network."""
    varying = job.scaling.varying
    if not len(varying):
        return [Fitted(_constant(job), 0.0, 0)] * job.members
    targets = ((job.targets - job.scaling.shift)[:, varying] / job.scaling.scale[varying]).astype(np.float32)
    heads = _heads(job)
    seeds = [seed + MEMBER_SEEDS * member for member in range(job.members)]
    members = fit_members(job.inputs, targets, job.loss, heads * len(varying), job.training, seeds)
    total = job.targets.shape[1]
    rows = np.concatenate([head * total + varying for head in range(heads)])
    found = []
    for fitted in members:
        weights, biases = fitted.network.layers[-1]
        full_weights = np.zeros((heads * total, weights.shape[1]), np.float32)
        full_biases = np.zeros(heads * total, np.float32)
        full_weights[rows], full_biases[rows] = weights, biases
        layers = (*fitted.network.layers[:-1], (full_weights, full_biases))
        linear = None
        if fitted.network.linear is not None:
            linear = np.zeros((heads * total, job.inputs.shape[1]), np.float32)
            linear[rows] = fitted.network.linear
        network = Network(fitted.network.inputs, layers, linear)
        found.append(Fitted(network, fitted.loss, fitted.iterations))
    if job.part == "policy":
        return [replace(found[0], network=mean_of([one.network for one in found]))]
    return found


def _heads(job: Job) -> int:
    """Return how many outputs there are for each target: means and variances, or values."""
    return 2 if job.loss is gaussian_negative_log_likelihood else 1


def _constant(job: Job) -> Network:
    """Return a network for targets that never vary: scaled, they are zero."""
    columns, total = job.inputs.shape[1], job.targets.shape[1]
    outputs = _heads(job) * total
    layer = np.zeros((outputs, columns), np.float32), np.zeros(outputs, np.float32)
    return Network(Scaling.of(job.inputs), (layer,))


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


def sampler_of(dimension: int, fitted: FittedParts) -> LearnedSampler:
    """Put a sampler of subgoals of this dimension together."""
    nothing = Scaling(np.zeros(0, np.float32), np.zeros(0, np.float32))
    generators = tuple(result.network for part, (result, _) in fitted.items() if part.startswith("generator"))
    discriminator = fitted["discriminator"][0].network if "discriminator" in fitted else None
    subgoals = fitted["generator-0"][1] if generators else nothing
    return LearnedSampler.of(dimension, generators, subgoals, discriminator)
