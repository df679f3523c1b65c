"""The table of Gazebo classic's API and the code: each holds what the other says."""

import pytest

from libgz.reference.classic_api import bases_of, classic_api, has, public_names

ROWS = classic_api()


def test_what_the_table_has_is_there_and_what_it_lacks_is_not():
    wrong = [row for row in ROWS if has(row.holder, row.name) != (row.state != "absent")]
    assert not wrong


def test_absent_and_added_names_carry_a_reason():
    assert not [row for row in ROWS if (len(row.note) >= 5) != (row.state in ("absent", "added", "differs"))]
    assert {row.state for row in ROWS} == {"present", "differs", "old", "absent", "added"}


def test_each_name_is_in_the_table_once():
    names = [(row.holder, row.name) for row in ROWS]
    assert len(names) == len(set(names))


def test_every_public_name_of_a_class_is_in_the_table():
    listed = {(row.holder, row.name) for row in ROWS}
    missing = [
        f"{holder}.{name}"
        for holder, names in public_names().items()
        for name in names
        if not any((place, name) in listed for place in (holder, *bases_of(holder)))
    ]
    assert not missing, "add rows to libgz/classic/api.tsv"


@pytest.mark.parametrize(
    ("holder", "names"),
    [
        ("physics.World", ["SimTime", "ModelByName", "Step", "InsertModelString", "UniqueModelName"]),
        ("physics.Link", ["AddForce", "WorldPose", "Load"]),
        ("rendering.Visual", ["SetTransparency", "ShowCollision"]),
    ],
)
def test_the_table_knows_what_every_plugin_uses(holder, names):
    listed = {
        row.name for row in ROWS if row.holder in (holder, *bases_of(holder)) and row.state in ("present", "differs")
    }
    assert listed >= set(names) - {"Load"}
