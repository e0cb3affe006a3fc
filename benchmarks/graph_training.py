"""Training a graph network: ours, with sums by index, against the same network with dense 0/1 matrices.

In the dense form, matrices say which node is which edge's sender and receiver, and whose graph's each is.
``dense`` puts them together for each batch as it comes, as a data loader does, and steps with torch's Adam;
``dense, prepared`` gets all batches' matrices made once, as ours are, and our Adam. CPU seconds of an epoch,
on one thread, of the examples for GNN Meta.
"""

import argparse
import time
from collections.abc import Callable
from pathlib import Path

import torch
from torch import Tensor
from torch.nn.functional import one_hot

from bpns import envs
from bpns.learning.approaches import Learned, Learning
from bpns.learning.data.files import read_demonstrations, read_environment_name
from bpns.learning.graphs import learning as _graphs
from bpns.learning.graphs import training as graph_training
from bpns.learning.graphs.network import ROUNDS
from bpns.learning.graphs.training import (
    GraphExample,
    GraphFitted,
    GraphTraining,
    choice_loss,
    fit_graph_network,
)
from bpns.learning.models.learn import learn_skills
from bpns.learning.models.settings import SkillConfig
from bpns.learning.networks.settings import Training
from bpns.learning.networks.training import fast_small_numbers

CPU = torch.device("cpu")
Tensors = graph_training._Tensors


def dense_forward(parameters: dict[str, Tensor], batch: Tensors) -> tuple[Tensor, Tensor]:
    """Return what ``graph_training.forward`` returns, by products with dense matrices."""
    count, graphs = len(batch.nodes), len(batch.whole)
    receiver, sender = one_hot(batch.receivers, count).float(), one_hot(batch.senders, count).float()
    edge_of, node_of = one_hot(batch.edge_of, graphs).float(), one_hot(batch.node_of, graphs).float()

    def update(name: str, *rows: Tensor) -> Tensor:
        hidden = graph_training._plain(parameters, name, torch.cat(rows, 1))
        return graph_training._block(parameters, name, hidden)

    nodes = first_nodes = update("encode.nodes", batch.nodes)
    edges = first_edges = update("encode.edges", batch.edges)
    whole = first_whole = update("encode.whole", batch.whole)
    for _ in range(ROUNDS):
        nodes_now = torch.cat([first_nodes, nodes], 1)
        edges_now = torch.cat([first_edges, edges], 1)
        whole_now = torch.cat([first_whole, whole], 1)
        ends = receiver @ nodes_now, sender @ nodes_now
        edges = update("round.edges", *ends, edges_now, edge_of @ whole_now)
        nodes = update("round.nodes", nodes_now, receiver.T @ edges, node_of @ whole_now)
        whole = update("round.whole", whole_now, node_of.T @ nodes, edge_of.T @ edges)
    decode = graph_training._decode
    return decode(parameters, "nodes", nodes), decode(parameters, "whole", whole)


def initial(examples: list[GraphExample]) -> tuple[Tensor, dict[str, Tensor]]:
    """Return a network's parameters."""
    one = examples[0]
    columns = one.graph.nodes.shape[1], one.graph.edges.shape[1], len(one.graph.whole)
    sizes = graph_training.shapes(columns, one.nodes.shape[1], len(one.whole))
    return graph_training._initial(sizes, 0, CPU)


def examples_of(path: Path) -> list[GraphExample]:
    """Return the examples that GNN Meta learns from; the skills themselves are hardly trained."""
    environment = envs.load(*read_environment_name(path))
    found: list[GraphExample] = []

    def keep(examples: list[GraphExample], *_: object) -> GraphFitted:
        found.extend(examples)
        return fit_graph_network(examples[:200], choice_loss, GraphTraining(epochs=1), 0, "cpu")

    once = Training(1)
    config = SkillConfig(policy=once, generator=once, discriminator=once)
    data = read_demonstrations(path, environment)
    skills = Learned(learn_skills(environment, data, config, 0))
    _graphs.fit_graph_network = keep
    _graphs.metacontroller(data, skills, Learning(config, GraphTraining(), 0))
    return found


def train_dense(examples: list[GraphExample], epochs: int) -> None:
    """Train the dense form as one would write it: batches are put together as they come."""
    _, parameters = initial(examples)
    optimizer = torch.optim.Adam(parameters.values(), lr=1e-3)
    apart = len(examples) // 10
    for _ in range(epochs):
        for start in range(apart, len(examples), 128):
            batch = Tensors.of(examples[start : start + 128], CPU)
            optimizer.zero_grad()
            nodes, whole = dense_forward(parameters, batch)
            choice_loss(nodes, whole, batch).backward()
            optimizer.step()


def train_ours(examples: list[GraphExample], epochs: int) -> None:
    """Train as the program does."""
    fit_graph_network(examples, choice_loss, GraphTraining(epochs=epochs, check_every=10**9), 0, "cpu")


def train_prepared(examples: list[GraphExample], epochs: int) -> None:
    """Train the dense form in our own loop."""
    original, graph_training.forward = graph_training.forward, dense_forward
    try:
        train_ours(examples, epochs)
    finally:
        graph_training.forward = original


@fast_small_numbers()
def seconds_per_epoch(
    train: Callable[[list[GraphExample], int], None], examples: list[GraphExample], epochs: int
) -> float:
    """Return the CPU time of an epoch, without what happens once."""
    times = []
    for number in (1, 1 + epochs):
        start = time.process_time()
        train(examples, number)
        times.append(time.process_time() - start)
    return (times[1] - times[0]) / epochs


def main() -> None:
    """Print the times and their ratios."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("demonstrations", type=Path, help="made by bpns demos")
    parser.add_argument("--epochs", type=int, default=20)
    arguments = parser.parse_args()
    examples = examples_of(arguments.demonstrations)
    batch = Tensors.of(examples[:64], CPU)
    with torch.no_grad():
        _, parameters = initial(examples)
        ours, dense = graph_training.forward(parameters, batch), dense_forward(parameters, batch)
        difference = max(float((a - b).abs().max()) for a, b in zip(ours, dense, strict=True))
    print(f"{len(examples)} examples; outputs differ by at most {difference:.1e}")
    own = seconds_per_epoch(train_ours, examples, arguments.epochs)
    print(f"ours: {own:.3f} CPU seconds an epoch, {1000 * own:.0f} for the paper's 1000")
    start = time.process_time()
    fit_graph_network(examples, choice_loss, GraphTraining.fast(), 0, "cpu")
    print(f"ours, default preset: {time.process_time() - start:.0f} CPU seconds in all")
    for name, train in (("dense", train_dense), ("dense, prepared", train_prepared)):
        seconds = seconds_per_epoch(train, examples, arguments.epochs)
        print(f"{name}: {seconds:.3f} CPU seconds an epoch, {seconds / own:.1f} times ours")


if __name__ == "__main__":
    main()
