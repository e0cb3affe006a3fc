"""Plug-ins: one module is one, and its file name is its name; others are ``module:attribute``.

A package's modules are its plug-ins where they offer a certain attribute, such as ``ENVIRONMENT``. To add
one, add a file. What lies beside them without the attribute serves them.
"""

import re
import sys
import sysconfig
from collections.abc import Iterable
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

    def load(self, name: str, folders: Iterable[Path] = ()) -> Any:
        """Return what a plug-in offers, ours by its name or another as ``module:attribute``.

        ``folders`` are where its module may be too. Raises InputError where there is none of that name.
        """
        if (ours := name.replace(self.dash, "_")) in self.names():
            return getattr(import_module(f"{self.package}.{ours}"), self.offers)
        if ":" not in name:
            raise InputError(f"unknown {self.kind} '{name}' (have: {self._have()}, or MODULE:ATTRIBUTE)")
        return load_foreign(self.kind, name, folders, f"have: {self._have()}; ")

    def _have(self) -> str:
        return ", ".join(name.replace("_", self.dash) for name in self.names())


def load_foreign(kind: str, name: str, folders: Iterable[Path] = (), have: str = "") -> Any:
    """Return ``module:attribute`` of the user's; raise InputError where there is none of that name."""
    module, colon, attribute = name.partition(":")
    try:
        if not colon:
            raise ValueError("write it as MODULE:ATTRIBUTE")
        return getattr(import_foreign(module, folders), attribute)
    except Exception as error:  # whatever a stranger's module does at import
        raise InputError(
            f"cannot load {kind} '{name}': {type(error).__name__}: {error} ({have}modules are looked for in "
            "the current folder, in PYTHONPATH and among installed packages)"
        ) from error


def import_foreign(module: str, folders: Iterable[Path] = ()) -> ModuleType:
    """Import a module of the user's; the current folder is searched after all else, then ``folders``."""
    for folder in map(str, (Path.cwd(), *folders)):
        if folder not in sys.path:
            sys.path.append(folder)
    return import_module(module)


def folder_of(module: str) -> Path | None:
    """Return the folder in which an imported module of the user's was found; None where it is installed."""
    file = getattr(sys.modules.get(module.partition(".")[0]), "__file__", None)
    if file is None:
        return None
    folder = Path(file).resolve().parents[1 if Path(file).name == "__init__.py" else 0]
    installed = {Path(path).resolve() for path in sysconfig.get_paths().values()}
    return None if folder in installed else folder


def _module(entry: Traversable) -> tuple[str, Traversable]:
    """Return the name of a module or package and the file where its attributes are."""
    if entry.name.endswith(".py"):
        return entry.name.removesuffix(".py"), entry
    return ("", entry) if "." in entry.name else (entry.name, entry / "__init__.py")
