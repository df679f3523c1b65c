"""All messages and enumerations of classic, written and read by Google's protobuf in a pool of its own."""

import random

import pytest
from classic_wire import declared, new, types

from libgz.classic import msgs

ENUMS = [name for name, text in declared().items() if text.startswith("enum ")]
MESSAGES = [name for name in types() if name != "KeyEvent"]  # which is not of classic


def fill(message, source, depth=0):
    """Set the fields at random, and those within them, down to three levels, as long as they are not required."""
    for field in message.DESCRIPTOR.fields:
        if not field.is_required and (depth == 3 or source.random() < 0.2):
            continue
        for _ in range(source.randrange(1, 3) if field.is_repeated else 1):
            if field.message_type is not None:
                whole = getattr(message, field.name)
                part = whole.add() if field.is_repeated else whole
                part.SetInParent()
                fill(part, source, depth + 1)
                continue
            value = value_of(field, source)
            if field.is_repeated:
                getattr(message, field.name).append(value)
            else:
                setattr(message, field.name, value)


def value_of(field, source):
    if field.enum_type is not None:
        return source.choice(field.enum_type.values).number
    if field.cpp_type in (field.CPPTYPE_DOUBLE, field.CPPTYPE_FLOAT):
        return source.choice((0.0, -0.5, float("inf"), 2.0**-20))
    if field.cpp_type == field.CPPTYPE_BOOL:
        return source.random() < 0.5
    if field.type == field.TYPE_STRING:
        return source.choice(("", "a b", "zwei ✓"))
    if field.type == field.TYPE_BYTES:
        return source.randbytes(5)
    return source.choice((0, 1, 2**31 - 1) if field.type in (field.TYPE_UINT32, field.TYPE_UINT64) else (-1, 7))


def test_there_are_all_of_classic():
    assert (len(MESSAGES), len(ENUMS)) == (147, 15)
    assert {f"gazebo.msgs.{name}" for name in types()} <= set(msgs.known_types())


@pytest.mark.parametrize("name", MESSAGES)
def test_a_message_is_equal_on_both_sides(name):
    source = random.Random(name)
    for _ in range(5):
        theirs = new(name)
        fill(theirs, source)
        data = theirs.SerializeToString()
        ours = msgs.message_type(name).FromString(data)
        assert ours.SerializeToString() == data
        assert sorted(field.name for field, _ in ours.ListFields()) == sorted(f.name for f, _ in theirs.ListFields())
        assert type(theirs).FromString(ours.SerializeToString()) == theirs


@pytest.mark.parametrize("name", MESSAGES)
def test_an_empty_message_can_be_read(name):
    theirs = new(name)
    theirs.ParseFromString(msgs.message_type(name)().SerializeToString())
    assert theirs.IsInitialized()


@pytest.mark.parametrize("name", ENUMS)
def test_an_enumeration_has_the_same_numbers(name):
    outer, _, short = name.rpartition(".")
    theirs = types()[outer].DESCRIPTOR.enum_types_by_name[short].values
    assert theirs
    for value in theirs:
        assert getattr(msgs.message_type(outer), value.name) == value.number


def test_numbers_that_clients_of_classic_use():
    """Taken from classic's own messages, not from the table."""
    for name, field, number in (
        ("Quaternion", "x", 2),
        ("Quaternion", "w", 5),
        ("Color", "r", 2),
        ("Color", "a", 5),
        ("Packet", "serialized_data", 3),
        ("WorldStatistics", "sim_time", 2),
        ("WorldControl", "multi_step", 3),
        ("LaserScan", "ranges", 13),
        ("Factory", "sdf", 1),
        ("Model", "pose", 4),
        ("Response", "serialized_data", 5),
        ("PosesStamped", "pose", 2),
    ):
        assert msgs.message_type(name).DESCRIPTOR.fields_by_name[field].number == number, f"{name}.{field}"
    assert (msgs.Visual.ENTITY, msgs.Geometry.BOX, msgs.Joint.REVOLUTE) == (0, 1, 1)
    multi_step = msgs.LogPlaybackControl(multi_step=-2).SerializeToString()
    assert multi_step == b"\x10\x03"  # sint32: zigzag
