"""What the site adds to the Markdown files, which are written for their plain view: navigation, tabs and links to the playground.

A run of ```toml, ```cpp and ```python blocks with nothing between them becomes tabs. A scenario in such a run, and each
`<!-- playground: PATH -->`, gets a link that opens that scenario in the playground, in the format of web/src/playground/share.ts.
"""

from __future__ import annotations

import base64
import re
import shutil
import zlib
from pathlib import Path
from typing import Any

from navigation import BELOW, NAVIGATION
from sphinx import addnodes

ROOT = Path(__file__).resolve().parents[2]
TABS = {"toml": "Scenario", "cpp": "C++", "python": "Python"}
FENCED = re.compile(r"^```(?P<language>\w*)[^\n]*\n(?P<code>.*?)^```\n", re.M | re.S)


def share_fragment(scenario: str) -> str:
    packed = base64.urlsafe_b64encode(zlib.compress(scenario.encode(), 9))
    return "#s=" + packed.decode().rstrip("=")


def playground_link(scenario: str, page: str) -> str:
    up = "../" * page.count("/")
    return f'<a class="playground" href="{up}playground.html{share_fragment(scenario)}">Open in the playground</a>'


def scenario_for_browser(path: str) -> str:
    """Browsers read no model files: scenarios that name one are in web/gallery as `momentree convert` writes them."""
    converted = ROOT / "web/gallery" / Path(path).name
    return (converted if converted.exists() else ROOT / path).read_text(encoding="utf-8")


def with_tabs(text: str, page: str) -> str:
    """Replaces each run of blocks in several of the languages of TABS."""
    parts: list[str] = []
    end = 0
    blocks = list(FENCED.finditer(text))
    while blocks:
        run = [blocks.pop(0)]
        while blocks and run[-1]["language"] in TABS and blocks[0]["language"] in TABS:
            if text[run[-1].end() : blocks[0].start()].strip():
                break
            run.append(blocks.pop(0))
        if len({block["language"] for block in run}) > 1:
            parts += [text[end : run[0].start()], tab_set(run, page)]
            end = run[-1].end()
    return "".join(parts) + text[end:]


def tab_set(run: list[re.Match[str]], page: str) -> str:
    lines = ["`````{tab-set}", ":sync-group: language", ""]
    for block in run:
        language = block["language"]
        lines += [f"````{{tab-item}} {TABS[language]}", f":sync: {language}", "", block.group().rstrip("\n")]
        if language == "toml" and re.search(r"^format *= *1$", block["code"], re.M) and "scenario" not in block["code"]:
            lines += ["", playground_link(block["code"], page)]
        lines += ["````", ""]
    return "\n".join([*lines, "`````", ""])


def without_folders(text: str, page: str) -> str:
    """Links to folders, which the site has not, become plain text."""
    folder = (ROOT / page).parent

    def replaced(match: re.Match[str]) -> str:
        return match["text"] if (folder / match["target"]).is_dir() else match.group()

    return re.sub(r"\[(?P<text>[^][]+)\]\((?P<target>[\w./-]+)\)", replaced, text)


def outside_of_code(text: str, change: Any) -> str:
    parts, end = [], 0
    for block in FENCED.finditer(text):
        parts += [change(text[end : block.start()]), block.group()]
        end = block.end()
    return "".join(parts) + change(text[end:])


def on_source_read(app: Any, page: str, source: list[str]) -> None:
    if not str(app.env.doc2path(page)).endswith(".md"):
        return

    def change(text: str) -> str:
        text = re.sub(r'^<a id="([\w-]+)"></a>', r"{#\1}\n", text, flags=re.M)
        text = re.sub(
            r"^<!-- playground: (\S+) -->$",
            lambda match: playground_link(scenario_for_browser(match[1]), page),
            text,
            flags=re.M,
        )
        return without_folders(text, page)

    text = with_tabs(outside_of_code(source[0], change), page)
    if page == app.config.root_doc:
        for caption, entries in NAVIGATION:
            text += f"\n```{{toctree}}\n:hidden:\n:caption: {caption}\n\n" + "\n".join(entries) + "\n```\n"
    if page in BELOW:
        text += f"\n```{{toctree}}\n:hidden:\n:glob:\n\n{BELOW[page]}\n```\n"
    source[0] = text


def on_doctree_read(app: Any, doctree: Any) -> None:
    """Breathe adds objects to the tables of contents despite `toc_object_entries`; they would be copied for every page."""
    for signature in doctree.findall(addnodes.desc_signature):
        signature["_toc_name"] = ""


def on_page(app: Any, page: str, template: str, context: dict[str, Any], doctree: Any) -> None:
    """Sphinx gives the captions of the navigation the role of a heading, which needs a level."""
    for part, text in context.items():
        if isinstance(text, str):
            context[part] = re.sub(r'<p class="caption" role="heading"(?! aria-level)', r'\g<0> aria-level="2"', text)


def on_build_finished(app: Any, error: Exception | None) -> None:
    if error is None:
        shutil.copyfile(Path(app.outdir) / f"{app.config.root_doc}.html", Path(app.outdir) / "index.html")


def setup(app: Any) -> dict[str, bool]:
    app.connect("source-read", on_source_read)
    app.connect("doctree-read", on_doctree_read, priority=100)  # before Sphinx collects the contents
    app.connect("html-page-context", on_page, priority=900)  # after the theme has made the navigation
    app.connect("build-finished", on_build_finished)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
