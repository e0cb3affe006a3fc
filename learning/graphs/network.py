"""A graph network: encode, three rounds of messages, decode. Source: spec, baselines.md section 2."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bpns.learning.graphs.graph import Graph
from bpns.learning.networks.network import Array32

WIDTH = 16  # of every layer
ROUNDS = 3  # of messages
EPSILON = 1e-5  # in the layer normalisation, as in PyTorch

Wide = NDArray[np.float64]


def shapes(columns: tuple[int, int, int], node_outputs: int, outputs: int) -> dict[str, tuple[int, ...]]:
    """Return all arrays of a network by name; ``columns`` are those of nodes, edges and the whole.

    A block is a linear layer, ReLU, another one and layer normalisation. Matrices are (in, out). The rounds
    share their blocks, which read what is to be updated, twice as wide as a layer, since the first latent
    values stand beside the present ones.
    """
    nodes, edges, whole = columns
    blocks = {
        "encode.nodes": nodes,
        "encode.edges": edges,
        "encode.whole": whole,
        "round.edges": 8 * WIDTH,  # receiver, sender, edge, whole
        "round.nodes": 5 * WIDTH,  # node, sum of the messages that arrive, whole
        "round.whole": 4 * WIDTH,  # whole, sum of all nodes, sum of all messages
    }
    found: dict[str, tuple[int, ...]] = {}
    for block, inputs in blocks.items():
        found |= {f"{block}.0.weights": (inputs, WIDTH), f"{block}.0.biases": (WIDTH,)}
        found |= {f"{block}.1.weights": (WIDTH, WIDTH), f"{block}.1.biases": (WIDTH,)}
        found |= {f"{block}.norm.weights": (WIDTH,), f"{block}.norm.biases": (WIDTH,)}
    for part, size in (("nodes", node_outputs), ("whole", outputs)):
        if size:
            found |= {f"decode.{part}.weights": (WIDTH, size), f"decode.{part}.biases": (size,)}
    return found


@dataclass(frozen=True, slots=True, eq=False)
class GraphNetwork:
    """A trained graph network, for use on one graph at a time."""

    arrays: Mapping[str, Array32]

    def __call__(self, graph: Graph) -> tuple[Wide, Wide]:
        """Return outputs for each node, (N, K), and for the whole, (T,); nodes have none where K is 0."""
        nodes = first_nodes = self._block("encode.nodes", graph.nodes)
        edges = first_edges = self._block("encode.edges", graph.edges)
        whole = first_whole = self._block("encode.whole", graph.whole)
        for _ in range(ROUNDS):
            nodes_now = np.concatenate([first_nodes, nodes], axis=1)
            edges_now = np.concatenate([first_edges, edges], axis=1)
            whole_now = np.concatenate([first_whole, whole])
            beside = np.broadcast_to(whole_now, (len(edges_now), len(whole_now)))
            ends = [nodes_now[graph.receivers], nodes_now[graph.senders]]
            edges = self._block("round.edges", np.concatenate([*ends, edges_now, beside], axis=1))
            arrived = np.zeros((len(nodes), WIDTH))
            np.add.at(arrived, graph.receivers, edges)
            beside = np.broadcast_to(whole_now, (len(nodes_now), len(whole_now)))
            nodes = self._block("round.nodes", np.concatenate([nodes_now, arrived, beside], axis=1))
            whole = self._block(
                "round.whole", np.concatenate([whole_now, nodes.sum(axis=0), edges.sum(axis=0)])
            )
        return self._decode("nodes", nodes), self._decode("whole", whole)

    def _block(self, name: str, rows: NDArray[np.floating]) -> Wide:
        array = self.arrays
        hidden = rows @ array[f"{name}.0.weights"] + array[f"{name}.0.biases"]
        values = np.maximum(hidden, 0) @ array[f"{name}.1.weights"] + array[f"{name}.1.biases"]
        values = values - values.mean(axis=-1, keepdims=True)
        scale = np.sqrt(np.square(values).mean(axis=-1, keepdims=True) + EPSILON)
        return np.asarray(values / scale * array[f"{name}.norm.weights"] + array[f"{name}.norm.biases"])

    def _decode(self, part: str, values: Wide) -> Wide:
        weights = self.arrays.get(f"decode.{part}.weights")
        if weights is None:
            return np.zeros((*values.shape[:-1], 0))
        return np.asarray(values @ weights + self.arrays[f"decode.{part}.biases"])
