"""Losses, each with its gradient: a pure function of outputs and targets."""

from collections.abc import Callable
from typing import TypeAlias

import torch
from torch import Tensor

Loss: TypeAlias = Callable[[Tensor, Tensor], tuple[Tensor, Tensor]]

MIN_VARIANCE = 1e-6

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
