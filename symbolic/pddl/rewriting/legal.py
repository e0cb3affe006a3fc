"""Names that every planner reads: lower case, no words of PDDL, each used once across all kinds."""

import re
from collections.abc import Iterable

from bpns.symbolic.pddl.vocabulary import NAME, NO_PREDICATES

# Measured: for each of these, some reader refuses it as the name of a type, a predicate, an operator or an
# object (kairos 1.0.6, unified-planning 1.3, pyperplan 2.1), or the language itself gives it a meaning.
_WORDS = frozenset(
    """object either number always sometime within at-most-once sometime-after sometime-before always-within
    hold-during hold-after is-violated total-cost total-time minimize maximize define domain problem
    undefined""".split()
)
RESERVED = NO_PREDICATES | _WORDS


class Names:
    """Gives out names, none twice."""

    def __init__(self, taken: Iterable[str] = ()) -> None:
        self._taken = {*RESERVED, *taken}
        self._numbers: dict[str, int] = {}  # by stem, the last number that was put behind it

    def fresh(self, wish: str, kind: str) -> str:
        """Return the wish in lower case, or something like it where it is taken or no legal name."""
        name = re.sub(r"[^a-z0-9_-]", "-", wish.lower())
        if not NAME.match(name):
            name = f"{kind}-{name}"
        if name in self._taken:
            name = f"{name}-{kind}"
        stem = name
        while name in self._taken:
            self._numbers[stem] = self._numbers.get(stem, 1) + 1
            name = f"{stem}-{self._numbers[stem]}"
        self._taken.add(name)
        return name

    def legal(self, wishes: Iterable[tuple[str, str]]) -> dict[tuple[str, str], str]:
        """Name (kind, wish) pairs; wishes that are fine stay as they are, the first of several equal ones."""
        found: dict[tuple[str, str], str] = {}
        rest = []
        for kind, wish in wishes:
            if NAME.match(wish) and wish not in self._taken:
                found[kind, wish] = self.fresh(wish, kind)
            else:
                rest.append((kind, wish))
        for kind, wish in rest:
            if (kind, wish) not in found:
                found[kind, wish] = self.fresh(wish, kind)
        return found
