"""The pages' code runs, page by page, in the order in which it stands there; links lead somewhere."""

import re
import shlex
from collections.abc import Callable
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
BLOCK = re.compile(r"^```(python|sh)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
PAGES = [
    str(page.relative_to(ROOT))
    for page in (ROOT / "README.md", *sorted(DOCS.glob("*.md")))
    if BLOCK.search(page.read_text(encoding="utf-8"))
]
Run = Callable[..., tuple[int, str, str]]


def test_the_pages_with_code_are_these() -> None:
    tutorials = {"docs/tutorial-python.md", "docs/tutorial-command-line.md", "docs/lecture.md"}
    assert {"README.md", "docs/environment.md", *tutorials} <= set(PAGES)


@pytest.mark.parametrize("page", PAGES)
def test_code_on_a_page_runs(page: str, bpns: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {"__name__": "__main__"}
    for kind, text in BLOCK.findall((ROOT / page).read_text(encoding="utf-8")):
        if kind == "python":
            exec(compile(text, page, "exec"), names)
            continue
        for line in text.splitlines():
            words = shlex.split(line, comments=True)
            if words[:1] == ["bpns"]:
                code, out, err = bpns(*words[1:])
                assert code in (0, 12), f"{line}\n{out}{err}"  # 12: a goal that cannot be reached


@pytest.mark.parametrize("page", ["README.md", *(f"docs/{p.name}" for p in DOCS.glob("*.md"))])
def test_links_lead_somewhere(page: str) -> None:
    text = re.sub(r"```.*?```", "", (ROOT / page).read_text(encoding="utf-8"), flags=re.DOTALL)
    for target in re.findall(r"\]\(([^)#\s]+)", text):
        if "://" not in target:
            assert ((ROOT / page).parent / target).exists(), target
