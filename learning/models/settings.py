"""How skills are learned: ours by default, or as in the paper."""

from dataclasses import dataclass, replace

from bpns.learning.networks.settings import Training

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
