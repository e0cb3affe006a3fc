"""Compiling away negative conditions and equality, for planners that lack them.

*not p* becomes a predicate of its own that the effects keep opposite to p. Equality becomes static predicates
over the pairs of objects that are the same, or different. Initial atoms of these are written only where the
goal or some reachable ground operator has to do with them.
"""

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, replace

from bpns.symbolic.grounding.ground import GroundProblem, ground
from bpns.symbolic.operators import Domain, GroundOperator, Operator, Problem
from bpns.symbolic.pddl.rewriting.legal import Names
from bpns.symbolic.structs import OBJECT, GroundAtom, LiftedAtom, Predicate, sort_atoms

_EQUAL = "="


def reachable_operators(domain: Domain, problem: Problem) -> tuple[GroundOperator, ...]:
    """Return the ground operators of a task, whether its goal can be reached or not."""
    found = ground(domain, replace(problem, goal=frozenset(), negative_goal=frozenset()))
    assert isinstance(found, GroundProblem)  # an empty goal is never out of reach
    return found.operators


def positive_task(
    domain: Domain, problem: Problem, names: Names, negation: bool, equality: bool
) -> tuple[Domain, Problem, dict[str, str]]:
    """Return a task without negative conditions, without equality, or without both.

    The dictionary gives the operator that each new one is a version of.
    """
    same = {o.name: o.name for o in domain.operators}
    if not equality or not negation:
        domain, problem = _without_equality(domain, problem, names, equality, equality and negation)
    if negation:
        return domain, problem, same
    negative = {a.predicate for o in domain.operators for a in o.negative_preconditions}
    negative |= {a.predicate for a in problem.negative_goal}
    if not negative:
        return domain, problem, same
    complements = {
        p: Predicate(names.fresh(f"not-{p.name}", "predicate"), p.types)
        for p in domain.predicates
        if p in negative
    }
    return _Complement(domain, problem, names, complements).task()


def _split(atoms: Iterable[LiftedAtom]) -> tuple[frozenset[LiftedAtom], frozenset[LiftedAtom]]:
    """Part equalities from other atoms."""
    equal = frozenset(a for a in atoms if a.predicate.name == _EQUAL)
    return equal, frozenset(atoms) - equal


def _without_equality(
    domain: Domain, problem: Problem, names: Names, keep_same: bool, keep_different: bool
) -> tuple[Domain, Problem]:
    """Replace equalities, or only the negative ones, by static predicates."""
    same = Predicate(names.fresh("same", "predicate"), (OBJECT, OBJECT))
    different = Predicate(names.fresh("different", "predicate"), (OBJECT, OBJECT))
    wanted: dict[str, frozenset[LiftedAtom]] = {}
    operators = []
    for operator in domain.operators:
        equal, positive = _split(operator.preconditions)
        unequal, negative = _split(operator.negative_preconditions)
        replaced = frozenset(LiftedAtom(same, a.terms) for a in equal if not keep_same)
        replaced |= frozenset(LiftedAtom(different, a.terms) for a in unequal if not keep_different)
        wanted[operator.name] = replaced
        positive |= replaced | (equal if keep_same else frozenset())
        negative |= unequal if keep_different else frozenset()
        operators.append(replace(operator, preconditions=positive, negative_preconditions=negative))
    used = {a.predicate for replaced in wanted.values() for a in replaced}
    if not used:
        return domain, problem
    pairs: set[GroundAtom] = set()
    for step in reachable_operators(domain, problem):
        binding = dict(zip(step.operator.parameters, step.objects, strict=True))
        pairs |= {a.ground(binding) for a in wanted[step.operator.name]}
    predicates = (*domain.predicates, *(p for p in (same, different) if p in used))
    domain = replace(domain, predicates=predicates, operators=tuple(operators))
    return domain, replace(problem, init=problem.init | pairs)


@dataclass(slots=True)
class _Complement:
    domain: Domain
    problem: Problem
    names: Names
    complements: dict[Predicate, Predicate]

    def task(self) -> tuple[Domain, Problem, dict[str, str]]:
        """Replace negative conditions by complements; see positive_task."""
        steps = reachable_operators(self.domain, self.problem)
        # Those that are only ever deleted too: else abstract states would differ in what nobody asks for.
        tracked = self.problem.negative_goal.union(
            *(s.negative_preconditions for s in steps),
            *([a for a in s.delete_effects if a.predicate in self.complements] for s in steps),
        )
        init = self.problem.init | self.opposite(tracked - self.problem.init)
        by_operator: dict[str, list[GroundOperator]] = defaultdict(list)
        for step in steps:
            by_operator[step.operator.name].append(step)
        operators: list[Operator] = []
        origin: dict[str, str] = {}
        cases: list[Predicate] = []
        for operator in self.domain.operators:
            versions = self.versions(operator, by_operator[operator.name])
            for overridden, members in versions.items():
                version = self.version(operator, overridden)
                if len(versions) > 1:
                    name = self.names.fresh(operator.name, "case") if overridden else operator.name
                    case = Predicate(
                        self.names.fresh(f"{name}-fits", "predicate"),
                        tuple(v.type for v in operator.parameters),
                    )
                    condition = case.lifted(*operator.parameters)
                    version = replace(version, name=name, preconditions=version.preconditions | {condition})
                    cases.append(case)
                    init |= {case(*step.objects) for step in members}
                operators.append(version)
                origin[version.name] = operator.name
        predicates = (*self.domain.predicates, *self.complements.values(), *cases)
        goal = self.problem.goal | self.opposite(self.problem.negative_goal)
        return (
            replace(self.domain, predicates=predicates, operators=tuple(operators)),
            replace(self.problem, init=init, goal=goal, negative_goal=frozenset()),
            origin,
        )

    def opposite(self, atoms: Iterable[GroundAtom]) -> frozenset[GroundAtom]:
        return frozenset(GroundAtom(self.complements[a.predicate], a.objects) for a in atoms)

    def versions(
        self, operator: Operator, steps: list[GroundOperator]
    ) -> dict[frozenset[LiftedAtom], list[GroundOperator]]:
        """Group ground operators by the delete effects that an add effect overrides, with these objects.

        p(x) deleted and p(y) added means, where x is y, that p(x) holds afterwards. Complements would not
        know: both would be added.
        """
        found: dict[frozenset[LiftedAtom], list[GroundOperator]] = {}
        deleted = sort_atoms(a for a in operator.delete_effects if a.predicate in self.complements)
        for step in steps if deleted else ():
            binding = dict(zip(operator.parameters, step.objects, strict=True))
            overridden = frozenset(a for a in deleted if a.ground(binding) in step.add_effects)
            found.setdefault(overridden, []).append(step)
        return found or {frozenset(): steps}

    def version(self, operator: Operator, overridden: frozenset[LiftedAtom]) -> Operator:
        """Write an operator with complements; the overridden effects are left out."""
        deleted = operator.delete_effects - overridden

        def opposite(atoms: Iterable[LiftedAtom]) -> frozenset[LiftedAtom]:
            known = self.complements
            return frozenset(LiftedAtom(known[a.predicate], a.terms) for a in atoms if a.predicate in known)

        return Operator(
            operator.name,
            operator.parameters,
            operator.preconditions | opposite(operator.negative_preconditions),
            operator.add_effects | opposite(deleted),
            deleted | opposite(operator.add_effects),
        )
