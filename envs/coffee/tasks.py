"""Where things are at the start of a task of Coffee. Source: spec, coffee.md section 6."""

from math import pi

import numpy as np

from bpns.envs.coffee.world import CUP, CUP_FILLED, GRIPPER, OPEN, PLATE, POT, WORLD, X, Y
from bpns.symbolic.state import Features, State, Task
from bpns.symbolic.structs import Object

START: Features = (5.0, 5.0, WORLD, 0.0, 0.0, OPEN)  # of the gripper
MAX_START_ROTATION = 2 * pi / 3
POT_BOX, CUP_BOX = ((8.0, 9.0), (2.4, 4.6)), ((0.74, 6.76), (2.4, 4.6))  # bounds of x, of y
CUP_SPACING = 2 * 0.74
CAPACITIES, TARGET_SHARE = (0.75, 1.5), 0.75
TRIES_PER_CUP = 10
SETS_PER_SPACING, SHRINKING = 100, 0.95


def _sample_set(count: int, spacing: float, rng: np.random.Generator) -> list[Features]:
    """Draw places and capacities; the list ends early where a cup finds no place."""
    cups: list[Features] = []
    for _ in range(count):
        for _ in range(TRIES_PER_CUP):
            x, y = (rng.uniform(low, high) for low, high in CUP_BOX)
            if all((x - c[X]) ** 2 + (y - c[Y]) ** 2 >= spacing**2 for c in cups):
                capacity = rng.uniform(*CAPACITIES)
                cups.append((x, y, capacity, TARGET_SHARE * capacity, 0.0))
                break
        else:
            break
    return cups


def _sample_cups(count: int, rng: np.random.Generator) -> list[Features]:
    """Draw sets of cups until one is complete, with less spacing whenever many sets were not.

    The paper has one spacing and up to 3 cups; of more than 6 hardly any set would ever be complete.
    """
    spacing = CUP_SPACING
    while True:
        for _ in range(SETS_PER_SPACING):
            if len(cups := _sample_set(count, spacing, rng)) == count:
                return cups
        spacing *= SHRINKING


def sample_task(rng: np.random.Generator, counts: tuple[int, ...]) -> Task:
    """Draw a task with one of these numbers of cups: fill all. Source: spec, coffee.md section 6."""
    count = int(rng.choice(counts))
    cups = {Object(f"cup{i}", CUP): cup for i, cup in enumerate(_sample_cups(count, rng))}
    x, y = (rng.uniform(low, high) for low, high in POT_BOX)
    rotation = rng.uniform(-MAX_START_ROTATION, MAX_START_ROTATION)
    features: dict[Object, Features] = {
        **cups,
        Object("robby", GRIPPER): START,
        Object("pot", POT): (x, y, rotation, 0.0, 0.0),
        Object("plate", PLATE): (0.0,),
    }
    return Task(State.of(features), frozenset(CUP_FILLED(cup) for cup in cups))
