"""Diagnostics: collected, reported together, each once."""

import pytest

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
