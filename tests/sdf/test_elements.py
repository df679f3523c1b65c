"""Elements of SDF documents: how they are searched, and which texts are values."""

import math

import pytest

from libgz.sdf.element import Element
from libgz.sdf.reader import SdfFile
from libgz.sdf.upgrade import upgraded
from libgz.sdf.value import check


def names(elements):
    return [element.Get(str, "name") for element in elements]


def test_elements_are_found_at_any_depth_in_the_order_of_the_file():
    root = SdfFile.from_string(
        "<sdf version='1.6'><model name='a'><link name='1'/><model name='b'><link name='2'/></model>"
        "<link name='3'/></model><model name='c'><link name='4'/></model></sdf>"
    ).root
    assert names(root.find("link")) == ["1", "2", "3", "4"]
    assert names(root.find("model")) == ["a", "b", "c"]


def test_the_first_child_of_a_name_counts():
    element = Element("plugin")
    for text in ("1", "2"):
        element.AddElement("size").Set(text)
    assert element.Get(int, "size") == 1
    assert element.HasElement("size")
    assert not element.HasElement("mass")
    assert element.GetElement("mass") is None


NUMBERS = {"vector2d": (2,), "vector2i": (2,), "vector3": (3,), "pose": (6,), "color": (3, 4)}


@pytest.mark.parametrize("kind", NUMBERS)
def test_lists_have_their_count_of_finite_numbers(kind):
    for count in range(8):
        assert (check(kind, " ".join(["1.5"] * count)) == "") == (count in (0, *NUMBERS[kind]))
    for word in ("nan", "inf", "x", str(-math.inf)):
        assert check(kind, " ".join([word, *["1"] * (NUMBERS[kind][0] - 1)])) != ""


@pytest.mark.parametrize(
    ("kind", "right", "wrong"),
    [
        ("double", ("1", " 2e3 ", "inf", ""), ("x", "nan", "1 2")),
        ("int", ("1", " 0x1f ", ""), ("1.5", "1 2", "x")),
        ("bool", ("true", "0", " FALSE "), ("yes", "2")),
        ("string", ("", "anything at all"), ()),
    ],
)
def test_single_values_are_of_their_kind(kind, right, wrong):
    assert [check(kind, text) for text in right] == [""] * len(right)
    assert all(check(kind, text) for text in wrong)


def test_what_a_plugin_made_by_get_element_is_kept():
    file = SdfFile.from_string("<sdf version='1.6'><model name='m'><link name='l'/></model></sdf>")
    link = next(file.root.find("link"))
    link.child("inertial").child("inertia")  # read only
    assert not upgraded(link).HasElement("inertial")
    link.GetElement("inertial")
    assert upgraded(link).HasElement("inertial")
