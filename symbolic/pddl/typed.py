"""Reading PDDL's typed lists, ``a b - t c``: types, objects and variables."""

from bpns.symbolic.pddl.lists import List, Node, Word, shown
from bpns.symbolic.pddl.scope import Scope, have
from bpns.symbolic.pddl.vocabulary import NAME
from bpns.symbolic.structs import OBJECT, Object, Type, Variable, either


def typed_list(scope: Scope, items: tuple[Node, ...], what: str) -> list[tuple[Word, Node | None]]:
    """Return each name with its type, None where there is none; what is no word in a type's place is kept."""
    pairs: list[tuple[Word, Node | None]] = []
    waiting: list[Word] = []
    position = 0
    while position < len(items):
        word = scope.word(items[position], what)
        if word.text == "-":
            if position + 1 == len(items) or not waiting:
                scope.fail(word, f"'-' must stand between {what} and a type")
            kind = items[position + 1]
            pairs += [(w, kind) for w in waiting]
            waiting = []
            position += 1
        else:
            waiting.append(word)
        position += 1
    return pairs + [(w, None) for w in waiting]


def type_of(scope: Scope, node: Node | None) -> Type:
    """Return the type that a name or ``(either a b)`` stands for; ``object`` where there is none."""
    if node is None:
        return OBJECT
    if isinstance(node, Word):
        if node.text not in scope.types:
            scope.fail(node, f"unknown type '{shown(node.text)}' {have(scope.types)}")
        return scope.types[node.text]
    kinds = node.items[1:]
    if node.head != "either" or not kinds:
        scope.fail(node, "expected a type, or (either a b), found a list")
    return either(type_of(scope, scope.word(kind, "a type")) for kind in kinds)


def read_variables(scope: Scope, items: tuple[Node, ...]) -> dict[str, Variable]:
    """Read parameters, of an action or a predicate."""
    found: dict[str, Variable] = {}
    kinds: dict[int, Type] = {}  # by the place of the type's node: many variables share one
    for word, kind in typed_list(scope, items, "a variable"):
        if not word.text.startswith("?") or not NAME.match(word.text[1:]):
            scope.fail(word, f"expected a variable such as ?x, found '{shown(word.text)}'")
        if word.text in found:
            scope.fail(word, f"a second parameter '{shown(word.text)}': rename one")
        place = -1 if kind is None else kind.start
        if place not in kinds:
            kinds[place] = type_of(scope, kind)
        found[word.text] = Variable(word.text, kinds[place])
    return found


def read_objects(scope: Scope, section: List) -> None:
    """Read constants or a problem's objects; a constant may be listed once more among the objects."""
    constants = dict(scope.objects)
    listed: set[str] = set()
    for word, kind in typed_list(scope, section.items[1:], "an object"):
        name = scope.name(word, "an object")
        if isinstance(kind, List) and kind.head == "either":
            scope.unsupported(kind, "either as the type of an object", "give it one type, the common parent")
        obj = Object(scope.spelled(name), type_of(scope, kind))
        if name in listed or constants.get(name, obj) != obj:
            scope.fail(word, f"a second object '{shown(name)}': rename one")
        if name in constants:
            scope.warn(word, f"'{shown(name)}' is a constant of the domain already")
        if name in scope.types:
            what = f"'{name}' is already a type: rename the object"
            scope.unsupported(word, "an object that is called like a type", what)
        listed.add(name)
        scope.objects[name] = obj


def read_types(scope: Scope, section: List) -> None:
    """Read the types, with what each specialises, in any order."""
    scope.need(section, ":typing")
    parents: dict[str, Word | None] = {}
    words: dict[str, Word] = {}
    for word, kind in typed_list(scope, section.items[1:], "a type"):
        name = scope.name(word, "a type")
        parent = _parent(scope, kind)
        if name == "object":
            if parent is not None:
                scope.fail(word, "'object' is the root of all types, it has no parent")
        elif name not in words:
            words[name], parents[name] = word, parent
        else:
            parents[name] = _merged(scope, word, parents[name], kind, parent)
    for parent in list(parents.values()):
        if parent is not None and parent.text not in parents:
            parents[scope.name(parent, "a type")] = None  # declared by being named as a parent
            words[parent.text] = parent
    scope.types = {"object": OBJECT, **_built(scope, parents, words)}


def _parent(scope: Scope, kind: Node | None) -> Word | None:
    """Return the name of a type's parent, None where that is ``object``."""
    if isinstance(kind, List):
        if kind.head == "either":
            scope.unsupported(kind, "either as the parent of a type", "several parents: keep one")
        scope.fail(kind, "expected a type, found a list")
    return None if kind is None or kind.text == "object" else kind


def _merged(
    scope: Scope, word: Word, first: Word | None, kind: Node | None, second: Word | None
) -> Word | None:
    """Return the parent of a type that is declared twice: allowed where one of them is ``object`` only."""
    if (first is None) == (second is None):
        if first is None or second is None or first.text == second.text:
            scope.fail(word, f"a second type '{shown(word.text)}': remove it")
        both = f"'{shown(word.text)}' specialises both {shown(first.text)} and {shown(second.text)}: keep one"
        scope.unsupported(word, "a type with several parents", both)
    if kind is None:
        scope.fail(word, f"a second type '{shown(word.text)}': remove it")
    scope.warn(word, f"type '{shown(word.text)}' is declared twice, once as a mere object")
    return first or second


def _built(scope: Scope, parents: dict[str, Word | None], words: dict[str, Word]) -> dict[str, Type]:
    """Return the types in the order of ``parents``, with their ancestors; fail where these go in a ring."""
    made: dict[str, Type] = {}
    for name in parents:
        chain: dict[str, None] = {}
        step: str | None = name
        while step is not None and step not in made:
            if step in chain:
                ring = " - ".join(shown(link) for link in list(chain)[:5])
                scope.fail(words[name], f"type '{shown(name)}' is its own ancestor: {ring}")
            chain[step] = None
            above = parents[step]
            step = above.text if above else None
        for link in reversed(chain):
            above = parents[link]
            made[link] = Type(scope.spelled(link), (), made[above.text] if above else None)
    return {name: made[name] for name in parents}
