"""States, atoms and goals as graphs: what the graph networks read. Source: spec, baselines.md section 2."""

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bpns.learning.networks.network import Array32
from bpns.symbolic.state import State
from bpns.symbolic.structs import GroundAtom, Object, Predicate, Type

Numbers = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Graph:
    """One node per object, in canonical order, and an edge where two objects share an atom."""

    nodes: Array32  # (N, node columns)
    edges: Array32  # (E, edge columns)
    senders: Numbers  # (E,), numbers of nodes
    receivers: Numbers  # (E,)
    whole: Array32  # (global columns,)


@dataclass(frozen=True, slots=True)
class Schema:
    """What the columns of graphs mean: names, each tuple sorted.

    Nodes: one-hot type; unary predicates that hold; those that are in the goal; features, one column for each
    name. Edges, sender i and receiver j: p(i, j) holds; p(j, i) holds; p(i, j) is in the goal; p(j, i) is.
    The whole: predicates without arguments that hold, and those that are in the goal.
    """

    types: tuple[str, ...]
    unary: tuple[str, ...]
    binary: tuple[str, ...]
    nullary: tuple[str, ...]
    features: tuple[str, ...]

    @classmethod
    def of(cls, types: Iterable[Type], predicates: Collection[Predicate]) -> "Schema":
        """Return the columns for objects of these types and atoms of these predicates.

        Predicates of more than two arguments have no place in a graph and are left out.
        """
        kinds = tuple(types)

        def names(arity: int) -> tuple[str, ...]:
            return tuple(sorted({p.name for p in predicates if len(p.types) == arity}))

        return cls(
            tuple(sorted({t.name for t in kinds})),
            names(1),
            names(2),
            names(0),
            tuple(sorted({feature for t in kinds for feature in t.features})),
        )

    @property
    def widths(self) -> tuple[int, int, int]:
        """The numbers of columns of nodes, edges and the whole; at least one each."""
        nodes = len(self.types) + 2 * len(self.unary) + len(self.features)
        return nodes, max(1, 4 * len(self.binary)), max(1, 2 * len(self.nullary))

    def encode(self, state: State, atoms: Iterable[GroundAtom], goal: Iterable[GroundAtom]) -> Graph:
        """Return the graph of a state with its atoms and a goal, of what the schema names."""
        number = {o.name: i for i, o in enumerate(state.objects)}
        node_columns, edge_columns, whole_columns = self.widths
        nodes = np.zeros((len(number), node_columns), np.float32)
        whole = np.zeros(whole_columns, np.float32)
        type_at = {name: i for i, name in enumerate(self.types)}
        feature_at = {name: node_columns - len(self.features) + i for i, name in enumerate(self.features)}
        for row, obj in enumerate(state.objects):
            if obj.type.name in type_at:
                nodes[row, type_at[obj.type.name]] = 1
            for name, value in zip(obj.type.features, state[obj], strict=True):
                if name in feature_at:
                    nodes[row, feature_at[name]] = value
        unary_at = {name: len(self.types) + i for i, name in enumerate(self.unary)}
        binary_at = {name: i for i, name in enumerate(self.binary)}
        nullary_at = {name: i for i, name in enumerate(self.nullary)}
        pairs: list[int] = []  # sender * N + receiver
        columns: list[int] = []
        for block, given in enumerate((atoms, goal)):
            for atom in given:
                name = atom.predicate.name
                if name in binary_at:
                    one, two = atom.objects
                    i, j = number[one.name], number[two.name]
                    pairs += (i * len(number) + j, j * len(number) + i)
                    column = binary_at[name] + 2 * block * len(self.binary)
                    columns += (column, column + len(self.binary))
                elif name in unary_at:
                    nodes[number[atom.objects[0].name], unary_at[name] + block * len(self.unary)] = 1
                elif name in nullary_at:
                    whole[nullary_at[name] + block * len(self.nullary)] = 1
        found, rows = np.unique(np.array(pairs, np.int64), return_inverse=True)
        edges = np.zeros((len(found), edge_columns), np.float32)
        edges[rows, columns] = 1
        return Graph(nodes, edges, *np.divmod(found, len(number)), whole)


@dataclass(frozen=True, slots=True, eq=False)
class Batch:
    """Several graphs side by side as one that falls apart; ``node_of`` and ``edge_of`` say whose each is."""

    nodes: Array32  # (N, node columns)
    edges: Array32  # (E, edge columns)
    senders: Numbers  # (E,)
    receivers: Numbers  # (E,)
    whole: Array32  # (G, global columns)
    node_of: Numbers  # (N,)
    edge_of: Numbers  # (E,)

    @classmethod
    def of(cls, graphs: Sequence[Graph]) -> "Batch":
        """Put graphs together."""
        sizes = np.array([len(g.nodes) for g in graphs])
        first = np.repeat(np.cumsum(sizes) - sizes, [len(g.senders) for g in graphs])
        return cls(
            np.concatenate([g.nodes for g in graphs]),
            np.concatenate([g.edges for g in graphs]),
            np.concatenate([g.senders for g in graphs]) + first,
            np.concatenate([g.receivers for g in graphs]) + first,
            np.stack([g.whole for g in graphs]),
            np.repeat(np.arange(len(graphs)), sizes),
            np.repeat(np.arange(len(graphs)), [len(g.senders) for g in graphs]),
        )


def of_type(objects: Sequence[Object], type_: Type) -> list[int]:
    """Return the numbers of the nodes whose objects are of a type."""
    return [number for number, obj in enumerate(objects) if obj.type.is_a(type_)]
