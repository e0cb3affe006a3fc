"""What has been declared so far in a PDDL text, and how its faults are reported."""

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NoReturn

from bpns.symbolic.errors import PddlError, UnsupportedPddl
from bpns.symbolic.pddl.lists import List, Node, Word, pddl_error, shown
from bpns.symbolic.pddl.vocabulary import NAME, TITLE
from bpns.symbolic.structs import OBJECT, Object, Predicate, Type

_MOST_NAMES = 30  # in a message


class PddlWarning(UserWarning):
    """Something that strict readers refuse; the text carries the place."""


class MissingRequirement(PddlWarning):
    """A part of PDDL is used that :requirements does not name."""


@dataclass(slots=True)
class Scope:
    """A text with its path for messages, the spelling of names, and what has been declared so far."""

    text: str
    path: str
    names: Mapping[str, str]
    types: dict[str, Type] = field(default_factory=lambda: {"object": OBJECT})
    objects: dict[str, Object] = field(default_factory=dict)
    predicates: dict[str, Predicate] = field(default_factory=dict)
    requirements: frozenset[str] = frozenset()

    def fail(self, node: Node, message: str) -> NoReturn:
        """Raise the error that the text is wrong at a node."""
        raise pddl_error(self.text, self.path, node.start, message)

    def unsupported(self, node: Node, feature: str, what: str = "") -> NoReturn:
        """Raise the error that a feature is not read, with what it is and what to do."""
        message = f"unsupported PDDL: {feature}" + (f" ({what})" if what else "")
        raise pddl_error(self.text, self.path, node.start, message, UnsupportedPddl)

    def warn(self, node: Node, message: str, kind: type[PddlWarning] = PddlWarning) -> None:
        """Warn about something that is read all the same."""
        place: PddlError = pddl_error(self.text, self.path, node.start, message)
        warnings.warn(str(place), kind, stacklevel=2)

    def need(self, node: Node, flag: str) -> None:
        """Warn where a feature is used whose requirement is missing."""
        if not self.requirements & {flag, ":adl", ":ucpop"}:
            self.warn(node, f"{flag} is used but missing in :requirements", MissingRequirement)

    def word(self, node: Node, what: str) -> Word:
        """Return the node if it is a word; fail otherwise."""
        if isinstance(node, List):
            self.fail(node, f"expected {what}, found a list")
        return node

    def name(self, node: Node, what: str) -> str:
        """Return the name that the node is; fail otherwise."""
        word = self.word(node, what)
        if not NAME.match(word.text):
            fault = f"'{shown(word.text)}' is no name for {what} (letters, digits, - and _, a letter first)"
            self.fail(word, fault)
        return word.text

    def title(self, node: Node, kind: str) -> str:
        """Return a domain's or problem's name; with a warning one that is no name, such as ``5-4.1``."""
        word = self.word(node, f"a {kind}")
        if NAME.match(word.text) or not TITLE.match(word.text):
            return self.name(word, f"a {kind}")
        return kind + "-" + word.text.replace(".", "-")

    def spelled(self, name: str) -> str:
        """Return how a name of the text is spelled in the model."""
        return self.names.get(name, name)


def have(names: Mapping[str, object]) -> str:
    """Return what was allowed, for messages."""
    some = [shown(name) for name in sorted(names)[:_MOST_NAMES]] or ["none"]
    more = [f"and {len(names) - _MOST_NAMES} more"] if len(names) > _MOST_NAMES else []
    return f"(have: {', '.join(some + more)})"
