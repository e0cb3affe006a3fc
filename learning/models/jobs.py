"""The networks of skills: what each learns from, and training them, in this process or in several."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

import numpy as np

from bpns.learning.models.settings import SkillConfig
from bpns.learning.networks.losses import (
    Loss,
    binary_cross_entropy,
    gaussian_negative_log_likelihood,
    mean_squared_error,
)
from bpns.learning.networks.network import Array32, Network, Scaling, mean_of
from bpns.learning.networks.policies import Changing, policy_examples
from bpns.learning.networks.samplers import LearnedSampler, discriminator_examples, generator_examples
from bpns.learning.networks.settings import Training
from bpns.learning.networks.training import Fitted, fit_members
from bpns.learning.operators.learn import OperatorData
from bpns.learning.parallel import parallel_map

FEW_DECAY = 0.1  # weight decay of networks that have few rows
MEMBER_SEEDS = 1_000_003  # between the seeds of networks that are alike


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


def skill_jobs(
    number: int, operator: OperatorData, changing: Changing, config: SkillConfig, rng: np.random.Generator
) -> Iterator[Job]:
    """Yield the networks of a skill: its policy, and those of its sampler where there are subgoals."""
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


def sampler_of(dimension: int, fitted: FittedParts) -> LearnedSampler:
    """Put a sampler of subgoals of this dimension together."""
    nothing = Scaling(np.zeros(0, np.float32), np.zeros(0, np.float32))
    generators = tuple(result.network for part, (result, _) in fitted.items() if part.startswith("generator"))
    discriminator = fitted["discriminator"][0].network if "discriminator" in fitted else None
    subgoals = fitted["generator-0"][1] if generators else nothing
    return LearnedSampler.of(dimension, generators, subgoals, discriminator)
