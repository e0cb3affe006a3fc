"""Multilayer perceptrons in fixed buffers, and Adam on all of their parameters."""

from collections.abc import Sequence
from itertools import pairwise
from math import sqrt

import torch
from torch import Tensor

BETA1, BETA2, EPSILON = 0.9, 0.999, 1e-8  # Adam's usual ones

_relu_backward = torch.ops.aten.threshold_backward.grad_input


class Perceptron:
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
