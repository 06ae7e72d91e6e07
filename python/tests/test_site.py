"""What the documentation site adds to the Markdown files: docs/site/site_pages.py."""

from __future__ import annotations

import base64
import re
import sys
import zlib
from pathlib import Path
from typing import Any

import pytest

SITE = Path(__file__).parents[2] / "docs/site"


@pytest.fixture(name="pages")
def site_pages(monkeypatch: pytest.MonkeyPatch) -> Any:
    pytest.importorskip("sphinx")
    if not SITE.exists():
        pytest.skip("the documentation is not here")
    monkeypatch.setattr(sys, "path", [str(SITE), *sys.path])
    return __import__("site_pages")


def scenario_of(link: str) -> str:
    """As web/src/playground/share.ts reads it."""
    found = re.search(r"playground\.html#s=([\w-]*)\"", link)
    assert found
    packed = found[1].replace("-", "+").replace("_", "/")
    return zlib.decompress(base64.b64decode(packed + "=" * (-len(packed) % 4))).decode()


def test_blocks_in_several_languages_become_tabs(pages: Any) -> None:
    toml = '# arm.toml\nformat = 1\ntitle = "µ"\n'
    text = f"Before.\n\n```toml\n{toml}```\n\n```cpp\nint main() {{}}\n```\n\n```python\nimport momentree\n```\n\nAfter.\n"
    tabs = pages.with_tabs(text, "docs/guide")
    assert [*re.findall(r"\{tab-item\} (\S+)", tabs)] == ["Scenario", "C++", "Python"]
    assert tabs.startswith("Before.\n\n`````{tab-set}") and tabs.endswith("`````\n\nAfter.\n")
    assert scenario_of(tabs) == toml and 'href="../playground.html#s=' in tabs


@pytest.mark.parametrize("between", ["", "\nThe same in C++:\n\n"])
def test_other_blocks_stay(pages: Any, between: str) -> None:
    text = f"```toml\na = 1\n```\n{between or '```toml'}" + ("```cpp\n;\n```\n" if between else "\nb = 2\n```\n")
    assert pages.with_tabs(text, "docs/guide") == text


def test_sweeps_have_no_link_to_the_playground(pages: Any) -> None:
    text = '```toml\nformat = 1\nscenario = "arm.toml"\n```\n```cpp\n;\n```\n'
    assert "playground" not in pages.with_tabs(text, "docs/guide")


def test_links_open_the_scenario_that_the_browser_can_read(pages: Any) -> None:
    text = pages.scenario_for_browser("scenarios/panda_lets_go.toml")
    assert "model" not in re.findall(r"^(\w+) *=", text, re.M)
    assert scenario_of(pages.playground_link(text, "docs/gallery")) == text
    assert pages.playground_link(text, "README").startswith('<a class="playground" href="playground.html#s=')


def test_links_to_folders_become_text(pages: Any) -> None:
    text = "see [the examples](../python/examples) and [loops](loops.md)"
    assert pages.without_folders(text, "docs/python-gallery") == "see the examples and [loops](loops.md)"
