"""The documentation site: Sphinx reads the Markdown files where they are, from the root of the repository. See tools/build_site."""

import os
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

ROOT = Path(__file__).resolve().parents[2]

project = "momentree"
copyright = "the momentree authors"
html_title = "momentree"
root_doc = "README"
extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_design",
    "breathe",
    "site_pages",
]
include_patterns = [
    "README.md",
    "ARCHITECTURE.md",
    "CONTRIBUTING.md",
    "CHANGELOG.md",
    "CODE_OF_CONDUCT.md",
    "SECURITY.md",
    "docs/**.md",
    "docs/site/**.rst",
    "bench/README.md",
    "bench/peers/README.md",
    "bench/peers/contact/README.md",
    "bench/results/peers.md",
    "packaging/README.md",
    "tests/data/README.md",
    "wasm/npm/README.md",
]
exclude_patterns = [".*", "build", "install", "results", "web", "momentree", "scenarios"]

myst_heading_anchors = 4
myst_enable_extensions = ["attrs_block"]
# Each header opens namespace momentree; short names in docstrings can be attributes of several classes.
suppress_warnings = ["myst.header", "duplicate_declaration.cpp", "ref.python"]

autodoc_member_order = "bysource"
autodoc_default_options = {"members": True, "inherited-members": True, "undoc-members": False}

breathe_projects = {"momentree": os.environ.get("MOMENTREE_DOXYGEN", "")}
breathe_default_project = "momentree"
breathe_default_members = ("members",)
breathe_show_include = False  # the pages give the whole path

toc_object_entries = False  # thousands, which would be copied for every page

html_theme = "furo"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_js_files = [("site.js", {"defer": "defer"})]
html_extra_path = ["../../web/dist/playground.html"]
html_copy_source = False
html_show_sphinx = False
