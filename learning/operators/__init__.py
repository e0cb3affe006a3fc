"""Operators from segments.

Read ``learn``, which says what is learned; then its steps in turn: ``clustering`` (segments with the same
effects, but for the objects), ``context`` (more parameters) and ``preconditions``.
"""
