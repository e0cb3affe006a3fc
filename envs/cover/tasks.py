"""Where blocks, targets and hand regions of a task of Cover are. Source: spec, cover.md section 6."""

from itertools import pairwise

import numpy as np

from bpns.envs.cover.world import (
    BLOCK,
    BLOCK_HEIGHT,
    BLOCK_REGION,
    BLOCK_WIDTHS,
    COVERS,
    GRIPPER,
    MAX_TRIES,
    REGION_SHARE,
    TARGET,
    TARGET_REGION,
    TARGET_WIDTHS,
    TOP_Y,
)
from bpns.symbolic.state import Features, State, Task
from bpns.symbolic.structs import Object


def _sample_positions(rng: np.random.Generator) -> tuple[list[float], list[float]]:
    """Draw block and target centers that leave room for every covering placement."""
    for _ in range(MAX_TRIES):
        blocks = [rng.uniform(w / 2, 1 - w / 2) for w in BLOCK_WIDTHS]
        targets = []
        spans = []
        for width, target in zip(BLOCK_WIDTHS, TARGET_WIDTHS, strict=True):
            x = rng.uniform(width - target / 2, 1 - width + target / 2)
            targets.append(x)
            spans.append((x + target / 2 - width, x - target / 2 + width))
        spans += [(x - w / 2, x + w / 2) for x, w in zip(blocks, BLOCK_WIDTHS, strict=True)]
        spans.sort(key=lambda span: span[0])
        if all(right[0] >= left[1] for left, right in pairwise(spans)):
            return blocks, targets
    raise RuntimeError(f"no free places for blocks and targets in {MAX_TRIES} tries")


def _sample_block_region(
    rng: np.random.Generator, block: tuple[float, float], target: tuple[float, float], region: Features
) -> Features:
    """Draw a block's hand region from which its target's region can be reached; arguments are (x, width)."""
    x, width = block
    left_edge, right_edge = x - width / 2, x + width / 2
    length = REGION_SHARE * width
    for _ in range(MAX_TRIES):
        left = rng.uniform(left_edge, right_edge - length)
        right = left + length
        if right_edge - left >= target[0] + target[1] / 2 - region[1] and right - left_edge >= region[0] - (
            target[0] - target[1] / 2
        ):
            return (left - x, right - x)
    raise RuntimeError(f"no hand region for a block in {MAX_TRIES} tries")


def sample_task(rng: np.random.Generator, index: int, irrelevant: int) -> Task:
    """Draw a task with so many irrelevant blocks; the goals take turns. Source: spec, cover.md section 6."""
    blocks, targets = _sample_positions(rng)
    features: dict[Object, Features] = {Object("robby", GRIPPER): (0.0, TOP_Y, -1.0, -1.0)}
    regions = []
    for i, (x, width) in enumerate(zip(targets, TARGET_WIDTHS, strict=True)):
        length = REGION_SHARE * width
        left = rng.uniform(x - width / 2, x + width / 2 - length)
        regions.append((left, left + length))
        features[Object(f"target{i}", TARGET)] = (width, x)
        features[Object(f"target{i}-region", TARGET_REGION)] = regions[i]
    for i, (x, width) in enumerate(zip(blocks, BLOCK_WIDTHS, strict=True)):
        target = (targets[i], TARGET_WIDTHS[i])
        features[Object(f"block{i}-region", BLOCK_REGION)] = _sample_block_region(
            rng, (x, width), target, regions[i]
        )
        features[Object(f"block{i}", BLOCK)] = (BLOCK_HEIGHT, width, x, BLOCK_HEIGHT, -1.0)
    for i in range(irrelevant):
        far = (BLOCK_HEIGHT, 0.001, -100.0, BLOCK_HEIGHT, -1.0)
        features[Object(f"irrelevant-block{i}", BLOCK)] = far
    pairs = [COVERS(Object(f"block{i}", BLOCK), Object(f"target{i}", TARGET)) for i in range(2)]
    goals = ({pairs[0]}, {pairs[1]}, set(pairs))
    return Task(State.of(features), frozenset(goals[index % 3]))
