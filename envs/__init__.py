"""Worlds: one module is one environment and its file name is the environment's name."""

from collections.abc import Iterable, Mapping
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import cast

from bpns.symbolic.errors import InputError
from bpns.symbolic.plugins import PlugIns, folder_of
from bpns.symbolic.skills.environment import Environment

ENVIRONMENTS = PlugIns("environment", "bpns.envs", "ENVIRONMENT")


def names() -> list[str]:
    """Return the names of the shipped environments, without importing them."""
    return ENVIRONMENTS.names()


def load(name: str, folders: Iterable[Path] = ()) -> Environment:
    """Return an environment: a shipped one by name, a user's own as ``module:attribute``.

    The attribute is an environment, or a class that needs no arguments. Options, the fields of environments
    that are dataclasses, may follow: ``stick_button:test_buttons=3,4``. ``folders`` are where the
    module may be, beside the current folder. Raises InputError where there is none of that name.
    """
    return complete(find(name, folders), name)


def complete(found: object, name: str) -> Environment:
    """Return what was found as an environment; raise InputError where it lacks something."""
    missing = [a for a in dir(Environment) if not a.startswith("_") and not hasattr(found, a)]
    if missing:
        raise InputError(f"'{name}' is no environment: it has no {', '.join(missing)}")
    return cast(Environment, found)


def find(name: str, folders: Iterable[Path] = ()) -> object:
    """Return what is called like that, whether or not it is an environment; see ``load``."""
    place, options = _parts(name)
    found = ENVIRONMENTS.load(place, folders)
    if isinstance(found, type):
        try:
            found = found()
        except Exception as error:  # whatever a stranger's class does
            raise InputError(f"cannot make environment '{place}': {type(error).__name__}: {error}") from error
    return with_options(found, options, place) if options else found


def folder(name: str) -> Path | None:
    """Return the folder where the module of a loaded ``module:attribute`` was; None for what is installed."""
    module, colon, _ = _parts(name)[0].partition(":")
    return folder_of(module) if colon else None


def _parts(name: str) -> tuple[str, dict[str, str]]:
    """Split ``place:option=value:option=value``."""
    place, options = [], {}
    for piece in name.split(":"):
        option, equals, value = piece.partition("=")
        if not equals:
            place.append(piece)
        elif option in options:
            raise InputError(f"environment '{name}': {option} is given twice")
        else:
            options[option] = value
    return ":".join(place), options


def with_options(environment: object, options: Mapping[str, object], place: str) -> object:
    """Return an environment with other values in some of its fields: values of their types, or text.

    ``place`` is how it is called in messages. Raises InputError for options that it does not have, and for
    values that it does not take.
    """
    if not is_dataclass(environment) or isinstance(environment, type):
        raise InputError(f"environment '{place}' takes no options: it is no dataclass")
    have = {f.name: getattr(environment, f.name) for f in fields(environment) if f.init}
    values = {}
    for option, value in options.items():
        if option not in have:
            raise InputError(
                f"environment '{place}' has no option '{option}' (have: {', '.join(have) or 'none'})"
            )
        default = have[option]
        try:
            values[option] = _value(value, default) if isinstance(value, str) else value
        except (ValueError, KeyError) as error:
            raise InputError(
                f"environment '{place}': cannot read '{value}' as {option} (default: {default!r})"
            ) from error
        if isinstance(default, tuple) and not isinstance(values[option], tuple):
            values[option] = (values[option],)
    try:
        return replace(environment, **values)
    except (ValueError, TypeError) as error:
        raise InputError(f"environment '{place}': {error}") from error


def _value(text: str, like: object) -> object:
    """Read a value of the same type as another one; tuples are written with commas."""
    if isinstance(like, tuple) and like:
        return tuple(_value(piece, like[0]) for piece in text.split(","))
    if isinstance(like, bool):
        return {"true": True, "false": False}[text.lower()]
    if isinstance(like, (int, float, str)):
        return type(like)(text)
    raise ValueError
