"""PDDL's skeleton: text -> nested lists of words that know where they stand."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TypeAlias

from lark import Lark, Token, Transformer
from lark.exceptions import UnexpectedToken

from symbolic.errors import PddlError


@dataclass(frozen=True, slots=True)
class Word:
    """A word in lower case and where it stands."""

    text: str
    line: int
    column: int


@dataclass(frozen=True, slots=True)
class List:
    """A parenthesised list and where it opens."""

    items: "tuple[Node, ...]"
    line: int
    column: int

    @property
    def head(self) -> str:
        """The first word, or nothing."""
        return self.items[0].text if self.items and isinstance(self.items[0], Word) else ""


Node: TypeAlias = Word | List


class _Build(Transformer[Token, List]):
    def start(self, children: list[List]) -> List:
        return children[0]

    def list(self, children: "list[Token | Node]") -> List:
        opening, *items, _ = children
        assert isinstance(opening, Token)
        nodes = (Word(i.lower(), i.line or 0, i.column or 0) if isinstance(i, Token) else i for i in items)
        return List(tuple(nodes), opening.line or 0, opening.column or 0)


@cache
def _parser() -> Lark:
    text = (Path(__file__).parent / "grammar.lark").read_text(encoding="utf-8")
    return Lark(text, parser="lalr", transformer=_Build(), keep_all_tokens=True, propagate_positions=False)


def parse_lists(text: str, path: str) -> List:
    """Return the one list that a text consists of; raise PddlError where it does not."""
    try:
        tree = _parser().parse(text)
    except UnexpectedToken as error:
        line, column = max(error.line, 1), max(error.column, 1)
        if error.token.type == "$END":
            line, column = text.count("\n") + 1, len(text) - text.rfind("\n")
            if "(" not in text:
                raise PddlError(path, line, column, "no PDDL here: expected (define ...)") from None
            what = "the file ends inside a list: a ')' is missing, or the file is cut off"
            raise PddlError(path, line, column, what) from None
        if error.token == ")":
            raise PddlError(path, line, column, "')' without its '(': remove it") from None
        raise PddlError(path, line, column, f"'{error.token}' outside the definition: remove it") from None
    assert isinstance(tree, List)
    return tree
