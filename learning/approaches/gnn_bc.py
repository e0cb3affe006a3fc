"""A graph network from states to actions: behavioral cloning. Source: spec, baselines.md section 4."""

from bpns.learning.approaches import Approach, Learned, Learning
from bpns.learning.data.demonstrations import Demonstrations
from bpns.symbolic.skills.environment import Environment


def learn(environment: Environment, data: Demonstrations, how: Learning) -> Learned:
    """Learn the network; there are no skills."""
    from bpns.learning.graphs.learning import cloning  # torch: slow to import

    return cloning(environment, data, how)


APPROACH = Approach(
    "GNN BC", "a graph network gives the next action; no skills, no planner", learn, skills=False
)
