"""The structs of all interfaces: their layouts, functions and descriptions."""

import ctypes
import importlib
import pkgutil
from pathlib import Path

import pytest
from served import serve
from wire_layout import LAYOUT

import libgz
import libgz.interfaces
from libgz.interfaces.catalog import INTERFACES, new_interface
from libgz.interfaces.gripper import GripperDataCvs
from libgz.interfaces.position import Position
from libgz.interfaces.sim import Sim
from libgz.transport.interface import Interface
from libgz.transport.layout import ABIS, VERSIONS, Data, Struct, fields_of, for_abi, parts_of
from libgz.transport.server import Server


def interface_kinds():
    """The interfaces of all modules, whether they are in the catalog or not."""
    kinds = []
    for found in pkgutil.iter_modules(libgz.interfaces.__path__, "libgz.interfaces."):
        for value in vars(importlib.import_module(found.name)).values():
            is_interface = isinstance(value, type) and issubclass(value, Interface) and "type" in vars(value)
            if is_interface and value.__module__ == found.name:
                kinds.append(value)
    return kinds


KINDS = interface_kinds()


ELEMENTS = {
    "FiducialFid": "gz_fiducial_fid",
    "WifiLink": "gz_wifi_link",
    "JointData": "gz_joint_data",
    "ActarrayActuator": "gazebo_actarray_actuator",
}


def check_struct(struct, expected):
    assert ctypes.sizeof(struct) == expected["size"]
    for name, (offset, size, _) in expected["fields"].items():
        field = getattr(struct, name)
        assert (field.offset, field.size) == (offset, size), name
    declared = {name for name, *_ in struct._fields_} | ({"head"} if issubclass(struct, Data) else set())
    assert declared == set(expected["fields"])


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_misspelt_fields_are_errors(kind):
    data = kind.data_class()
    structs = [
        data,
        data.head,
        *(field.ctype() for field in fields_of(kind.data_class).values() if issubclass(field.ctype, Struct)),
    ]
    for struct in structs:
        with pytest.raises(AttributeError, match="has no attribute 'cmd_vel'"):
            struct.cmd_vel = 1


def test_all_interfaces_of_the_old_library_are_declared():
    assert {kind.type: kind for kind in KINDS} == INTERFACES
    assert {kind.type for kind in KINDS} == set(LAYOUT["_files"])
    check_struct(GripperDataCvs, LAYOUT["gz_gripper_data_cvs"])


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.type)
def test_struct_layouts(kind):
    described = LAYOUT["_files"][kind.type]
    check_struct(kind.data_class, LAYOUT[described["struct"]])
    assert kind.has_post == described["post_function"]
    for field in fields_of(kind.data_class).values():
        if issubclass(field.ctype, ctypes.Structure):
            check_struct(field.ctype, LAYOUT[ELEMENTS[field.ctype.__name__]])


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.type)
def test_struct_layouts_of_0x050(kind):
    struct = LAYOUT["_files"][kind.type]["struct"]
    differs = LAYOUT["_versions"]["0x050"]["differs"]
    assert set(kind.older) == ({0x050} if struct in differs else set())
    if kind.older:
        check_struct(kind.older[0x050], differs[struct])


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.type)
def test_old_functions_exist_for_every_interface(kind):
    module = importlib.import_module(kind.__module__)
    for verb in ("alloc", "free", "create", "destroy", "open", "close", "lock", "unlock"):
        assert callable(getattr(module, f"gz_{kind.type}_{verb}"))
        assert getattr(libgz, f"gz_{kind.type}_{verb}") is not None
    assert hasattr(module, f"gz_{kind.type}_post") == kind.has_post


@pytest.mark.parametrize("version", [0x050, 0x060])
def test_both_versions_can_be_announced(wire, version):
    server = Server(wire, version=version)
    server.start()
    truth, camera = serve(server, libgz.Truth, "t"), serve(server, libgz.Camera, "c")
    serve(server, Sim, "default")
    sizes = {0x050: (264, 230576), 0x060: (280, 921776)}[version]
    for interface, size in ((truth, sizes[0]), (camera, sizes[1])):
        raw = (Path(server.path) / f"{interface.type}.{interface.id}").read_bytes()
        assert (len(raw), raw[:4], raw[8:16]) == (size, version.to_bytes(4, "little"), size.to_bytes(8, "little"))
    here = libgz.GzPose(libgz.GzVector(1, 2, 3), libgz.GzQuaternFromEuler(0.1, 0.2, 0.3))
    there = libgz.GzPose(libgz.GzVector(4, 5, 6), libgz.GzQuaternFromEuler(-0.1, 0.4, 2.3))
    with truth.locked():
        truth.publish(1.5, here)
        assert truth.take_move() is None
    if version == 0x050:
        assert truth.rot.tolist() == pytest.approx([0.1, 0.2, 0.3])
    with libgz.Client(wire) as client:
        seen = client.truth("t")
        assert tuple(seen.pose.pos) == (1, 2, 3)
        assert tuple(seen.pose.rot) == pytest.approx(tuple(here.rot), abs=1e-15)
        seen.move(there)
        assert client.camera("c").all_pixels.size == camera.all_pixels.size
    with truth.locked():
        moved = truth.take_move()
        assert tuple(moved.rot) == pytest.approx(tuple(there.rot), abs=1e-15)
        assert truth.take_move() is None
    server.stop()


def test_every_field_has_a_description_and_a_writer():
    for kind in KINDS:
        for name, field in fields_of(kind.data_class).items():
            assert field.help, (kind.type, name)
            assert field.writer in ("S", "C", "S/C")


def test_docstrings_of_views_have_units():
    assert Position.vel_pos.__doc__.startswith("velocity in the robot's frame, forward first [m/s], shape (3,)")


@pytest.mark.parametrize("kind", INTERFACES)
@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("abi", ABIS)
def test_parts_are_all_of_a_struct(kind, version, abi):
    struct = for_abi(new_interface(kind).layout_for(version, None), abi)
    parts = parts_of(struct)
    ends = [0, *(part.offset + part.size for part in parts)]
    assert [*(part.offset for part in parts), ctypes.sizeof(struct)] == ends
    arrays = [part for part in parts if part.element]
    counted = [(name, field) for name, field in fields_of(struct).items() if field.used]
    for part, (name, field) in zip(arrays, counted, strict=True):
        assert (part.offset, part.used) == (getattr(struct, name).offset, getattr(struct, field.used).offset)
        assert part.element * field.shape[0] == part.size
        assert getattr(struct, field.used).size == 4
