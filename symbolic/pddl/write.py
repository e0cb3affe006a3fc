"""Write PDDL that every reader takes: lower case, types and requirements spelled out, one stable layout."""

from collections.abc import Iterable, Mapping
from itertools import groupby

from bpns.symbolic.errors import InputError
from bpns.symbolic.operators import Domain, Operator, Problem
from bpns.symbolic.pddl.vocabulary import NAME, NO_PREDICATES
from bpns.symbolic.structs import EQUAL, OBJECT, GroundAtom, LiftedAtom, Predicate, Type, sort_atoms


def model_names(domain: Domain, problem: Problem | None = None) -> dict[str, str]:
    """Return how PDDL's lower-case names are spelled in the model: the reader's ``names``.

    Raises InputError for names that PDDL cannot hold or tell apart.
    """
    kinds = [(t.name, "type") for t in domain.types]
    kinds += [(p.name, "predicate") for p in domain.predicates]
    kinds += [(o.name, "operator") for o in domain.operators]
    kinds += [(o.name, "object") for o in domain.constants]
    if problem is not None:
        kinds += [(o.name, "object") for o in problem.objects]
    spelled: dict[str, str] = {}
    used: dict[str, set[str]] = {}
    for name, kind in kinds:
        low = name.lower()
        others = used.setdefault(low, set())
        if not NAME.match(low):
            raise InputError(
                f"{kind} '{name}' is no PDDL name (letters, digits, - and _, a letter first): rename it"
            )
        if kind == "predicate" and low in NO_PREDICATES:
            raise InputError(f"predicate '{name}' has the name of a word of PDDL: rename it")
        if kind in others:
            raise InputError(f"two {kind}s are called '{low}' in PDDL, which ignores case: rename one")
        if spelled.get(low, name) != name:
            raise InputError(f"'{name}' and '{spelled[low]}' are both '{low}' in PDDL: rename one")
        spelled[low] = name
        others.add(kind)
    for constant in domain.constants:
        if "type" in used[constant.name.lower()]:
            raise InputError(f"'{constant.name}' names a type and a constant: rename one")
    for title in [domain.name] + ([problem.name] if problem else []):
        low = title.lower()
        if not NAME.match(low):
            raise InputError(
                f"'{title}' is no PDDL name (letters, digits, - and _, a letter first): rename it"
            )
        if spelled.setdefault(low, title) != title:
            raise InputError(f"'{title}' and '{spelled[low]}' are both '{low}' in PDDL: rename one")
    for operator in domain.operators:
        if len({v.name.lower() for v in operator.parameters}) < len(operator.parameters):
            names = ", ".join(v.name for v in operator.parameters)
            raise InputError(f"{operator.name}: PDDL cannot tell its parameters {names} apart: rename one")
    return spelled


def object_names(problem: Problem, domain: Domain) -> dict[str, str]:
    """Return how a problem's objects are called in PDDL: one with the name of a type gets a longer name.

    PDDL could tell them apart, but unified-planning cannot. Raises InputError as ``model_names``.
    """
    model_names(domain, problem)
    types = {t.name.lower() for t in domain.types}
    taken = types | {o.name.lower() for o in problem.objects}
    names = {}
    for obj in problem.objects:
        name = obj.name.lower()
        if name in types:
            while name in taken:
                name += "-object"
            taken.add(name)
        names[obj.name] = name
    return names


def write_domain(domain: Domain, header: str = "", comments: Mapping[str, str] | None = None) -> str:
    """Return a domain as PDDL text; ``comments`` are put above the operators of those names."""
    model_names(domain)
    lines = _comment(header, "")
    lines += [
        f"(define (domain {domain.name.lower()})",
        f"  (:requirements {' '.join(_requirements(domain))})",
    ]
    if domain.types:
        pairs = [(t.name.lower(), t.parent or OBJECT) for t in domain.types]
        lines += _section("types", _typed(pairs))
    if domain.constants:
        lines += _section("constants", _typed([(o.name.lower(), o.type) for o in domain.constants]))
    lines += _section("predicates", [_signature(p, bool(domain.types)) for p in domain.predicates])
    for operator in domain.operators:
        lines.append("")
        lines += _comment((comments or {}).get(operator.name, ""), "  ")
        lines += _operator(operator, bool(domain.types))
    return "\n".join(lines) + ")\n"


def write_problem(problem: Problem, domain: Domain, header: str = "") -> str:
    """Return a problem as PDDL text, with the objects' names of ``object_names``."""
    names = object_names(problem, domain)

    def written(atoms: Iterable[GroundAtom]) -> list[str]:
        rows = (
            [a.predicate.name.lower(), *(names.get(o.name, o.name.lower()) for o in a.objects)]
            for a in sort_atoms(atoms)
        )
        return [f"({' '.join(row)})" for row in rows]

    goal = written(problem.goal) + [f"(not {text})" for text in written(problem.negative_goal)]
    pairs = [(names[o.name], o.type) for o in problem.objects]
    lines = _comment(header, "")
    lines += [f"(define (problem {problem.name.lower()})", f"  (:domain {domain.name.lower()})"]
    if problem.negative_goal:
        lines.append(f"  (:requirements {' '.join(_requirements(domain, negative=True))})")
    lines += _section("objects", _typed(pairs) if domain.types else [name for name, _ in pairs])
    lines += _section("init", written(problem.init))
    lines += [f"  (:goal {_conjunction(goal, '    ')}))"]
    return "\n".join(lines) + "\n"


def _comment(text: str, indent: str) -> list[str]:
    return [f"{indent}; {line}".rstrip() for line in text.splitlines()]


def _section(name: str, items: list[str]) -> list[str]:
    """Write a section, one item a line."""
    if not items:
        return [f"  (:{name})"]
    return [f"  (:{name}", *(f"    {item}" for item in items[:-1]), f"    {items[-1]})"]


def _requirements(domain: Domain, negative: bool = False) -> list[str]:
    found = [":strips"]
    if domain.types:
        found.append(":typing")
    if negative or any(o.negative_preconditions for o in domain.operators):
        found.append(":negative-preconditions")
    conditions = (a for o in domain.operators for a in o.preconditions | o.negative_preconditions)
    if any(atom.predicate == EQUAL for atom in conditions):
        found.append(":equality")
    return found


def _typed(pairs: Iterable[tuple[str, Type]]) -> list[str]:
    """Write ``a b - t``, one line for each run of names with one type."""
    runs = groupby(pairs, key=lambda pair: pair[1].name.lower())
    return [f"{' '.join(name for name, _ in run)} - {kind}" for kind, run in runs]


def _variables(pairs: Iterable[tuple[str, Type]], typed: bool) -> str:
    return " ".join(f"{name} - {t.name.lower()}" if typed else name for name, t in pairs)


def _signature(predicate: Predicate, typed: bool) -> str:
    pairs = [(f"?x{i}", t) for i, t in enumerate(predicate.types)]
    return f"({' '.join(filter(None, [predicate.name.lower(), _variables(pairs, typed)]))})"


def _atom(atom: LiftedAtom) -> str:
    return f"({' '.join([atom.predicate.name, *(t.name for t in atom.terms)]).lower()})"


def _conjunction(parts: list[str], indent: str) -> str:
    return f"(and\n{indent}" + f"\n{indent}".join(parts) + ")" if parts else "(and)"


def _operator(operator: Operator, typed: bool) -> list[str]:
    parameters = _variables([(v.name.lower(), v.type) for v in operator.parameters], typed)
    conditions = [_atom(a) for a in sort_atoms(operator.preconditions)]
    conditions += [f"(not {_atom(a)})" for a in sort_atoms(operator.negative_preconditions)]
    effects = [_atom(a) for a in sort_atoms(operator.add_effects)]
    effects += [f"(not {_atom(a)})" for a in sort_atoms(operator.delete_effects)]
    return [
        f"  (:action {operator.name.lower()}",
        f"    :parameters ({parameters})",
        f"    :precondition {_conjunction(conditions, '      ')}",
        f"    :effect {_conjunction(effects, '      ')})",
    ]
