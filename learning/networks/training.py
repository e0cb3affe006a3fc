"""Fit networks: Adam on small multilayer perceptrons, in one place. The only user of torch.

Rows are few and layers narrow, so that autograd and allocations would cost more than the products
themselves: activations live in fixed buffers, one column per row of data, and the gradient of a loss by the
outputs comes from the loss. A row of ones below each layer's activations makes biases part of the weights.
Networks that differ only in their initial weights are fitted together, as one batched computation.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from math import cos, pi, sqrt
from typing import TypeAlias

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from bpns.learning.networks.network import Array32, Method, Network, Scaling

Loss: TypeAlias = Callable[[Tensor, Tensor], tuple[Tensor, Tensor]]

BETA1, BETA2, EPSILON = 0.9, 0.999, 1e-8  # Adam's usual ones
MIN_VARIANCE = 1e-6
CHECK_EVERY = 50  # iterations: how often the loss on other rows than the batch is asked for
MAX_CHECKED = 500  # rows for that
PENALTIES = 10.0 ** np.arange(-9, 1)  # of linear parts, for each row

_relu_backward = torch.ops.aten.threshold_backward.grad_input


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


# ------------------------------------------------------------------------------------------- losses
# Each takes outputs (members, columns, rows) and targets (columns, rows), the same for all members, and gives
# each member's loss, (members,), and its gradient by the outputs. The dimension of members may be absent.


def mean_squared_error(outputs: Tensor, targets: Tensor) -> tuple[Tensor, Tensor]:
    """Mean over all entries."""
    difference = outputs - targets
    return difference.square().mean((-2, -1)), difference.mul_(2 / targets.numel())


def binary_cross_entropy(outputs: Tensor, targets: Tensor) -> tuple[Tensor, Tensor]:
    """Mean cross entropy of labels 0/1; outputs are logits."""
    loss = torch.nn.functional.softplus(outputs).sub_(outputs * targets).mean((-2, -1))
    return loss, torch.sigmoid(outputs).sub_(targets).mul_(1 / targets.numel())


def gaussian_negative_log_likelihood(outputs: Tensor, targets: Tensor) -> tuple[Tensor, Tensor]:
    """Mean over all entries; the first half of the outputs are means, the second raw variances.

    The variance is ELU(raw) + 1, at least 1e-6. Source: spec, algorithm.md section 7.
    """
    means, raw = outputs.chunk(2, -2)
    variance = torch.nn.functional.elu(raw).add_(1).clamp_min_(MIN_VARIANCE)
    difference = means - targets
    ratio = difference / variance
    square = difference.mul_(ratio)
    loss = torch.log(variance).add_(square).sum((-2, -1)).div_(2 * targets.numel())
    gradient = torch.empty_like(outputs)
    by_mean, by_raw = gradient.chunk(2, -2)
    torch.mul(ratio, 1 / targets.numel(), out=by_mean)
    # d variance / d raw is 1 above zero and the variance itself below; a clamped variance does not move.
    slope = variance.clamp_max(1).mul_(variance > MIN_VARIANCE).mul_(0.5 / targets.numel())
    torch.div(square.neg_().add_(1).mul_(slope), variance, out=by_raw)
    return loss, gradient


# ---------------------------------------------------------------------------------------------- fit


class _Perceptron:
    """All members' parameters, (members, P), their gradients, and a batch's activations in fixed buffers."""

    def __init__(
        self, columns: int, batch: int, layers: tuple[int, ...], fan_in: int, seeds: Sequence[int]
    ) -> None:
        sizes, members = [columns, *layers], len(seeds)
        self.shapes = [(b, a + 1) for a, b in pairwise(sizes)]
        self.flat = torch.empty(members, sum(a * b for a, b in self.shapes))
        self.gradient = torch.empty_like(self.flat)
        self.weights, self.gradients = self.views(self.flat), self.views(self.gradient)
        for member, seed in enumerate(seeds):
            generator = torch.Generator().manual_seed(seed)
            for layer, weights in enumerate(self.weights):  # PyTorch's default for linear layers
                bound = 1 / sqrt(fan_in if layer == 0 else sizes[layer])
                weights[member].uniform_(-bound, bound, generator=generator)
        self.activations = [torch.ones(members, size + 1, batch) for size in sizes[1:-1]]
        self.values = [a[:, :-1] for a in self.activations]
        self.outputs = torch.empty(members, sizes[-1], batch)
        self.errors = [torch.empty(members, size, batch) for size in sizes[1:-1]]
        self.activations_by_row = [a.transpose(1, 2) for a in self.activations]
        self.weights_by_input = [w[:, :, :-1].transpose(1, 2) for w in self.weights]

    def views(self, flat: Tensor) -> list[Tensor]:
        """Return the layers' matrices within vectors, (members, out, in + 1): biases in the last column."""
        pieces = torch.split(flat, [a * b for a, b in self.shapes], dim=1)
        return [piece.view(len(flat), *shape) for piece, shape in zip(pieces, self.shapes, strict=True)]

    def predict(self, inputs: Tensor) -> Tensor:
        """Return outputs (members, columns, rows) for any number of rows, (columns + 1, rows)."""
        values = torch.matmul(self.weights[0], inputs)
        for weights in self.weights[1:]:
            values = torch.baddbmm(weights[:, :, -1:], weights[:, :, :-1], values.relu_())
        return values

    def forward(self, inputs: Tensor) -> Tensor:
        """Return the outputs for one batch, (members, columns + 1, B); the next call reuses the buffer."""
        below = inputs
        for weights, after, with_ones in zip(self.weights, self.values, self.activations, strict=False):
            torch.bmm(weights, below, out=after)
            after.relu_()
            below = with_ones
        return torch.bmm(self.weights[-1], below, out=self.outputs)

    def backward(self, inputs: Tensor, output_error: Tensor) -> None:
        """Fill ``gradient`` from the loss's gradient by the outputs, after ``forward``."""
        error = output_error
        for layer in range(len(self.weights) - 1, 0, -1):
            torch.bmm(error, self.activations_by_row[layer - 1], out=self.gradients[layer])
            below = self.errors[layer - 1]
            torch.bmm(self.weights_by_input[layer], error, out=below)
            _relu_backward(below, self.values[layer - 1], 0, grad_input=below)
            error = below
        torch.bmm(error, inputs.transpose(1, 2), out=self.gradients[0])


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
    scaling = Scaling.of(inputs, training.scaling)
    varying = np.flatnonzero(inputs.max(axis=0) > inputs.min(axis=0))
    order, learned = _chosen_rows(len(inputs), training, seeds[0])
    ones = np.ones((1, len(order)), np.float32)
    scaled = scaling.apply(inputs)[:, varying]
    linear = np.zeros((outputs, inputs.shape[1]), np.float32)
    constant = np.zeros(outputs, np.float32)
    if training.linear:
        wide = targets.shape[1]
        linear[:wide, varying], constant[:wide] = _ridge(scaled[order[:learned]], targets[order[:learned]])
        targets = targets - (scaled @ linear[:wide, varying].T + constant[:wide])
    columns = torch.from_numpy(np.vstack([scaled[order].T, ones]))
    wanted = torch.from_numpy(np.ascontiguousarray(targets[order].T))
    size = min(training.batch or learned, learned)
    # What a batch's loss is not enough to judge weights by: rows held out, or else some of all.
    apart = learned < len(order) or size < learned
    checked = slice(learned, learned + MAX_CHECKED) if learned < len(order) else slice(MAX_CHECKED)
    judged, judged_wanted = columns[:, checked].contiguous(), wanted[:, checked].contiguous()
    model = _Perceptron(len(varying), size, (*training.hidden, outputs), inputs.shape[1], seeds)
    adam = Adam(model.flat)
    batches = _batches(columns[:, :learned], wanted[:, :learned], len(seeds), size, seeds[0])
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
    fitted = []
    layers = [view.numpy() for view in model.views(best)]
    for member, lowest in enumerate(best_loss):
        (weights, biases), *rest = [(x[member, :, :-1].copy(), x[member, :, -1].copy()) for x in layers]
        full = np.zeros((len(weights), inputs.shape[1]), np.float32)
        full[:, varying] = weights
        network = Network(scaling, ((full, biases), *rest))
        if training.linear:
            weights, biases = network.layers[-1]
            network = Network(scaling, (*network.layers[:-1], (weights, biases + constant)), linear)
        fitted.append(Fitted(network, lowest, iteration + 1))
    return fitted


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


class Adam:
    """Adam's moments of all parameters, put one after the other. Source: Kingma and Ba, ICLR 2015."""

    def __init__(self, flat: Tensor) -> None:
        self.flat = flat
        self.mean, self.square = torch.zeros_like(flat), torch.zeros_like(flat)
        self.spread = torch.empty_like(flat)
        self.steps = 0

    def step(self, gradient: Tensor, rate: float) -> None:
        """Change the parameters by their gradient."""
        self.steps += 1
        self.mean.lerp_(gradient, 1 - BETA1)
        self.square.mul_(BETA2).addcmul_(gradient, gradient, value=1 - BETA2)
        # Both moments' corrections for having begun at zero are numbers: put into the rate and EPSILON.
        correction = sqrt(1 - BETA2**self.steps)
        torch.sqrt(self.square, out=self.spread)
        self.spread.add_(EPSILON * correction)
        rate *= correction / (1 - BETA1**self.steps)
        self.flat.addcdiv_(self.mean, self.spread, value=-rate)
