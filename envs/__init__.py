"""Worlds: one module is one environment and its file name is the environment's name."""

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

    The attribute is an environment, or a class that needs no arguments.
    Raises InputError where there is none of that name.
    """
    found = find(name)
    missing = [a for a in dir(Environment) if not a.startswith("_") and not hasattr(found, a)]
    if missing:
        raise InputError(f"'{name}' is no environment: it has no {', '.join(missing)}")
    return cast(Environment, found)


def find(name: str) -> object:
    """Return what is called like that, whether or not it is an environment; see ``load``."""
    if ":" not in name:
        if name not in names():
            have = ", ".join(names())
            raise InputError(f"unknown environment '{name}' (have: {have}, or MODULE:ATTRIBUTE)")
        return import_module(f"envs.{name}").ENVIRONMENT
    module, _, attribute = name.partition(":")
    try:
        found = getattr(import_module(module), attribute)
        return found() if isinstance(found, type) else found
    except Exception as error:  # whatever a stranger's module does at import
        raise InputError(f"cannot load environment '{name}': {type(error).__name__}: {error}") from error
