"""Reading PDDL's formulas: conjunctions of atoms that are to be true or false."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from bpns.symbolic.pddl.lists import List, Node, shown
from bpns.symbolic.pddl.scope import Scope, have
from bpns.symbolic.pddl.vocabulary import NUMBER, UNSUPPORTED_FORMULAS
from bpns.symbolic.structs import EQUAL, LiftedAtom, Object, Variable


@dataclass(frozen=True, slots=True)
class Formula:
    """A conjunction's atoms, those to be true and those to be false, and where each stood first."""

    true: frozenset[LiftedAtom]
    false: frozenset[LiftedAtom]
    places: Mapping[LiftedAtom, List] = field(compare=False)


def read_formula(scope: Scope, node: Node, variables: Mapping[str, Variable]) -> Formula:
    """Read a conjunction."""
    true: dict[LiftedAtom, List] = {}
    false: dict[LiftedAtom, List] = {}
    stack: list[tuple[Node, bool]] = [(node, True)]
    while stack:
        part, positive = stack.pop()
        if not isinstance(part, List):
            scope.fail(part, f"expected an atom in parentheses, found '{shown(part.text)}'")
        if part.head == "and" and positive:
            stack += [(item, True) for item in reversed(part.items[1:])]
        elif part.head == "not" and positive:
            if len(part.items) != 2:
                scope.fail(part, "(not ...) takes one atom")
            stack.append((part.items[1], False))
        elif part.head in ("and", "not"):
            scope.unsupported(part, f"({part.head} ...) inside (not ...)", "put a (not ...) on each atom")
        elif part.head in UNSUPPORTED_FORMULAS:
            scope.unsupported(part, part.head, UNSUPPORTED_FORMULAS[part.head])
        elif part.items or not positive:
            (true if positive else false).setdefault(read_atom(scope, part, variables), part)
    return Formula(frozenset(true), frozenset(false), {**false, **true})


def read_effect(scope: Scope, node: Node, variables: Mapping[str, Variable]) -> Formula:
    """Read a conjunction that changes atoms: all but equality can change."""
    effect = read_formula(scope, node, variables)
    for atom, place in effect.places.items():
        if atom.predicate == EQUAL:
            scope.fail(place, "an effect cannot change what '=' says: remove it")
    return effect


def read_atom(scope: Scope, node: List, variables: Mapping[str, Variable]) -> LiftedAtom:
    """Read an atom over variables and objects."""
    if not node.items:
        scope.fail(node, "expected an atom, found ()")
    name = scope.word(node.items[0], "a predicate")
    if name.text == "=":
        _refuse_numbers(scope, node)
    elif name.text not in scope.predicates:
        scope.fail(name, f"unknown predicate '{shown(name.text)}' {have(scope.predicates)}")
    predicate = EQUAL if name.text == "=" else scope.predicates[name.text]
    terms: list[Variable | Object] = []
    for item in node.items[1:]:
        word = scope.word(item, "a variable or an object")
        known: Mapping[str, Variable | Object] = variables if word.text.startswith("?") else scope.objects
        if word.text not in known:
            kind = "variable" if word.text.startswith("?") else "object"
            scope.fail(word, f"unknown {kind} '{shown(word.text)}' {have(known)}")
        terms.append(known[word.text])
    try:
        return predicate.lifted(*terms)
    except ValueError as error:
        scope.fail(node, str(error))


def _refuse_numbers(scope: Scope, node: List) -> None:
    """Refuse ``=`` between numbers: it is another word than ``=`` between objects."""
    for item in node.items[1:]:
        if isinstance(item, List) or NUMBER.match(item.text):
            scope.unsupported(node, "= between numbers", UNSUPPORTED_FORMULAS["increase"])


def need_flags(scope: Scope, node: Node, condition: Formula) -> None:
    """Warn where a condition needs a requirement that is missing."""
    if any(atom.predicate != EQUAL for atom in condition.false):
        scope.need(node, ":negative-preconditions")
    if any(atom.predicate == EQUAL for atom in condition.places):
        scope.need(node, ":equality")
