"""Ours: operators, policies that pursue subgoals, samplers that propose them. Source: spec, algorithm.md."""

from learning.approaches import Approach, Learned, Learning
from learning.demonstrations import Demonstrations
from symbolic.environment import Environment


def learn(environment: Environment, data: Demonstrations, how: Learning) -> Learned:
    """Learn skills; raises InputError where there is nothing to learn."""
    from learning.skills import learn_skills  # torch: slow to import

    return Learned(learn_skills(environment, data, how.skills, how.seed, how.workers, how.progress))


APPROACH = Approach("BPNS", "plans with learned operators, samplers and policies", learn)
