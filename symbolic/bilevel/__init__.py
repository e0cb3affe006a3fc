"""Bilevel planning: abstract plans are found, refined in the simulator and carried out."""
