"""The site of the documents: `make docs`.

Its source is a copy of the tree that scripts/make_docs.py writes with all generated pages, so that links between pages
are the same here and in the repository. What a README lists becomes the navigation: each link at the beginning of a
list item or of a table's row is a page below it. Generated pages are below the pages that GENERATED names.
"""

from __future__ import annotations

import re
from itertools import groupby
from pathlib import PurePosixPath

from sphinx.application import Sphinx

from libgz._version import __version__

project = "libgz"
version = release = __version__
root_doc = "docs/README"
include_patterns = ["docs/**.md", "examples/**.md", "*.md"]
exclude_patterns = ["README.md", "build", ".*", "**/node_modules"]  # README.md is the repository's front
extensions = ["myst_parser", "sphinx_copybutton"]

myst_heading_anchors = 3
myst_links_external_new_tab = False
smartquotes = False  # options keep their two hyphens
highlight_language = "text"
copybutton_prompt_text = "$ "
copybutton_only_copy_prompt_lines = True

html_theme = "furo"
html_title = f"libgz {__version__}"
html_extra_path = ["site"]  # index.html, which leads to the first page
html_static_path = ["static"]
html_css_files = ["libgz.css"]
html_copy_source = False
html_show_copyright = False

GENERATED = {  # page -> what is generated of its subject
    "docs/api": "api/README",
    "docs/classic": "classic/README",
    "docs/classic_cxx": "cxx_api",
    "docs/interfaces": "structs",
    "docs/models": "models/README",
    "docs/player": "player_devices",
    "docs/sdf": "sdf_elements",
    "docs/tools": "commands",
}
ENTRY = re.compile(r"^(?:- |\| )\[([^\]]+)\]\(([^)#:]+\.md)\)")


def add_navigation(_app: Sphinx, page: str, source: list[str]) -> None:
    """Append what a README lists as tables of contents that the page itself does not show, and generated pages."""
    if (below := GENERATED.get(page)) is not None:
        source[0] += f"\n\n## In full\n\n```{{toctree}}\n:maxdepth: 1\n\n{below}\n```\n"
    if PurePosixPath(page).name != "README":
        return
    entries, heading = [], ""
    for line in source[0].splitlines():
        if line.startswith("## "):
            heading = line[3:].strip()
        elif (entry := ENTRY.match(line)) is not None:
            entries.append((heading, entry[2]))
    for heading, group in groupby(entries, key=lambda entry: entry[0]):
        caption = f":caption: {heading}\n" if page == root_doc else ""
        pages = "\n".join(target.removesuffix(".md") for _, target in group)
        source[0] += f"\n\n```{{toctree}}\n:hidden:\n{caption}\n{pages}\n```\n"


def setup(app: Sphinx) -> None:
    """Connect the navigation."""
    app.connect("source-read", add_navigation)
