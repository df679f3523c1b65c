"""The numbers of interfaces, which pages show and plot."""

import types

import pytest

from libgz.interfaces.joint import JointsData
from libgz.interfaces.laser import LaserData
from libgz.view.fields import KEY, fields_of_interface, value_of


def interface(kind, layout, **values):
    data = layout()
    for name, value in values.items():
        setattr(data, name, value)
    return types.SimpleNamespace(type=kind, id="a.b", layout=layout, data=data)


def test_numbers_in_structs_of_arrays_are_fields():
    joints = interface("joint", JointsData, joint_count=2)
    joints.data.joints[1].anchor[2] = 0.5
    found = {field["label"]: field for field in fields_of_interface(joints)}
    assert found["joints[#]/anchor[2]"] == {
        **{"of": "joint.a.b", "key": "joint.a.b.joints[#]/anchor[2]"},
        **{"label": "joints[#]/anchor[2]", "unit": "m", "count": 2},
    }  # fmt: skip
    assert found["joint_count"]["whole"]
    key = KEY.fullmatch(found["joints[#]/anchor[2]"]["key"].replace("#", "1"))
    assert (key["type"], key["id"], value_of(joints, key["path"])) == ("joint", "a.b", 0.5)


@pytest.mark.parametrize(
    "path", ["nothing", "ranges", "ranges[401]", "ranges[0][0]", "head", "__class__", "max_range/real", "head/size"]
)
def test_what_is_no_number_has_no_value(path):
    assert value_of(interface("laser", LaserData), path) is None


def test_numbers_that_are_not_finite_have_no_value():
    assert value_of(interface("laser", LaserData, max_range=float("inf")), "max_range") is None
