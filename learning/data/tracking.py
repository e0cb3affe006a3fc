"""Abstract states along a trajectory: a classifier is asked again only when what it looked at has changed."""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from itertools import product

from bpns.symbolic.skills.environment import Environment
from bpns.symbolic.state import Features, State
from bpns.symbolic.structs import GroundAtom


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
        self.atoms: list[GroundAtom] = []  # all there can be: numbers are hashed faster than atoms
        self.read: list[set[str]] = []  # whose features decided about each atom
        self.readers: dict[str, dict[int, None]] = defaultdict(dict)  # numbers of atoms, by object
        self.holds: list[bool] = []
        self.true: set[GroundAtom] = set()

    def move_to(self, state: State) -> frozenset[GroundAtom]:
        """Return the atoms that hold in a state."""
        last, self.state = self.state, state
        if last is None or last.objects != state.objects:
            self.atoms = [
                GroundAtom(predicate, objects)
                for predicate in self.environment.classifiers
                for objects in product(*(state.of_type(t) for t in predicate.types))
            ]
            self.read = [set() for _ in self.atoms]
            self.readers.clear()
            self.holds = [False] * len(self.atoms)
            self.true.clear()
            self._ask(range(len(self.atoms)), state)
        else:
            before = last.features
            changed = [n for n, now in state.features.items() if now is not before[n] and now != before[n]]
            self._ask(dict.fromkeys(n for name in changed for n in self.readers[name]), state)
        return frozenset(self.true)

    def _ask(self, numbers: Iterable[int], state: State) -> None:
        """Ask atoms' classifiers and note whose features they look at."""
        seen = _Seen(state.features)
        watched = State(state.objects, seen, state.by_type)
        for number in numbers:
            atom = self.atoms[number]
            now: set[str] = set()
            seen.names = now
            true = bool(self.environment.classifiers[atom.predicate](watched, atom.objects))
            if true != self.holds[number]:
                self.holds[number] = true
                (self.true.add if true else self.true.discard)(atom)
            before = self.read[number]
            if now != before:
                self.read[number] = now
                for name in before - now:
                    del self.readers[name][number]
                for name in now - before:
                    self.readers[name][number] = None
