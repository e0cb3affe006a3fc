"""Legal names and plain types: a task spelled so that every planner reads it."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import chain

from bpns.symbolic.operators import Domain, Operator, Problem
from bpns.symbolic.pddl.rewriting.legal import Names
from bpns.symbolic.structs import EQUAL, OBJECT, GroundAtom, LiftedAtom, Object, Predicate, Type, Variable


@dataclass(frozen=True, slots=True)
class Spelling:
    """The new names of a task's types, predicates, operators, objects and titles, by kind and old name."""

    names: Names  # for more names that differ from all of these
    legal: dict[tuple[str, str], str]

    @classmethod
    def of(cls, domain: Domain, problem: Problem) -> "Spelling":
        """Name everything in a task."""
        wishes = [("type", t.name) for t in _all_types(domain)]
        wishes += [("predicate", p.name) for p in domain.predicates]
        wishes += [("operator", o.name) for o in domain.operators]
        wishes += [("object", o.name) for o in (*domain.constants, *problem.objects)]
        wishes += [("domain", domain.name), ("problem", problem.name)]
        names = Names()
        return cls(names, names.legal(wishes))


def plain_task(domain: Domain, problem: Problem, spelling: Spelling, typing: bool) -> tuple[Domain, Problem]:
    """Return a task with new names and without ``either``, or without any types.

    Where the plain type of a parameter has objects that the parameter cannot be, a static predicate with one
    argument says which objects it can be.
    """
    return _Plain(domain, problem, spelling, typing).task()


def _all_types(domain: Domain) -> list[Type]:
    """Return the domain's types without ``object`` and ``either``, with all their ancestors."""
    found: dict[str, Type] = {}
    for kind in domain.types:
        step: Type | None = kind
        while step is not None and step != OBJECT and not step.either:
            found.setdefault(step.name, step)
            step = step.parent
    return list(found.values())


def _ancestors(kind: Type) -> list[Type]:
    """Return a type and what it specialises, nearest first; ``either`` gives the common ones."""
    if kind.either:
        first, *others = map(_ancestors, kind.either)
        return [t for t in first if all(t in other for other in others)]
    return [kind, *(_ancestors(kind.parent) if kind.parent else [OBJECT])] if kind != OBJECT else [OBJECT]


@dataclass(slots=True)
class _Plain:
    domain: Domain
    problem: Problem
    spelling: Spelling
    typing: bool
    types: dict[str, Type] = field(default_factory=dict)  # new ones, by old name
    guards: dict[str, Predicate | None] = field(default_factory=dict)  # static predicates, by old type
    guarded: set[GroundAtom] = field(default_factory=set)  # the static predicates' atoms

    @property
    def objects(self) -> tuple[Object, ...]:
        return (*self.domain.constants, *self.problem.objects)

    def task(self) -> tuple[Domain, Problem]:
        """Translate everything."""
        types = tuple(self.type(t) for t in _all_types(self.domain)) if self.typing else ()
        operators = tuple(map(self.operator, self.domain.operators))
        guards = [guard for guard in self.guards.values() if guard is not None]
        predicates = (*map(self.predicate, self.domain.predicates), *guards)
        wanted = {t for p in predicates for t in p.types} | {v.type for o in operators for v in o.parameters}

        conditions = chain.from_iterable((*o.preconditions, *o.negative_preconditions) for o in operators)
        compared = {term for atom in conditions if atom.predicate == EQUAL for term in atom.terms}

        def kept(objects: Iterable[Object]) -> tuple[Object, ...]:
            # Nothing can be said of the others, and unified-planning does not read them.
            plain = [self.object(o) for o in objects]
            return tuple(o for o in plain if o.type != OBJECT or OBJECT in wanted or o in compared)

        domain, problem, legal = self.domain, self.problem, self.spelling.legal
        return Domain(
            legal["domain", domain.name], types, predicates, operators, kept(domain.constants)
        ), Problem(
            legal["problem", problem.name],
            kept(problem.objects),
            self.ground(problem.init) | self.guarded,
            self.ground(problem.goal),
            self.ground(problem.negative_goal),
        )

    def type(self, old: Type) -> Type:
        """Return the plain type that has all objects of the old one."""
        if not self.typing or old == OBJECT:
            return OBJECT
        if old.either:
            return self.type(_ancestors(old)[0])
        if old.name not in self.types:
            parent = self.type(old.parent) if old.parent else OBJECT
            name = self.spelling.legal["type", old.name]
            self.types[old.name] = Type(name, (), None if parent == OBJECT else parent)
        return self.types[old.name]

    def guard(self, old: Type) -> Predicate | None:
        """Return the static predicate that tells a type's objects from others of its plain type, if any."""
        if old.name not in self.guards:
            plain = self.type(old)
            candidates = [o for o in self.objects if self.type(o.type).is_a(plain)]
            fitting = [o for o in candidates if o.type.is_a(old)]
            self.guards[old.name] = None
            if len(fitting) < len(candidates):
                wish = "-or-".join(t.name for t in old.either) or old.name
                guard = Predicate(self.spelling.names.fresh(f"is-{wish}", "predicate"), (plain,))
                self.guards[old.name] = guard
                self.guarded |= {GroundAtom(guard, (self.object(o),)) for o in fitting}
        return self.guards[old.name]

    def object(self, old: Object) -> Object:
        return Object(self.spelling.legal["object", old.name], self.type(old.type))

    def predicate(self, old: Predicate) -> Predicate:
        if ("predicate", old.name) not in self.spelling.legal:
            return old  # equality
        name = self.spelling.legal["predicate", old.name]
        return Predicate(name, tuple(map(self.type, old.types)))

    def ground(self, atoms: Iterable[GroundAtom]) -> frozenset[GroundAtom]:
        return frozenset(
            GroundAtom(self.predicate(a.predicate), tuple(map(self.object, a.objects))) for a in atoms
        )

    def operator(self, old: Operator) -> Operator:
        names = Names()
        variables = {v: f"?{names.fresh(v.name.lstrip('?'), 'x')}" for v in old.parameters}
        parameters = {v: Variable(name, self.type(v.type)) for v, name in variables.items()}
        guards = [(v, self.guard(v.type)) for v in old.parameters]

        def lifted(atoms: Iterable[LiftedAtom]) -> frozenset[LiftedAtom]:
            return frozenset(
                LiftedAtom(
                    self.predicate(a.predicate),
                    tuple(parameters[t] if isinstance(t, Variable) else self.object(t) for t in a.terms),
                )
                for a in atoms
            )

        return Operator(
            self.spelling.legal["operator", old.name],
            tuple(parameters.values()),
            lifted(old.preconditions) | {g.lifted(parameters[v]) for v, g in guards if g is not None},
            lifted(old.add_effects),
            lifted(old.delete_effects - old.add_effects),  # what is both deleted and added holds
            lifted(old.negative_preconditions),
        )
