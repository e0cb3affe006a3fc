"""Fit graph networks with torch, on the CPU or a GPU. Source: spec, baselines.md section 2."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import cos, pi, sqrt
from typing import TypeAlias

import numpy as np
import torch
from torch import Tensor
from torch.nn.functional import binary_cross_entropy_with_logits, cross_entropy, layer_norm, mse_loss

from bpns.learning.graphs.graph import Batch, Graph
from bpns.learning.graphs.network import EPSILON, ROUNDS, WIDTH, GraphNetwork, shapes
from bpns.learning.networks.network import Array32
from bpns.learning.networks.perceptron import Adam
from bpns.learning.networks.training import fast_small_numbers
from bpns.symbolic.errors import InputError

Parameters: TypeAlias = dict[str, Tensor]


@dataclass(frozen=True, slots=True)
class GraphTraining:
    """How to fit a graph network; the defaults are the paper's, but for which weights are kept.

    The first ``held_out`` of the examples decide, every ``check_every`` epochs, which weights are best. With
    ``iterations`` there are at most so many batches in all, and with ``decay`` the learning rate falls to
    zero along half a cosine. With ``pointers`` a skill's arguments are learned by ``pointer_loss``.
    """

    epochs: int = 1000
    batch: int = 128
    learning_rate: float = 1e-3
    held_out: float = 0.1
    check_every: int = 100
    iterations: int | None = None
    decay: bool = False
    pointers: bool = False

    @classmethod
    def fast(cls) -> "GraphTraining":
        """Return ours: small batches and a rate that falls; as many steps however many examples there are."""
        return cls(batch=16, learning_rate=3e-3, check_every=2, iterations=12_000, decay=True, pointers=True)


@dataclass(frozen=True, slots=True, eq=False)
class GraphExample:
    """A graph and what the network should answer."""

    graph: Graph
    nodes: Array32  # (N, K)
    whole: Array32  # (T,)


@dataclass(frozen=True, slots=True, eq=False)
class GraphFitted:
    """A trained network, its best loss on the examples held out, and the epochs that were run."""

    network: GraphNetwork
    loss: float
    epochs: int


def device_of(name: str) -> torch.device:
    """Return a device by name (``auto``: a GPU if there is one); raise InputError where it is missing."""
    gpus = torch.cuda.device_count()
    known = ["cpu", *(["cuda"] if gpus else []), *(f"cuda:{number}" for number in range(gpus))]
    if name == "auto":
        name = "cuda" if gpus else "cpu"
    if name not in known:
        raise InputError(f"no device '{name}' here (have: {', '.join(known)}, or auto)")
    return torch.device(name)


@dataclass(frozen=True, slots=True, eq=False)
class _Tensors:
    """A batch and its targets, where the network is."""

    nodes: Tensor
    edges: Tensor
    senders: Tensor
    receivers: Tensor
    whole: Tensor
    node_of: Tensor
    edge_of: Tensor
    wanted_nodes: Tensor
    wanted_whole: Tensor

    @classmethod
    def of(cls, examples: Sequence[GraphExample], device: torch.device) -> "_Tensors":
        batch = Batch.of([one.graph for one in examples])
        wanted = np.concatenate([one.nodes for one in examples]), np.stack([one.whole for one in examples])
        indices = batch.senders, batch.receivers, batch.whole, batch.node_of, batch.edge_of
        arrays = (batch.nodes, batch.edges, *indices, *wanted)
        return cls(*(torch.from_numpy(array).to(device) for array in arrays))


GraphLoss: TypeAlias = Callable[[Tensor, Tensor, _Tensors], Tensor]


def choice_loss(nodes: Tensor, whole: Tensor, batch: _Tensors) -> Tensor:
    """For a skill (one-hot, the whole's target) and its arguments (0/1, the nodes'). Source: section 3."""
    wanted = batch.wanted_nodes
    arguments = binary_cross_entropy_with_logits(nodes, wanted) if wanted.numel() else 0
    return cross_entropy(whole, batch.wanted_whole) + arguments


def pointer_loss(nodes: Tensor, whole: Tensor, batch: _Tensors) -> Tensor:
    """As ``choice_loss``, but each argument is one choice among a graph's nodes, as it is when it is used.

    Among a hundred nodes, deciding about each alone is learned slowly: nearly all are no argument.
    """
    wanted, count = batch.wanted_nodes, len(whole)
    highest = nodes.new_full((count, nodes.shape[1]), -torch.inf)
    of_column = batch.node_of[:, None].expand_as(nodes)
    highest = highest.scatter_reduce(0, of_column, nodes.detach(), "amax")
    above = nodes - highest.index_select(0, batch.node_of)
    total = _sums(above.exp(), batch.node_of, count).log().index_select(0, batch.node_of)
    return cross_entropy(whole, batch.wanted_whole) + (wanted * (total - above)).sum() / count


def action_loss(nodes: Tensor, whole: Tensor, batch: _Tensors) -> Tensor:
    """For actions, the whole's target; nodes have none. Source: section 4."""
    return mse_loss(whole, batch.wanted_whole)


@fast_small_numbers()
def fit_graph_network(
    examples: Sequence[GraphExample],
    loss: GraphLoss,
    training: GraphTraining,
    seed: int,
    device: str,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> GraphFitted:
    """Fit a network; batches keep the examples' order. Raises InputError where there are too few examples.

    The weights with the best loss on the examples held out are kept: a copy of them, as training goes on.
    ``progress`` gets the number of epochs done and of all.
    """
    if len(examples) < 2:
        raise InputError(
            f"{len(examples)} examples are too few for a graph network: give more demonstrations"
        )
    place = device_of(device)
    apart = max(1, int(training.held_out * len(examples)))
    judged, learned = [
        [_Tensors.of(part[i : i + training.batch], place) for i in range(0, len(part), training.batch)]
        for part in (examples[:apart], examples[apart:])
    ]
    first = examples[0]
    columns = first.graph.nodes.shape[1], first.graph.edges.shape[1], len(first.graph.whole)
    flat, parameters = _initial(shapes(columns, first.nodes.shape[1], len(first.whole)), seed, place)
    adam = Adam(flat)
    epochs = training.epochs
    if training.iterations is not None:
        epochs = min(epochs, max(1, training.iterations // len(learned)))
    total = epochs * len(learned)
    best: dict[str, Array32] = {}
    best_loss = float("inf")
    for epoch in range(epochs + 1):
        progress(epoch, epochs)
        if epoch % training.check_every == 0 or epoch == epochs:
            with torch.no_grad():
                losses = [float(_loss(parameters, batch, loss)) for batch in judged]
            found = float(np.average(losses, weights=[len(batch.whole) for batch in judged]))
            if found < best_loss or not best:
                best_loss = found
                best = {name: values.detach().cpu().numpy().copy() for name, values in parameters.items()}
        for batch in learned if epoch < epochs else ():
            fall = 0.5 * (1 + cos(pi * adam.steps / total)) if training.decay else 1.0
            gradients = torch.autograd.grad(_loss(parameters, batch, loss), list(parameters.values()))
            adam.step(torch.cat([one.reshape(-1) for one in gradients]), training.learning_rate * fall)
    return GraphFitted(GraphNetwork(best), best_loss, epochs)


def _loss(parameters: Parameters, batch: _Tensors, loss: GraphLoss) -> Tensor:
    nodes, whole = forward(parameters, batch)
    return loss(nodes, whole, batch)


def _initial(sizes: dict[str, tuple[int, ...]], seed: int, device: torch.device) -> tuple[Tensor, Parameters]:
    """Return initial values as PyTorch's layers have them, the same on every device; all in one vector."""
    generator = torch.Generator().manual_seed(seed)
    values = []
    for name, shape in sizes.items():
        if ".norm." in name:
            values.append(torch.full(shape, 1.0 if name.endswith("weights") else 0.0))
        else:
            bound = 1 / sqrt(sizes[name.replace("biases", "weights")][0])
            values.append(torch.empty(shape).uniform_(-bound, bound, generator=generator))
    flat = torch.cat([one.reshape(-1) for one in values]).to(device)
    pieces = torch.split(flat, [one.numel() for one in values])
    views = {name: piece.view(sizes[name]) for name, piece in zip(sizes, pieces, strict=True)}
    return flat, {name: view.detach().requires_grad_() for name, view in views.items()}


def forward(parameters: Parameters, batch: _Tensors) -> tuple[Tensor, Tensor]:
    """Return the outputs of all nodes and of all graphs.

    Linear layers read what stands beside each other part by part, so that what many edges have in common is
    multiplied once, for the node or the graph that they have it from.
    """
    nodes = first_nodes = _block(parameters, "encode.nodes", _plain(parameters, "encode.nodes", batch.nodes))
    edges = first_edges = _block(parameters, "encode.edges", _plain(parameters, "encode.edges", batch.edges))
    whole = first_whole = _block(parameters, "encode.whole", _plain(parameters, "encode.whole", batch.whole))
    wide = 2 * WIDTH
    by_receiver, by_sender, by_edge, by_whole = torch.split(parameters["round.edges.0.weights"], wide)
    for _ in range(ROUNDS):
        nodes_now = torch.cat([first_nodes, nodes], 1)
        whole_now = torch.cat([first_whole, whole], 1)
        hidden = torch.addmm(parameters["round.edges.0.biases"], torch.cat([first_edges, edges], 1), by_edge)
        hidden = hidden + (nodes_now @ by_receiver).index_select(0, batch.receivers)
        hidden = hidden + (nodes_now @ by_sender).index_select(0, batch.senders)
        hidden = hidden + (whole_now @ by_whole).index_select(0, batch.edge_of)
        edges = _block(parameters, "round.edges", hidden)
        arrived = _sums(edges, batch.receivers, len(nodes))
        own, by_arrived, from_whole = torch.split(parameters["round.nodes.0.weights"], [wide, WIDTH, wide])
        hidden = torch.addmm(parameters["round.nodes.0.biases"], nodes_now, own) + arrived @ by_arrived
        hidden = hidden + (whole_now @ from_whole).index_select(0, batch.node_of)
        nodes = _block(parameters, "round.nodes", hidden)
        count = len(whole)
        sums = [_sums(nodes, batch.node_of, count), _sums(edges, batch.edge_of, count)]
        whole = _block(
            parameters,
            "round.whole",
            _plain(parameters, "round.whole", torch.cat([whole_now, *sums], 1)),
        )
    return _decode(parameters, "nodes", nodes), _decode(parameters, "whole", whole)


def _plain(parameters: Parameters, block: str, rows: Tensor) -> Tensor:
    """Apply a block's first linear layer."""
    return torch.addmm(parameters[f"{block}.0.biases"], rows, parameters[f"{block}.0.weights"])


def _block(parameters: Parameters, block: str, hidden: Tensor) -> Tensor:
    """Apply what follows a block's first linear layer."""
    values = torch.addmm(parameters[f"{block}.1.biases"], hidden.relu(), parameters[f"{block}.1.weights"])
    weights, biases = parameters[f"{block}.norm.weights"], parameters[f"{block}.norm.biases"]
    return layer_norm(values, (WIDTH,), weights, biases, EPSILON)


def _sums(rows: Tensor, groups: Tensor, count: int) -> Tensor:
    """Add up rows by group."""
    return rows.new_zeros(count, rows.shape[1]).index_add(0, groups, rows)


def _decode(parameters: Parameters, part: str, values: Tensor) -> Tensor:
    weights = parameters.get(f"decode.{part}.weights")
    if weights is None:
        return values.new_zeros(len(values), 0)
    return torch.addmm(parameters[f"decode.{part}.biases"], values, weights)
