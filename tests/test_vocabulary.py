"""The words of the project: standard terms, so that a reader never has to translate. CONTRIBUTING.md has the table."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PLACES = ["libgz", "interfaces", "models", "examples", "docs", "scripts", "benchmarks", "worlds"]
ENDINGS = {".py", ".pyi", ".c", ".h", ".md", ".world", ".sh", ".toml", ".cfg"}

# A word that must not be used, and what to use.
INSTEAD = {
    r"told|tells|tell": "report, print, log, raise, notify",
    r"faults?": "error, warning, diagnostic",
    r"mend|mends|mended|mending": "recover, repair, restore",
    r"drawn|drawing|draws": "render, rendered, rendering",
    r"pictures": "images",
    r"moorings?": "world joints, fixed joints",
    r"leavings": "stale files",
    r"strays": "unregistered",
    r"sleepy": "auto-disable, sleeping",
    r"run(s|ning)? away|ran away|runaways?": "diverge, divergence",
    r"houses?|rooms?": "package, module",
    r"goes along|go along|went along": "move with, run beside",
    r"let(s|ting)? go": "release, disconnect, end",
    r"cut short": "truncated",
    r"reckon(ed)?": "compute",
}
# Where a word stands for something else.
ALLOWED = re.compile(
    r"draws? calls?|random|a draw|drawn? (lots|from the generator)|"  # random draws, draw calls
    r"segmentation fault|gz_.*|"
    r"head ?room|class ?room|"
    r"living room|rooms</id>|a room with|the room: |hall and rooms|between houses",  # buildings in worlds
    re.IGNORECASE,
)


TERM = re.compile("|".join(rf"(?<![\w-])(?P<t{i}>{word})(?![\w-])" for i, word in enumerate(INSTEAD)), re.IGNORECASE)


def texts():
    yield from (p for place in PLACES for p in sorted((ROOT / place).rglob("*")) if p.suffix in ENDINGS)
    yield from ROOT.glob("*.md")


def terms(line):
    """What stands in a line that must not, and what to use."""
    if TERM.search(line):  # quicker than taking out what is allowed
        for found in TERM.finditer(ALLOWED.sub("", line)):
            yield f"{found[0]!r}, use {list(INSTEAD.values())[int(found.lastgroup[1:])]}"


def test_standard_terms_are_used():
    found = [
        f"{path.relative_to(ROOT)}:{number}: {term}"
        for path in texts()
        for number, line in enumerate(path.read_text(encoding="utf-8", errors="replace").splitlines(), 1)
        for term in terms(line)
        if not (path.name == "CONTRIBUTING.md" and line.startswith("|"))  # its table
    ]
    assert not found, "\n".join(found)


@pytest.mark.parametrize(
    "line", ["the server told us", "let it go; LETTING GO of it", "it was drawn", "a mended fault"]
)
def test_other_terms_are_found(line):
    assert list(terms(line))


@pytest.mark.parametrize("line", ["a segmentation fault", "draw calls of a frame", "pictured", "a retold story"])
def test_allowed_terms_are_not(line):
    assert not list(terms(line))
