"""Plug-ins: one module is one, and its file name is its name; others are ``module:attribute``.

A package's modules are its plug-ins where they offer a certain attribute, such as ``ENVIRONMENT``. To add
one, add a file. What lies beside them without the attribute serves them.
"""

import re
import sys
from dataclasses import dataclass
from importlib import import_module, resources
from importlib.resources.abc import Traversable
from pathlib import Path
from types import ModuleType
from typing import Any

from bpns.symbolic.errors import InputError


@dataclass(frozen=True, slots=True)
class PlugIns:
    """The plug-ins of one kind."""

    kind: str  # in messages: "environment"
    package: str  # whose modules they are
    offers: str  # the attribute that makes a module one of them
    dash: str = "_"  # between the words of a name where people write it; "_" is understood too

    def names(self) -> list[str]:
        """Return their names, without importing them."""
        defines = re.compile(rf"^(def )?{self.offers}\b", re.MULTILINE)
        found = []
        for entry in resources.files(self.package).iterdir():
            name, source = _module(entry)
            if name and source.is_file() and defines.search(source.read_text(encoding="utf-8")):
                found.append(name)
        return sorted(found)

    def load(self, name: str) -> Any:
        """Return what a plug-in offers, ours by its name or another as ``module:attribute``.

        Raises InputError where there is none of that name.
        """
        if (ours := name.replace(self.dash, "_")) in self.names():
            return getattr(import_module(f"{self.package}.{ours}"), self.offers)
        module, colon, attribute = name.partition(":")
        if not colon:
            raise InputError(f"unknown {self.kind} '{name}' (have: {self._have()}, or MODULE:ATTRIBUTE)")
        try:
            return getattr(import_foreign(module), attribute)
        except Exception as error:  # whatever a stranger's module does at import
            raise InputError(
                f"cannot load {self.kind} '{name}': {type(error).__name__}: {error} "
                f"(have: {self._have()}; modules are looked for in the current folder, in PYTHONPATH and "
                "among installed packages)"
            ) from error

    def _have(self) -> str:
        return ", ".join(name.replace("_", self.dash) for name in self.names())


def import_foreign(module: str) -> ModuleType:
    """Import a module of the user's; the current folder is searched last of all."""
    here = str(Path.cwd())
    if here not in sys.path:
        sys.path.append(here)
    return import_module(module)


def _module(entry: Traversable) -> tuple[str, Traversable]:
    """Return the name of a module or package and the file where its attributes are."""
    if entry.name.endswith(".py"):
        return entry.name.removesuffix(".py"), entry
    return ("", entry) if "." in entry.name else (entry.name, entry / "__init__.py")
