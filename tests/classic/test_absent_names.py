"""Names of Gazebo's API that libgz has not: each module says what serves instead."""

from importlib import import_module

import pytest

from libgz import classic
from libgz.classic.api import classic_api

# The modules' names: a class by one of its rows, a function or constant by its own.
ABSENT = sorted(
    {
        (module, row.name if kind.startswith("(") else kind, row.note)
        for row in classic_api()
        if row.state == "absent"
        for module, _, kind in [row.holder.rpartition(".")]
    }
)


def holder_of(module):
    return import_module(f"libgz.classic.{module}") if module else classic


def test_there_are_some():
    assert len(ABSENT) > 150
    expected = {"common", "gui", "math", "msgs", "physics", "rendering", "sdf", "sensors", "transport", ""}
    assert expected <= {module for module, *_ in ABSENT}


def test_each_absent_name_has_a_sentence_that_says_what_serves_instead():
    wrong, seen = [], set()
    for module, name, note in ABSENT:
        holder = holder_of(module)
        if hasattr(holder, name) or (module, name) in seen:
            continue  # a class with some absent methods
        seen.add((module, name))
        with pytest.raises(AttributeError) as raised:
            getattr(holder, name)
        if str(raised.value) != f"{holder.__name__} has no {name}, which Gazebo has: {note}":
            wrong.append((module, name, str(raised.value)))
    assert not wrong
    assert {("common", "URI"), ("msgs", "GUIFromSDF"), ("", "util"), ("sensors", "RFIDSensor")} <= seen


@pytest.mark.parametrize(
    ("module", "name", "nearest"),
    [("common", "Tim", "'Time'"), ("physics", "Modle", "'Model'"), ("msgs", "Vektor3d", "'Vector3d'")],
)
def test_other_names_have_the_nearest_one(module, name, nearest):
    with pytest.raises(AttributeError, match=rf"{name}'.*did you mean .*{nearest}"):
        getattr(holder_of(module), name)
    assert not hasattr(holder_of(module), "__path_of_nothing__")
