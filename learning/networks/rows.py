"""What networks are fitted to: rows that are chosen and scaled, and a linear part that is fitted first."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bpns.learning.networks.network import Array32, Network, Scaling
from bpns.learning.networks.settings import Training

PENALTIES = 10.0 ** np.arange(-9, 1)  # of linear parts, for each row


@dataclass(frozen=True, slots=True, eq=False)
class Rows:
    """What networks learn from, scaled, with the linear part that is fitted before them."""

    scaling: Scaling
    varying: NDArray[np.intp]  # the columns of inputs that do
    columns: Array32  # (C + 1, B) inputs that vary, above ones
    wanted: Array32  # (T, B) what the linear part leaves of the targets
    learned: int  # rows; those after them are held out
    size: int  # of a batch
    linear: Array32 | None  # (outputs, C)
    constant: Array32  # (outputs,) of the linear part

    @classmethod
    def of(cls, inputs: Array32, targets: Array32, outputs: int, training: Training, seed: int) -> "Rows":
        """Prepare inputs (B, C) and scaled targets (B, T) for a last layer of ``outputs`` values."""
        scaling = Scaling.of(inputs, training.scaling)
        varying = np.flatnonzero(inputs.max(axis=0) > inputs.min(axis=0))
        order, learned = _chosen_rows(len(inputs), training, seed)
        ones = np.ones((1, len(order)), np.float32)
        scaled = scaling.apply(inputs)[:, varying]
        linear = np.zeros((outputs, inputs.shape[1]), np.float32)
        constant = np.zeros(outputs, np.float32)
        if training.linear:
            wide, rows = targets.shape[1], order[:learned]
            linear[:wide, varying], constant[:wide] = _ridge(scaled[rows], targets[rows])
            targets = targets - (scaled @ linear[:wide, varying].T + constant[:wide])
        columns = np.vstack([scaled[order].T, ones])
        wanted = np.ascontiguousarray(targets[order].T)
        size = min(training.batch or learned, learned)
        return cls(
            scaling, varying, columns, wanted, learned, size, linear if training.linear else None, constant
        )

    def network(self, layers: Sequence[Array32]) -> Network:
        """Return a network of layers (out, in + 1) that takes all columns and has the linear part."""
        (weights, biases), *rest = [(layer[:, :-1].copy(), layer[:, -1].copy()) for layer in layers]
        full = np.zeros((len(weights), len(self.scaling.shift)), np.float32)
        full[:, self.varying] = weights
        found = [(full, biases), *rest]
        if self.linear is not None:
            weights, biases = found[-1]
            found[-1] = weights, biases + self.constant
        return Network(self.scaling, tuple(found), self.linear)


def _chosen_rows(count: int, training: Training, seed: int) -> tuple[NDArray[np.intp], int]:
    """Return the rows in order, and how many of them are learned from; the others are held out."""
    if not training.held_out:
        return np.arange(count), count
    order = np.random.default_rng(seed).permutation(count)
    return order, count - min(max(1, round(training.held_out * count)), count - 1)


def _ridge(inputs: Array32, targets: Array32) -> tuple[Array32, Array32]:
    """Return weights (T, C) and biases (T,) of a ridge regression on rows (B, C) and (B, T).

    Of a few penalties, the one is taken whose fit predicts each row best from all others, which is known in
    closed form (PRESS). Source: Golub, Heath and Wahba, Technometrics 1979.
    """
    wide, wanted = inputs.astype(np.float64), targets.astype(np.float64)
    center, level = wide.mean(axis=0), wanted.mean(axis=0)
    left, singular, right = np.linalg.svd(wide - center, full_matrices=False)
    parts = left.T @ (wanted - level)
    lowest, best = np.inf, np.zeros((wide.shape[1], wanted.shape[1]))
    for penalty in PENALTIES * len(wide):
        kept = singular**2 / (singular**2 + penalty)
        error = wanted - level - left @ (kept[:, None] * parts)
        influence = left**2 @ kept + 1 / len(wide)  # of each row on its own prediction
        error /= np.maximum(1 - influence, 1e-3)[:, None]
        if (error**2).mean() < lowest:
            lowest = (error**2).mean()
            best = right.T @ ((singular / (singular**2 + penalty))[:, None] * parts)
    return best.T.astype(np.float32), (level - center @ best).astype(np.float32)
