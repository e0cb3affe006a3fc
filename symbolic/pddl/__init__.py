"""PDDL text in and out."""
