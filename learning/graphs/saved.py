"""A graph network's part of a model folder: an entry of skills.json and arrays of skills.safetensors."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from pydantic import BaseModel, ConfigDict

from bpns.learning.graphs.graph import Schema
from bpns.learning.graphs.network import GraphNetwork, shapes
from bpns.learning.graphs.reactive import GraphModel
from bpns.learning.networks.network import Array32
from bpns.symbolic.errors import InputError
from bpns.symbolic.operators import Operator

PREFIX = "(graph)."  # no operator is called so


class GraphEntry(BaseModel):
    """What skills.json says of a graph network: what its columns mean, and what it answers."""

    model_config = ConfigDict(extra="forbid")
    types: list[str]
    unary: list[str]
    binary: list[str]
    nullary: list[str]
    features: list[str]
    skills: list[str]  # among which it chooses; empty: it gives actions
    training: tuple[float, int]  # best loss, epochs


def graph_entry(model: GraphModel, training: tuple[float, int]) -> GraphEntry:
    """Describe a graph network for skills.json."""
    schema = model.schema
    return GraphEntry(
        types=list(schema.types),
        unary=list(schema.unary),
        binary=list(schema.binary),
        nullary=list(schema.nullary),
        features=list(schema.features),
        skills=list(model.skills),
        training=training,
    )


def graph_tensors(model: GraphModel) -> dict[str, Array32]:
    """Return its arrays by name."""
    return {f"{PREFIX}{name}": np.ascontiguousarray(a) for name, a in model.network.arrays.items()}


def read_graph(
    entry: GraphEntry,
    operators: Sequence[Operator],
    actions: int,
    tensors: Mapping[str, Array32],
    folder: Path,
) -> GraphModel:
    """Put a graph network together; raise InputError where it does not fit the operators or is incomplete."""
    known = {operator.name: len(operator.parameters) for operator in operators}
    for name in entry.skills:
        if name not in known:
            raise InputError(
                f"{folder / 'skills.json'}: the graph network chooses '{name}', which domain.pddl lacks: "
                "put the operator back, or learn again"
            )
    schema = Schema(
        *(tuple(x) for x in (entry.types, entry.unary, entry.binary, entry.nullary, entry.features))
    )
    places = max((known[name] for name in entry.skills), default=0)
    wanted = shapes(schema.widths, places, len(entry.skills) or actions)
    arrays = {}
    for name, shape in wanted.items():
        array = tensors.get(f"{PREFIX}{name}")
        if array is None or array.shape != shape:
            what = "missing" if array is None else f"of shape {array.shape}, not {shape}"
            raise InputError(
                f"{folder / 'skills.safetensors'}: {PREFIX}{name} is {what}: learn the model again"
            )
        arrays[name] = array
    return GraphModel(schema, GraphNetwork(arrays), tuple(entry.skills))
