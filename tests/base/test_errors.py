"""Diagnostics: collected, reported together, each once."""

import itertools

import pytest

from libgz.base import errors
from libgz.base.errors import Diagnostics, Place, Remark, WorldFileError, nearest
from libgz.sdf.element import Element


def test_errors_and_warnings_are_collected_in_order_once_each():
    diagnostics, place = Diagnostics(), Place("a.world", 3, "size")
    for _ in range(2):
        diagnostics.warn(place, "has no effect")
        diagnostics.error(place, "must be above 0")
    assert [str(found) for found in diagnostics.found] == [
        "a.world:3: <size>: has no effect",
        "a.world:3: <size>: must be above 0",
    ]
    assert [found.message for found in diagnostics.warnings] == ["has no effect"]
    assert [found.message for found in diagnostics.errors] == ["must be above 0"]


def test_all_errors_are_raised_together_and_warnings_never():
    diagnostics = Diagnostics()
    diagnostics.warn(Place("a.world", 1, "a"), "odd")
    diagnostics.raise_errors()
    diagnostics.error(Place("a.world", 2, "b"), "wrong")
    diagnostics.error(Place("a.world", 3, "c"), "wrong, too")
    with pytest.raises(WorldFileError) as raised:
        diagnostics.raise_errors()
    assert str(raised.value).splitlines() == ["a.world:2: <b>: wrong", "a.world:3: <c>: wrong, too"]


def test_elements_are_places_and_those_of_no_file_are_strings():
    diagnostics = Diagnostics()
    diagnostics.warn(Element("link", line=4), "is empty")
    assert [str(found) for found in diagnostics.found] == ["<string>:4: <link>: is empty"]


def test_nearest_names():
    assert nearest("radus", ["radius", "mass"]) == "; did you mean 'radius'?"
    assert nearest("xyz", ["radius", "mass"]) == ""


def test_a_log_has_a_few_warnings_of_a_kind():
    diagnostics = Diagnostics()
    for line in range(1, 10):
        diagnostics.warn(
            Place("a.sdf", line, "mesh"), f"Unable to find uri[model://m{line}]; looked for /a/m{line}, /b"
        )
        diagnostics.warn(Place("a.sdf", line, "size"), f"is '{line}'; did you mean {line + 1}?")
    diagnostics.warn(Place("a.sdf", 20, "size"), "is another kind")
    lines = diagnostics.summary()
    assert len(lines) == 2 * 5 + 1 + 2
    assert lines[-2] == "a.sdf: <mesh>: 4 more like the warning of line 1; `libgz sdf --check a.sdf` lists all"
    diagnostics.most_alike = 100
    assert lines[:2] == diagnostics.summary()[:2]
    assert len(diagnostics.summary()) == 19


def test_a_message_names_only_what_is_known_of_its_place():
    assert str(Remark("a.sdf", 3, "mesh", "is empty")) == "a.sdf:3: <mesh>: is empty"
    assert str(Remark("a.sdf", 0, "mesh", "is empty")) == "a.sdf: <mesh>: is empty"
    assert str(Remark("a.sdf", 0, "", "is empty")) == "a.sdf: is empty"


def test_what_thousands_of_errors_say_is_bounded():
    diagnostics, place = Diagnostics(), Place("a.world", 3, "size")
    for number in range(1500):
        diagnostics.error(place, f"wrong {number} {'x' * 100_000} end {number}")
    with pytest.raises(WorldFileError) as raised:
        diagnostics.raise_errors()
    lines = str(raised.value).splitlines()
    assert len(lines) == 1001
    assert max(map(len, lines)) < 9000
    assert lines[7].startswith("a.world:3: <size>: wrong 7 xxx")
    assert lines[7].endswith("xxx end 7")
    assert lines[-1] == "a.world:3: <size>: this and 499 more errors are not listed"
    diagnostics.warn(place, "odd")
    assert [warning.message for warning in diagnostics.warnings] == ["odd"]
    outer = Diagnostics()
    outer.include(diagnostics, "b.world", 7)
    assert outer.errors == diagnostics.errors


def test_warnings_beyond_the_most_are_counted_and_leave_errors_their_place():
    diagnostics = Diagnostics()
    for line in range(10_005):
        diagnostics.warn(Place("a.world", line, "size"), "odd")
        diagnostics.warn(Place("a.world", 1, "size"), "odd")
    diagnostics.error(Place("a.world", 5, "size"), "wrong")
    assert len(diagnostics.warnings) == 10_001
    assert diagnostics.warnings[-1].message == "this and 4 more warnings are not listed"
    assert len(diagnostics.errors) == 1


@pytest.mark.parametrize("text", ["a", "[", "[a", "]a", "/~"])
def test_warnings_are_grouped_in_time_that_grows_with_their_length(text):
    diagnostics = Diagnostics()
    for line in range(200):
        diagnostics.warn(Place("a.world", line, "size"), (text * 8000)[:8000])
    assert diagnostics.summary()  # which would take minutes if it were the square


def test_suggestions_take_a_second_and_then_a_tenth_of_the_time(monkeypatch):
    clock = itertools.count()
    monkeypatch.setattr(errors.time, "process_time", lambda: next(clock) * 0.05)  # [s]: each comparison takes as much
    monkeypatch.setattr(errors, "_allowance", errors._Allowance())
    hints = [bool(nearest("lnk", ["link"])) for _ in range(1000)]
    assert all(hints[:10])
    assert 50 < hints[100:].count(True) < 100


def test_long_names_are_not_compared():
    assert nearest("a" * 1000, ["a" * 999]) == nearest("a" * 200, ["a" * 201]) == ""
