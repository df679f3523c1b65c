"""The words of the project: standard terms, so that a reader never has to translate. CONTRIBUTING.md has the table."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PLACES = ["libgz", "interfaces", "models", "examples", "docs", "scripts", "benchmarks", "worlds"]
ENDINGS = {".py", ".pyi", ".c", ".h", ".js", ".in", ".md", ".world", ".sh", ".toml", ".cfg"}

# Word of the table's last column -> its forms that are looked for. Others have a second, usual meaning.
FORMS = {
    "fault": r"faults?",
    "tell": r"tells?",
    "told": r"told",
    "mend": r"mend|mends|mended|mending",
    "draw": r"drawing|draws",
    "drawn": r"drawn",
    "picture": r"pictures",
    "moorings": r"moorings?",
    "leavings": r"leavings",
    "sleepy": r"sleepy",
    "run away": r"run(s|ning)? away|ran away",
    "runaway": r"runaways?",
    "house": r"houses?",
    "room": r"rooms?",
    "let go": r"let(s|ting)? go",
    "cut short": r"cut short",
    "go on": r"go(es|ing)? on|went on",
    "clock of the world": r"clocks? of the world",
    "asked first": r"asked first",
    "cannot be reckoned with": r"reckon(ed)?",
    "what something left behind": r"leave(s)? trouble|left behind by",
    "what was to be done after": r"what was to be done after",
}
MEANT_OTHERWISE = {"say", "word", "go", "push", "floor", "gone", "has left"}  # too usual to look for
# Sentences that readers stumbled over, and other words.
ALSO = {
    r"strays": "unregistered",
    r"goes along|go along|went along": "move with, run beside",
    r"(is|are) given out again": "rescheduled",
    r"built anew instead": "rebuilt",
    r"can come and go": "start and stop",
    r"present browser": "current browser",
    r"bytes that can be kept": "save as bytes",
    r"for what is no": "if it is not a",
}


def table():
    """(word that is not to be used, what to use) of the table in CONTRIBUTING.md."""
    page = (ROOT / "CONTRIBUTING.md").read_text().partition("| for | use | not |")[2].partition("\n\n")[0]
    for line in page.splitlines()[2:]:
        _, _, use, words, _ = line.split("|")
        for word in re.sub(r"\(.*?\)", "", words).split(","):
            yield word.strip(), use.strip()


INSTEAD = {FORMS[word]: use for word, use in table() if word in FORMS} | ALSO
# Where a word stands for something else.
ALLOWED = re.compile(
    r"\.tell\(\)|"  # the method of files
    r"draws? calls?|random|a draw|drawn? (lots|from the generator)|"  # random draws, draw calls
    r"segmentation fault|gz_.*|xmlrpc\.client\.Fault|"
    r"head ?room|class ?room|"
    r"living room|rooms</id>|a room with|the room: |hall and rooms|between houses",  # buildings in worlds
    re.IGNORECASE,
)


TERM = re.compile("|".join(rf"(?<![\w-])(?P<t{i}>{word})(?![\w-])" for i, word in enumerate(INSTEAD)), re.IGNORECASE)


def texts():
    found = (p for place in PLACES for p in sorted((ROOT / place).rglob("*")) if p.suffix in ENDINGS)
    yield from (p for p in found if "vendor" not in p.parts)
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


def test_every_word_of_the_table_is_looked_for():
    words = [word for word, _ in table()]
    assert len(words) > 20
    assert set(words) == FORMS.keys() | MEANT_OTHERWISE


@pytest.mark.parametrize(
    "line", ["the server told us", "let it go; LETTING GO of it", "it was drawn", "a mended fault"]
)
def test_other_terms_are_found(line):
    assert list(terms(line))


@pytest.mark.parametrize("line", ["a segmentation fault", "draw calls of a frame", "pictured", "a retold story"])
def test_allowed_terms_are_not(line):
    assert not list(terms(line))
