"""docs/errors.md: every message in it is one that libgz has."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "errors.md").read_text()
ROWS = re.findall(r"^\| `(.*?)` \| (.*?) \| (.*?) \|$", PAGE, re.M)
GAP = "\0"


def text_of(node):
    """The text of a string, f-string, sum or choice of strings, with GAP for what is filled in."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return re.sub(r"%[-\d.]*[a-z]|%%", GAP, node.value)
    if isinstance(node, ast.JoinedStr):
        return "".join(text_of(part) if isinstance(part, ast.Constant) else GAP for part in node.values)
    return GAP


@pytest.fixture(scope="module")
def messages():
    """The texts of all strings of the package's code."""
    found = set()
    for folder in ("libgz", "interfaces", "models"):
        for path in sorted((ROOT / folder).rglob("*.py")):
            strings = (n for n in ast.walk(ast.parse(path.read_text())) if isinstance(n, ast.JoinedStr | ast.Constant))
            found |= {text for text in map(text_of, strings) if len(text) > 10}
    for path in sorted((ROOT / "libgz/cxx").glob("*.c")):  # what is written when a plugin crashes
        found |= set(re.findall(r'"([^"\n]{11,})"', path.read_text()))
    return found


def known(message, messages):
    """Whether a message of the page is, up to what is filled in, one of the code, or the end or beginning of one."""
    pieces = [piece.strip() for piece in message.split("...")]
    pieces = [piece for piece in pieces if re.search(r"\w{2}", piece)]
    pattern = re.compile(".*".join(map(re.escape, pieces)), re.S)
    return any(pattern.search(text) for text in messages)


def test_there_are_rows():
    assert len(ROWS) > 80
    assert len(ROWS) == sum(line.startswith("| `") for line in PAGE.splitlines())
    assert len({message for message, _, _ in ROWS}) == len(ROWS)


@pytest.mark.parametrize("message", [message for message, _, _ in ROWS])
def test_the_message_is_in_the_code(message, messages):
    assert known(message, messages), message


def test_what_is_not_in_the_code_is_noticed(messages):
    assert not known("body ... has exploded; its velocity was reset", messages)


def test_every_class_of_errors_is_on_its_page():
    from libgz.apps.api_pages import api_pages
    from libgz.base import errors

    page = api_pages()["errors.md"]

    for name in errors.__all__:
        thing = getattr(errors, name)
        if isinstance(thing, type) and issubclass(thing, errors.GazeboError):
            assert f"\n## {name}\n" in page
