"""The pages of docs/examples: their links lead somewhere, their Python runs; each has its scenario, picture and place in the index."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from scenario_run import ROOT

PAGES = sorted((ROOT / "docs/examples").glob("*.md"))
EXAMPLES = [page for page in PAGES if page.name != "README.md"]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_links_lead_somewhere(page: Path) -> None:
    links = re.findall(r"\]\((?!https?:)([^)#]+)", page.read_text(encoding="utf-8"))
    assert links
    for link in links:
        assert (page.parent / link).exists(), link


@pytest.mark.parametrize("page", EXAMPLES, ids=lambda page: page.stem)
def test_an_example_is_complete(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    name = page.stem
    assert f"(../../scenarios/{name}.toml)" in text
    assert f"momentree run scenarios/{name}.toml" in text
    assert f"(pictures/{name}.webp)" in text
    for part in ("Question", "Model", "What happens", "Answer", "Vary it", "Sources"):
        assert f"**{part}" in text
    assert f"({name}.md)" in (page.parent / "README.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("page", EXAMPLES, ids=lambda page: page.stem)
def test_its_python_runs(page: Path) -> None:
    for block in re.findall(r"(?ms)^```python\n(.*?)^```", page.read_text(encoding="utf-8")):
        done = subprocess.run([sys.executable, "-c", block], capture_output=True, text=True, cwd=ROOT, timeout=300)
        assert done.returncode == 0, done.stderr
        assert done.stdout
