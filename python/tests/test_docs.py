"""Runs the ```python blocks of the documents, each after the blocks before it.

A ```text block that follows, also after blocks in other languages, is what the block prints. `<!-- not run: why -->` on the last
line before a block omits it. Both are as in tools/doc_blocks.
"""

from __future__ import annotations

import contextlib
import io
import re
import shutil
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [
    "docs/coming-from/drake.md",
    "docs/coming-from/mujoco.md",
    "docs/contact.md",
    "docs/conventions.md",
    "docs/guide.md",
    "docs/howto/export.md",
    "docs/howto/live-view.md",
    "docs/python.md",
    "docs/python-sweeps.md",
    "README.md",
]
NEEDED = {"plot": "matplotlib", "to_pandas": "pandas"}


@dataclass
class Block:
    line: int
    note: str
    code: str
    printed: str | None = field(default=None)


def blocks_of(text: str) -> list[Block]:
    found: list[Block] = []
    pattern = re.compile(r"^(?P<fence>```)(?P<language>\w*)[^\n]*\n(?P<code>.*?)^```$", re.M | re.S)
    end, last = 0, None
    for match in pattern.finditer(text):
        between = text[end : match.start()].strip()
        end = match.end()
        if between:
            last = None
        if match["language"] == "python":
            line = text.count("\n", 0, match.start()) + 2
            last = Block(line, between.rpartition("\n")[2], match["code"])
            found.append(last)
        elif match["language"] == "text" and last:
            last.printed, last = match["code"], None
    return found


@pytest.mark.parametrize("page", PAGES)
def test_blocks_run(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if not (ROOT / page).exists():
        pytest.skip("the documentation is not here")
    blocks = blocks_of((ROOT / page).read_text(encoding="utf-8"))
    assert blocks
    for name, package in NEEDED.items():
        if any(f".{name}(" in block.code for block in blocks):
            pytest.importorskip(package)
    for package in ("mujoco", "mcap"):
        if any(re.search(rf"(import|from) {package}\b", block.code) for block in blocks):
            pytest.importorskip(package)
    shutil.copytree(ROOT / "scenarios", tmp_path / "scenarios")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "agg")
    names: dict[str, Any] = {"__name__": "__main__"}
    for block in blocks:
        if re.fullmatch(r"<!-- not run: .+ -->", block.note):
            continue
        printed = io.StringIO()
        code = compile("\n" * (block.line - 1) + block.code, page, "exec")
        with contextlib.redirect_stdout(printed):
            exec(code, names)
        if block.printed is not None:
            assert printed.getvalue() == block.printed, f"{page}:{block.line}"


def test_blocks_and_what_they_print_are_found() -> None:
    one_block = "```python\na = 1\n```\n\n```cpp\nint a;\n```\n\n```text\n1\n```\n\n"
    one, other = blocks_of(one_block + "<!-- not run: no network -->\n```python\nb\n```\ntext\n```text\n2\n```\n")
    assert (one.line, one.code, one.printed) == (2, "a = 1\n", "1\n")
    assert other.note == "<!-- not run: no network -->"
    assert other.printed is None
