"""Worlds: one module is one environment and its file name is the environment's name."""

from dataclasses import fields, is_dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import cast

from symbolic.environment import Environment
from symbolic.errors import InputError


def names() -> list[str]:
    """Return the names of the shipped environments, without importing them."""
    files = Path(__file__).parent.glob("[!_]*.py")
    return sorted(file.stem for file in files)


def load(name: str) -> Environment:
    """Return an environment: a shipped one by name, a user's own as ``module:attribute``.

    The attribute is an environment, or a class that needs no arguments. Options, the fields of environments
    that are dataclasses, may follow: ``stick_button:test_buttons=3,4``.
    Raises InputError where there is none of that name.
    """
    found = find(name)
    missing = [a for a in dir(Environment) if not a.startswith("_") and not hasattr(found, a)]
    if missing:
        raise InputError(f"'{name}' is no environment: it has no {', '.join(missing)}")
    return cast(Environment, found)


def find(name: str) -> object:
    """Return what is called like that, whether or not it is an environment; see ``load``."""
    place, options = _parts(name)
    if ":" not in place:
        if place not in names():
            have = ", ".join(names())
            raise InputError(f"unknown environment '{place}' (have: {have}, or MODULE:ATTRIBUTE)")
        found = import_module(f"envs.{place}").ENVIRONMENT
    else:
        module, _, attribute = place.partition(":")
        try:
            found = getattr(import_module(module), attribute)
            found = found() if isinstance(found, type) else found
        except Exception as error:  # whatever a stranger's module does at import
            raise InputError(f"cannot load environment '{place}': {type(error).__name__}: {error}") from error
    return _with_options(found, options, place) if options else found


def _parts(name: str) -> tuple[str, dict[str, str]]:
    """Split ``place:option=value:option=value``."""
    pieces = name.split(":")
    pairs = (piece.partition("=") for piece in pieces if "=" in piece)
    return ":".join(p for p in pieces if "=" not in p), {option: value for option, _, value in pairs}


def _with_options(environment: object, options: dict[str, str], place: str) -> object:
    """Return an environment with other values in some of its fields."""
    if not is_dataclass(environment) or isinstance(environment, type):
        raise InputError(f"environment '{place}' takes no options: it is no dataclass")
    have = {f.name: getattr(environment, f.name) for f in fields(environment) if f.init}
    values = {}
    for option, text in options.items():
        if option not in have:
            raise InputError(
                f"environment '{place}' has no option '{option}' (have: {', '.join(have) or 'none'})"
            )
        try:
            values[option] = _value(text, have[option])
        except ValueError as error:
            raise InputError(
                f"environment '{place}': cannot read '{text}' as {option} (default: {have[option]!r})"
            ) from error
    try:
        return replace(environment, **values)
    except (ValueError, TypeError) as error:
        raise InputError(f"environment '{place}': {error}") from error


def _value(text: str, like: object) -> object:
    """Read a value of the same type as another one; tuples are written with commas."""
    if isinstance(like, tuple) and like:
        return tuple(_value(piece, like[0]) for piece in text.split(","))
    if isinstance(like, (int, float, str)) and not isinstance(like, bool):
        return type(like)(text)
    raise ValueError
