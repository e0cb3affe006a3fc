"""Which operators enable which, against all groundings; and where the picture puts things."""

from collections.abc import Iterator
from itertools import combinations, product
from pathlib import Path

import networkx as nx
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bpns.symbolic.compare.enabling import enabling_graph, unify
from bpns.symbolic.compare.layout import Array, Size, circular_order, lay_out
from bpns.symbolic.pddl.read import read_domain
from bpns.symbolic.structs import OBJECT, LiftedAtom, Object, Predicate, Type, Variable, either

ITEM, ROBOT = Type("item"), Type("robot")
CUP, JUG = Type("cup", parent=ITEM), Type("jug", parent=ITEM)
LEAVES = (ROBOT, CUP, JUG)
OBJECTS = [Object(f"{kind.name}{i}", kind) for kind in LEAVES for i in range(3)]
VARIABLES = [
    Variable(f"?{i}", kind) for i, kind in enumerate([*LEAVES, ITEM, ITEM, OBJECT, either([ROBOT, CUP])])
]
ROOT = Path(__file__).parents[2]


@st.composite
def atoms(draw: st.DrawFn) -> LiftedAtom:
    terms = st.sampled_from([*VARIABLES, OBJECTS[0], OBJECTS[3], OBJECTS[4]])
    return LiftedAtom(Predicate("p", (OBJECT,) * 3), tuple(draw(terms) for _ in range(3)))


def groundings(atom: LiftedAtom) -> Iterator[tuple[Object, ...]]:
    variables = sorted({t for t in atom.terms if isinstance(t, Variable)}, key=str)
    for objects in product(*([o for o in OBJECTS if o.type.is_a(v.type)] for v in variables)):
        yield atom.ground(dict(zip(variables, objects, strict=True))).objects


@given(atoms(), atoms())
def test_atoms_unify_when_they_have_a_ground_atom_in_common(one: LiftedAtom, other: LiftedAtom) -> None:
    assert unify(one, other) == bool(set(groundings(one)) & set(groundings(other)))


def test_cover_and_stick_button() -> None:
    def edges(name: str) -> dict[tuple[str, str], tuple[str, ...]]:
        graph = enabling_graph(read_domain(ROOT / "pddl_out" / name / "domain.pddl").operators)
        return {(a, b): found for a, b, found in graph.edges(data="predicates")}

    assert edges("cover") == {("op0", "op1"): ("holding",), ("op1", "op0"): ("handempty",)}
    found = edges("stick_button")
    assert len(found) == 18
    assert found["op5", "op5"] == ("pressed", "robotabovebutton")
    assert found["op3", "op2"] == ("grasped",)  # picking the stick up enables pressing with it
    assert ("op2", "op3") not in found


def test_a_ring_is_laid_out_as_one() -> None:
    names = ["a", "d", "b", "e", "c", "f"]
    order = circular_order(names, list(zip("abcdef", "bcdefa", strict=True)))
    assert order[0] == "a"
    assert "".join(order) in ("abcdef", "afedcb")


def corners(centre: Array, size: Size) -> Array:
    half = np.array(size) / 2
    return np.concatenate([centre - half, centre + half])


def overlap(one: Array, other: Array) -> bool:
    return bool(np.all(np.minimum(one[2:], other[2:]) > np.maximum(one[:2], other[:2])))


@pytest.mark.parametrize("name", ["cover", "doors", "stick_button", "coffee"])
def test_nothing_is_drawn_over_anything_else(name: str) -> None:
    graph = enabling_graph(read_domain(ROOT / "pddl_out" / name / "domain.pddl").operators)
    labels = {edge: (1.1, 0.15 * len(graph.edges[edge]["predicates"])) for edge in graph.edges}
    boxes = dict.fromkeys(graph, (1.5, 0.46))
    layout = lay_out(graph, boxes, labels)
    drawn = [corners(layout.nodes[n], boxes[n]) for n in graph]
    drawn += [corners(layout.labels[e], labels[e]) for e in graph.edges]
    assert not any(overlap(one, other) for one, other in combinations(drawn, 2))
    for (start, end), points in layout.arrows.items():
        for other in graph:
            inside = (points > drawn[list(graph).index(other)][:2]) & (
                points < drawn[list(graph).index(other)][2:]
            )
            assert not inside.all(axis=1).any(), f"{start} -> {end} runs through {other}"


def test_many_boxes_do_not_overlap() -> None:
    graph = nx.complete_graph([str(i) for i in range(25)], create_using=nx.DiGraph)
    boxes = dict.fromkeys(graph, (2.0, 0.46))
    layout = lay_out(graph, boxes, dict.fromkeys(graph.edges, (1.0, 0.15)))
    drawn = [corners(centre, (2.0, 0.46)) for centre in layout.nodes.values()]
    assert not any(overlap(one, other) for one, other in combinations(drawn, 2))
