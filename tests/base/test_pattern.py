"""Regular expressions of files: what matches, what is refused, and that none takes long."""

import random
import re

import pytest

from libgz.base.errors import ParameterError
from libgz.base.pattern import Pattern

NAMES = (
    "",
    "a",
    "ab",
    "aab",
    "joint_1",
    "joint_12",
    "left_wheel",
    "right_wheel",
    "a::b",
    "b-c",
    "Joint",
    "a\nb",
    "x.y",
)
TEXTS = (
    "joint_.*",
    "(left|right)_wheel",
    "joint_[0-9]{1,2}",
    r"joint_\d+",
    "[^_]*",
    "a{2}b",
    "a{1,}b",
    "(?:a|ab)(?:b|)",
    "(a+)+b",
    "^a$",
    r"a\b.*",
    r"a\Bb",
    "a??b",
    r"x\.y",
    "x.y",
    "a.b",
    "",
    "a|",
    "[]a]",
    r"[\]a]",
    "(a*)*",
    "((a|b)*c?){0,3}",
    "a{,2}",
    "{",
)


@pytest.mark.parametrize("text", TEXTS)
def test_it_matches_as_python_does(text):
    if text == "a{,2}":  # Python 3.11 reads it as a{0,2}, ECMAScript as no repetition
        assert Pattern(text).matches("a{,2}")
        return
    assert [Pattern(text).matches(name) for name in NAMES] == [re.fullmatch(text, name) is not None for name in NAMES]


def test_random_patterns_match_as_python_does():
    rng = random.Random(5)
    for _ in range(2000):
        text = "".join(rng.choice(["a", "b", ".", "(", ")", "|", "*", "+", "?", "[ab]", "{1,2}"]) for _ in range(8))
        try:
            mine = Pattern(text)
        except ParameterError:
            continue
        try:
            other = re.compile(text)
        except re.error:  # repetitions that Python does not nest
            continue
        if re.search(r"[*+?}][+]", text):  # Python's possessive repetitions
            continue
        for _ in range(10):
            name = "".join(rng.choice("abc") for _ in range(rng.randrange(6)))
            assert mine.matches(name) == (other.fullmatch(name) is not None), (text, name)


def test_classes_have_names_as_in_c_plus_plus():
    assert Pattern("wheel[[:digit:]_]+").matches("wheel_01")
    assert not Pattern("[[:alpha:]]+").matches("a1")


@pytest.mark.parametrize(
    "text", ["(a+)+b", "(a|aa)+$", "(a|a?)+b", "(.*a){12}b", "(a*)*b", "((a*)*)*b", "(x+x+)+y", "a?" * 200 + "a" * 200]
)
def test_no_pattern_takes_long(text):
    assert not Pattern(text).matches("a" * 30 + "!")
    assert not Pattern(text).matches("x" * 300)


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("(", "without )"),
        (")", "nothing opens"),
        ("[a", "without ]"),
        ("*a", "after nothing"),
        ("a{3,2}", "below its least"),
        (r"(a)\1", "escape"),
        ("(?=a)", "not supported"),
        ("[z-a]", "wrong"),
        ("((a{100}){100}){100}", "more than"),
        ("(" * 500, "deep"),
        ("a" * 1001, "1001 characters"),
        ("\\", "escape"),
    ],
)
def test_what_is_refused(text, what):
    with pytest.raises(ParameterError, match=re.escape(what)):
        Pattern(text)
