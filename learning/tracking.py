"""Abstract states along a trajectory: a classifier is asked again only when what it looked at has changed."""

from collections import defaultdict
from collections.abc import Iterator, Mapping
from itertools import product

from symbolic.environment import Environment
from symbolic.state import Features, State
from symbolic.structs import GroundAtom


class _Seen(Mapping[str, Features]):
    """A state's features that note whose were looked at."""

    __slots__ = ("features", "names")

    def __init__(self, features: Mapping[str, Features]) -> None:
        self.features = features
        self.names: set[str] = set()

    def __getitem__(self, name: str) -> Features:
        self.names.add(name)
        return self.features[name]

    def __iter__(self) -> Iterator[str]:
        self.names.update(self.features)
        return iter(self.features)

    def __len__(self) -> int:
        return len(self.features)


class Tracker:
    """Follows all atoms from state to state; the same as ``abstract``, but faster where little changes.

    That is so because classifiers are functions of the state: where all features that one has looked at are
    as they were, it looks at the same ones again and says the same.
    """

    def __init__(self, environment: Environment) -> None:
        self.environment = environment
        self.state: State | None = None
        self.read: dict[GroundAtom, frozenset[str]] = {}  # whose features decided about an atom
        self.readers: dict[str, dict[GroundAtom, None]] = defaultdict(dict)  # atoms by object
        self.true: set[GroundAtom] = set()

    def move_to(self, state: State) -> frozenset[GroundAtom]:
        """Return the atoms that hold in a state."""
        last, self.state = self.state, state
        if last is None or last.objects != state.objects:
            self.read.clear()
            self.readers.clear()
            self.true.clear()
            for predicate in self.environment.classifiers:
                for objects in product(*(state.of_type(t) for t in predicate.types)):
                    self._ask(GroundAtom(predicate, objects), state)
        else:
            before = last.features
            changed = [n for n, now in state.features.items() if now is not before[n] and now != before[n]]
            for atom in dict.fromkeys(a for name in changed for a in self.readers[name]):
                self._ask(atom, state)
        return frozenset(self.true)

    def _ask(self, atom: GroundAtom, state: State) -> None:
        """Ask a classifier and note whose features it looks at."""
        seen = _Seen(state.features)
        watched = State(state.objects, seen, state.by_type)
        if self.environment.classifiers[atom.predicate](watched, atom.objects):
            self.true.add(atom)
        else:
            self.true.discard(atom)
        before = self.read.get(atom, frozenset())
        if seen.names != before:
            self.read[atom] = now = frozenset(seen.names)
            for name in before - now:
                del self.readers[name][atom]
            for name in now - before:
                self.readers[name][atom] = None
