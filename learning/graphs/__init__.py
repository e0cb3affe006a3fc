"""The paper's graph-network approaches: they act without a planner."""
