"""The paper's graph-network approaches: they act without a planner.

Read ``graph`` (a state with its atoms and a goal as a graph), ``network`` (numpy) and ``reactive`` (acting
with one). ``learning`` makes the examples and ``training`` fits them, with torch; ``saved`` is a graph
network's part of a model folder.
"""
