"""Ours: operators, policies that pursue subgoals, samplers that propose them. Source: spec, algorithm.md."""

from bpns.learning.approaches import Approach, Learned, Learning
from bpns.learning.data.demonstrations import Demonstrations
from bpns.symbolic.skills.environment import Environment


def learn(environment: Environment, data: Demonstrations, how: Learning) -> Learned:
    """Learn skills; raises InputError where there is nothing to learn."""
    from bpns.learning.models.learn import learn_skills  # torch: slow to import

    return Learned(learn_skills(environment, data, how.skills, how.seed, how.workers, how.progress))


APPROACH = Approach("BPNS", "plans with learned operators, samplers and policies", learn)
