"""Read PDDL domains and problems: ``:strips :typing :negative-preconditions :constants``, any case.

Everything else in the language is refused as unsupported, by name and with its place. Names are lower-cased
as PDDL demands; ``names`` gives their spelling in our model (``handempty`` -> ``HandEmpty``).
"""

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn

from symbolic.errors import PddlError, UnsupportedPddl
from symbolic.files import read_text
from symbolic.pddl.lists import List, Node, Word, parse_lists
from symbolic.pddl.vocabulary import (
    ACTION_KEYS,
    DOMAIN_SECTIONS,
    NAME,
    NO_PREDICATES,
    PROBLEM_SECTIONS,
    REQUIREMENTS,
    UNSUPPORTED_FORMULAS,
    UNSUPPORTED_SECTIONS,
)
from symbolic.structs import (
    OBJECT,
    Domain,
    GroundAtom,
    LiftedAtom,
    Object,
    Operator,
    Predicate,
    Problem,
    Type,
    Variable,
)


class PddlWarning(UserWarning):
    """Something that strict readers refuse; the text carries the place."""


def read_domain(path: Path, names: Mapping[str, str] | None = None) -> Domain:
    """Read a domain file; raise PddlError, UnsupportedPddl or InputError."""
    return parse_domain(read_text(path), str(path), names)


def read_problem(path: Path, domain: Domain, names: Mapping[str, str] | None = None) -> Problem:
    """Read a problem file of a domain; raise PddlError, UnsupportedPddl or InputError."""
    return parse_problem(read_text(path), domain, str(path), names)


def parse_domain(text: str, path: str = "<text>", names: Mapping[str, str] | None = None) -> Domain:
    """Return the domain that a text describes; see the module's docstring."""
    return _Reader(path, names or {}).domain(parse_lists(text, path))


def parse_problem(
    text: str, domain: Domain, path: str = "<text>", names: Mapping[str, str] | None = None
) -> Problem:
    """Return the problem that a text describes; see the module's docstring."""
    reader = _Reader(path, names or {})
    reader.adopt(domain)
    return reader.problem(parse_lists(text, path), domain)


def _have(names: "Mapping[str, object]") -> str:
    return f"(have: {', '.join(sorted(names)) or 'none'})"


@dataclass(slots=True)
class _Reader:
    """Knows the path for messages, the spelling of names, and what has been declared so far."""

    path: str
    names: Mapping[str, str]
    types: dict[str, Type] = field(default_factory=lambda: {"object": OBJECT})
    objects: dict[str, Object] = field(default_factory=dict)
    predicates: dict[str, Predicate] = field(default_factory=dict)
    requirements: frozenset[str] = frozenset()

    def fail(self, node: Node, message: str) -> NoReturn:
        raise PddlError(self.path, node.line, node.column, message)

    def unsupported(self, node: Node, feature: str) -> NoReturn:
        raise UnsupportedPddl(self.path, node.line, node.column, f"unsupported PDDL: {feature}")

    def warn(self, node: Node, message: str) -> None:
        warnings.warn(f"{self.path}:{node.line}:{node.column}: {message}", PddlWarning, stacklevel=2)

    def need(self, node: Node, flag: str, *also: str) -> None:
        if not self.requirements & {flag, ":adl", *also}:
            self.warn(node, f"{flag} is used but missing in :requirements")

    def word(self, node: Node, what: str) -> Word:
        if isinstance(node, List):
            self.fail(node, f"expected {what}, found a list")
        return node

    def name(self, node: Node, what: str) -> str:
        word = self.word(node, what)
        if not NAME.match(word.text):
            self.fail(word, f"'{word.text}' is no name for {what} (letters, digits, - and _, a letter first)")
        return word.text

    def spelled(self, name: str) -> str:
        return self.names.get(name, name)

    def typed_list(self, items: tuple[Node, ...], what: str) -> list[tuple[Word, Word | None]]:
        """Read ``a b - t c``: each name with its type's word, None where there is none."""
        pairs: list[tuple[Word, Word | None]] = []
        waiting: list[Word] = []
        position = 0
        while position < len(items):
            word = self.word(items[position], what)
            if word.text == "-":
                if position + 1 == len(items) or not waiting:
                    self.fail(word, f"'-' must stand between {what} and a type")
                kind = items[position + 1]
                if isinstance(kind, List):
                    if kind.head == "either":
                        self.unsupported(kind, "either")
                    self.fail(kind, "expected a type, found a list")
                pairs += [(w, kind) for w in waiting]
                waiting = []
                position += 1
            else:
                waiting.append(word)
            position += 1
        return pairs + [(w, None) for w in waiting]

    def type_of(self, word: Word | None) -> Type:
        if word is None:
            return OBJECT
        if word.text not in self.types:
            self.fail(word, f"unknown type '{word.text}' {_have(self.types)}")
        return self.types[word.text]

    def sections(self, tree: List, kind: str, allowed: tuple[str, ...]) -> tuple[str, list[List]]:
        """Check ``(define (kind name) ...)``; return the name and the sections."""
        if tree.head != "define" or len(tree.items) < 2:
            self.fail(tree, f"expected (define ({kind} NAME) ...)")
        title = tree.items[1]
        if not isinstance(title, List) or title.head != kind or len(title.items) != 2:
            found = f"({title.head} ...)" if isinstance(title, List) else f"'{title.text}'"
            self.fail(title, f"expected ({kind} NAME), found {found}: is this the right file?")
        sections = []
        seen: set[str] = set()
        for node in tree.items[2:]:
            if not isinstance(node, List) or not node.items:
                self.fail(node, f"expected a section such as ({allowed[-1]} ...)")
            if node.head in UNSUPPORTED_SECTIONS:
                self.unsupported(node, node.head)
            if node.head not in allowed:
                self.fail(node, f"unknown section '{node.head}' (have: {', '.join(allowed)})")
            if node.head in seen and node.head != ":action":
                self.fail(node, f"a second {node.head} section: merge it with the first")
            seen.add(node.head)
            sections.append(node)
        return self.name(title.items[1], f"a {kind}"), sections

    def read_requirements(self, section: List) -> None:
        flags = set()
        for node in section.items[1:]:
            flag = self.word(node, "a requirement")
            if flag.text not in REQUIREMENTS:
                self.fail(
                    flag, f"unknown requirement '{flag.text}' (have: {', '.join(sorted(REQUIREMENTS))})"
                )
            flags.add(flag.text)
        self.requirements = frozenset(flags)

    def domain(self, tree: List) -> Domain:
        name, sections = self.sections(tree, "domain", DOMAIN_SECTIONS)
        readers: dict[str, Callable[[List], None]] = {
            ":requirements": self.read_requirements,
            ":types": self.read_types,
            ":constants": self.read_objects,
            ":predicates": self.read_predicates,
        }
        for kind, read in readers.items():  # people write them in any order
            for section in sections:
                if section.head == kind:
                    read(section)
        operators: dict[str, Operator] = {}
        for section in sections:
            if section.head == ":action":
                operator = self.operator(section)
                if operator.name.lower() in operators:
                    self.fail(section.items[1], f"a second operator '{operator.name}': rename one")
                operators[operator.name.lower()] = operator
        types = tuple(t for t in self.types.values() if t != OBJECT)
        return Domain(
            self.spelled(name),
            types,
            tuple(self.predicates.values()),
            tuple(operators.values()),
            tuple(self.objects.values()),
        )

    def read_types(self, section: List) -> None:
        self.need(section, ":typing")
        parents: dict[str, Word | None] = {}
        words: dict[str, Word] = {}
        for word, parent in self.typed_list(section.items[1:], "a type"):
            name = self.name(word, "a type")
            if name == "object" and parent is None:
                continue
            if name in words:
                self.fail(word, f"a second type '{name}': remove it")
            words[name], parents[name] = word, parent
        for parent in list(parents.values()):
            if parent is not None and parent.text not in parents and parent.text != "object":
                parents[self.name(parent, "a type")] = None  # declared by being named as a parent
                words[parent.text] = parent
        for name in parents:
            chain = [name]
            step = parents[name]
            while step is not None and step.text != "object":
                if step.text in chain:
                    self.fail(words[name], f"type '{name}' is its own ancestor: {' - '.join(chain)}")
                chain.append(step.text)
                step = parents[step.text]
            for link in reversed(chain):
                above = parents[link]
                parent_type = self.types[above.text] if above and above.text != "object" else None
                self.types.setdefault(link, Type(self.spelled(link), (), parent_type))
        order = {name: self.types[name] for name in parents}
        self.types = {"object": OBJECT, **order}

    def read_objects(self, section: List) -> None:
        for word, kind in self.typed_list(section.items[1:], "an object"):
            name = self.name(word, "an object")
            if name in self.objects:
                self.fail(word, f"a second object '{name}': rename one")
            if name in self.types:
                self.fail(word, f"'{name}' is already a type: rename the object")
            self.objects[name] = Object(self.spelled(name), self.type_of(kind))

    def read_predicates(self, section: List) -> None:
        for node in section.items[1:]:
            if not isinstance(node, List) or not node.items:
                self.fail(node, "expected a predicate such as (on ?x ?y)")
            name = self.name(node.items[0], "a predicate")
            if name in NO_PREDICATES:
                self.fail(node.items[0], f"'{name}' begins a formula, it cannot be a predicate: rename it")
            if name in self.predicates:
                self.fail(node, f"a second predicate '{name}': rename one")
            parameters = self.parameters(node.items[1:])
            self.predicates[name] = Predicate(self.spelled(name), tuple(v.type for v in parameters.values()))

    def parameters(self, items: tuple[Node, ...]) -> dict[str, Variable]:
        found: dict[str, Variable] = {}
        for word, kind in self.typed_list(items, "a variable"):
            if not word.text.startswith("?") or not NAME.match(word.text[1:]):
                self.fail(word, f"expected a variable such as ?x, found '{word.text}'")
            if word.text in found:
                self.fail(word, f"a second parameter '{word.text}': rename one")
            found[word.text] = Variable(word.text, self.type_of(kind))
        return found

    def operator(self, section: List) -> Operator:
        if len(section.items) < 2:
            self.fail(section, "an action without a name")
        name = self.name(section.items[1], "an action")
        rest = section.items[2:]
        parts: dict[str, Node] = {}
        for key, value in zip(rest[::2], rest[1::2], strict=False):
            word = self.word(key, f"one of {', '.join(ACTION_KEYS)}")
            if word.text not in ACTION_KEYS:
                self.fail(
                    word, f"unknown part '{word.text}' of action {name} (have: {', '.join(ACTION_KEYS)})"
                )
            if word.text in parts:
                self.fail(word, f"a second {word.text} in action {name}: remove one")
            parts[word.text] = value
        if len(rest) % 2:
            self.fail(rest[-1], f"action {name}: this part has no value")
        if ":effect" not in parts:
            self.fail(section, f"action {name} has no :effect")
        listed = parts.get(":parameters", List((), section.line, section.column))
        if not isinstance(listed, List):
            self.fail(listed, f"expected a list of parameters, found '{listed.text}'")
        variables = self.parameters(listed.items)
        positive: set[LiftedAtom] = set()
        negative: set[LiftedAtom] = set()
        if ":precondition" in parts:
            self.formula(parts[":precondition"], variables, positive, negative)
            if negative:
                self.need(parts[":precondition"], ":negative-preconditions")
        add: set[LiftedAtom] = set()
        delete: set[LiftedAtom] = set()
        self.formula(parts[":effect"], variables, add, delete)
        return Operator(
            self.spelled(name),
            tuple(variables.values()),
            frozenset(positive),
            frozenset(add),
            frozenset(delete),
            frozenset(negative),
        )

    def formula(
        self, node: Node, variables: Mapping[str, Variable], true: set[LiftedAtom], false: set[LiftedAtom]
    ) -> None:
        """Sort a conjunction's atoms into those that are to be true and those that are to be false."""
        stack: list[tuple[Node, bool]] = [(node, True)]
        while stack:
            part, positive = stack.pop()
            if not isinstance(part, List):
                self.fail(part, f"expected an atom in parentheses, found '{part.text}'")
            if part.head == "and" and positive:
                stack += [(item, True) for item in reversed(part.items[1:])]
            elif part.head == "not" and positive:
                if len(part.items) != 2:
                    self.fail(part, "(not ...) takes one atom")
                stack.append((part.items[1], False))
            elif part.head in UNSUPPORTED_FORMULAS:
                self.unsupported(part, part.head)
            elif part.head in ("and", "not"):
                self.unsupported(part, f"({part.head} ...) inside (not ...)")
            elif part.items or not positive:
                (true if positive else false).add(self.atom(part, variables))

    def atom(self, node: List, variables: Mapping[str, Variable]) -> LiftedAtom:
        """Read an atom over variables and objects."""
        if not node.items:
            self.fail(node, "expected an atom, found ()")
        name = self.word(node.items[0], "a predicate")
        if name.text not in self.predicates:
            self.fail(name, f"unknown predicate '{name.text}' {_have(self.predicates)}")
        terms: list[Variable | Object] = []
        for item in node.items[1:]:
            word = self.word(item, "a variable or an object")
            known: Mapping[str, Variable | Object] = variables if word.text.startswith("?") else self.objects
            if word.text not in known:
                kind = "variable" if word.text.startswith("?") else "object"
                self.fail(word, f"unknown {kind} '{word.text}' {_have(known)}")
            terms.append(known[word.text])
        try:
            return self.predicates[name.text].lifted(*terms)
        except ValueError as error:
            self.fail(node, str(error))

    def adopt(self, domain: Domain) -> None:
        """Start from what a domain declares."""
        self.types |= {t.name.lower(): t for t in domain.types}
        self.objects |= {o.name.lower(): o for o in domain.constants}
        self.predicates |= {p.name.lower(): p for p in domain.predicates}
        self.requirements = frozenset({":adl"})  # the domain's own reading has warned already

    def problem(self, tree: List, domain: Domain) -> Problem:
        name, sections = self.sections(tree, "problem", PROBLEM_SECTIONS)
        by_kind = {section.head: section for section in sections}
        if ":requirements" in by_kind:
            self.read_requirements(by_kind[":requirements"])
        for kind in (":domain", ":init", ":goal"):
            if kind not in by_kind:
                self.fail(tree, f"the problem has no {kind} section")
        section = by_kind[":domain"]
        if len(section.items) != 2 or self.name(section.items[1], "a domain") != domain.name.lower():
            self.fail(
                section, f"this problem is not of domain '{domain.name}': give the domain that it names"
            )
        if ":objects" in by_kind:
            self.read_objects(by_kind[":objects"])
        init: set[GroundAtom] = set()
        for node in by_kind[":init"].items[1:]:
            if not isinstance(node, List):
                self.fail(node, f"expected an atom in parentheses, found '{node.text}'")
            if node.head == "not":
                self.fail(node, "(not ...) in :init: leave it out, what is not listed is false")
            if node.head in UNSUPPORTED_FORMULAS:
                self.unsupported(node, f"{node.head} in :init")
            init.add(self.atom(node, {}).ground({}))
        section = by_kind[":goal"]
        if len(section.items) != 2:
            self.fail(section, "(:goal ...) takes one formula")
        goal: set[LiftedAtom] = set()
        negative: set[LiftedAtom] = set()
        self.formula(section.items[1], {}, goal, negative)
        known = {o.name for o in domain.constants}
        return Problem(
            self.spelled(name),
            tuple(o for o in self.objects.values() if o.name not in known),
            frozenset(init),
            frozenset(a.ground({}) for a in goal),
            frozenset(a.ground({}) for a in negative),
        )
