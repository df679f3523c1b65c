"""The reference of the interfaces."""

from libgz.interfaces.catalog import INTERFACES
from libgz.interfaces.reference import describe, reference


def test_every_interface_has_its_struct_and_its_functions():
    page = reference()
    for type_ in INTERFACES:
        section = describe(type_)
        assert f"`gz_{type_}_data_t`" in section
        assert section in page
    assert "| 160 | 24 | double[3] | `pos` | S |" in describe("position")
    assert describe("postion") == ""
