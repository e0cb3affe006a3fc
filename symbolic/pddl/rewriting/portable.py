"""A task rewritten so that every planner reads it, and the way back from its plans.

The rewritten task has the same plans, step for step: legal names, each used once; no ``either``; a goal that
is not empty; and, as asked for, no negative conditions, no equality, no types.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from bpns.symbolic.operators import Domain, Problem
from bpns.symbolic.pddl.rewriting.plain import Spelling, plain_task
from bpns.symbolic.pddl.rewriting.positive import positive_task
from bpns.symbolic.pddl.write import write_domain, write_problem
from bpns.symbolic.structs import Predicate


@dataclass(frozen=True, slots=True)
class Origin:
    """What a rewritten operator stands for: an operator, and its arguments as places or as objects' names."""

    operator: str
    arguments: tuple[int | str, ...]
    arity: int  # how many arguments the rewritten operator has; some may stand for nothing


@dataclass(frozen=True, slots=True)
class Rewritten:
    """A rewritten task, and what its operators and objects are in the original one."""

    domain: Domain
    problem: Problem
    operators: Mapping[str, Origin]
    objects: Mapping[str, str]

    @property
    def texts(self) -> tuple[str, str]:
        """The domain and the problem as PDDL."""
        return write_domain(self.domain), write_problem(self.problem, self.domain)

    def original(self, name: str, arguments: Sequence[str]) -> tuple[str, tuple[str, ...]]:
        """Return operator and objects of the original task for a step as a planner writes it, in any case.

        Raises ValueError for a step that the rewritten task does not have.
        """
        origin = self.operators.get(name.lower())
        if origin is None:
            raise ValueError(f"unknown operator '{name}'")
        if len(arguments) != origin.arity:
            raise ValueError(f"operator '{name}' takes {origin.arity} object(s), not {len(arguments)}")
        found = []
        for place in origin.arguments:
            if isinstance(place, str):
                found.append(place)
            elif arguments[place].lower() in self.objects:
                found.append(self.objects[arguments[place].lower()])
            else:
                raise ValueError(f"unknown object '{arguments[place]}' in a step of '{name}'")
        return origin.operator, tuple(found)


def portable(
    domain: Domain, problem: Problem, negation: bool, equality: bool, typing: bool = True
) -> Rewritten:
    """Rewrite a task; each flag says whether the planner has that part of PDDL.

    Names that are fine stay as they are. Equality stays in negative conditions only where both are there.
    """
    spelling = Spelling.of(domain, problem)
    named, task = plain_task(domain, problem, spelling, typing)
    plain, task, versions = positive_task(named, task, spelling.names, negation, equality)
    if not task.goal and not task.negative_goal:
        done = Predicate(spelling.names.fresh("nothing-to-do", "predicate"), ())
        plain = replace(plain, predicates=(*plain.predicates, done))
        task = replace(task, init=task.init | {done()}, goal=frozenset({done()}))
    old = {name: wish for (kind, wish), name in spelling.legal.items() if kind == "operator"}
    arity = {o.name: len(o.parameters) for o in plain.operators}
    origins = {new: Origin(old[of], tuple(range(arity[new])), arity[new]) for new, of in versions.items()}
    objects = {name: wish for (kind, wish), name in spelling.legal.items() if kind == "object"}
    return Rewritten(plain, task, origins, objects)
