"""From the lists of a PDDL problem to our Problem."""

from bpns.symbolic.operators import Domain, Problem
from bpns.symbolic.pddl.formulas import Formula, read_atom, read_formula
from bpns.symbolic.pddl.lists import List, shown
from bpns.symbolic.pddl.scope import Scope
from bpns.symbolic.pddl.sections import read_requirements, read_sections
from bpns.symbolic.pddl.typed import read_objects
from bpns.symbolic.pddl.vocabulary import PROBLEM_SECTIONS, UNSUPPORTED_FORMULAS
from bpns.symbolic.structs import EQUAL, GroundAtom, LiftedAtom


def build_problem(scope: Scope, tree: List, domain: Domain) -> Problem:
    """Return the problem that the lists describe; the scope knows the domain's declarations."""
    name, sections = read_sections(scope, tree, "problem", PROBLEM_SECTIONS)
    by_kind = {section.head: section for section in sections}
    if ":requirements" in by_kind:
        read_requirements(scope, by_kind[":requirements"])
    for kind in (":domain", ":init", ":goal"):
        if kind not in by_kind:
            scope.fail(tree, f"the problem has no {kind} section")
    section = by_kind[":domain"]
    if len(section.items) != 2 or scope.title(section.items[1], "domain") != domain.name.lower():
        fault = f"this problem is not of domain '{domain.name}': give the domain that it names"
        scope.fail(section, fault)
    if ":objects" in by_kind:
        read_objects(scope, by_kind[":objects"])
    init = _read_init(scope, by_kind[":init"])
    section = by_kind[":goal"]
    if len(section.items) != 2:
        scope.fail(section, "(:goal ...) takes one formula")
    goal = read_formula(scope, section.items[1], {})
    known = {o.name for o in domain.constants}
    return Problem(
        scope.spelled(name),
        tuple(o for o in scope.objects.values() if o.name not in known),
        init,
        _decided(scope, goal, goal.true, True),
        _decided(scope, goal, goal.false, False),
    )


def _read_init(scope: Scope, section: List) -> frozenset[GroundAtom]:
    init: set[GroundAtom] = set()
    for node in section.items[1:]:
        if not isinstance(node, List):
            scope.fail(node, f"expected an atom in parentheses, found '{shown(node.text)}'")
        if node.head == "not":
            scope.fail(node, "(not ...) in :init: leave it out, what is not listed is false")
        if node.head == "and":
            scope.fail(node, "(and ...) in :init: list its atoms without it")
        if node.head in UNSUPPORTED_FORMULAS:
            scope.unsupported(node, f"{node.head} in :init", UNSUPPORTED_FORMULAS[node.head])
        atom = read_atom(scope, node, {}).ground({})
        if atom.predicate != EQUAL:
            init.add(atom)
        elif atom.objects[0] != atom.objects[1]:
            scope.fail(node, f"{atom.objects[0]} and {atom.objects[1]} are two objects: remove this")
    return frozenset(init)


def _decided(
    scope: Scope, goal: Formula, atoms: frozenset[LiftedAtom], wanted: bool
) -> frozenset[GroundAtom]:
    """Ground a goal's atoms without the equalities, which nothing changes; refuse those that are never so."""
    found = set()
    for lifted in atoms:
        atom = lifted.ground({})
        if atom.predicate != EQUAL:
            found.add(atom)
        elif (atom.objects[0] == atom.objects[1]) != wanted:
            what = "are two objects" if wanted else "are one object"
            fault = f"{atom.objects[0]} and {atom.objects[1]} {what}, no plan changes that"
            scope.unsupported(goal.places[lifted], "a goal that never holds", fault)
    return frozenset(found)
