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
from torch import Tensor

from learning.networks import Array32, Network, Scaling

Loss: TypeAlias = Callable[[Tensor, Tensor], tuple[float, Tensor]]

BETA1, BETA2, EPSILON = 0.9, 0.999, 1e-8  # Adam's usual ones
MIN_VARIANCE = 1e-6
COLUMN_BLOCK = 16

_relu_backward = torch.ops.aten.threshold_backward.grad_input


@dataclass(frozen=True, slots=True)
class Stop:
    """Stop once the best loss has fallen by at most ``min_gain`` over the last ``window`` iterations."""

    window: int
    min_gain: float


@dataclass(frozen=True, slots=True)
class Training:
    """How to fit one network; ``stop`` None means all iterations.

    Of more than ``max_rows`` rows of data a random subset is used: what small networks learn from thousands
    of similar rows does not need all of them.
    """

    iterations: int
    stop: Stop | None = None
    hidden: tuple[int, ...] = (32, 32)
    learning_rate: float = 1e-3
    decay: bool = False  # of the learning rate, to zero at the last iteration
    max_rows: int | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Fitted:
    """A trained network, its best training loss and the iterations that it took."""

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

    The buffers have a few more columns than there are rows of data, up to a multiple that matrix products
    like; the error of these columns is always zero.
    """

    def __init__(self, inputs: Tensor, outputs: int, hidden: tuple[int, ...], fan_in: int, seed: int) -> None:
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
        self.output_error = self.errors[-1][:, : self.rows]
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
    """Fit a network to scaled targets; the weights with the lowest training loss are kept.

    Shapes: inputs (B, C), targets (B, T); the network's last layer has ``outputs`` values. Inputs are scaled
    here; columns that never vary get weight zero, as they carry nothing.
    Source: spec, algorithm.md section 6.
    """
    scaling = Scaling.of(inputs)
    varying = np.flatnonzero(inputs.max(axis=0) > inputs.min(axis=0))
    if training.max_rows is not None and len(inputs) > training.max_rows:
        chosen = np.random.default_rng(seed).choice(len(inputs), training.max_rows, replace=False)
        inputs, targets = inputs[chosen], targets[chosen]
    columns = torch.from_numpy(np.ascontiguousarray(scaling.apply(inputs)[:, varying].T))
    wanted = torch.from_numpy(np.ascontiguousarray(targets.T))
    model = _Perceptron(columns, outputs, training.hidden, inputs.shape[1], seed)
    mean, square = torch.zeros_like(model.flat), torch.zeros_like(model.flat)
    best, best_loss = model.flat.clone(), float("inf")
    history: list[float] = []  # the best loss before each iteration
    for iteration in range(1, training.iterations + 2):  # the spec's 0..N
        value, error = loss(model.forward(), wanted)
        if value < best_loss:
            best_loss = value
            best.copy_(model.flat)
        history.append(best_loss)
        if _settled(history, training.stop):
            break
        model.backward(error)
        mean.lerp_(model.gradient, 1 - BETA1)
        square.mul_(BETA2).addcmul_(model.gradient, model.gradient, value=1 - BETA2)
        spread = (square / (1 - BETA2**iteration)).sqrt_().add_(EPSILON)
        rate = training.learning_rate
        if training.decay:  # half a cosine
            rate *= 0.5 * (1 + cos(pi * iteration / training.iterations))
        model.flat.addcdiv_(mean, spread, value=-rate / (1 - BETA1**iteration))
    (weights, biases), *rest = model.layers(best)
    full = np.zeros((len(weights), inputs.shape[1]), np.float32)
    full[:, varying] = weights
    return Fitted(Network(scaling, ((full, biases), *rest)), best_loss, len(history))


def _settled(history: list[float], stop: Stop | None) -> bool:
    """Say whether the loss has stopped falling."""
    if stop is None or len(history) <= stop.window:
        return False
    return history[-1 - stop.window] - history[-1] <= stop.min_gain
