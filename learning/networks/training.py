"""Fit networks: Adam on small multilayer perceptrons, in one place. The only user of torch.

Rows are few and layers narrow, so that autograd and allocations would cost more than the products
themselves: activations live in fixed buffers, one column per row of data, and the gradient of a loss by the
outputs comes from the loss. A row of ones below each layer's activations makes biases part of the weights.
Networks that differ only in their initial weights are fitted together, as one batched computation.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from math import cos, pi

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from bpns.learning.networks.losses import Loss
from bpns.learning.networks.network import Array32, Method, Network, Scaling
from bpns.learning.networks.perceptron import Adam, Perceptron

CHECK_EVERY = 50  # iterations: how often the loss on other rows than the batch is asked for
MAX_CHECKED = 500  # rows for that
PENALTIES = 10.0 ** np.arange(-9, 1)  # of linear parts, for each row


@dataclass(frozen=True, slots=True)
class Training:
    """How to fit one network: at most so many iterations.

    An iteration takes all rows or, of more than ``batch`` rows, that many, in a random order that is new each
    time round. With ``decay`` the learning rate falls to zero along half a cosine. With ``held_out``, that
    share of the rows is kept apart and the loss on it decides which weights are best; otherwise the training
    loss does. ``scaling`` is of inputs and targets; see Scaling. ``patience`` is after how many iterations
    without a better loss to stop. With ``linear``, a linear part is fitted first, and the network learns what
    that leaves. ``weight_decay`` shrinks the weights at each iteration, relative to the learning rate.
    """

    iterations: int
    learning_rate: float = 1e-3
    decay: bool = False
    held_out: float = 0.0
    batch: int | None = None
    scaling: Method = "paper"
    patience: int | None = None
    hidden: tuple[int, ...] = (32, 32)
    linear: bool = False
    weight_decay: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Fitted:
    """A trained network, its best loss and the iterations that it took."""

    network: Network
    loss: float
    iterations: int


@contextmanager
def fast_small_numbers() -> Iterator[None]:
    """Use one thread, since more make these sizes slower, and no denormals, where Adam's moments end up."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    torch.set_flush_denormal(True)
    try:
        yield
    finally:
        torch.set_flush_denormal(False)
        torch.set_num_threads(threads)


def fit(inputs: Array32, targets: Array32, loss: Loss, outputs: int, training: Training, seed: int) -> Fitted:
    """Fit one network; see ``fit_members``."""
    return fit_members(inputs, targets, loss, outputs, training, (seed,))[0]


@fast_small_numbers()
def fit_members(
    inputs: Array32, targets: Array32, loss: Loss, outputs: int, training: Training, seeds: Sequence[int]
) -> list[Fitted]:
    """Fit networks to scaled targets, one for each seed; of each, the weights with the lowest loss are kept.

    Shapes: inputs (B, C), targets (B, T); the networks' last layer has ``outputs`` values. Inputs are scaled
    here; columns that never vary get weight zero, as they carry nothing. The first seed chooses the rows.
    Source: spec, algorithm.md section 6.
    """
    data = _Rows.of(inputs, targets, outputs, training, seeds[0])
    layers = (*training.hidden, outputs)
    model = Perceptron(len(data.varying), data.size, layers, inputs.shape[1], seeds)
    best, lowest, iterations = _descend(model, data, loss, training, seeds)
    return [
        Fitted(data.network([view[member].numpy() for view in model.views(best)]), lowest[member], iterations)
        for member in range(len(seeds))
    ]


@dataclass(frozen=True, slots=True, eq=False)
class _Rows:
    """What networks learn from, scaled, with the linear part that is fitted before them."""

    scaling: Scaling
    varying: NDArray[np.intp]  # the columns of inputs that do
    columns: Tensor  # (C + 1, B) inputs that vary, above ones
    wanted: Tensor  # (T, B) what the linear part leaves of the targets
    learned: int  # rows; those after them are held out
    size: int  # of a batch
    linear: Array32 | None  # (outputs, C)
    constant: Array32  # (outputs,) of the linear part

    @classmethod
    def of(cls, inputs: Array32, targets: Array32, outputs: int, training: Training, seed: int) -> "_Rows":
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
        columns = torch.from_numpy(np.vstack([scaled[order].T, ones]))
        wanted = torch.from_numpy(np.ascontiguousarray(targets[order].T))
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


def _descend(
    model: Perceptron, data: _Rows, loss: Loss, training: Training, seeds: Sequence[int]
) -> tuple[Tensor, list[float], int]:
    """Train; return for each member the best parameters, (members, P), and their loss, and the iterations."""
    columns, wanted, learned = data.columns, data.wanted, data.learned
    # What a batch's loss is not enough to judge weights by: rows held out, or else some of all.
    apart = learned < columns.shape[1] or data.size < learned
    held_out = learned < columns.shape[1]
    checked = slice(learned, learned + MAX_CHECKED) if held_out else slice(MAX_CHECKED)
    judged, judged_wanted = columns[:, checked].contiguous(), wanted[:, checked].contiguous()
    adam = Adam(model.flat)
    batches = _batches(columns[:, :learned], wanted[:, :learned], len(seeds), data.size, seeds[0])
    best, best_loss, best_at = model.flat.clone(), [float("inf")] * len(seeds), 0
    for iteration in range(training.iterations + 1):  # the spec's 0..N
        batch, batch_wanted = next(batches)
        values, error = loss(model.forward(batch), batch_wanted)
        asked = not apart or iteration % CHECK_EVERY == 0 or iteration == training.iterations
        if apart and asked:
            values, _ = loss(model.predict(judged), judged_wanted)
        for member, value in enumerate(values.tolist() if asked else ()):
            if value < best_loss[member]:
                best_loss[member], best_at = value, iteration
                best[member].copy_(model.flat[member])
        if training.patience is not None and iteration - best_at > training.patience:
            break
        model.backward(batch, error)
        fall = 0.5 * (1 + cos(pi * iteration / training.iterations)) if training.decay else 1.0
        rate = training.learning_rate * fall
        adam.step(model.gradient, rate)
        if training.weight_decay:  # apart from Adam's moments: Loshchilov and Hutter, ICLR 2019
            model.flat.mul_(1 - training.weight_decay * rate)
    return best, best_loss, iteration + 1


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


def _batches(
    inputs: Tensor, targets: Tensor, members: int, size: int, seed: int
) -> Iterator[tuple[Tensor, Tensor]]:
    """Yield batches (members, columns, B) and targets (columns, B) without end, all rows in new orders.

    What is left over of one time round is left out of it.
    """
    count = inputs.shape[1]
    generator = torch.Generator().manual_seed(seed)
    while True:
        order = torch.arange(count) if size == count else torch.randperm(count, generator=generator)
        for rows in torch.split(order, size)[: count // size]:
            batch = inputs[:, rows].expand(members, -1, -1).contiguous(), targets[:, rows]
            yield batch
            while size == count:
                yield batch


def _chosen_rows(count: int, training: Training, seed: int) -> tuple[NDArray[np.intp], int]:
    """Return the rows in order, and how many of them are learned from; the others are held out."""
    if not training.held_out:
        return np.arange(count), count
    order = np.random.default_rng(seed).permutation(count)
    return order, count - min(max(1, round(training.held_out * count)), count - 1)
