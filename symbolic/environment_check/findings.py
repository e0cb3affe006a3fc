"""What a check finds, in words."""

import sys
import sysconfig
import traceback
from collections.abc import Generator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypeAlias

Level: TypeAlias = Literal["ok", "warning", "fault", "skipped"]

OURS = Path(__file__).parents[1]  # symbolic/: where code of ours calls the user's


@dataclass(frozen=True, slots=True)
class Finding:
    """What was checked and what was found: where, what, what to do."""

    check: str
    level: Level
    text: str


@dataclass(frozen=True, slots=True)
class Remark:
    """A fault or a warning of one check; ``about`` names the attribute that later checks cannot use."""

    level: Literal["warning", "fault"]
    text: str
    about: str = ""


Remarks: TypeAlias = Generator[Remark, None, str]  # returns what to say where there was no fault


def fault(text: str, about: str = "") -> Remark:
    """Return a remark on something that must be mended."""
    return Remark("fault", text, about)


def raised(error: Exception, subject: object) -> str:
    """Name an exception that a stranger's code raised, its function, and the file and line there."""
    text = " ".join(f"{type(error).__name__}: {error}".split())
    frames = [f for f in traceback.extract_tb(error.__traceback__) if not _below(f.filename, OURS)]
    folders = [Path(sysconfig.get_path(name)) for name in ("stdlib", "purelib", "platlib")]
    home = getattr(sys.modules.get(type(subject).__module__), "__file__", None)
    installed = [f for f in frames if home and _below(f.filename, Path(home).parent)]
    theirs = [f for f in frames if not any(_below(f.filename, folder) for folder in folders)]
    chosen = theirs or installed
    if not chosen:
        return text
    frame = chosen[-1]
    return f"{text}, in {frame.name} ({_short(Path(frame.filename))}:{frame.lineno})"


def kind_of(value: object) -> str:
    """Name a value's type, with its module unless it is Python's own: numpy's bool is called bool, too."""
    kind = type(value)
    return kind.__name__ if kind.__module__ == "builtins" else f"{kind.__module__}.{kind.__name__}"


def _below(file: str, folder: Path) -> bool:
    return Path(file).is_relative_to(folder)


def _short(path: Path) -> Path:
    return path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path
