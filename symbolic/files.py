"""Writing files so that a crash never leaves half of one."""

import json
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from bpns.symbolic.errors import InputError


def check_output(path: Path, overwrite: bool = False, folder: bool = False) -> None:
    """Raise InputError where ``path`` exists (unless told to overwrite it) or could not be written.

    To be called before long work, not after it.
    """
    if path.exists() and not overwrite:
        raise InputError(f"{path} exists: give --overwrite to replace it, or another name")
    if path.is_dir() and not folder:
        raise InputError(f"{path} is a folder: give the name of a file")
    parent = path.parent
    while not parent.exists():
        parent = parent.parent
    if not parent.is_dir() or not os.access(parent, os.W_OK):
        raise InputError(f"cannot write {path}: {parent} is no folder that you may write to")


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Give a temporary name beside ``path``; rename it to ``path`` on success, remove it on failure."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield temporary
        os.replace(temporary, path)
    except OSError as error:
        raise InputError(f"cannot write {path}: {error.strerror or error}") from error
    finally:
        temporary.unlink(missing_ok=True)


@contextmanager
def replacing_folder(folder: Path) -> Iterator[Path]:
    """Give a temporary folder that takes the place of ``folder`` on success; failure changes nothing."""
    temporary = folder.with_name(f".{folder.name}.{os.getpid()}.tmp")
    previous = folder.with_name(f".{folder.name}.{os.getpid()}.previous")
    try:
        temporary.mkdir(parents=True)
        yield temporary
        if folder.exists():
            folder.rename(previous)
        try:
            temporary.rename(folder)
        except BaseException:
            if previous.exists():
                previous.rename(folder)
            raise
    except OSError as error:
        raise InputError(f"cannot write {folder}: {error.strerror or error}") from error
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
        if folder.exists():
            shutil.rmtree(previous, ignore_errors=True)


def write_text(path: Path, text: str) -> None:
    """Write a text file in one piece."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def write_json(path: Path, value: Any) -> None:
    """Write a value as readable JSON."""
    write_text(path, json.dumps(value, indent=2, allow_nan=False) + "\n")


def read_text(path: Path, errors: str = "strict") -> str:
    """Return a text file; raise InputError where there is none.

    ``errors`` says what becomes of bytes that are no UTF-8, as in ``bytes.decode``.
    """
    try:
        text = path.read_text(encoding="utf-8-sig", errors=errors)  # some editors begin a file with a mark
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: not a text file (byte {error.start} is no UTF-8)") from error
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror or error}") from error
    if "\0" in text:
        raise InputError(f"{path}: not a text file (character {text.index(chr(0))} is NUL)")
    return text


def read_json(path: Path) -> Any:
    """Return a JSON file's value; raise InputError with the place of a fault."""
    try:
        return json.loads(read_text(path))
    except json.JSONDecodeError as error:
        raise InputError(f"{path}:{error.lineno}:{error.colno}: not JSON: {error.msg}") from error
