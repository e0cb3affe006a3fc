"""Domains compared: against brute force over renamings, and on edits whose difference is known."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise, permutations
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bpns.symbolic.compare.difference import OperatorPair, compare
from bpns.symbolic.compare.difference_text import difference_json, difference_text
from bpns.symbolic.compare.matching import PARTS, correspondence, fingerprint, placed_atoms, renamed, renaming
from bpns.symbolic.operators import Domain, Operator
from bpns.symbolic.pddl.read import parse_domain
from bpns.symbolic.structs import EQUAL, OBJECT, LiftedAtom, Object, Predicate, Type, Variable
from tests.symbolic._texts import DOMAIN, replaced

ITEM, ROBOT = Type("item"), Type("robot")
NAIL = Object("nail", ITEM)
PREDICATES = (Predicate("p", (OBJECT,)), Predicate("q", (OBJECT, OBJECT)), Predicate("done", ()))


@st.composite
def operators(draw: st.DrawFn, most: int = 4) -> Operator:
    count = draw(st.integers(0, most))
    kinds = draw(st.lists(st.sampled_from([ITEM, ROBOT]), min_size=count, max_size=count))
    parameters = tuple(Variable(f"?v{i}", kind) for i, kind in enumerate(kinds))
    term = st.sampled_from([*parameters, NAIL])

    def atom(predicate: Predicate) -> st.SearchStrategy[LiftedAtom]:
        return st.tuples(*[term] * len(predicate.types)).map(lambda terms: LiftedAtom(predicate, terms))

    atoms = st.frozensets(st.sampled_from(PREDICATES).flatmap(atom), max_size=3)
    return Operator("op", parameters, *(draw(atoms) for _ in range(4)))


def with_parameters(operator: Operator, order: Sequence[int], names: Sequence[str]) -> Operator:
    """Return an operator with its parameters in another order, under other names."""
    new = {v: Variable(names[place], v.type) for place, v in enumerate(operator.parameters)}
    parts: dict[str, Any] = {
        part: frozenset(
            LiftedAtom(atom.predicate, tuple(new[t] if isinstance(t, Variable) else t for t in atom.terms))
            for atom in getattr(operator, part)
        )
        for part in PARTS
    }
    return Operator(operator.name, tuple(new[operator.parameters[i]] for i in order), **parts)


def domain(*those: Operator) -> Domain:
    named = tuple(replace(operator, name=f"{operator.name}{i}") for i, operator in enumerate(those))
    return Domain("d", (ITEM, ROBOT), PREDICATES, named, (NAIL,))


def mappings(first: Operator, second: Operator) -> list[dict[int, int]]:
    """Return all partial injections of the parameters' places."""
    count = len(first.parameters)
    choices = [*range(len(second.parameters)), *[-1] * count]
    return [{a: b for a, b in enumerate(images) if b >= 0} for images in set(permutations(choices, count))]


@given(operators(6), st.randoms(use_true_random=False))
def test_order_and_names_do_not_count(operator: Operator, random: Any) -> None:
    order = list(range(len(operator.parameters)))
    random.shuffle(order)
    names = random.sample(["?v0", "?v1", "?a", "?b", "?c", "?D"], len(order))
    other = with_parameters(operator, order, names)
    found = renaming(operator, other)
    assert found is not None
    assert sorted(found) == sorted(found.values()) == sorted(order)
    assert renamed(placed_atoms(operator), found) == placed_atoms(other)
    assert fingerprint(placed_atoms(operator)) == fingerprint(placed_atoms(other))
    assert compare(domain(operator), domain(replace(other, name="another"))).same


@given(operators(3), operators(3), st.randoms(use_true_random=False))
def test_equality_is_that_of_brute_force(one: Operator, other: Operator, random: Any) -> None:
    """A near copy too, as two drawn operators are hardly ever equal."""
    order = list(range(len(one.parameters)))
    random.shuffle(order)
    near = with_parameters(one, order, ["?a", "?b", "?c"])
    part = random.choice(PARTS)
    near = replace(near, **{part: frozenset(list(getattr(near, part))[1:])})
    for second in (other, near):
        same_types = sorted(v.type.name for v in one.parameters) == sorted(
            v.type.name for v in second.parameters
        )
        equal = same_types and any(
            renamed(placed_atoms(one), m) == placed_atoms(second)
            for m in mappings(one, second)
            if len(m) == len(one.parameters)
        )
        assert (renaming(one, second) is not None) == equal
        assert compare(domain(one), domain(second)).same == equal


@given(operators(3), operators(3))
def test_the_correspondence_shares_as_much_as_any(one: Operator, other: Operator) -> None:
    def shared(mapping: dict[int, int]) -> int:
        return len(renamed(placed_atoms(one), mapping) & placed_atoms(other))

    assert shared(correspondence(one, other)) == max(map(shared, mappings(one, other)))


@settings(max_examples=60)
@given(st.lists(operators(3), max_size=4), st.lists(operators(3), max_size=4))
def test_a_difference_leads_from_one_domain_to_the_other(
    first: list[Operator], second: list[Operator]
) -> None:
    before, after = domain(*first), domain(*second)
    difference = compare(before, after)
    assert sorted([p.before.name for p in difference.pairs] + [o.name for o in difference.removed]) == [
        o.name for o in before.operators
    ]
    assert sorted([p.after.name for p in difference.pairs] + [o.name for o in difference.added]) == [
        o.name for o in after.operators
    ]
    for pair in difference.pairs:
        assert_leads(pair)
    back = compare(after, before)
    assert sum(p.same for p in back.pairs) == sum(p.same for p in difference.pairs)
    assert difference_json(compare(before, before))["same"] is True


def assert_leads(pair: OperatorPair) -> None:
    new: dict[Variable, Variable] = dict(pair.renaming)
    changes = {change.part: change for change in pair.atoms}
    for part in PARTS:
        kept = set(getattr(pair.before, part))
        added: set[LiftedAtom] = set()
        if part in changes:
            assert set(changes[part].removed) <= kept
            kept -= set(changes[part].removed)
            added = set(changes[part].added)
        images = {
            LiftedAtom(a.predicate, tuple(new[t] if isinstance(t, Variable) else t for t in a.terms))
            for a in kept
        }
        assert not images & added
        assert images | added == getattr(pair.after, part)
    assert {*new, *pair.removed} == {*pair.before.parameters}
    assert {*new.values(), *pair.added} == {*pair.after.parameters}


KITCHEN = """\
(define (domain kitchen)
  (:requirements :strips :typing :negative-preconditions)
  (:types robot item - object cup jug - item)
  (:constants robby - robot)
  (:predicates (free ?r - robot) (holding ?r - robot ?x) (filled ?x) (done))
  (:action pick :parameters (?r - robot ?x - item)
    :precondition (and (free ?r) (not (done)))
    :effect (and (holding ?r ?x) (not (free ?r))))
  (:action fill :parameters (?c - cup)
    :precondition (holding robby ?c)
    :effect (and (filled ?c) (done))))
"""


@pytest.mark.parametrize(
    ("old", "new", "lines"),
    [
        (
            "(not (done)))\n    :effect (and (holding ?r ?x)",
            "(filled ?x))\n    :effect (and (holding ?r ?x) (done)",
            [
                "changed   pick",
                "            precondition   + filled(?x)",
                "            precondition   - not done()",
                "            add effect     + done()",
            ],
        ),
        (
            "(?r - robot ?x - item)\n    :precondition (and",
            "(?y - cup ?x - object ?r - robot)\n    :precondition (and (filled ?y)",
            [
                "changed   pick",
                "            parameter      - ?x - item  + ?x - object",
                "            parameter      + ?y - cup",
                "            precondition   + filled(?y)",
            ],
        ),
        (
            "(?c - cup)\n    :pre",
            "(?c - cup ?r - robot)\n    :pre",
            ["changed   fill", "            parameter      + ?r - robot"],
        ),
        (
            "(not (free ?r))",
            "(not (filled ?x))",
            [
                "changed   pick",
                "            delete effect  - free(?r)",
                "            delete effect  + filled(?x)",
            ],
        ),
        ("holding robby ?c", "holding ROBBY ?C", []),
        ("(:action pick", "(:action TAKE", ["same      pick -> take"]),
        ("(done))\n  (:action pick", "(done) (lit))\n  (:action pick", ["predicate + lit()"]),
        ("(filled ?x) (done)", "(filled ?x - item) (done)", ["predicate - filled(object)  + filled(item)"]),
        ("cup jug - item", "cup - item jug - object", ["type      - jug - item  + jug - object"]),
        ("(:constants robby", "(:constants marvin robby", ["constant  + marvin - robot"]),
    ],
)
def test_edits_are_found(old: str, new: str, lines: list[str]) -> None:
    difference = compare(parse_domain(KITCHEN), parse_domain(replaced(KITCHEN, old, new)))
    found = difference_text(difference).splitlines()[:-1]
    assert [line for line in found if line not in ("same      pick", "same      fill")] == lines
    assert difference.same == (not lines or lines[0].startswith("same"))


def test_nothing_in_common_is_removed_and_added() -> None:
    r = Variable("?r", ROBOT)
    p, q, done = (LiftedAtom(PREDICATES[i], (r,) * i) for i in (1, 2, 0))
    none: frozenset[LiftedAtom] = frozenset()
    one = Operator("same-name", (r,), frozenset({p}), frozenset({done}), none)
    other = Operator("same-name", (r,), frozenset({q}), frozenset({p}), none)
    difference = compare(domain(one), domain(other))
    assert (difference.pairs, len(difference.removed), len(difference.added)) == ((), 1, 1)
    assert difference_text(difference).splitlines() == [
        "removed   same-name0(?r - robot)",
        "added     same-name0(?r - robot)",
        "operators: 0 same, 0 changed, 1 removed, 1 added",
    ]


def test_the_most_similar_are_paired_whatever_their_names() -> None:
    """Each operator loses one atom and takes the name of another."""
    before = parse_domain(DOMAIN)
    pick, fill = before.operators
    changed = [
        replace(fill, name="pick", preconditions=frozenset()),
        replace(pick, name="fill", negative_preconditions=frozenset()),
    ]
    difference = compare(before, before.with_operators(changed))
    assert [(p.before.name, p.after.name, p.same) for p in difference.pairs] == [
        ("pick", "fill", False),
        ("fill", "pick", False),
    ]


def test_equality_has_no_first_and_second() -> None:
    a, b, c = (Variable(f"?{name}", ITEM) for name in "abc")
    none: frozenset[LiftedAtom] = frozenset()

    def of(x: Variable, y: Variable) -> Operator:
        differ = frozenset({LiftedAtom(EQUAL, (x, y))})
        effect = frozenset({LiftedAtom(PREDICATES[1], (a, b)), LiftedAtom(PREDICATES[0], (c,))})
        return Operator("op", (a, b, c), none, effect, none, differ)

    assert compare(domain(of(a, b)), domain(of(b, a))).same
    assert not compare(domain(of(a, b)), domain(of(a, c))).same


def test_many_parameters_that_are_alike_do_not_blow_up() -> None:
    parameters = tuple(Variable(f"?v{i}", ITEM) for i in range(25))
    links = [LiftedAtom(PREDICATES[1], pair) for pair in pairwise(parameters)]
    none: frozenset[LiftedAtom] = frozenset()
    ring = LiftedAtom(PREDICATES[1], (parameters[-1], parameters[0]))
    chain = Operator("chain", parameters, frozenset(links), none, none)
    other = with_parameters(chain, range(24, -1, -1), [f"?w{i}" for i in range(25)])
    assert renaming(chain, other) is not None
    closed = replace(chain, preconditions=chain.preconditions | {ring})
    assert renaming(chain, closed) is None
    (pair,) = compare(
        domain(chain), domain(with_parameters(closed, range(25), [f"?w{i}" for i in range(25)]))
    ).pairs
    assert_leads(pair)
    assert not pair.same


def test_the_order_of_an_atoms_arguments_counts() -> None:
    a, b = Variable("?a", ITEM), Variable("?b", ITEM)
    none: frozenset[LiftedAtom] = frozenset()

    def of(marked: Variable, x: Variable, y: Variable) -> Operator:
        effect = frozenset({LiftedAtom(PREDICATES[0], (marked,)), LiftedAtom(PREDICATES[1], (x, y))})
        return Operator("op", (a, b), none, effect, none)

    assert renaming(of(a, a, b), of(b, b, a)) is not None
    assert renaming(of(a, a, b), of(b, a, b)) is None
    assert renaming(of(a, a, b), of(a, b, a)) is None
