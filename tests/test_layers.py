"""Layers: cli -> the door -> envs, learning -> symbolic; no circles, no names private elsewhere."""

import ast
from collections.abc import Iterator
from pathlib import Path

import networkx as nx
import pytest

ROOT = Path(__file__).parents[1]
MAY_IMPORT = {
    "symbolic": {"symbolic"},
    "envs": {"envs", "symbolic"},
    "learning": {"learning", "symbolic"},
    "bpns": {"bpns", "envs", "learning", "symbolic"},
    "cli": {"cli", "bpns", "envs", "learning", "symbolic"},
}
ONLY_IN = {
    "torch": {
        "bpns.learning.networks.losses",
        "bpns.learning.networks.perceptron",
        "bpns.learning.networks.training",
        "bpns.learning.graphs.training",
    },
    "gymnasium": {"bpns.gymnasium"},
    "pyperplan": {"bpns.symbolic.planners.pyperplan"},
    "kairos": {"bpns.symbolic.planners.kairos", "bpns.symbolic.checkers.kairos"},
    "unified_planning": {
        "bpns.symbolic.planners.up",
        "bpns.symbolic.planners.foreign.up_problem",
        "bpns.symbolic.checkers.unified_planning",
    },
    "matplotlib": {"bpns.symbolic.compare.drawing", "bpns.learning.experiments.drawing"},
    "sqlite3": {"bpns.learning.experiments.results"},
    "pickle": set(),
}


def module_name(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    parts = parts if parts[0] == "bpns" else ("bpns", *parts)
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {
    module_name(path): path
    for layer in MAY_IMPORT
    for path in sorted((ROOT / layer).rglob("*.py"))
    if layer != "bpns" or path.parent == ROOT / "bpns"  # the other folders in it are links to these
}


def imported(name: str) -> Iterator[str]:
    """Yield what a module imports, anywhere in it: modules, and names within modules."""
    for node in ast.walk(ast.parse(MODULES[name].read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{name}: imports name their module in full"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def layer_of(name: str) -> str:
    parts = name.split(".")
    if name == "bpns.__main__":  # starts the command line
        return "cli"
    return parts[1] if len(parts) > 1 and parts[1] in MAY_IMPORT else "bpns"


def module_of(target: str) -> str:
    """Return the module of ours that a dotted name is, or lies in."""
    return target if target in MODULES else target.rpartition(".")[0]


@pytest.mark.parametrize("name", MODULES)
def test_a_module_imports_its_own_layer_or_a_lower_one(name: str) -> None:
    for target in imported(name):
        package = target.partition(".")[0]
        if package == "bpns":
            assert layer_of(target) in MAY_IMPORT[layer_of(name)], target
        assert name in ONLY_IN.get(package, {name}), f"{package} has its own place: {ONLY_IN[package]}"


@pytest.mark.parametrize("name", MODULES)
def test_nothing_private_is_taken_from_another_package(name: str) -> None:
    """A name ``a.b._c`` belongs to the package ``a.b`` and what is below it."""
    package = name if MODULES[name].name == "__init__.py" else name.rpartition(".")[0]
    for target in imported(name):
        parts = target.split(".")
        private = [i for i, part in enumerate(parts) if part.startswith("_") and not part.endswith("__")]
        if target.startswith("bpns") and private:
            owner = ".".join(parts[: private[0]])
            assert f"{package}.".startswith(f"{owner}."), target


def test_there_are_no_circles() -> None:
    arrows = {(name, module_of(target)) for name in MODULES for target in imported(name)}
    graph = nx.DiGraph((a, b) for a, b in arrows if b in MODULES)
    assert list(nx.simple_cycles(graph)) == []


def test_modules_and_functions_stay_readable() -> None:
    long = {}
    for name, path in MODULES.items():
        text = path.read_text(encoding="utf-8")
        if (lines := text.count("\n")) > 300:
            long[name] = lines
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.FunctionDef) and (lines := node.end_lineno - node.lineno + 1) > 50:
                long[f"{name}.{node.name}"] = lines
    assert long == {}


def test_the_core_has_few_loose_modules() -> None:
    assert len(list((ROOT / "symbolic").glob("[!_]*.py"))) <= 6
