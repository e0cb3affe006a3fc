"""Planners that are not ours: their processes, their PDDL, and what comes back from them."""
