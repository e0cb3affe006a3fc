"""Demonstrations -> skills: the whole of learning, step by step."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from learning.demonstrations import Demonstrations
from learning.networks import Array32, Network, Part, Scaling
from learning.operators import OperatorData, learn_operators
from learning.parallel import parallel_map
from learning.policies import Changing, LearnedPolicy, changing_features, policy_examples
from learning.samplers import LearnedSampler, discriminator_examples, generator_examples
from learning.segmentation import segment
from learning.training import (
    Fitted,
    Loss,
    Stop,
    Training,
    binary_cross_entropy,
    fit,
    gaussian_negative_log_likelihood,
    mean_squared_error,
)
from symbolic.environment import Environment
from symbolic.errors import InputError
from symbolic.skills import Skill

DEFAULT_POLICY = Training(10_000, Stop(1000, 1e-6))
DEFAULT_GENERATOR = Training(50_000, Stop(1000, 1e-2))
DEFAULT_DISCRIMINATOR = Training(10_000, Stop(1000, 1e-3))


@dataclass(frozen=True, slots=True)
class SkillConfig:
    """The paper's settings (spec, hyperparameters.md), with two savings that cost no success.

    Training stops when a loss has settled, and a roll-out that takes far longer than any demonstration is
    given up. ``full`` switches both off: every iteration, and only the environment's roll-out limit.
    """

    min_share: float = 0.01  # of all segments, below which an operator is dropped
    patience: int | None = 5  # a roll-out may take this many times the longest segment's actions
    policy: Training = DEFAULT_POLICY
    generator: Training = DEFAULT_GENERATOR
    discriminator: Training = DEFAULT_DISCRIMINATOR

    @classmethod
    def full(cls) -> "SkillConfig":
        """Return the paper's iterations and roll-out limit."""
        discriminator = Training(10_000, Stop(5000, 0.0))
        return cls(
            patience=None,
            policy=Training(10_000),
            generator=Training(50_000),
            discriminator=discriminator,
        )


@dataclass(frozen=True, slots=True, eq=False)
class LearnedSkill:
    """A skill, the segments of its cluster and how many demonstrations these are of; loss and iterations."""

    skill: Skill
    segments: int
    demonstrations: int
    fits: dict[Part, tuple[float, int]]


@dataclass(frozen=True, slots=True, eq=False)
class _Job:
    """One network to train."""

    operator: int
    part: Part
    inputs: Array32
    targets: Array32
    scaling: Scaling
    loss: Loss
    training: Training


def learn_skills(
    environment: Environment,
    data: Demonstrations,
    config: SkillConfig,
    seed: int,
    workers: int = 1,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> tuple[LearnedSkill, ...]:
    """Learn operators, then a policy and a sampler for each; raise InputError where nothing can be learned.

    Networks are trained one after the other, or in ``workers`` processes with the same result. Batched into
    one computation, their products would cost about a tenth less (benchmarks/training.py) if they had equal
    numbers of rows and stopped together; padding costs more than that.
    """
    by_demonstration = [segment(environment, d.trajectory, d.labels) for d in data.demonstrations]
    segments = [s for found in by_demonstration for s in found]
    if not segments:
        raise InputError(f"nothing to learn: {len(data.demonstrations)} demonstrations hold no segment")
    operators = learn_operators(segments, config.min_share)
    changing = [() if operator.given else changing_features(operator) for operator in operators]
    rng = np.random.default_rng(seed)
    jobs = [
        job
        for number, (operator, features) in enumerate(zip(operators, changing, strict=True))
        if operator.given is None
        for job in _jobs(number, operator, features, config, rng)
    ]
    fitted: dict[tuple[int, Part], tuple[Fitted, Scaling]] = {}
    results = parallel_map(partial(_train, seed), jobs, workers)
    for done, (job, result) in enumerate(zip(jobs, results, strict=True), 1):
        fitted[job.operator, job.part] = result, job.scaling
        progress(done, len(jobs))
    given = {skill.name: skill for skill in environment.given_skills}
    box = environment.action_low, environment.action_high
    owner = {id(s): number for number, found in enumerate(by_demonstration) for s in found}
    learned = []
    for number, (operator, features) in enumerate(zip(operators, changing, strict=True)):
        own = {part: result for (n, part), result in fitted.items() if n == number}
        if operator.given:
            skill = Skill.of_given(operator.operator, given[operator.given], operator.arguments)
        else:
            skill = _assemble(operator, features, own, box, config.patience)
        support = len({owner[id(member.segment)] for member in operator.members})
        fits = {part: (result.loss, result.iterations) for part, (result, _) in own.items()}
        learned.append(LearnedSkill(skill, len(operator.members), support, fits))
    return tuple(learned)


def _jobs(
    number: int, operator: OperatorData, changing: Changing, config: SkillConfig, rng: np.random.Generator
) -> Iterator[_Job]:
    inputs, actions = policy_examples(operator, changing)
    scaling = Scaling.of_targets(actions)
    yield _Job(number, "policy", inputs, actions, scaling, mean_squared_error, config.policy)
    if not changing:
        return
    inputs, subgoals = generator_examples(operator, changing)
    scaling = Scaling.of_targets(subgoals)
    loss = gaussian_negative_log_likelihood
    yield _Job(number, "generator", inputs, subgoals, scaling, loss, config.generator)
    examples = discriminator_examples(operator, changing, rng)
    if examples is not None:
        labels = Scaling(np.zeros(1, np.float32), np.ones(1, np.float32))
        training = config.discriminator
        yield _Job(number, "discriminator", *examples, labels, binary_cross_entropy, training)


def _train(seed: int, job: _Job) -> Fitted:
    """Fit the columns of the targets that vary; the others are constants that need no network."""
    varying = job.scaling.varying
    if not len(varying):
        return Fitted(_constant(job), 0.0, 0)
    targets = ((job.targets - job.scaling.shift)[:, varying] / job.scaling.scale[varying]).astype(np.float32)
    heads = 2 if job.part == "generator" else 1
    fitted = fit(job.inputs, targets, job.loss, heads * len(varying), job.training, seed)
    total = job.targets.shape[1]
    rows = np.concatenate([head * total + varying for head in range(heads)])
    weights, biases = fitted.network.layers[-1]
    full_weights = np.zeros((heads * total, weights.shape[1]), np.float32)
    full_biases = np.zeros(heads * total, np.float32)
    full_weights[rows], full_biases[rows] = weights, biases
    layers = (*fitted.network.layers[:-1], (full_weights, full_biases))
    return Fitted(Network(fitted.network.inputs, layers), fitted.loss, fitted.iterations)


def _constant(job: _Job) -> Network:
    """Return a network for targets that never vary: scaled, they are zero."""
    columns, total = job.inputs.shape[1], job.targets.shape[1]
    outputs = 2 * total if job.part == "generator" else total
    layer = np.zeros((outputs, columns), np.float32), np.zeros(outputs, np.float32)
    return Network(Scaling.of(job.inputs), (layer,))


def _assemble(
    data: OperatorData,
    changing: Changing,
    fitted: dict[Part, tuple[Fitted, Scaling]],
    box: tuple[Array32, Array32],
    patience: int | None,
) -> Skill:
    """Put an operator and its networks together."""
    policy, actions = fitted["policy"]
    nothing = Scaling(np.zeros(0, np.float32), np.zeros(0, np.float32))
    generator = fitted["generator"][0].network if "generator" in fitted else None
    discriminator = fitted["discriminator"][0].network if "discriminator" in fitted else None
    subgoals = fitted["generator"][1] if "generator" in fitted else nothing
    longest = max(len(member.segment.trajectory.actions) for member in data.members)
    return Skill(
        data.operator,
        LearnedPolicy.of(changing, policy.network, actions, box),
        LearnedSampler.of(changing, generator, subgoals, discriminator),
        max_actions=None if patience is None else patience * longest,
    )
