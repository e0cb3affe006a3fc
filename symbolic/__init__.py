"""What is true and what follows: values, PDDL, planners, refinement."""
