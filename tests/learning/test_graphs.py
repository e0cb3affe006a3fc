"""Graphs of states, and the networks on them: numpy against torch, and both against the spec's words."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch.nn.functional import cross_entropy

from bpns.learning.graphs import training as graph_training
from bpns.learning.graphs.graph import Batch, Graph, Schema
from bpns.learning.graphs.network import GraphNetwork, shapes
from bpns.learning.graphs.training import (
    GraphExample,
    GraphLoss,
    GraphTraining,
    action_loss,
    choice_loss,
    device_of,
    fit_graph_network,
    pointer_loss,
)
from bpns.symbolic.errors import InputError
from bpns.symbolic.state import State
from bpns.symbolic.structs import Object, Predicate, Type

CUP = Type("cup", ("x", "full"))
HAND = Type("hand", ("x", "grip"))
HOLDS = Predicate("Holds", (HAND, CUP))
NEAR = Predicate("Near", (CUP, CUP))
FULL = Predicate("Full", (CUP,))
DAY = Predicate("Day", ())
CUP_0, CUP_1, HAND_0 = Object("cup0", CUP), Object("cup1", CUP), Object("hand0", HAND)
STATE = State.of({CUP_0: [0.25, 0], CUP_1: [0.5, 1], HAND_0: [0.75, -1]})
SCHEMA = Schema.of([HAND, CUP], {HOLDS, NEAR, FULL, DAY})
FEW = GraphTraining(epochs=60, learning_rate=1e-2, check_every=10)


def test_columns_are_as_specified() -> None:
    assert SCHEMA.types == ("cup", "hand")
    assert SCHEMA.features == ("full", "grip", "x")
    graph = SCHEMA.encode(
        STATE, {FULL(CUP_1), HOLDS(HAND_0, CUP_0), DAY()}, {FULL(CUP_0), NEAR(CUP_0, CUP_1)}
    )
    # types, Full holds, Full in the goal, features
    assert graph.nodes.tolist() == [
        [1, 0, 0, 1, 0, 0, 0.25],
        [1, 0, 1, 0, 1, 0, 0.5],
        [0, 1, 0, 0, 0, -1, 0.75],
    ]
    # (Holds, Near) x (holds, holds reversed, in the goal, in the goal reversed)
    found = dict(zip(zip(graph.senders, graph.receivers, strict=True), graph.edges.tolist(), strict=True))
    assert found == {
        (2, 0): [1, 0, 0, 0, 0, 0, 0, 0],
        (0, 2): [0, 0, 1, 0, 0, 0, 0, 0],
        (0, 1): [0, 0, 0, 0, 0, 1, 0, 0],
        (1, 0): [0, 0, 0, 0, 0, 0, 0, 1],
    }
    assert graph.whole.tolist() == [1, 0]


def test_an_atom_of_one_object_twice_is_a_loop() -> None:
    graph = SCHEMA.encode(STATE, {NEAR(CUP_0, CUP_0)}, ())
    assert graph.edges.tolist() == [[0, 1, 0, 1, 0, 0, 0, 0]]
    assert (graph.senders.tolist(), graph.receivers.tolist()) == ([0], [0])


def test_what_was_not_seen_in_training_has_no_column() -> None:
    schema = Schema.of([CUP], {FULL})
    graph = schema.encode(STATE, {HOLDS(HAND_0, CUP_0), DAY()}, {NEAR(CUP_0, CUP_1)})
    assert graph.nodes.shape == (3, 5)
    assert graph.nodes[2].tolist() == [0, 0, 0, 0, 0.75]  # x is a cup's feature, too
    assert graph.edges.shape == (0, 1)
    assert graph.whole.tolist() == [0]


def random_graph(rng: np.random.Generator) -> Graph:
    nodes, edges = rng.integers(1, 6), rng.integers(0, 8)
    return Graph(
        rng.normal(size=(nodes, 5)).astype(np.float32),
        rng.integers(0, 2, (edges, 4)).astype(np.float32),
        rng.integers(0, nodes, edges),
        rng.integers(0, nodes, edges),
        rng.normal(size=2).astype(np.float32),
    )


@given(st.integers(0, 10_000))
def test_numpy_one_by_one_is_torch_in_a_batch(seed: int) -> None:
    """Two implementations: one multiplies what stands side by side, the other its parts."""
    rng = np.random.default_rng(seed)
    graphs = [random_graph(rng) for _ in range(4)]
    _, parameters = graph_training._initial(shapes((5, 4, 2), 3, 6), seed, torch.device("cpu"))
    examples = [
        GraphExample(g, np.zeros((len(g.nodes), 3), np.float32), np.zeros(6, np.float32)) for g in graphs
    ]
    with torch.no_grad():
        nodes, whole = graph_training.forward(
            parameters, graph_training._Tensors.of(examples, torch.device("cpu"))
        )
    network = GraphNetwork({name: one.detach().numpy() for name, one in parameters.items()})
    found = [network(graph) for graph in graphs]
    assert np.allclose(np.concatenate([n for n, _ in found]), nodes.numpy(), atol=1e-4)
    assert np.allclose(np.stack([w for _, w in found]), whole.numpy(), atol=1e-4)


def test_batches_keep_graphs_apart() -> None:
    rng = np.random.default_rng(0)
    batch = Batch.of([random_graph(rng) for _ in range(5)])
    assert (batch.node_of[batch.senders] == batch.edge_of).all()
    assert (batch.node_of[batch.receivers] == batch.edge_of).all()


def choices(count: int) -> list[GraphExample]:
    """Which cup is full decides the argument; whether the hand is closed decides the skill."""
    rng = np.random.default_rng(0)
    found = []
    for _ in range(count):
        full, grip = int(rng.integers(2)), int(rng.integers(2))
        values = {CUP_0: [rng.uniform(), 0], CUP_1: [rng.uniform(), 0], HAND_0: [rng.uniform(), grip]}
        graph = SCHEMA.encode(State.of(values), {FULL((CUP_0, CUP_1)[full])}, ())
        arguments = np.zeros((3, 1), np.float32)
        arguments[full] = 1
        found.append(GraphExample(graph, arguments, np.eye(2, dtype=np.float32)[grip]))
    return found


def test_an_argument_is_one_choice_among_its_graphs_nodes() -> None:
    rng = np.random.default_rng(0)
    examples = []
    for graph in [random_graph(rng) for _ in range(6)]:
        wanted = np.zeros((len(graph.nodes), 3), np.float32)
        for place in range(int(rng.integers(0, 4))):  # skills take none to three
            wanted[rng.integers(len(wanted)), place] = 1
        examples.append(GraphExample(graph, wanted, np.eye(2, dtype=np.float32)[int(rng.integers(2))]))
    batch = graph_training._Tensors.of(examples, torch.device("cpu"))
    nodes, whole = torch.randn(len(batch.nodes), 3) * 20, torch.randn(6, 2)
    total, start = 0.0, 0
    for example, scores in zip(examples, whole, strict=True):
        own = nodes[start : start + len(example.nodes)]
        start += len(example.nodes)
        total += float(cross_entropy(scores, torch.from_numpy(example.whole)))
        for place in range(3):
            if example.nodes[:, place].any():
                total += float(cross_entropy(own[:, place], torch.from_numpy(example.nodes[:, place])))
    assert float(pointer_loss(nodes, whole, batch)) == pytest.approx(total / 6, rel=1e-4)


@pytest.mark.parametrize("loss", [choice_loss, pointer_loss])
def test_training_learns_choices_and_keeps_the_best_weights(loss: GraphLoss) -> None:
    examples = choices(300)
    fitted = fit_graph_network(examples, loss, FEW, 0, "cpu")
    outputs = [fitted.network(one.graph) for one in examples]
    assert all(
        n[:, 0].argmax() == e.nodes[:, 0].argmax() for (n, _), e in zip(outputs, examples, strict=True)
    )
    assert all(w.argmax() == e.whole.argmax() for (_, w), e in zip(outputs, examples, strict=True))
    held_out = graph_training._Tensors.of(examples[:30], torch.device("cpu"))
    parameters = {name: torch.from_numpy(array) for name, array in fitted.network.arrays.items()}
    assert float(graph_training._loss(parameters, held_out, loss)) == pytest.approx(fitted.loss)


def test_the_kept_weights_do_not_follow_the_training() -> None:
    """A rate that is far too high makes them worse and worse; the first ones must be what is given back."""
    wild = replace(FEW, learning_rate=10.0, check_every=1, epochs=5)
    examples = choices(100)
    fitted = fit_graph_network(examples, choice_loss, wild, 0, "cpu")
    outputs = [fitted.network(one.graph)[1] for one in examples[:10]]
    kept = [one.whole @ (np.log(np.exp(w).sum()) - w) for one, w in zip(examples, outputs, strict=False)]
    assert np.mean(kept) < 3  # cross entropy; the last weights' is in the hundreds


def test_training_repeats() -> None:
    done: list[tuple[int, int]] = []
    one, two = (
        fit_graph_network(choices(40), choice_loss, FEW, 3, "cpu", lambda *epoch: done.append(epoch))
        for _ in range(2)
    )
    assert done == 2 * [(epoch, FEW.epochs) for epoch in range(FEW.epochs + 1)]
    assert all((one.network.arrays[n] == two.network.arrays[n]).all() for n in one.network.arrays)


def test_actions_are_learned() -> None:
    examples = [replace(one, nodes=np.zeros((3, 0), np.float32)) for one in choices(200)]
    fitted = fit_graph_network(examples, action_loss, FEW, 0, "cpu")
    nodes, action = fitted.network(examples[0].graph)
    assert nodes.shape == (3, 0)
    assert np.allclose(action, examples[0].whole, atol=0.2)


def test_iterations_bound_the_epochs() -> None:
    fitted = fit_graph_network(choices(300), choice_loss, replace(FEW, iterations=9, decay=True), 0, "cpu")
    assert fitted.epochs == 3  # of three batches each


def test_too_few_examples_and_no_such_device() -> None:
    with pytest.raises(InputError, match="too few"):
        fit_graph_network(choices(1), choice_loss, FEW, 0, "cpu")
    with pytest.raises(InputError, match="no device 'nonsense'"):
        device_of("nonsense")


@pytest.mark.slow  # of machines that have one
@pytest.mark.skipif(not torch.cuda.is_available(), reason="no GPU here")
def test_a_gpu_gives_the_same_within_tolerance() -> None:
    once = replace(FEW, epochs=2)  # sums in another order grow apart in the end
    one, two = (
        fit_graph_network(choices(300), choice_loss, once, 0, device).network for device in ("cpu", "cuda")
    )
    for example in choices(20):
        assert np.allclose(one(example.graph)[1], two(example.graph)[1], atol=1e-3)
