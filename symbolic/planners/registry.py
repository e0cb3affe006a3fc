"""Planners by name: one module of this package is one planner, or one family."""

from collections.abc import Callable, Sequence
from importlib import import_module
from inspect import signature

from bpns.symbolic.errors import InputError
from bpns.symbolic.planners.foreign.apart import Apart
from bpns.symbolic.planners.foreign.checked import Checked
from bpns.symbolic.planners.protocol import About, Planner
from bpns.symbolic.plugins import PlugIns

PLANNERS = PlugIns("planner", "bpns.symbolic.planners", "create")


def names() -> list[str]:
    """Return the names of the planners, without importing them."""
    return PLANNERS.names()


def about() -> list[About]:
    """Return what each planner can do. Nothing foreign is imported for it."""
    return [one for name in names() for one in import_module(f"{PLANNERS.package}.{name}").ABOUT]


def load(name: str) -> Planner:
    """Return a planner by name, with options after colons (``astar:hff``, ``pyperplan:gbf:hff``).

    Each module offers ``create(*options)``. A planner from elsewhere is ``module:function`` with its options
    after that. Raises InputError for unknown names and options, MissingPackage where a package is missing.
    """
    asked, *options = name.split(":")
    ours = asked in names()
    if not ours and options:
        asked = f"{asked}:{options.pop(0)}"
    create: Callable[..., Planner] = PLANNERS.load(asked)
    try:
        signature(create).bind(*options)
    except TypeError as error:
        form = "".join(
            f":{p.name.upper()}" if p.default is p.empty else f"[:{p.name.upper()}]"
            for p in signature(create).parameters.values()
        )
        raise InputError(f"planner '{name}' has too many or too few options: it is {asked}{form}") from error
    return create(*options) if ours else _with_checks(name, create, options)


def _with_checks(name: str, create: Callable[..., Planner], options: Sequence[str]) -> Planner:
    """Return a planner from elsewhere; raise InputError where the function gives none."""
    try:
        planner = create(*options)
    except Exception as error:  # whatever a stranger's module does
        raise InputError(f"planner '{name}': {type(error).__name__}: {error}") from error
    if not hasattr(planner, "plans") or not hasattr(planner, "name"):
        raise InputError(f"'{name}' gives no planner: what it returns needs a name and a method plans")
    return planner if isinstance(planner, Apart) else Checked(planner)  # Apart checks by itself
