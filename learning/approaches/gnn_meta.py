"""A graph network chooses the next skill, in place of a planner. Source: spec, baselines.md section 3."""

from bpns.learning.approaches import Approach, Learned, Learning, bpns
from bpns.learning.data.demonstrations import Demonstrations
from bpns.symbolic.skills.environment import Environment


def learn(environment: Environment, data: Demonstrations, how: Learning) -> Learned:
    """Learn skills as BPNS does, then the network that chooses."""
    from bpns.learning.graphs.learning import metacontroller  # torch: slow to import

    return metacontroller(data, bpns.learn(environment, data, how), how)


APPROACH = Approach("GNN Meta", "a graph network chooses the next skill; no planner", learn)
