"""GNN Meta with skills that have no subgoals. Source: spec, baselines.md section 3."""

from bpns.learning.approaches import Approach, Learned, Learning, no_subgoal
from bpns.learning.data.demonstrations import Demonstrations
from bpns.symbolic.skills.environment import Environment


def learn(environment: Environment, data: Demonstrations, how: Learning) -> Learned:
    """Learn skills without subgoals, then the network that chooses."""
    from bpns.learning.graphs.learning import metacontroller  # torch: slow to import

    return metacontroller(data, no_subgoal.learn(environment, data, how), how)


APPROACH = Approach(
    "GNN Meta No Subgoal", "a graph network chooses the next skill, of those without subgoals", learn
)
