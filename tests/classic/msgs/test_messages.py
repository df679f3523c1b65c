"""Messages: fields, presence, copies, and their forms on the wire, as text and as JSON."""

import json
import math
import pickle
import struct
import types

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from libgz.base.errors import NotFoundError, ParameterError
from libgz.base.geometry import GzColor, GzPose, GzQuatern, GzVector
from libgz.classic import msgs
from libgz.classic.common import Time
from libgz.classic.math import Color, Pose3d, Quaterniond, Vector2d, Vector3d

CLASSIC = [name for name in msgs.known_types() if name.startswith("gazebo.msgs.")]


def filled(kind, depth=0):
    """A message whose every field is set, down to three levels."""
    message = kind()
    for field in kind.DESCRIPTOR.fields:
        if field.message_type is not None:
            if depth == 3:
                continue
            value = filled(msgs.message_type(field.message_type.full_name), depth + 1)
        elif field.enum_type is not None:
            value = field.enum_type.values[-1].number
        else:
            value = {
                field.TYPE_DOUBLE: 1.5,
                field.TYPE_FLOAT: 0.25,
                field.TYPE_BOOL: True,
                field.TYPE_STRING: "a\n\"b'é",
                field.TYPE_BYTES: b'\x00\xff"\\x',
            }.get(field.type, 1)
        setattr(message, field.name, [value, value] if field.is_repeated else value)
    return message


def test_fields_are_attributes():
    v = msgs.Vector3d(x=1, y=2)
    assert (v.x, v.y, v.z) == (1.0, 2.0, 0.0)
    v.z = np.float32(0.5)
    assert v == msgs.Vector3d(x=1, y=2, z=0.5)
    pose = msgs.Pose()
    pose.position.x = 1.0
    assert pose.position.x == 1.0
    assert pose.orientation.w == 1.0


@pytest.mark.parametrize("name", CLASSIC)
def test_every_declared_message_can_be_made_and_keeps_its_fields(name):
    kind = msgs.message_type(name)
    assert kind.GetTypeName() == name
    full = filled(kind)
    assert [field.name for field in kind.DESCRIPTOR.fields] == [field.name for field, _ in full.ListFields()]
    full = kind.FromString(full.SerializeToString())  # with what is required on the last level
    assert kind.FromString(full.SerializeToString()) == full
    assert kind().FromDict(json.loads(json.dumps(full.ToDict()))) == full
    again = kind()
    msgs.Parse(again, str(full))
    assert again == full
    again = kind()
    msgs.Parse(again, full.ShortDebugString())
    assert again == full
    assert str(kind()) == "" == repr(kind()).removeprefix(kind.__qualname__ + "()")


def test_enumerations_belong_to_their_messages():
    geometry = msgs.Geometry(type=msgs.Geometry.SPHERE)
    assert geometry.type == msgs.Geometry.SPHERE == 3
    geometry.type = "BOX"
    assert geometry.type == msgs.Geometry.BOX
    assert msgs.Geometry().type == msgs.Geometry.BOX
    assert msgs.Physics().type == msgs.Physics.ODE
    with pytest.raises(ParameterError, match=r"Geometry.type cannot be 'CUBE': it must be one of BOX \(1\), CYL"):
        geometry.type = "CUBE"


def test_presence():
    factory = msgs.Factory()
    assert not factory.HasField("pose")
    assert factory.pose.position.x == 0.0
    assert not factory.HasField("pose")  # asking sets nothing
    factory.pose.position.x = 0.0
    assert factory.HasField("pose")
    assert not factory.HasField("sdf")
    factory.sdf = ""
    assert factory.HasField("sdf")
    factory.ClearField("pose")
    assert not factory.HasField("pose")
    factory.pose.SetInParent()
    assert msgs.Factory.FromString(factory.SerializeToString()).HasField("pose")
    factory.Clear()
    assert factory == msgs.Factory()
    with pytest.raises(ParameterError, match="did you mean 'pose'"):
        factory.HasField("poes")
    with pytest.raises(ParameterError, match="repeated"):
        msgs.Pose_V().HasField("pose")


def test_repeated_fields():
    poses = msgs.PosesStamped()
    one = poses.pose.add(name="box", id=3)
    one.position.z = 2.0
    poses.pose.add().name = "ball"
    assert [p.name for p in poses.pose] == ["box", "ball"]
    assert poses.pose[0].position.z == 2.0
    scan = msgs.LaserScan(ranges=np.array([1.0, math.inf]))
    scan.ranges.append(3)
    scan.ranges.append(4)
    scan.ranges.extend([5])
    scan.ranges[0] = 0.5
    assert scan.ranges == [0.5, math.inf, 3.0, 4.0, 5.0]
    assert all(type(r) is float for r in scan.ranges)
    assert msgs.LaserScan.FromString(scan.SerializeToString()).ranges == scan.ranges
    with pytest.raises(ParameterError, match=r"LaserScan.ranges cannot be 'far'"):
        scan.ranges = [1.0, "far"]
    with pytest.raises(TypeError):
        scan.ranges.append("far")
    assert scan.ranges == [0.5, math.inf, 3.0, 4.0, 5.0]
    with pytest.raises(ParameterError, match=r"pose cannot be Vector3d\(\): "):
        poses.pose = [msgs.Vector3d()]
    with pytest.raises(TypeError):
        poses.pose.append(msgs.Vector3d())
    with pytest.raises(ParameterError, match="takes a sequence"):
        scan.ranges = 5.0


@pytest.mark.parametrize(
    ("message", "field", "value"),
    [
        ("Vector3d", "x", "1"),
        ("Time", "sec", 1.5),
        ("Time", "sec", 1 << 31),
        ("Pose", "id", -1),
        ("Pose", "name", b"\xff"),
        ("Image", "data", 5),
        ("Image", "data", "abc"),
        ("WorldControl", "pause", "true"),
        ("Pose", "position", (1, 2, 3)),
    ],
)
def test_a_value_that_does_not_fit_is_refused(message, field, value):
    with pytest.raises(ParameterError, match=rf"gazebo.msgs.{message}.{field} cannot be "):
        setattr(msgs.message_type(message)(), field, value)


def test_an_unknown_field_is_refused():
    with pytest.raises(AttributeError, match=r"gazebo.msgs.Pose has no field 'postion'; did you mean 'position'"):
        msgs.Pose().postion = msgs.Vector3d()
    with pytest.raises(AttributeError, match="did you mean 'position'"):
        _ = msgs.Pose().postion
    with pytest.raises(AttributeError, match="did you mean 'Vector3d'"):
        _ = msgs.Vectr3d
    with pytest.raises(NotFoundError):
        msgs.message_type("Vectr3d")


def test_what_is_set_is_copied():
    v = msgs.Vector3d(x=1)
    pose = msgs.Pose(position=v)
    v.x = 2.0
    assert pose.position.x == 1.0
    other = msgs.Pose()
    other.CopyFrom(pose)
    pose.position.x = 5.0
    assert other.position.x == 1.0
    many = msgs.Pose_V()
    many.pose.append(pose)
    twin = many.copy()
    many.pose[0].name = "changed"
    assert twin.pose[0].name == ""
    assert pickle.loads(pickle.dumps(twin)) == twin
    with pytest.raises(ParameterError, match=r"a gazebo.msgs.Pose cannot be copied from a gazebo.msgs.Vector3d"):
        other.CopyFrom(v)


def test_the_wire_is_that_of_classic():
    """Bytes worked out by hand from the public description of the format, and the numbers of classic's messages."""
    assert msgs.Time(sec=300, nsec=-1).SerializeToString() == b"\x08\xac\x02\x10" + b"\xff" * 9 + b"\x01"
    assert msgs.GzString(data="hé").SerializeToString() == b"\x0a\x03h\xc3\xa9"
    assert msgs.Quaternion(x=1, y=0, z=0).SerializeToString() == b"".join(
        bytes((key,)) + struct.pack("<d", value) for key, value in ((0x11, 1), (0x19, 0), (0x21, 0), (0x29, 1))
    )
    assert msgs.LaserScan.DESCRIPTOR.fields_by_name["ranges"].number == 13
    assert msgs.Visual(name="v", parent_name="p", type="LINK").SerializeToString()[-1] == 2
    joystick = b"\x18\x01\x18\x00\x18\xac\x02"
    assert msgs.Joystick(buttons=[1, 0, 300]).SerializeToString() == joystick
    assert msgs.Joystick.FromString(b"\x1a\x04\x01\x00\xac\x02").buttons == [1, 0, 300]


def test_required_fields_are_sent_with_their_defaults():
    """A reader of classic refuses a message without them."""
    pose = msgs.Pose(position=msgs.Vector3d(y=2))
    assert not pose.HasField("orientation")
    read = msgs.Pose.FromString(pose.SerializeToString())
    assert read.position == msgs.Vector3d(x=0, y=2, z=0)
    assert read.orientation == msgs.Quaternion(x=0, y=0, z=0, w=1)
    assert not pose.HasField("orientation")
    assert not pose.position.HasField("x")
    scene = msgs.Scene(name="default", joint=[msgs.Joint()])
    assert msgs.Scene.FromString(scene.SerializeToString()).joint[0].HasField("name")


def test_unknown_fields_are_skipped():
    new = msgs.declare("test.New", "int32 a, double b, string c, Pose d, double e, float f, int32 g[]")
    old = msgs.declare("test.Old", "int32 a, int64 unused, uint32 also")
    data = new(a=7, b=2, c="x", d=msgs.Pose(id=1), e=1, f=1, g=[1, 2]).SerializeToString()
    assert old.FromString(data).a == 7


@pytest.mark.parametrize(
    "data", [b"\x09", b"\x09abc", b"\x1a\x7fx", b"\xff" * 11, b"\x0b", b"\x1a\x01\xff", b"\x0a\x01\xff"]
)
def test_damaged_data_are_refused(data):
    pose = msgs.Pose(id=1)
    with pytest.raises(ParameterError, match="damaged"):
        pose.ParseFromString(data)
    assert pose == msgs.Pose()


def test_messages_without_end_within_each_other_are_refused():
    data, key = b"", bytes((msgs.Model.DESCRIPTOR.fields_by_name["model"].number << 3 | 2,))
    for _ in range(120):
        size = len(data)
        data = key + (bytes((size,)) if size < 128 else bytes((size & 127 | 128, size >> 7))) + data
    with pytest.raises(ParameterError, match="damaged"):
        msgs.Model.FromString(data)


@settings(max_examples=200, deadline=None)
@given(st.binary(max_size=60))
def test_any_bytes_are_a_message_or_refused(data):
    try:
        message = msgs.Model.FromString(data)
    except ParameterError:
        return
    whole = msgs.Model.FromString(message.SerializeToString())
    assert msgs.Model.FromString(whole.SerializeToString()) == whole


def test_text_form():
    model = msgs.Model(name="m")
    model.link.add(name="l").visual.add().geometry.type = msgs.Geometry.BOX
    assert str(model) == 'name: "m"\nlink {\n  name: "l"\n  visual {\n    geometry {\n      type: BOX\n    }\n  }\n}\n'
    assert msgs.Vector3d(x=1, y=0.1, z=1e300).ShortDebugString() == "x: 1 y: 0.1 z: 1e+300"
    assert msgs.Color(r=0.1, g=1 / 3).ShortDebugString() == "r: 0.1 g: 0.33333334"
    message = msgs.Joint()
    msgs.Parse(message, "# a joint\nangle: [1, 2.5] angle: -inf; pose: < id: 0x10 >, type: SCREW name: 'a' 'b\\n\\101'")
    assert message.angle == [1.0, 2.5, -math.inf]
    assert (message.pose.id, message.type, message.name) == (16, msgs.Joint.SCREW, "ab\nA")


@pytest.mark.parametrize("words", ["x 1", "x:", "w: 1", "x: a", "x: 1 }", "x: [1]", "{", '"', "x: {", "x: 1 : 2"])
def test_text_that_cannot_be_read_is_refused(words):
    with pytest.raises(ParameterError):
        msgs.Parse(msgs.Vector3d(), words)


@pytest.mark.parametrize(
    ("kind", "words"), [("Pose", "position: 1"), ("Pose", "position {"), ("WorldControl", "pause: 2")]
)
def test_text_that_does_not_fit_is_refused(kind, words):
    with pytest.raises(ParameterError):
        msgs.Parse(msgs.message_type(kind)(), words)


@pytest.mark.parametrize("values", [{"a": 1}, {"x": "1"}, [1], {"x": [1]}])
def test_a_dict_that_does_not_fit_is_refused(values):
    with pytest.raises(ParameterError):
        msgs.Vector3d().FromDict(values)


def test_declared_messages():
    wheels = msgs.declare(
        "test.Wheels", "double left, double right = 2.5, Mode mode = DRIVING, bool on = true", Mode="IDLE DRIVING"
    )
    message = wheels(left=1)
    assert (message.left, message.right, message.mode, message.on) == (1.0, 2.5, wheels.DRIVING, True)
    assert wheels.GetTypeName() == "test.Wheels"
    assert msgs.message_type("test.Wheels") is wheels
    assert "test.Wheels" in msgs.known_types()
    again = "double left, double right = 2.5, Mode mode = DRIVING,  bool on = true"
    assert msgs.declare("test.Wheels", again, Mode="IDLE DRIVING") is wheels
    for name, fields in [
        ("test.Wheels", "double left"),
        ("Vector3d", "double x"),
        ("gazebo.msgs.Vector3d", "double x"),
        ("test.A", "doubble x"),
        ("test.A", "double"),
        ("test.A", "double x, int32 x"),
        ("test.A", "Pose p = 1"),
        ("test.A", "int32 x = a"),
        ("test A", "int32 x"),
    ]:
        with pytest.raises(ParameterError):
            msgs.declare(name, fields)
    assert "test.A" not in msgs.known_types()


def test_set_and_convert():
    pose = Pose3d(1, 2, 3, 0.5, 0.5, -0.5, 0.5)
    message = msgs.Convert(pose)
    assert message.GetTypeName() == "gazebo.msgs.Pose"
    assert (message.orientation.w, message.orientation.y) == (0.5, -0.5)
    back = msgs.ConvertIgn(message)
    assert type(back) is Pose3d
    assert (list(back.pos), list(back.rot)) == ([1, 2, 3], [0.5, 0.5, -0.5, 0.5])
    assert msgs.Convert(GzPose(GzVector(1, 2, 3), GzQuatern(0.5, 0.5, -0.5, 0.5))) == message
    for value in (Vector3d(1, 2, 3), Vector2d(1, 2), Quaterniond(0.6, 0.8, 0, 0), Color(1, 0.5, 0, 1), Time(3, 5)):
        there = msgs.Convert(value)
        assert type(msgs.Convert(there)) is type(value)
        assert msgs.ConvertIgn(there) == value
    v = msgs.Vector3d()
    msgs.Set(v, (1, 2, 3))
    assert list(msgs.Convert(v)) == [1, 2, 3]
    plane = msgs.PlaneGeom()
    msgs.Set(plane, types.SimpleNamespace(Normal=lambda: (0, 0, 1), Size=lambda: (2, 3), Offset=lambda: 4))
    assert (plane.normal.z, plane.size.y, plane.d) == (1.0, 3.0, 4.0)
    color = msgs.Convert(GzColor(0.5, 0.25, 0, 0.75))
    assert list(msgs.ConvertIgn(color)) == [0.5, 0.25, 0.0, 0.75]
    stamp = msgs.Convert(-0.25)
    assert (stamp.sec, stamp.nsec) == (-1, 750_000_000)
    light = msgs.Light()
    msgs.Set(light.diffuse, (1, 0, 0))
    assert (light.diffuse.r, light.diffuse.a) == (1.0, 1.0)
    with pytest.raises(ParameterError, match="cannot be set from"):
        msgs.Set(v, (1, 2))
    with pytest.raises(ParameterError, match=r"cannot fill a gazebo.msgs.Model"):
        msgs.Set(msgs.Model(), 1)
    with pytest.raises(ParameterError, match="no counterpart"):
        msgs.Convert(object())
    with pytest.raises(ParameterError, match="no counterpart"):
        msgs.ConvertIgn(msgs.Model())


def test_times_that_a_message_cannot_hold_are_the_latest():
    for value in (152e9, Time(152_000_000_000, 5)):
        message = msgs.Time()
        msgs.Set(message, value)
        assert message.sec == 2**31 - 1


def test_stamps_and_requests():
    header = msgs.Header()
    msgs.Stamp(header)
    assert header.stamp.sec > 1_600_000_000
    assert 0 <= header.stamp.nsec < 1_000_000_000
    kind = msgs.declare("test.WithHeader", "Header header, double x")
    message = kind()
    msgs.Init(message, "me")
    assert message.header.str_id == "me"
    assert message.header.HasField("stamp")
    one, two = msgs.CreateRequest("entity_delete", "box"), msgs.CreateRequest("scene_info")
    assert (one.request, one.data) == ("entity_delete", "box")
    assert one.id != two.id
    with pytest.raises(ParameterError, match="no header"):
        msgs.Init(msgs.Vector3d())
    with pytest.raises(ParameterError, match="has no time stamp"):
        msgs.Stamp(msgs.Vector3d())
