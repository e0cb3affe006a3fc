"""Policies without subgoals, and no samplers. Source: spec, baselines.md section 1."""

from dataclasses import replace

from bpns.learning.approaches import Approach, Learned, Learning, bpns
from bpns.learning.data.demonstrations import Demonstrations
from bpns.symbolic.skills.environment import Environment


def learn(environment: Environment, data: Demonstrations, how: Learning) -> Learned:
    """Learn skills whose policies see the state alone; they get the samplers' training on top of theirs."""
    config = how.skills
    iterations = config.policy.iterations + config.generator.iterations
    shared = None
    if config.policy_iterations is not None and config.generator_iterations is not None:
        shared = config.policy_iterations + config.generator_iterations
    policy = replace(config.policy, iterations=iterations)
    config = replace(config, subgoals=False, policy=policy, policy_iterations=shared)
    return bpns.learn(environment, data, replace(how, skills=config))


APPROACH = Approach(
    "BPNS No Subgoal", "plans; policies see the state but no subgoal, so each is tried once", learn
)
