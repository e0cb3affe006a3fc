"""Errors that are the user's to mend: one line each."""

from dataclasses import dataclass


class InputError(Exception):
    """Bad input: a file, a name or a value. The text is one line: where, what, what to do."""


@dataclass
class PddlError(InputError):
    """Bad PDDL, with the place where it was found; lines and columns count from 1."""

    path: str
    line: int
    column: int
    message: str

    def __str__(self) -> str:
        return f"{self.path}:{self.line}:{self.column}: {self.message}"


class Unsupported(InputError):
    """Valid PDDL that we, or the chosen planner, cannot handle. The text names the feature."""


class UnsupportedPddl(PddlError, Unsupported):
    """A feature that we do not read, with its place."""


class MissingPackage(InputError):
    """An optional package is not installed. The text says how to install it."""
