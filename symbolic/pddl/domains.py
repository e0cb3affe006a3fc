"""From the lists of a PDDL domain to our Domain."""

from bpns.symbolic.operators import Domain, Operator
from bpns.symbolic.pddl.formulas import Formula, need_flags, read_effect, read_formula
from bpns.symbolic.pddl.lists import List, shown
from bpns.symbolic.pddl.scope import Scope
from bpns.symbolic.pddl.sections import parts_of_action, read_requirements, read_sections
from bpns.symbolic.pddl.typed import read_objects, read_types, read_variables
from bpns.symbolic.pddl.vocabulary import ACTION_KEYS, DOMAIN_SECTIONS, NO_PREDICATES, UNSUPPORTED_ACTION_KEYS
from bpns.symbolic.structs import EQUAL, OBJECT, Predicate


def build_domain(scope: Scope, tree: List) -> Domain:
    """Return the domain that the lists describe."""
    name, sections = read_sections(scope, tree, "domain", DOMAIN_SECTIONS)
    readers = {
        ":requirements": read_requirements,
        ":types": read_types,
        ":constants": read_objects,
        ":predicates": _read_predicates,
    }
    for kind, read in readers.items():  # people write them in any order
        for section in sections:
            if section.head == kind:
                read(scope, section)
    operators: dict[str, Operator] = {}
    for section in sections:
        if section.head == ":action":
            operator = _operator(scope, section)
            if operator.name.lower() in operators:
                fault = f"a second operator '{shown(operator.name)}': rename one"
                scope.fail(section.items[1], fault)
            operators[operator.name.lower()] = operator
    return Domain(
        scope.spelled(name),
        tuple(t for t in scope.types.values() if t != OBJECT),
        tuple(scope.predicates.values()),
        tuple(operators.values()),
        tuple(scope.objects.values()),
    )


def _read_predicates(scope: Scope, section: List) -> None:
    for node in section.items[1:]:
        if not isinstance(node, List) or not node.items:
            scope.fail(node, "expected a predicate such as (on ?x ?y)")
        if node.head == "=" and len(read_variables(scope, node.items[1:])) == len(EQUAL.types):
            scope.warn(node, "'=' is built in and need not be declared")
            continue
        if node.head in NO_PREDICATES:
            fault = f"'{node.head}' begins a formula, it cannot be a predicate: rename it"
            scope.fail(node.items[0], fault)
        name = scope.name(node.items[0], "a predicate")
        if name in scope.predicates:
            scope.fail(node, f"a second predicate '{shown(name)}': rename one")
        parameters = read_variables(scope, node.items[1:])
        scope.predicates[name] = Predicate(scope.spelled(name), tuple(v.type for v in parameters.values()))


def _operator(scope: Scope, section: List) -> Operator:
    if len(section.items) < 2:
        scope.fail(section, "an action without a name")
    name = scope.name(section.items[1], "an action")
    parts = parts_of_action(scope, section, ACTION_KEYS, UNSUPPORTED_ACTION_KEYS)
    if ":effect" not in parts:
        scope.fail(section, f"action {shown(name)} has no :effect")
    listed = parts.get(":parameters", List((), section.start))
    if not isinstance(listed, List):
        scope.fail(listed, f"expected a list of parameters, found '{shown(listed.text)}'")
    variables = read_variables(scope, listed.items)
    condition = Formula(frozenset(), frozenset(), {})
    if ":precondition" in parts:
        condition = read_formula(scope, parts[":precondition"], variables)
        need_flags(scope, parts[":precondition"], condition)
    effect = read_effect(scope, parts[":effect"], variables)
    return Operator(
        scope.spelled(name),
        tuple(variables.values()),
        condition.true,
        effect.true,
        effect.false,
        condition.false,
    )
