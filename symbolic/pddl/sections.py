"""The frame of a PDDL file: ``(define (domain NAME) (:section ...) ...)``."""

from bpns.symbolic.pddl.lists import List, Node, Word, shown
from bpns.symbolic.pddl.scope import Scope, have
from bpns.symbolic.pddl.vocabulary import REQUIREMENTS, UNSUPPORTED_REQUIREMENTS, UNSUPPORTED_SECTIONS

_IGNORED = {":length": "how long plans may be is no part of the problem"}


def read_sections(scope: Scope, tree: List, kind: str, allowed: tuple[str, ...]) -> tuple[str, list[List]]:
    """Check ``(define (kind name) ...)``; return the name and the sections that are allowed."""
    if tree.head != "define" or len(tree.items) < 2:
        scope.fail(tree, f"expected (define ({kind} NAME) ...)")
    title = tree.items[1]
    if not isinstance(title, List) or title.head != kind or len(title.items) != 2:
        found = f"({shown(title.head)} ...)" if isinstance(title, List) else f"'{shown(title.text)}'"
        scope.fail(title, f"expected ({kind} NAME), found {found}: is this the right file?")
    sections = []
    seen: set[str] = set()
    for node in tree.items[2:]:
        if not isinstance(node, List) or not node.items:
            scope.fail(node, f"expected a section such as ({allowed[-1]} ...)")
        if node.head in _IGNORED or _counts_steps(node):
            scope.warn(
                node, f"{node.head} is ignored: {_IGNORED.get(node.head, 'every step takes one unit')}"
            )
            continue
        if node.head in UNSUPPORTED_SECTIONS:
            scope.unsupported(node, node.head, UNSUPPORTED_SECTIONS[node.head])
        if node.head not in allowed:
            scope.fail(node, f"unknown section '{shown(node.head)}' (have: {', '.join(allowed)})")
        if node.head in seen and node.head != ":action":
            scope.fail(node, f"a second {node.head} section: merge it with the first")
        seen.add(node.head)
        sections.append(node)
    name, word = scope.title(title.items[1], kind), scope.word(title.items[1], f"a {kind}")
    if name != word.text:
        scope.warn(word, f"'{shown(word.text)}' is no name for a {kind}: it is called {shown(name)}")
    return name, sections


def _counts_steps(section: List) -> bool:
    """Say whether a section is ``(:metric minimize (total-time))``: without durations, a plan's length."""
    match section.items:
        case (Word(":metric"), Word("minimize"), List((Word("total-time"),)) | Word("total-time")):
            return True
    return False


def read_requirements(scope: Scope, section: List) -> None:
    """Read the requirements: a flag is no fault if what it allows is not used."""
    flags = set()
    for node in section.items[1:]:
        flag = scope.word(node, "a requirement")
        if flag.text in UNSUPPORTED_REQUIREMENTS:
            scope.unsupported(flag, flag.text, UNSUPPORTED_REQUIREMENTS[flag.text])
        if flag.text not in REQUIREMENTS:
            known = have(dict.fromkeys(REQUIREMENTS))
            scope.fail(flag, f"unknown requirement '{shown(flag.text)}' {known}")
        flags.add(flag.text)
    scope.requirements |= flags


def parts_of_action(
    scope: Scope, section: List, keys: tuple[str, ...], refused: dict[str, str]
) -> dict[str, Node]:
    """Return what follows each of an action's keys."""
    name = shown(scope.name(section.items[1], "an action"))
    rest = section.items[2:]
    parts: dict[str, Node] = {}
    for key, value in zip(rest[::2], rest[1::2], strict=False):
        word = scope.word(key, f"one of {', '.join(keys)}")
        if word.text in refused:
            scope.unsupported(word, word.text, refused[word.text])
        if word.text not in keys:
            scope.fail(word, f"unknown part '{shown(word.text)}' of action {name} (have: {', '.join(keys)})")
        if word.text in parts:
            scope.fail(word, f"a second {word.text} in action {name}: remove one")
        parts[word.text] = value
    if len(rest) % 2:
        scope.fail(rest[-1], f"action {name}: this part has no value")
    return parts
