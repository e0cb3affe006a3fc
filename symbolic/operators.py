"""Operators, lifted and ground; domains and problems: what PDDL files say."""

from collections.abc import Iterable
from dataclasses import dataclass, field, fields
from html import escape
from typing import Any

from bpns.symbolic.structs import EQUAL, GroundAtom, LiftedAtom, Object, Predicate, Type, Variable, sort_atoms


@dataclass(frozen=True, slots=True)
class Operator:
    """When something can happen (preconditions) and what it changes (effects), over parameters.

    Printed, it has the notation of the paper.

    >>> block = Type("block")
    >>> b, holding = Variable("?b", block), Predicate("Holding", (block,))
    >>> pick = Operator("pick", (b,), frozenset(), frozenset({holding.lifted(b)}), frozenset())
    >>> pick.ground((Object("block0", block),)).add_effects
    frozenset({<Holding(block0)>})

    Preconditions of either sign may hold atoms of ``EQUAL``; effects may not, nor may any abstract state.
    """

    name: str
    parameters: tuple[Variable, ...]
    preconditions: frozenset[LiftedAtom]
    add_effects: frozenset[LiftedAtom]
    delete_effects: frozenset[LiftedAtom]
    negative_preconditions: frozenset[LiftedAtom] = frozenset()

    def __hash__(self) -> int:
        return hash(self.name)

    def __repr__(self) -> str:
        return f"<{self.name}({', '.join(map(str, self.parameters))})>"

    def __str__(self) -> str:
        """Return the operator in the notation of the paper's figure 10."""
        return "\n".join(
            [f"{self.name}:", *(f"  {title}: [{', '.join(texts)}]" for title, texts in self._rows())]
        )

    def _repr_html_(self) -> str:
        """Return the operator as a table, for notebooks."""

        def code(text: str) -> str:
            return f"<code>{escape(text)}</code>"

        rows = "".join(
            f"<tr><th style='text-align:left'>{title}</th>"
            f"<td style='text-align:left'>{', '.join(map(code, texts))}</td></tr>"
            for title, texts in self._rows()
        )
        return f"<table><caption><b>{escape(self.name)}</b></caption>{rows}</table>"

    def _rows(self) -> list[tuple[str, list[str]]]:
        conditions = [str(atom) for atom in sort_atoms(self.preconditions)]
        conditions += [f"not {atom}" for atom in sort_atoms(self.negative_preconditions)]
        return [
            ("Parameters", [str(variable) for variable in self.parameters]),
            ("Preconditions", conditions),
            ("Add Effects", [str(atom) for atom in sort_atoms(self.add_effects)]),
            ("Delete Effects", [str(atom) for atom in sort_atoms(self.delete_effects)]),
        ]

    def ground(self, objects: tuple[Object, ...]) -> "GroundOperator":
        """Bind the parameters; raise ValueError where the number, a type or an (in)equality is wrong."""
        if len(objects) != len(self.parameters):
            raise ValueError(f"{self.name} takes {len(self.parameters)} objects, not {len(objects)}")
        for variable, obj in zip(self.parameters, objects, strict=True):
            if not obj.type.is_a(variable.type):
                raise ValueError(f"{self.name}: {obj.name} is no {variable.type.name}")
        binding = dict(zip(self.parameters, objects, strict=True))

        def bind(atoms: frozenset[LiftedAtom]) -> frozenset[GroundAtom]:
            return frozenset(atom.ground(binding) for atom in atoms)

        def decide(atoms: frozenset[LiftedAtom], equal: bool) -> frozenset[GroundAtom]:
            bound = bind(atoms)
            equalities = [atom for atom in bound if atom.predicate.name == EQUAL.name]
            if not equalities:
                return bound
            for one, two in (atom.objects for atom in sort_atoms(equalities)):
                if (one == two) != equal:
                    must = "be one object" if equal else "differ"
                    raise ValueError(f"{self.name}: {one.name} and {two.name} must {must}")
            return bound.difference(equalities)

        return GroundOperator(
            self,
            objects,
            decide(self.preconditions, True),
            bind(self.add_effects),
            bind(self.delete_effects),
            decide(self.negative_preconditions, False),
        )


@dataclass(frozen=True, slots=True)
class GroundOperator:
    """An operator with objects; the atom sets are its operator's with the variables replaced.

    ``Operator.ground`` makes one.

    >>> Operator("wait", (), frozenset(), frozenset(), frozenset()).ground(())
    <wait()>
    """

    operator: Operator
    objects: tuple[Object, ...]
    preconditions: frozenset[GroundAtom] = field(compare=False)
    add_effects: frozenset[GroundAtom] = field(compare=False)
    delete_effects: frozenset[GroundAtom] = field(compare=False)
    negative_preconditions: frozenset[GroundAtom] = field(compare=False)
    _hash: int = field(init=False, compare=False, repr=False)  # a search asks for it all the time

    def __post_init__(self) -> None:
        object.__setattr__(self, "_hash", hash((self.operator.name, self.objects)))

    def __hash__(self) -> int:
        return self._hash

    def __repr__(self) -> str:
        return f"<{self}>"

    def __reduce__(self) -> tuple[Any, ...]:
        """Build it anew: in another process names have other hashes."""
        return GroundOperator, tuple(getattr(self, one.name) for one in fields(self) if one.init)

    def __str__(self) -> str:
        return f"{self.operator.name}({', '.join(o.name for o in self.objects)})"

    @property
    def call(self) -> str:
        """The step as planners write it: ``(pick block0 robby)``."""
        return f"({' '.join([self.operator.name, *(o.name for o in self.objects)])})".lower()

    def applicable(self, atoms: frozenset[GroundAtom]) -> bool:
        """Say whether the preconditions hold in an abstract state."""
        return self.preconditions <= atoms and not self.negative_preconditions & atoms

    def apply(self, atoms: frozenset[GroundAtom]) -> frozenset[GroundAtom]:
        """Return the next abstract state; as in PDDL, an atom both deleted and added holds."""
        return (atoms - self.delete_effects) | self.add_effects


@dataclass(frozen=True, slots=True)
class Domain:
    """Types, constants, predicates and operators: what a PDDL domain file says.

    >>> wait = Operator("wait", (), frozenset(), frozenset(), frozenset())
    >>> Domain("patience", (), (), (wait,))
    <domain patience: wait>
    """

    name: str
    types: tuple[Type, ...]
    predicates: tuple[Predicate, ...]
    operators: tuple[Operator, ...]
    constants: tuple[Object, ...] = ()

    def __repr__(self) -> str:
        return f"<domain {self.name}: {', '.join(one.name for one in self.operators)}>"

    def with_operators(self, operators: Iterable[Operator]) -> "Domain":
        """Return the same domain with other operators."""
        return Domain(self.name, self.types, self.predicates, tuple(operators), self.constants)


@dataclass(frozen=True, slots=True)
class Problem:
    """Objects, initial atoms and goal: what a PDDL problem file says. Constants are the domain's.

    >>> done = Predicate("Done", ())
    >>> Problem("p01", (), frozenset(), frozenset({done()}))
    <problem p01: 0 objects, 1 goal atoms>
    """

    name: str
    objects: tuple[Object, ...]
    init: frozenset[GroundAtom]
    goal: frozenset[GroundAtom]
    negative_goal: frozenset[GroundAtom] = frozenset()

    def __repr__(self) -> str:
        return f"<problem {self.name}: {len(self.objects)} objects, {len(self.goal)} goal atoms>"

    def satisfied(self, atoms: frozenset[GroundAtom]) -> bool:
        """Say whether the goal holds in an abstract state."""
        return self.goal <= atoms and not self.negative_goal & atoms
