"""Messages of ROS against the library rosbags: bytes of both wires, sums of types; damaged bytes."""

import itertools
import math
import random
import struct
from types import SimpleNamespace

import numpy as np
import pytest
from ros_types import JAZZY, NOETIC, described, stored
from rosbags.typesys import Stores, get_typestore

from libgz.base.errors import ParameterError
from libgz.ros.packed import PackedMessage
from libgz.ros.packing import CDR_HEADER, MOST_ITEMS, MOST_READ, Codec, FormatError, codec, read_schema
from libgz.ros.session import set_stamp
from libgz.ros.types import NUMBERS, TIMES, MessageType, Stamp, message_type, service_type, type_names
from libgz.simulation.recorder import Recorder

# What nodes of ROS say of types that rosbags does not know, from Gazebo's own gazebo_msgs and from Debian's tf2_msgs.
SUMS = {
    "gazebo_msgs/ApplyBodyWrench": "585b9f9618aa0581b207e2f2d90866bc",
    "gazebo_msgs/ApplyJointEffort": "c0039811b8cc919490b3cff748cdf46b",
    "gazebo_msgs/BodyRequest": "5eade9afe7f232d78005bd0cafeab755",
    "gazebo_msgs/ContactsState": "acbcb1601a8e525bf72509f18e6f668d",
    "gazebo_msgs/DeleteModel": "9ce56b4e9e54616de25d796dc972a262",
    "gazebo_msgs/GetJointProperties": "7b30be900f50aa21efec4a0ec92d91c9",
    "gazebo_msgs/GetLinkProperties": "0e06a70386d0ee3fb880c02f23fcd821",
    "gazebo_msgs/GetLinkState": "09d6c98cce97b35f7ab9bd70300657ab",
    "gazebo_msgs/GetModelProperties": "5717f7bd34ed990fa80e28b3015027a3",
    "gazebo_msgs/GetModelState": "4c515e936d3319c9610c559c60bfc3d4",
    "gazebo_msgs/GetPhysicsProperties": "575a5e74786981b7df2e3afc567693a6",
    "gazebo_msgs/GetWorldProperties": "36bb0f2eccf4d8be971410c22818ba3f",
    "gazebo_msgs/JointRequest": "0be1351618e1dc030eb7959d9a4902de",
    "gazebo_msgs/LinkState": "0818ebbf28ce3a08d48ab1eaa7309ebe",
    "gazebo_msgs/LinkStates": "48c080191eb15c41858319b4d8a609c2",
    "gazebo_msgs/ModelState": "9330fd35f2fcd82d457e54bd54e10593",
    "gazebo_msgs/ModelStates": "48c080191eb15c41858319b4d8a609c2",
    "gazebo_msgs/SetLinkState": "8a5146eb66ae4d26b0860b08f3f271be",
    "gazebo_msgs/SetModelConfiguration": "10e3139d3b669c40afc057d38956fff7",
    "gazebo_msgs/SetModelState": "5b3ab0281d4f5445def017e3a2e4a07b",
    "gazebo_msgs/SetPhysicsProperties": "97e2057080558ce4730434b5fae75c91",
    "gazebo_msgs/SpawnModel": "9ed9c82c96abe1a00c3e8cdaeee24413",
    "sensor_msgs/CompressedImage": "8f7a12909da2c9d3332d540a0977563f",
    "std_srvs/Empty": "d41d8cd98f00b204e9800998ecf8427e",
    "tf2_msgs/TFMessage": "94810edda583a504dfda3829e70d7eec",
}


def every_message(ros=1):
    """All types of messages of a ROS, those of requests and responses included."""
    for name in type_names(ros):
        try:
            yield message_type(name, ros)
        except LookupError:
            service = service_type(name, ros)
            yield from (service.request, service.response)


def filled(kind: MessageType, rng: random.Random, frame: str):
    """A message with random values, texts of one frame's name, and up to 3 values in each list."""
    message = kind()
    for field in kind.fields:
        count = field.size if field.size else rng.randrange(4)
        values = [value_of(field.kind, rng, frame, kind.ros) for _ in range(1 if field.size is None else count)]
        setattr(message, field.name, values[0] if field.size is None else values)
    return message


def value_of(kind, rng, frame, ros):
    if kind == "string":
        return frame
    if kind in TIMES:
        return Stamp(rng.randrange(1 << 31), rng.randrange(10**9))
    if kind not in NUMBERS:
        return filled(message_type(kind, ros), rng, frame)
    if kind == "bool":
        return rng.random() < 0.5
    if kind.startswith("float"):
        return struct.unpack("<f", struct.pack("<f", rng.uniform(-1e3, 1e3)))[0]
    low = 0 if kind.startswith("u") or kind == "char" else -(1 << 6)
    return rng.randrange(low, 1 << 7)


def as_theirs(message, store):
    """A message of ours as one of rosbags."""
    kind = store.types[stored(message.kind, store)]
    values = {}
    for name, _ in store.fielddefs[stored(message.kind, store)][1]:
        ours = next((f for f in message.kind.fields if f.name.lower() == name.lower()), None)
        if ours is None:  # only one of the two ROS has it
            values[name] = 0
            continue
        value = getattr(message, ours.name)
        values[name] = theirs(value, ours, store)
    return kind(**values)


def theirs(value, field, store):
    if field.size is None:
        if isinstance(value, Stamp):
            duration = field.kind == "duration"
            return store.types[f"builtin_interfaces/msg/{'Duration' if duration else 'Time'}"](value.secs, value.nsecs)
        return as_theirs(value, store) if hasattr(value, "kind") else value
    if field.kind in NUMBERS:
        return np.array(value, NUMBERS[field.kind])
    return [theirs(one, field._replace(size=None), store) for one in value]


@pytest.mark.parametrize("kind", list(every_message()), ids=lambda kind: kind.name)
def test_bytes_of_every_type_are_those_of_rosbags(kind):
    rng = random.Random(kind.name)
    for length in range(10):
        message = filled(kind, rng, "f" * length)
        own = codec(kind).pack(message)
        if kind.fields:  # rosbags gives an empty type a field in ROS 1, too
            assert own == bytes(NOETIC.serialize_ros1(as_theirs(message, NOETIC), stored(kind, NOETIC)))
        assert codec(kind).pack(codec(kind).unpack(own)) == own


@pytest.mark.parametrize("kind", list(every_message(2)), ids=lambda kind: kind.name)
def test_bytes_of_every_type_of_ros2_are_those_of_rosbags(kind):
    rng = random.Random(kind.name)
    own = Codec(kind, cdr=True, schema=read_schema(described(kind), kind))
    for length in range(10):
        message = filled(kind, rng, "f" * length)
        packed = own.pack(message)
        assert packed == bytes(JAZZY.serialize_cdr(as_theirs(message, JAZZY), stored(kind, JAZZY)))
        assert own.pack(own.unpack(packed)) == packed


def test_sums_are_those_of_ros():
    store, compared = get_typestore(Stores.ROS1_NOETIC), 0
    for kind in every_message():
        full = kind.name.replace("/", "/msg/")
        if full in store.fielddefs and kind.fields:
            assert store.generate_msgdef(full, ros_version=1)[1] == kind.md5, kind.name
            compared += 1
    assert compared > 40
    for name, sum_ in SUMS.items():
        try:
            kind = message_type(name)
        except LookupError:
            kind = service_type(name)
        assert kind.md5 == sum_, name


def test_tables_of_the_engine_pack_as_lists_do():
    states = message_type("gazebo_msgs/ModelStates")
    pose, twist = message_type("geometry_msgs/Pose"), message_type("geometry_msgs/Twist")
    one, other = pose(), twist()
    one.position.x, one.orientation.w, other.angular.z = 1.0, 0.5, 2.0
    listed = states(name=["a", "b"], pose=[one, one], twist=[other, other])
    table = states(
        name=["a", "b"], pose=np.array([[1, 0, 0, 0, 0, 0, 0.5]] * 2), twist=np.array([[0, 0, 0, 0, 0, 2.0]] * 2)
    )
    assert codec(states).pack(listed) == codec(states).pack(table)
    with pytest.raises(ParameterError, match="no table"):
        codec(states).pack(states(pose=np.zeros((2, 6))))


def test_damaged_bytes_are_refused():
    scan = codec(message_type("sensor_msgs/LaserScan"))
    whole = scan.pack(scan.kind(ranges=[1.0, 2.0]))
    for size in range(len(whole)):
        with pytest.raises(FormatError):
            scan.unpack(whole[:size])
    with pytest.raises(FormatError, match="follow"):
        scan.unpack(whole + b"\0" * 5)
    transforms = codec(message_type("tf2_msgs/TFMessage"))
    with pytest.raises(FormatError, match="end after 4 bytes"):
        transforms.unpack(b"\xff\xff\xff\xff")  # 4 billion transforms
    many = struct.pack("<I", MOST_ITEMS + 1) + bytes(4 * (MOST_ITEMS + 1))
    with pytest.raises(FormatError, match="more than 100000 texts"):  # it would take the time of many steps
        codec(message_type("sensor_msgs/JointState")).unpack(bytes(16) + many + bytes(12))
    text = codec(message_type("std_msgs/String"))
    with pytest.raises(FormatError, match="UTF-8"):
        text.unpack(b"\1\0\0\0\xff")
    with pytest.raises(FormatError, match="CDR"):
        Codec(text.kind, cdr=True).unpack(b"\0\0\0\0\1\0\0\0\0")
    for field in ({"x": "wstring"}, {"x y": "int8"}, {"x": "sequence<sequence<int8>>"}):
        with pytest.raises(FormatError, match="not supported"):
            read_schema({"a/B": field})


@pytest.mark.parametrize(
    ("inner", "count", "size"),
    [
        ({"geometry_msgs/Transform": {f"f{number}": "uint8" for number in range(100)}}, MOST_READ // 100, 100),
        ({"geometry_msgs/Transform": {f"f{number}": "sequence<uint8>" for number in range(99)}}, MOST_READ // 198, 396),
        (
            {
                "geometry_msgs/Transform": {f"f{number}": "nav_msgs/Odometry" for number in range(99)},
                "nav_msgs/Odometry": {"f": "uint8"},
            },
            MOST_READ // 99 // 80,
            99,
        ),
    ],
    ids=["numbers", "lists of numbers", "messages of fields that are not there"],
)
def test_values_of_messages_as_a_bridge_describes_them_are_bounded_together(inner, count, size):
    kind = message_type("tf2_msgs/TFMessage", 2)
    schema = {kind.name: {"transforms": "sequence<geometry_msgs/TransformStamped>"}}
    schema["geometry_msgs/TransformStamped"] = {"transform": "geometry_msgs/Transform"}
    own = Codec(kind, cdr=True, schema=read_schema(schema | inner, kind))

    def unpacked(items):
        return own.unpack(CDR_HEADER + struct.pack("<I", items) + bytes(items * size)).transforms

    read = unpacked(3)
    assert (len(read), read[2].child_frame_id, read[2].header.stamp.secs) == (3, "", 0)
    with pytest.raises(FormatError, match=f"more than {MOST_READ} values"):  # it would take the time of many steps
        unpacked(count)


def test_bytes_after_a_message_matter_in_ros1_only():
    kind = message_type("geometry_msgs/Point")
    message = kind(x=1.0)
    with pytest.raises(FormatError, match="12 bytes follow"):
        codec(kind).unpack(codec(kind).pack(message) + bytes(12))
    cdr = Codec(kind, cdr=True)  # of ROS 2, whose serialised requests end in a reserve
    assert cdr.unpack(cdr.pack(message) + bytes(12)).x == 1.0


def test_values_that_do_not_fit_name_the_type():
    with pytest.raises(ParameterError, match="std_msgs/Int32 cannot be packed"):
        codec(message_type("std_msgs/Int32")).pack(message_type("std_msgs/Int32")(data="x"))
    odometry = message_type("nav_msgs/Odometry")()
    odometry.pose.covariance = [0.0]
    with pytest.raises(ParameterError, match="36"):
        codec(odometry.kind).pack(odometry)
    with pytest.raises(ParameterError, match=r"no field 'dat'.*data"):
        message_type("std_msgs/Int32")(dat=1)


def test_numbers_of_packed_messages_are_set_in_place():
    kind, states = message_type("nav_msgs/Odometry"), message_type("sensor_msgs/JointState")
    for cdr, name in itertools.product((False, True), ("", "o", "frame", "a longer name")):
        message = kind(child_frame_id=name)
        message.header.frame_id = name
        one = Codec(kind, cdr)
        topic = SimpleNamespace(
            kind=kind, codec=one, stamped=True, number=3.0, gatherer=(SimpleNamespace(version=1), None)
        )
        packed, sent = PackedMessage(topic, message), []
        topic.send_body = lambda body, one=one, sent=sent: sent.append(one.unpack(body))
        packed.stamp(12.9999999996)
        packed.put("pose.pose", range(7))
        packed.put_array("twist.covariance", np.arange(36.0))
        packed.send()
        assert (sent[0].header.seq, sent[0].header.stamp, topic.number) == (3, Stamp(13, 0), 4.0)
        assert (sent[0].pose.pose.position.y, sent[0].pose.pose.orientation.w, sent[0].twist.covariance[35]) == (
            1,
            6,
            35,
        )
        assert (sent[0].header.frame_id, sent[0].child_frame_id) == (name, name)
        for path, values in (("pose.pose", (1.0,)), ("child_frame_id", ()), ("twist.twist.linear", ("x", "y", "z"))):
            with pytest.raises(ParameterError):
                packed.put(path, values)
        none = PackedMessage(SimpleNamespace(**vars(topic) | {"kind": states, "codec": Codec(states, cdr)}), states())
        none.put("position", ())
        none.put_array("effort", np.zeros(0))
        with pytest.raises(ParameterError, match="has 0 numbers"):
            none.put_array("effort", np.zeros(1))
        with pytest.raises(ParameterError, match="NaN"):
            packed.put("header.stamp", (math.nan, 0.0))


def test_times_that_stamps_cannot_hold_become_the_nearest_one():
    kind = message_type("rosgraph_msgs/Clock")
    topic = SimpleNamespace(kind=kind, codec=codec(kind), stamped=False)
    packed = PackedMessage(topic, kind())
    for time, nearest in ((-5.0, Stamp(0, 0)), (1e300, Stamp(2**31 - 1, 0))):
        packed.stamp(time, "clock")
        message = kind()
        set_stamp(message.clock, time)
        assert topic.codec.unpack(packed.memory[4:].tobytes()).clock == message.clock == nearest


def test_what_is_recorded_of_a_message_holds_until_it_is_packed_anew():
    kind = message_type("rosgraph_msgs/Clock")
    topic = SimpleNamespace(kind=kind, codec=codec(kind), stamped=False)
    packed, recorder = PackedMessage(topic, kind()), Recorder()
    recorder.record(packed.stamp, 1.0, "clock")
    assert Recorder().take(recorder)
    assert any(one is packed.memory for one in recorder.kept)  # native code writes there
    topic.codec = Codec(kind, cdr=True)
    packed.stamp(2.0, "clock")
    assert not Recorder().take(recorder)
