"""Symbolic values: types, objects, predicates, atoms. Operators stand in ``operators``.

Every value is frozen and compared by content. Hashes use names only, because a hash over the nested
fields would be computed anew each time that an atom enters a set.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TypeVar

Atom = TypeVar("Atom", "GroundAtom", "LiftedAtom")


@dataclass(frozen=True, slots=True)
class Type:
    """A type, its features (entries of a state vector, in order) and the type that it specialises.

    >>> block = Type("block", ("x", "width"))
    >>> Type("cube", ("x", "width"), parent=block).is_a(block)
    True

    ``either`` makes it PDDL's ``(either a b)``: what is of type a or of type b. See ``either``, below.
    """

    name: str
    features: tuple[str, ...] = ()
    parent: "Type | None" = None
    either: "tuple[Type, ...]" = ()

    def __hash__(self) -> int:
        return hash(self.name)

    def __repr__(self) -> str:
        return f"<type {self.name}>"

    def __eq__(self, other: object) -> bool:
        """Compare by content; a loop, as recursion would not survive a long line of ancestors."""
        if not isinstance(other, Type):
            return NotImplemented
        one: Type | None = self
        two: Type | None = other
        while one is not two:
            if one is None or two is None or one.name != two.name:
                return False
            if one.features != two.features or one.either != two.either:
                return False
            one, two = one.parent, two.parent
        return True

    def is_a(self, ancestor: "Type") -> bool:
        """Say whether every object of this type is one of ``ancestor`` too."""
        if self is ancestor or ancestor == OBJECT:
            return True
        if self.either:
            return all(kind.is_a(ancestor) for kind in self.either)
        if ancestor.either:
            return any(self.is_a(kind) for kind in ancestor.either)
        step: Type | None = self
        while step is not None:
            if step == ancestor:
                return True
            step = step.parent
        return False


OBJECT = Type("object")  # the root of all types in PDDL; types without a parent stand right below it


def either(types: Iterable[Type]) -> Type:
    """Return the type of what is of one of the given types, each named once; of one type, that type."""
    kinds = tuple(dict.fromkeys(types))
    if len(kinds) == 1 or OBJECT in kinds:
        return OBJECT if OBJECT in kinds else kinds[0]
    return Type(f"(either {' '.join(kind.name for kind in kinds)})", either=kinds)


@dataclass(frozen=True, slots=True)
class Object:
    """A thing of a task. Two objects of one task never share a name.

    >>> Object("block0", Type("block"))
    <block0:block>
    """

    name: str
    type: Type

    def __hash__(self) -> int:
        return hash(self.name)

    def __repr__(self) -> str:
        return f"<{self.name}:{self.type.name}>"

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True, slots=True)
class Variable:
    """A parameter of an operator; its name starts with ``?``.

    >>> Variable("?block", Type("block"))
    <?block:block>
    """

    name: str
    type: Type

    def __hash__(self) -> int:
        return hash(self.name)

    def __repr__(self) -> str:
        return f"<{self}>"

    def __str__(self) -> str:
        return f"{self.name}:{self.type.name}"


@dataclass(frozen=True, slots=True)
class Predicate:
    """A relation over objects of the given types.

    Applied to objects it gives a ground atom, ``lifted`` over variables a lifted one.

    >>> block = Type("block")
    >>> holding = Predicate("Holding", (block,))
    >>> holding(Object("block0", block)), holding.lifted(Variable("?b", block))
    (<Holding(block0)>, <Holding(?b:block)>)
    """

    name: str
    types: tuple[Type, ...]

    def __hash__(self) -> int:
        return hash(self.name)

    def __repr__(self) -> str:
        return f"<{self.signature}>"

    def __call__(self, *objects: Object) -> "GroundAtom":
        """Apply the predicate to objects; raise ValueError on a wrong number or type."""
        self.check([o.type for o in objects])
        return GroundAtom(self, objects)

    def lifted(self, *terms: "Variable | Object") -> "LiftedAtom":
        """Apply the predicate to variables and constants; raise ValueError on a wrong number or type."""
        self.check([t.type for t in terms])
        return LiftedAtom(self, terms)

    @property
    def signature(self) -> str:
        """The name with the argument types, for messages."""
        return f"{self.name}({', '.join(t.name for t in self.types)})"

    def check(self, types: list[Type]) -> None:
        """Raise ValueError unless the arguments' types fit."""
        if len(types) != len(self.types):
            raise ValueError(f"{self.name} takes {len(self.types)} argument(s), not {len(types)}")
        for place, (given, wanted) in enumerate(zip(types, self.types, strict=True), 1):
            if not given.is_a(wanted):
                raise ValueError(f"{self.name}: argument {place} is of type {given.name}, not {wanted.name}")


EQUAL = Predicate(
    "=", (OBJECT, OBJECT)
)  # built in: only in preconditions, decided when an operator is ground


@dataclass(frozen=True, slots=True)
class GroundAtom:
    """A predicate applied to objects.

    >>> Predicate("HandEmpty", ())()
    <HandEmpty()>
    """

    predicate: Predicate
    objects: tuple[Object, ...]

    def __hash__(self) -> int:
        return hash((self.predicate.name, self.objects))

    def __repr__(self) -> str:
        return f"<{self}>"

    def __str__(self) -> str:
        return f"{self.predicate.name}({', '.join(o.name for o in self.objects)})"


@dataclass(frozen=True, slots=True)
class LiftedAtom:
    """A predicate applied to variables (and, in domains with constants, objects).

    >>> Predicate("HandEmpty", ()).lifted()
    <HandEmpty()>
    """

    predicate: Predicate
    terms: tuple[Variable | Object, ...]

    def __hash__(self) -> int:
        return hash((self.predicate.name, self.terms))

    def __repr__(self) -> str:
        return f"<{self}>"

    def __str__(self) -> str:
        return f"{self.predicate.name}({', '.join(map(str, self.terms))})"

    def ground(self, binding: Mapping[Variable, Object]) -> GroundAtom:
        """Replace the variables by objects."""
        objects = (binding[t] if isinstance(t, Variable) else t for t in self.terms)
        return GroundAtom(self.predicate, tuple(objects))


def canonical_order(objects: Iterable[Object]) -> tuple[Object, ...]:
    """Sort objects by name, ties by type name: the order of every loop over objects."""
    return tuple(sorted(objects, key=lambda o: (o.name, o.type.name)))


def sort_atoms(atoms: Iterable[Atom]) -> list[Atom]:
    """Sort atoms as text, for output and wherever a set becomes a sequence."""
    return sorted(atoms, key=str)
