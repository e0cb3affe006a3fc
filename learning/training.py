"""Fit networks: full-batch Adam on small multilayer perceptrons, in one place. The only user of torch.

Rows are few and layers narrow, so that autograd and allocations would cost more than the products
themselves: activations live in fixed buffers, one column per row of data, and the gradient of a loss by the
outputs comes from the loss. A row of ones below each layer's activations makes biases part of the weights.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from math import cos, pi, sqrt
from typing import TypeAlias

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from learning.networks import Array32, Network, Scaling

Loss: TypeAlias = Callable[[Tensor, Tensor], tuple[float, Tensor]]

BETA1, BETA2, EPSILON = 0.9, 0.999, 1e-8  # Adam's usual ones
MIN_VARIANCE = 1e-6
COLUMN_BLOCK = 16
CHECK_EVERY = 10  # iterations: how often the loss on held-out rows is asked for

_relu_backward = torch.ops.aten.threshold_backward.grad_input


@dataclass(frozen=True, slots=True)
class Training:
    """How to fit one network: at most so many iterations.

    With ``decay`` the learning rate falls to zero along half a cosine. With ``held_out``, that share of the
    rows is kept apart and the loss on it decides which weights are best; otherwise the training loss does. Of
    more than ``max_rows`` rows a random subset is used: what small networks learn from thousands of similar
    rows does not need all of them. ``patience`` is after how many iterations without a better loss to stop.
    """

    iterations: int
    learning_rate: float = 1e-3
    decay: bool = False
    held_out: float = 0.0
    max_rows: int | None = None
    patience: int | None = None
    hidden: tuple[int, ...] = (32, 32)


@dataclass(frozen=True, slots=True, eq=False)
class Fitted:
    """A trained network, its best loss and the iterations that it took."""

    network: Network
    loss: float
    iterations: int


# ------------------------------------------------------------------------------------------- losses
# Each takes outputs and targets, both (columns, rows), and returns the loss and its gradient by the outputs.


def mean_squared_error(outputs: Tensor, targets: Tensor) -> tuple[float, Tensor]:
    """Mean over all entries."""
    difference = outputs - targets
    flat = difference.view(-1)
    return float(torch.dot(flat, flat)) / flat.numel(), difference.mul_(2 / flat.numel())


def binary_cross_entropy(outputs: Tensor, targets: Tensor) -> tuple[float, Tensor]:
    """Mean cross entropy of labels 0/1; outputs are logits."""
    loss = torch.nn.functional.binary_cross_entropy_with_logits(outputs, targets)
    return float(loss), torch.sigmoid(outputs).sub_(targets).mul_(1 / targets.numel())


def gaussian_negative_log_likelihood(outputs: Tensor, targets: Tensor) -> tuple[float, Tensor]:
    """Mean over all entries; the first half of the outputs are means, the second raw variances.

    The variance is ELU(raw) + 1, at least 1e-6. Source: spec, algorithm.md section 7.
    """
    size = len(targets)
    raw = outputs[size:]
    variance = torch.nn.functional.elu(raw).add_(1).clamp_min_(MIN_VARIANCE)
    difference = outputs[:size] - targets
    ratio = difference / variance
    square = ratio * difference
    loss = float(torch.log(variance).add_(square).sum()) / (2 * targets.numel())
    gradient = torch.empty_like(outputs)
    torch.mul(ratio, 1 / targets.numel(), out=gradient[:size])
    # d variance / d raw is 1 above zero and the variance itself below; a clamped variance does not move.
    slope = variance.clamp_max(1).mul_(variance > MIN_VARIANCE)
    torch.div(square.neg_().add_(1).mul_(slope), variance, out=gradient[size:])
    gradient[size:].mul_(0.5 / targets.numel())
    return loss, gradient


# ---------------------------------------------------------------------------------------------- fit


class _Perceptron:
    """Parameters in one vector, activations in fixed buffers, and gradients for all rows at once.

    Only the first ``learned`` rows are learned from. The buffers have a few more columns than there are rows
    of data, up to a multiple that matrix products like; the error of all other columns is always zero.
    """

    def __init__(
        self, inputs: Tensor, learned: int, outputs: int, hidden: tuple[int, ...], fan_in: int, seed: int
    ) -> None:
        sizes = [len(inputs), *hidden, outputs]
        generator = torch.Generator().manual_seed(seed)
        shapes = [(b, a + 1) for a, b in pairwise(sizes)]
        self.flat = torch.empty(sum(a * b for a, b in shapes))
        self.gradient = torch.empty_like(self.flat)
        self.weights = self._views(self.flat, shapes)
        self.gradients = self._views(self.gradient, shapes)
        for layer, weights in enumerate(self.weights):  # PyTorch's default for linear layers
            bound = 1 / sqrt(fan_in if layer == 0 else sizes[layer])
            weights.uniform_(-bound, bound, generator=generator)
        self.rows = inputs.shape[1]
        columns = -(-self.rows // COLUMN_BLOCK) * COLUMN_BLOCK
        self.activations = [torch.ones(size + 1, columns) for size in sizes[:-1]]
        self.activations[0][:-1, : self.rows] = inputs
        self.values = [a[:-1] for a in self.activations[1:]] + [torch.empty(outputs, columns)]
        self.outputs = self.values[-1][:, : self.rows]
        self.errors = [torch.zeros(size, columns) for size in sizes[1:]]
        self.output_error = self.errors[-1][:, :learned]
        self.values_by_row = [a[:-1].t() for a in self.activations]
        self.weights_by_input = [w[:, :-1].t() for w in self.weights]
        self.weight_gradients = [g[:, :-1] for g in self.gradients]
        self.bias_gradients = [g[:, -1] for g in self.gradients]

    @staticmethod
    def _views(flat: Tensor, shapes: list[tuple[int, int]]) -> list[Tensor]:
        pieces = torch.split(flat, [a * b for a, b in shapes])
        return [piece.view(shape) for piece, shape in zip(pieces, shapes, strict=True)]

    def forward(self) -> Tensor:
        """Return the outputs, (columns, rows); the buffer is reused by the next call."""
        for weights, before, after in zip(self.weights, self.activations, self.values, strict=True):
            torch.mm(weights, before, out=after)
            if after is not self.values[-1]:
                after.relu_()
        return self.outputs

    def backward(self, output_error: Tensor) -> None:
        """Fill ``gradient`` from the loss's gradient by the outputs."""
        self.output_error.copy_(output_error)
        for layer in range(len(self.weights) - 1, -1, -1):
            error = self.errors[layer]
            torch.mm(error, self.values_by_row[layer], out=self.weight_gradients[layer])
            torch.sum(error, 1, out=self.bias_gradients[layer])
            if layer:
                below = self.errors[layer - 1]
                torch.mm(self.weights_by_input[layer], error, out=below)
                _relu_backward(below, self.values[layer - 1], 0, grad_input=below)

    def layers(self, best: Tensor) -> list[tuple[Array32, Array32]]:
        """Return weights and biases of every layer."""
        views = self._views(best, [(w.shape[0], w.shape[1]) for w in self.weights])
        return [(v[:, :-1].numpy().copy(), v[:, -1].numpy().copy()) for v in views]


@contextmanager
def _fast_small_numbers() -> Iterator[None]:
    """Use one thread, since more make these sizes slower, and no denormals, where Adam's moments end up."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    torch.set_flush_denormal(True)
    try:
        yield
    finally:
        torch.set_flush_denormal(False)
        torch.set_num_threads(threads)


@_fast_small_numbers()
def fit(inputs: Array32, targets: Array32, loss: Loss, outputs: int, training: Training, seed: int) -> Fitted:
    """Fit a network to scaled targets; the weights with the lowest loss are kept.

    Shapes: inputs (B, C), targets (B, T); the network's last layer has ``outputs`` values. Inputs are scaled
    here; columns that never vary get weight zero, as they carry nothing.
    Source: spec, algorithm.md section 6.
    """
    scaling = Scaling.of(inputs)
    varying = np.flatnonzero(inputs.max(axis=0) > inputs.min(axis=0))
    order, learned = _chosen_rows(len(inputs), training, seed)
    columns = torch.from_numpy(np.ascontiguousarray(scaling.apply(inputs[order])[:, varying].T))
    wanted, held = (
        torch.from_numpy(np.ascontiguousarray(targets[rows].T)) for rows in (order[:learned], order[learned:])
    )
    model = _Perceptron(columns, learned, outputs, training.hidden, inputs.shape[1], seed)
    adam = _Adam(model)
    best, best_loss, best_at = model.flat.clone(), float("inf"), 0
    for iteration in range(training.iterations + 1):  # the spec's 0..N
        results = model.forward()
        value, error = loss(results[:, :learned], wanted)
        if len(order) > learned:
            checked = iteration % CHECK_EVERY == 0
            value = loss(results[:, learned:], held)[0] if checked else float("inf")
        if value < best_loss:
            best_loss, best_at = value, iteration
            best.copy_(model.flat)
        elif training.patience is not None and iteration - best_at > training.patience:
            break
        model.backward(error)
        fall = 0.5 * (1 + cos(pi * iteration / training.iterations)) if training.decay else 1.0
        adam.step(training.learning_rate * fall)
    (weights, biases), *rest = model.layers(best)
    full = np.zeros((len(weights), inputs.shape[1]), np.float32)
    full[:, varying] = weights
    return Fitted(Network(scaling, ((full, biases), *rest)), best_loss, iteration + 1)


def _chosen_rows(count: int, training: Training, seed: int) -> tuple[NDArray[np.intp], int]:
    """Return the rows to use, in order, and how many of them are learned from; the others are held out."""
    if training.max_rows is None and not training.held_out:
        return np.arange(count), count
    order = np.random.default_rng(seed).permutation(count)[: training.max_rows]
    held = min(max(1, round(training.held_out * len(order))), len(order) - 1) if training.held_out else 0
    return order, len(order) - held


class _Adam:
    """Adam's moments of all parameters. Source: Kingma and Ba, ICLR 2015."""

    def __init__(self, model: _Perceptron) -> None:
        self.model = model
        self.mean, self.square = torch.zeros_like(model.flat), torch.zeros_like(model.flat)
        self.steps = 0

    def step(self, rate: float) -> None:
        """Change the parameters by the gradient."""
        self.steps += 1
        gradient = self.model.gradient
        self.mean.lerp_(gradient, 1 - BETA1)
        self.square.mul_(BETA2).addcmul_(gradient, gradient, value=1 - BETA2)
        spread = (self.square / (1 - BETA2**self.steps)).sqrt_().add_(EPSILON)
        self.model.flat.addcdiv_(self.mean, spread, value=-rate / (1 - BETA1**self.steps))
