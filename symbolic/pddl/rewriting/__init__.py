"""One PDDL into another: for planners that lack something, and without plans that are known."""
