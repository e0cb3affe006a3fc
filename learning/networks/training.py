"""Fit networks: Adam on small multilayer perceptrons, in one place.

Rows are few and layers narrow, so that autograd and allocations would cost more than the products
themselves: activations live in fixed buffers, one column per row of data, and the gradient of a loss by the
outputs comes from the loss. A row of ones below each layer's activations makes biases part of the weights.
Networks that differ only in their initial weights are fitted together, as one batched computation.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from math import cos, pi

import torch
from torch import Tensor

from bpns.learning.networks.losses import Loss
from bpns.learning.networks.network import Array32, Network
from bpns.learning.networks.perceptron import Adam, Perceptron
from bpns.learning.networks.rows import Rows
from bpns.learning.networks.settings import Training

CHECK_EVERY = 50  # iterations: how often the loss on other rows than the batch is asked for
MAX_CHECKED = 500  # rows for that


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
    data = Rows.of(inputs, targets, outputs, training, seeds[0])
    layers = (*training.hidden, outputs)
    model = Perceptron(len(data.varying), data.size, layers, inputs.shape[1], seeds)
    best, lowest, iterations = _descend(model, data, loss, training, seeds)
    return [
        Fitted(data.network([view[member].numpy() for view in model.views(best)]), lowest[member], iterations)
        for member in range(len(seeds))
    ]


def _descend(
    model: Perceptron, data: Rows, loss: Loss, training: Training, seeds: Sequence[int]
) -> tuple[Tensor, list[float], int]:
    """Train; return for each member the best parameters, (members, P), and their loss, and the iterations."""
    columns, wanted = torch.from_numpy(data.columns), torch.from_numpy(data.wanted)
    learned = data.learned
    # What a batch's loss is not enough to judge weights by: rows held out, or else some of all.
    held_out = learned < columns.shape[1]
    apart = held_out or data.size < learned
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
