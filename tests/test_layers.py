"""The house's layers: cli -> envs, learning -> symbolic, and slow packages only where they belong."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
MAY_IMPORT = {
    "symbolic": {"symbolic"},
    "envs": {"envs", "symbolic"},
    "learning": {"learning", "symbolic"},
    "cli": {"cli", "envs", "learning", "symbolic", "bpns"},
    "bpns": {"bpns", "cli", "envs", "symbolic"},
}
ONLY_IN = {
    "torch": {"learning/training.py", "learning/graph_training.py"},
    "gymnasium": {"bpns/gymnasium.py"},
    "pyperplan": {"symbolic/planners/pyperplan.py"},
    "kairos": {"symbolic/planners/kairos.py", "symbolic/checkers/kairos.py"},
    "unified_planning": {
        "symbolic/planners/up.py",
        "symbolic/planners/_up_problem.py",
        "symbolic/checkers/unified_planning.py",
    },
    "matplotlib": {"symbolic/draw_operators.py", "learning/draw_results.py"},
    "sqlite3": {"learning/results.py"},
    "pickle": set(),
}
FILES = [path for layer in MAY_IMPORT for path in sorted((ROOT / layer).rglob("*.py"))]


def imports(path: Path) -> set[str]:
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.add(node.module.split(".")[0])
    return names


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(ROOT)))
def test_a_module_imports_its_own_layer_or_a_lower_one(path: Path) -> None:
    layer = path.relative_to(ROOT).parts[0]
    ours = imports(path) & {*MAY_IMPORT, "bpns"}
    assert ours <= MAY_IMPORT[layer]
    for package, places in ONLY_IN.items():
        if package in imports(path):
            assert str(path.relative_to(ROOT)) in places, f"{package} has its own place: {places}"


def test_modules_stay_readable() -> None:
    too_long = {str(p): n for p in FILES if (n := len(p.read_text(encoding="utf-8").splitlines())) > 400}
    assert not too_long
