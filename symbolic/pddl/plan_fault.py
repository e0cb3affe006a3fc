"""The first fault of a plan, in words."""

from collections.abc import Sequence

from bpns.symbolic.operators import GroundOperator, Problem
from bpns.symbolic.structs import sort_atoms


def first_fault(problem: Problem, steps: Sequence[GroundOperator]) -> str:
    """Say what is wrong with a plan: a step that is not applicable, or a goal not reached; empty if valid."""
    atoms = problem.init
    for number, step in enumerate(steps, 1):
        missing = sort_atoms(step.preconditions - atoms)
        present = sort_atoms(step.negative_preconditions & atoms)
        if missing or present:
            faults = [f"needs {a}" for a in missing] + [f"needs not {a}" for a in present]
            return f"step {number} {step}: {', '.join(faults)}"
        atoms = step.apply(atoms)
    missing, present = sort_atoms(problem.goal - atoms), sort_atoms(problem.negative_goal & atoms)
    if missing or present:
        return "goal not reached: " + ", ".join([str(a) for a in missing] + [f"not {a}" for a in present])
    return ""
