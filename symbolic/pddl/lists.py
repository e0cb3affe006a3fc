"""PDDL's skeleton: text -> nested lists of words that know where they stand."""

from functools import cache
from pathlib import Path
from typing import NamedTuple, TypeAlias

from lark import Lark, Token, Transformer
from lark.exceptions import UnexpectedToken

from bpns.symbolic.errors import PddlError


class Word(NamedTuple):
    """A word in lower case and where it starts in the text."""

    text: str
    start: int


class List(NamedTuple):
    """A parenthesised list and where it starts in the text."""

    items: "tuple[Node, ...]"
    start: int

    @property
    def head(self) -> str:
        """The first word, or nothing."""
        return self.items[0].text if self.items and isinstance(self.items[0], Word) else ""


Node: TypeAlias = Word | List


def shown(text: str, most: int = 60) -> str:
    """Return a text that is fit for a message: no control characters, and not too long."""
    cut = text if len(text) <= most else f"{text[:most]}..."
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in cut)


def pddl_error(
    text: str, path: str, start: int, message: str, kind: type[PddlError] = PddlError
) -> PddlError:
    """Return an error with the line and the column of a place in a text."""
    line, column = text.count("\n", 0, start) + 1, start - text.rfind("\n", 0, start)
    return kind(path, line, column, message)


class _Build(Transformer[Token, List]):
    def start(self, children: list[List]) -> List:
        return children[0]

    def list(self, children: "list[Token | Node]") -> List:
        assert isinstance(children[0], Token)
        items = [item for item in children[1:] if not isinstance(item, Token)]
        return List(tuple(items), children[0].start_pos or 0)

    def WORD(self, token: Token) -> Word:  # noqa: N802  (lark looks for the terminal's name)
        word = token.rstrip()  # with each token goes the space behind it, so that there are fewer of them
        return Word(word.lower() if word.isascii() else word, token.start_pos or 0)


@cache
def _parser() -> Lark:
    text = (Path(__file__).parent / "grammar.lark").read_text(encoding="utf-8")
    return Lark(text, parser="lalr", lexer="basic", transformer=_Build(), propagate_positions=False)


def parse_lists(text: str, path: str) -> List:
    """Return the one list that a text consists of; raise PddlError where it does not."""
    try:
        tree = _parser().parse(text)
    except UnexpectedToken as error:
        if error.token.type != "$END":
            raise pddl_error(text, path, error.token.start_pos or 0, _outside(error.token)) from None
        what = "the file ends inside a list: a ')' is missing, or the file is cut off"
        if not any(line.partition(";")[0].strip() for line in text.split("\n")):
            what = "no PDDL here: expected (define ...)"
        raise pddl_error(text, path, len(text), what) from None
    assert isinstance(tree, List)
    return tree


def _outside(token: str) -> str:
    token = token.rstrip()
    if token == ")":
        return "')' without its '(': remove it"
    if token == "(":
        return "'(' outside the definition: remove it, or put what it begins into a file of its own"
    return f"'{shown(token)}' outside the definition: remove it"
