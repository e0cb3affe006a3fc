"""Worlds: one module is one environment and its file name is the environment's name."""

from importlib import import_module
from pathlib import Path

from symbolic.environment import Environment
from symbolic.errors import InputError


def names() -> list[str]:
    """Return the names of the shipped environments, without importing them."""
    files = Path(__file__).parent.glob("[!_]*.py")
    return sorted(file.stem for file in files)


def load(name: str) -> Environment:
    """Return an environment: a shipped one by name, a user's own as ``module:attribute``.

    The attribute may be an environment or something that returns one when called without arguments.
    Raises InputError where there is none of that name.
    """
    if ":" not in name and name not in names():
        raise InputError(f"unknown environment '{name}' (have: {', '.join(names())}, or MODULE:ATTRIBUTE)")
    module, _, attribute = name.partition(":") if ":" in name else (f"envs.{name}", "", "ENVIRONMENT")
    try:
        found = getattr(import_module(module), attribute)
    except (ImportError, AttributeError) as error:
        raise InputError(f"cannot load environment '{name}': {error}") from error
    environment: Environment = (
        found if hasattr(found, "simulate") and not isinstance(found, type) else found()
    )
    return environment
