"""Damaged PDDL files: mutations of a corpus, and what must be true of whatever comes out."""

import re
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from random import Random
from time import monotonic, process_time
from traceback import format_exc

from bpns.symbolic.errors import InputError, PddlError
from bpns.symbolic.grounding.ground import ground
from bpns.symbolic.operators import Domain, Problem
from bpns.symbolic.pddl.read import parse_domain, parse_problem
from tests.symbolic._texts import read_back

Words = list[str]

_TOKENS = re.compile(r"\s+|[()]|;[^\n]*|[^\s();]+")
_PIECES = (
    "( ) - () ?x ?X ? = and not or either object define domain problem :action :parameters :precondition "
    ":effect :types :objects :init :goal :constants :predicates :requirements :typing :equality :length "
    ":metric minimize when forall exists imply increase total-cost 0 3.5 -1 a B-c _ @ # . , ; \" ' ` \\ "
    "é ß İ K \ufeff \u2028 \udc80 \0 \x1b"
).split(" ")
_SNIPPETS = (
    "(= ?x ?y)",
    "(not (= ?x ?x))",
    "(= 1 (f))",
    "(either a b)",
    "- (either block object)",
    "(:functions (total-cost) - number)",
    "(:metric minimize (total-cost))",
    "(:length (:serial 3))",
    "(when (p) (q))",
    "(and)",
    "(not (not (p)))",
    "; a comment without an end\n",
)


@dataclass(frozen=True)
class Files:
    """A domain and a problem as text."""

    domain: str
    problem: str


def corpus(folders: Sequence[Path]) -> list[Files]:
    """Read all problems below the folders, each with the domain file whose name fits best."""
    found = []
    for path in sorted(p for folder in folders for p in folder.rglob("*.pddl")):
        names = (
            path.name.replace("task", "domain"),
            f"{path.stem.rpartition('-')[0] or path.stem}-domain.pddl",
            "domain.pddl",
        )
        near = [path.with_name(name) for name in names if name != path.name]
        domain = next((file for file in near if file.exists()), None)
        if "domain" not in path.name and domain is not None:
            texts = [p.read_text(encoding="utf-8", errors="replace") for p in (domain, path)]
            found.append(Files(*texts))
    return found


# --------------------------------------------------------------------------------------- mutations


def _piece(rng: Random) -> str:
    return rng.choice(_PIECES) if rng.random() < 0.7 else rng.choice(_SNIPPETS)


def _span(rng: Random, words: Words) -> slice:
    start = rng.randrange(len(words) + 1)
    return slice(start, start + rng.choice((1, 1, 1, 2, 5, 30)))


def _delete(rng: Random, words: Words, other: Words) -> None:
    del words[_span(rng, words)]


def _double(rng: Random, words: Words, other: Words) -> None:
    span = _span(rng, words)
    words[span] = words[span] * 2


def _swap(rng: Random, words: Words, other: Words) -> None:
    if words:
        one, two = rng.randrange(len(words)), rng.randrange(len(words))
        words[one], words[two] = words[two], words[one]


def _insert(rng: Random, words: Words, other: Words) -> None:
    words.insert(rng.randrange(len(words) + 1), f" {_piece(rng)} ")


def _replace(rng: Random, words: Words, other: Words) -> None:
    words[_span(rng, words)] = [_piece(rng)]


def _kind(words: Words, place: int) -> str:
    """Return what sort of word stands at a place: a variable, a keyword, the head of a list, another name."""
    word = words[place]
    if word[0] in "?:-();" or word.isspace():
        return word[0]
    return "head" if place and words[place - 1] == "(" else "name"


def _rename(rng: Random, words: Words, other: Words) -> None:
    """Put one of the file's own words in another's place, mostly one of its kind."""
    places = [i for i in range(len(words)) if _kind(words, i) in ("?", ":", "head", "name")]
    if places:
        place = rng.choice(places)
        kind = _kind(words, place)
        alike = [i for i in places if _kind(words, i) == kind] if rng.random() < 0.9 else places
        words[place] = words[rng.choice(alike)]


def _snippet(rng: Random, words: Words, other: Words) -> None:
    words.insert(rng.randrange(len(words) + 1), f" {rng.choice(_SNIPPETS)} ")


def _list(rng: Random, words: Words) -> slice:
    """Return a whole list, or what comes after an opening parenthesis without its end."""
    start = rng.choice([i for i, word in enumerate(words) if word == "("] or [0])
    depth = 0
    for end in range(start, len(words)):
        depth += (words[end] == "(") - (words[end] == ")")
        if depth == 0:
            return slice(start, end + 1)
    return slice(start, len(words))


def _double_list(rng: Random, words: Words, other: Words) -> None:
    span = _list(rng, words)
    copy = words[span]
    place = span.start if rng.random() < 0.7 else rng.randrange(len(words) + 1)
    words[place:place] = copy


def _delete_list(rng: Random, words: Words, other: Words) -> None:
    del words[_list(rng, words)]


def _splice(rng: Random, words: Words, other: Words) -> None:
    """Put a list of another file in a list's place, or before it."""
    span = _list(rng, words)
    if rng.random() < 0.5:
        span = slice(span.start, span.start)
    words[span] = other[_list(rng, other)]


def _truncate(rng: Random, words: Words, other: Words) -> None:
    del words[rng.randrange(len(words) + 1) :]


def _noise(rng: Random, words: Words, other: Words) -> None:
    """Put random bytes somewhere."""
    noise = rng.randbytes(rng.choice((1, 4, 50))).decode("utf-8", errors="replace")
    words.insert(rng.randrange(len(words) + 1), noise)


def _nest(rng: Random, words: Words, other: Words) -> None:
    """Put a list into a thousand others."""
    span, depth = _list(rng, words), rng.choice((3, 300, 3000))
    head = rng.choice(("(and ", "(", "(not ", "(or "))
    words[span] = [head * depth, *words[span], ")" * (depth - (rng.random() < 0.1))]


def _many(rng: Random, words: Words, other: Words) -> None:
    """Repeat something often, with a number in it that makes each different."""
    name = rng.choice(words) if words else "a"
    name = name if name.strip("()") and not name.isspace() else "o"
    form = rng.choice(
        (f"{name}# ", f"({name} ?x#) ", f"?x# - {name} ", "t# - t## ", f"{name} ", f"({name}) ")
    )
    count = rng.choice((10, 300, 2000))
    text = "".join(form.replace("##", str(i + 1)).replace("#", str(i)) for i in range(count))
    words.insert(rng.randrange(len(words) + 1), f" {text}")


_Mutation = Callable[[Random, Words, Words], None]
_GENTLE: dict[_Mutation, int] = {  # they keep parentheses balanced, and many files valid
    _rename: 12,
    _double_list: 4,
    _delete_list: 4,
    _splice: 2,
    _snippet: 2,
    _nest: 1,
    _many: 1,
}
_ROUGH: dict[_Mutation, int] = {
    **_GENTLE,
    _delete: 5,
    _double: 5,
    _swap: 5,
    _insert: 5,
    _replace: 5,
    _truncate: 1,
    _noise: 2,
}


def mutate(rng: Random, text: str, other: str) -> str:
    """Return a text with a few mutations, of words or of characters; never more than a million of these."""
    mutations = _GENTLE if rng.random() < 0.5 else _ROUGH
    if mutations is _GENTLE or rng.random() < 0.6:
        words, strange = _TOKENS.findall(text), _TOKENS.findall(other)
    else:
        words, strange = list(text), list(other)
    for change in rng.choices([*mutations], [*mutations.values()], k=rng.choice((1, 1, 1, 1, 2, 3, 6))):
        change(rng, words, strange)
    return "".join(words)[:300_000]  # reading takes time in proportion


def mutated(rng: Random, files: Sequence[Files]) -> Files:
    """Return a task of the corpus with its domain, its problem or both mutated."""
    one, two = rng.choice(files), rng.choice(files)
    domain, problem = one.domain, one.problem
    which = rng.random()
    if which < 0.55:
        domain = mutate(rng, domain, two.domain)
    if which > 0.5:
        problem = mutate(rng, problem, two.problem)
    return Files(domain, problem)


# ------------------------------------------------------------------------------------------ checks


def _misplaced(error: InputError, text: str) -> str:
    """Say what is wrong with a message: more than one line, or no place in the text."""
    if not isinstance(error, PddlError):
        return f"no place: {error}"
    lines = text.split("\n")
    if not 1 <= error.line <= len(lines) or not 1 <= error.column <= len(lines[error.line - 1]) + 1:
        return f"a place outside the text: {error}"
    if len(str(error).splitlines()) != 1 or not error.message.isprintable() or len(str(error)) > 5000:
        return f"not one readable line: {str(error)[:200]!r}"
    return ""


@dataclass(frozen=True)
class Verdict:
    """What came of a pair of files: ``refused``, ``read``, or what should not be."""

    outcome: str
    offence: str
    seconds: float


def judge(files: Files, allowed: float = 1.0, grounding: float = 0.3) -> Verdict:
    """Read, write, read again and ground; seconds are those of the processor, as machines are shared."""
    start = process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            outcome, offence = _judge(files, grounding)
        except Exception:
            outcome, offence = "traceback", format_exc(limit=-6)
    seconds = process_time() - start
    if not offence and seconds > allowed:
        offence = f"took {seconds:.2f} s"
    return Verdict(outcome, offence, seconds)


def _judge(files: Files, grounding: float) -> tuple[str, str]:
    try:
        domain = parse_domain(files.domain)
    except InputError as error:
        return "refused", _misplaced(error, files.domain)
    try:
        problem: Problem | None = parse_problem(files.problem, domain)
    except InputError as error:
        problem, offence = None, _misplaced(error, files.problem)
        if offence:
            return "refused", offence
    offence = _round_trip(domain, problem)
    if problem is None or offence:
        return "refused" if problem is None else "read", offence
    ground(domain, problem, monotonic() + grounding)
    return "read", ""


def _round_trip(domain: Domain, problem: Problem | None) -> str:
    try:
        again = read_back(domain, problem)
    except InputError as error:
        return f"what was read cannot be written and read again: {error}"
    return "" if again == (domain, problem) else "what was written is read as something else"
