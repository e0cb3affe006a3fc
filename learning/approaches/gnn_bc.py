"""A graph network from states to actions: behavioral cloning. Source: spec, baselines.md section 4."""

from learning.approaches import Approach, Learned, Learning
from learning.demonstrations import Demonstrations
from symbolic.environment import Environment


def learn(environment: Environment, data: Demonstrations, how: Learning) -> Learned:
    """Learn the network; there are no skills."""
    from learning.approaches._graphs import cloning  # torch: slow to import

    return cloning(environment, data, how)


APPROACH = Approach(
    "GNN BC", "a graph network gives the next action; no skills, no planner", learn, skills=False
)
