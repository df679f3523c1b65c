"""What is set is read: every pair of accessors of math and common, and every field of every message."""

import inspect

import pytest
from accessor_pairs import accessor_pairs

from libgz.classic import common, math, msgs
from libgz.classic.msgs.message import Message

ARGUMENTS = {  # of classes that cannot be made without
    common.Battery: ("cell", 12.0),
    common.NumericAnimation: ("swing", 10.0, False),
    common.PoseAnimation: ("walk", 10.0, False),
}
EXCEPTIONS = {
    math.Matrix3d: {"SetAxes": "Axes sets, too: it is the same function"},
    math.Matrix4d: {"SetTranslate": "Translate sets, too: it is the same function"},
    math.Vector3d: {
        "Max": "an argument raises components, and none is set to it",
        "Min": "an argument lowers components, and none is set to it",
    },
    common.NumericAnimation: {"GetInterpolatedKeyFrame": "the argument is what to fill"},
    common.PoseAnimation: {"GetInterpolatedKeyFrame": "the argument is what to fill"},
}
VALUES = {
    math.Inertiald: {
        name: (math.MassMatrix3d(2.0, (1.0, 2.0, 3.0)), math.MassMatrix3d(1.0, (0.1, 0.1, 0.1)))
        for name in ("MassMatrix", "SetMassMatrix")
    },
    math.BiQuad: dict.fromkeys(("Set", "SetValue"), (1.0, 2.0)),
    math.BiQuadVector3: {name: (math.Vector3d(1, 2, 3), math.Vector3d(2, 3, 4)) for name in ("Set", "SetValue")},
    math.OnePole: {"Set": (1.0, 2.0)},
    math.OnePoleVector3: {"Set": (math.Vector3d(1, 2, 3), math.Vector3d(2, 3, 4))},
    math.OnePoleQuaternion: {"Set": (math.Quaterniond(0, 0, 1), math.Quaterniond(1, 0, 0))},
    math.Matrix4d: {"SetTranslation": (math.Vector3d(1, 2, 3), math.Vector3d(2, 3, 4))},
    math.Vector2i: {"X": (2, 3), "Y": (2, 3)},
    common.SphericalCoordinates: {"SetSurfaceType": (common.SphericalCoordinates.EARTH_WGS84,)},
}
BEFORE = {common.Battery: {"SetPowerLoad": (0,)}}
NOT_MADE = {
    common.Animation: "the base of NumericAnimation and PoseAnimation",
    common.Console: "prints, and is set by logging",
    common.ConsoleFormatter: "a formatter of logging",
    common.ConsoleHandler: "a handler of logging",
    common.LogFormatter: "a formatter of logging",
    common.SkeletonAnimation: "a view of an actor's, without setters",
    common.Mesh: "test_more_common.py has one with vertices",
    common.SubMesh: "test_more_common.py has one with vertices",
    math.PlaneSide: "an enumeration",
    common.SystemPaths: "has no setters, and is one of the process",
}


def holders():
    for module in (math, common):
        for name in module.__all__:
            kind = getattr(module, name)
            if inspect.isclass(kind) and kind not in NOT_MADE and kind.__name__ == name:
                yield kind


def pairs():
    for kind in dict.fromkeys(holders()):
        holder = kind(*ARGUMENTS.get(kind, ()))
        if isinstance(holder, common.Battery):
            holder.AddConsumer()
        yield from accessor_pairs(
            holder, exceptions=EXCEPTIONS.get(kind), values=VALUES.get(kind), before=BEFORE.get(kind)
        )


@pytest.mark.parametrize("pair", list(pairs()), ids=str)
def test_what_is_set_is_read(pair):
    pair.check()


SAMPLES = {
    "DOUBLE": (0.1, -2.5),
    "FLOAT": (0.5, -2.5),
    "BOOL": (True, False),
    "INT32": (-1, 2**31 - 1),
    "SINT32": (-1, 2**31 - 1),
    "UINT32": (1, 2**32 - 1),
    "UINT64": (1, 2**64 - 1),
    "STRING": ("one", "zwei \u2713"),
    "BYTES": (b"one", b"\x00\xff"),
}


def samples(field):
    if field.message_type is not None:
        return (msgs.message_type(field.message_type.full_name)(),)
    if field.enum_type is not None:
        return tuple(field.enum_type.values_by_number)
    return next(values for name, values in SAMPLES.items() if field.type == getattr(field, f"TYPE_{name}"))


@pytest.mark.parametrize("name", [name for name in msgs.known_types() if name.startswith("gazebo.msgs.")])
def test_a_field_that_is_set_is_read_also_from_the_wire(name):
    kind = msgs.message_type(name)
    for field in kind.DESCRIPTOR.fields:
        for value in samples(field):
            message = kind(**{field.name: [value, value] if field.is_repeated else value})
            wanted = [value, value] if field.is_repeated else value
            assert getattr(message, field.name) == wanted, field
            assert [found.name for found, _ in message.ListFields()] == [field.name]
            copy = kind.FromString(message.SerializeToString())
            assert isinstance(copy, Message)
            if field.message_type is None:
                assert getattr(copy, field.name) == wanted, field
            if not field.is_repeated:
                assert message.HasField(field.name)
                assert copy.HasField(field.name)
