"""Grounding: lifted operators and objects to ground operators, and a problem as numbered atoms."""
