"""Losses against autograd, the hand-written gradient against autograd, and that fitting fits."""

from itertools import pairwise

import numpy as np
import pytest
import torch
from torch import Tensor

from bpns.learning.networks.losses import (
    Loss,
    binary_cross_entropy,
    gaussian_negative_log_likelihood,
    mean_squared_error,
)
from bpns.learning.networks.network import Folded, Network, Scaling, mean_of
from bpns.learning.networks.perceptron import Perceptron
from bpns.learning.networks.rows import _chosen_rows
from bpns.learning.networks.settings import Training
from bpns.learning.networks.training import _batches, fit, fit_members


def reference_likelihood(outputs: Tensor, targets: Tensor) -> Tensor:
    mean, raw = outputs.chunk(2)
    variance = torch.clamp(torch.nn.functional.elu(raw) + 1, min=1e-6)
    return (0.5 * (torch.log(variance) + (targets - mean) ** 2 / variance)).mean()


LOSSES = [
    (mean_squared_error, torch.nn.functional.mse_loss, 1),
    (binary_cross_entropy, torch.nn.functional.binary_cross_entropy_with_logits, 1),
    (gaussian_negative_log_likelihood, reference_likelihood, 2),
]


@pytest.mark.parametrize(("loss", "reference", "heads"), LOSSES)
@pytest.mark.parametrize("scale", [0.1, 3.0, 20.0])
def test_losses_and_their_gradients(loss: Loss, reference: Loss, heads: int, scale: float) -> None:
    generator = torch.Generator().manual_seed(0)
    outputs = (torch.randn(heads * 3, 50, generator=generator).double() * scale).requires_grad_()
    targets = torch.rand(3, 50, generator=generator).double()
    expected = reference(outputs, targets)
    expected.backward()  # type: ignore[union-attr]
    value, gradient = loss(outputs.detach(), targets)
    assert value.item() == pytest.approx(expected.item(), rel=1e-5)
    assert torch.allclose(gradient, outputs.grad, rtol=1e-6)  # type: ignore[arg-type]
    values, gradients = loss(torch.stack([outputs.detach() + 1, outputs.detach()]), targets)  # two members
    assert values[1].item() == pytest.approx(value.item())
    assert torch.allclose(gradients[1], gradient)


@pytest.mark.parametrize("hidden", [(8,), (8, 5), (7, 6, 5)])
@pytest.mark.parametrize("rows", [1, 15, 16, 33])
def test_backward_is_autograd(hidden: tuple[int, ...], rows: int) -> None:
    generator = torch.Generator().manual_seed(1)
    inputs, targets = torch.rand(4, rows, generator=generator), torch.rand(2, rows, generator=generator)
    with_ones = torch.cat([inputs, torch.ones(1, rows)]).expand(2, -1, -1).contiguous()
    model = Perceptron(4, rows, (*hidden, 2), 4, seeds=(0, 1))
    outputs = model.forward(with_ones)
    assert torch.allclose(outputs, model.predict(with_ones[0]), atol=1e-6)
    model.backward(with_ones, mean_squared_error(outputs, targets)[1])
    for member in range(2):
        parameters = [w[member].clone().requires_grad_() for w in model.weights]
        values = inputs
        for number, weights in enumerate(parameters):
            values = weights[:, :-1] @ values + weights[:, -1:]
            if number < len(hidden):
                values = values.relu()
        torch.nn.functional.mse_loss(values, targets).backward()
        assert torch.allclose(outputs[member], values, atol=1e-6)
        for ours, theirs in zip(model.gradients, parameters, strict=True):
            assert torch.allclose(ours[member], theirs.grad, atol=1e-6)  # type: ignore[arg-type]


def test_weights_start_as_in_pytorch() -> None:
    model = Perceptron(3, 5, (400, 300, 2), fan_in=9, seeds=(0,))
    for weights, fan_in in zip(model.weights, (9, 400, 300), strict=True):
        bound = fan_in**-0.5
        assert weights.abs().max() <= bound
        assert weights.abs().max() > 0.95 * bound


def rows(count: int = 200) -> tuple[np.ndarray, np.ndarray]:  # type: ignore[type-arg]
    rng = np.random.default_rng(0)
    inputs = rng.uniform(-1, 1, (count, 3)).astype(np.float32)
    inputs[:, 1] = 7  # a column that never varies
    return inputs, np.stack([inputs[:, 0] + inputs[:, 2], abs(inputs[:, 0])], axis=1).astype(np.float32)


def test_adam_as_in_pytorch() -> None:
    inputs, targets = rows()
    fitted = fit(inputs, targets, mean_squared_error, 2, Training(50), seed=3)
    varying = Scaling.of(inputs).apply(inputs)[:, [0, 2]]
    start = Perceptron(2, 200, (32, 32, 2), 3, seeds=(3,))
    layers = []
    for (weights,) in start.weights:
        layer = torch.nn.Linear(weights.shape[1] - 1, weights.shape[0])
        layer.weight.data, layer.bias.data = weights[:, :-1].clone(), weights[:, -1].clone()
        layers += [layer, torch.nn.ReLU()]
    model = torch.nn.Sequential(*layers[:-1])
    optimizer = torch.optim.Adam(model.parameters(), 1e-3)
    best = float("inf")
    for _ in range(51):
        loss = torch.nn.functional.mse_loss(model(torch.from_numpy(varying)), torch.from_numpy(targets))
        best = min(best, loss.item())
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
    assert fitted.loss == pytest.approx(best, rel=1e-3)
    assert fitted.iterations == 51


def test_fit_learns_and_ignores_columns_that_never_vary() -> None:
    inputs, targets = rows()
    fitted = fit(inputs, targets, mean_squared_error, 2, Training(2000), seed=0)
    network = Folded.of(fitted.network)
    assert np.abs(network(inputs.astype(float)) - targets).mean() < 0.02
    changed = inputs.copy()
    changed[:, 1] = -100
    assert np.array_equal(network(changed.astype(float)), network(inputs.astype(float)))


def test_the_best_weights_are_kept() -> None:
    inputs, targets = rows()
    wild = Training(300, learning_rate=0.3)
    fitted = fit(inputs, targets, mean_squared_error, 2, wild, seed=0)
    reached = ((Folded.of(fitted.network)(inputs.astype(float)) - targets) ** 2).mean()
    assert reached == pytest.approx(fitted.loss, rel=1e-3)


def test_training_stops_when_the_loss_no_longer_gets_better() -> None:
    inputs, targets = rows()
    jumpy = Training(5000, learning_rate=0.5, patience=50)
    stopped = fit(inputs, targets, mean_squared_error, 2, jumpy, seed=0)
    assert 50 < stopped.iterations < 5001
    assert fit(inputs, targets, mean_squared_error, 2, Training(300), seed=0).iterations == 301


def test_a_learning_rate_that_falls_gives_other_weights_and_still_learns() -> None:
    inputs, targets = rows()
    steady, falling = (
        fit(inputs, targets, mean_squared_error, 2, Training(400, 1e-2, decay=decay), seed=0)
        for decay in (False, True)
    )
    assert falling.loss < 1e-3
    assert falling.loss != steady.loss


def test_held_out_rows_choose_the_weights_but_teach_nothing() -> None:
    inputs, targets = rows()
    training = Training(200, held_out=0.25)
    order, learned = _chosen_rows(len(inputs), training, 0)
    assert sorted(order) == list(range(200))
    assert learned == 150
    fitted = fit(inputs, targets, mean_squared_error, 2, training, seed=0)
    held = order[learned:]
    error = Folded.of(fitted.network)(inputs[held].astype(float)) - targets[held]
    assert fitted.loss == pytest.approx((error**2).mean(), rel=1e-3)
    unlearnable = targets.copy()
    unlearnable[held] += 5
    again = fit(inputs, unlearnable, mean_squared_error, 2, training, seed=0)
    assert again.loss > 20  # had they been learned from, it would be about 14


def test_few_rows_are_held_out() -> None:
    assert _chosen_rows(1000, Training(1, held_out=0.1), 0)[1] == 900
    assert _chosen_rows(1, Training(1, held_out=0.1), 0)[1] == 1
    assert _chosen_rows(2, Training(1, held_out=0.1), 0)[1] == 1


def test_batches_take_each_row_once_in_a_round() -> None:
    numbers = torch.arange(10.0)[None]
    found = _batches(numbers, 2 * numbers, members=2, size=3, seed=0)
    rounds = [[next(found) for _ in range(3)] for _ in range(2)]
    for batches in rounds:
        assert len({x for inputs, _ in batches for x in inputs[0].view(-1).tolist()}) == 9
        assert all(torch.equal(2 * inputs[1], targets) for inputs, targets in batches)
    assert not torch.equal(rounds[0][0][0], rounds[1][0][0])
    everything = _batches(numbers, numbers, members=1, size=10, seed=0)
    assert all(torch.equal(next(everything)[0][0], numbers) for _ in range(3))


def test_batches_and_members_learn() -> None:
    """Together, networks come out as each does alone, where the rows are the same."""
    inputs, targets = rows()
    training = Training(600, 1e-2, decay=True, batch=64, scaling="deviation")
    together = fit_members(inputs, targets, mean_squared_error, 2, training, (0, 1))
    alone = fit(inputs, targets, mean_squared_error, 2, training, seed=0)
    assert all(fitted.loss < 1e-3 for fitted in together)
    assert together[0].loss != together[1].loss
    assert alone.loss == pytest.approx(together[0].loss, rel=0.2)


def test_the_same_seed_gives_the_same_weights() -> None:
    inputs, targets = rows()
    fits = [fit(inputs, targets, mean_squared_error, 2, Training(20), seed=s) for s in (0, 0, 1)]
    one, two, other = ([w.tolist() for w, _ in fitted.network.layers] for fitted in fits)
    assert one == two
    assert one != other


def test_fitting_leaves_the_process_as_it_was() -> None:
    """Flushing tiny numbers to zero would change simulators and planners in the same process."""
    threads = torch.get_num_threads()
    inputs, targets = rows(20)
    fit(inputs, targets, mean_squared_error, 2, Training(2), seed=0)
    assert np.float64(5e-324) * 1 > 0
    assert torch.get_num_threads() == threads


def test_scaling_of_targets_keeps_constants_exact() -> None:
    scaling = Scaling.of_targets(np.array([[2, 0.5], [2, 3.5]], np.float32))
    assert scaling.scale.tolist() == [0, 3]
    assert scaling.varying.tolist() == [1]
    assert Scaling.of(np.array([[0.1], [0.4]], np.float32)).scale.tolist() == [1]  # at least 1
    assert Scaling.of(np.array([[0.1], [0.4]], np.float32), "range").scale[0] == pytest.approx(0.3)
    standard = Scaling.of_targets(np.array([[2, 0.5], [2, 3.5]], np.float32), "deviation")
    assert (standard.shift.tolist(), standard.scale.tolist()) == ([2, 2], [0, 1.5])


@pytest.mark.parametrize("rows", [1, 3, 40])
@pytest.mark.parametrize("columns", [1, 3])
def test_a_linear_part_is_exact_beyond_the_rows(rows: int, columns: int) -> None:
    rng = np.random.default_rng(0)
    inputs = np.hstack([np.ones((rows, 1)), rng.random((rows, columns - 1))]).astype(np.float32)
    targets = (inputs @ np.array([[2.0], [3.0], [-1.0]][:columns]) + 4).astype(np.float32)
    training = Training(50, decay=True, linear=True, weight_decay=0.1)
    found = fit(inputs, targets, mean_squared_error, 1, training, 0)
    network = Folded.of(found.network)
    assert np.allclose(network(inputs.astype(float)), targets, atol=0.5)
    if rows > columns == 3:
        assert found.network.linear is not None
        assert np.allclose(found.network.linear, [[0, 3, -1]], atol=1e-4)


def test_weight_decay_shrinks_weights() -> None:
    inputs, targets = np.zeros((4, 2), np.float32), np.zeros((4, 1), np.float32)
    inputs[:, 1] = np.arange(4)
    targets[:, 0] = [0, 1, 0, 1]
    sizes = [
        sum(
            float(np.square(weights).sum())
            for weights, _ in fit(
                inputs, targets, mean_squared_error, 1, Training(300, 1e-2, weight_decay=decay), 0
            ).network.layers
        )
        for decay in (0.0, 0.5)
    ]
    assert sizes[1] < 0.7 * sizes[0]


@pytest.mark.parametrize("sizes", [(3, 2), (3, 4, 2), (3, 4, 5, 2)])
@pytest.mark.parametrize("linear", [False, True])
def test_the_mean_of_networks_is_one_network(sizes: tuple[int, ...], linear: bool) -> None:
    rng = np.random.default_rng(0)
    scaling = Scaling(rng.random(3, np.float32), 1 + rng.random(3, np.float32))
    outputs = Scaling(rng.random(2, np.float32), 1 + rng.random(2, np.float32))

    def drawn() -> Network:
        layers = [
            (rng.standard_normal((b, a)).astype(np.float32), rng.standard_normal(b).astype(np.float32))
            for a, b in pairwise(sizes)
        ]
        return Network(scaling, tuple(layers), rng.random((2, 3), np.float32) if linear else None)

    networks = [drawn() for _ in range(3)]
    rows = rng.random((7, 3))
    wanted = np.mean([Folded.of(network, outputs)(rows) for network in networks], axis=0)
    assert np.allclose(Folded.of(mean_of(networks), outputs)(rows), wanted, atol=1e-5)
