"""Texts from outside, as terminals and logs show them."""

import logging

import pytest

from libgz.apps.console import PREFIXES, _ConsoleFormatter
from libgz.base.visible import one_line, visible


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("plain ä 日本", "plain ä 日本"),
        ("two\nlines\tand a tab", "two\nlines\tand a tab"),
        ("\x1b]0;title\x07\x9b2J\r\0\x7f", "\\x1b]0;title\\x07\\x9b2J\\r\\x00\\x7f"),
        ("turned \u202eround, broken \udcff", "turned \\u202eround, broken \\udcff"),
    ],
)
def test_control_characters_are_escaped(text, shown):
    assert visible(text) == shown
    assert one_line(text) == shown.replace("\n", "\\n")


def test_commands_print_no_control_characters():
    record = logging.LogRecord("libgz", logging.ERROR, "x.py", 1, "%s: wrong", ("a\x1b[2J.world",), None)
    assert _ConsoleFormatter("%(message)s").format(record) == f"{PREFIXES[logging.ERROR]}a\\x1b[2J.world: wrong"
