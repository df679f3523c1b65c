"""Bytes that were made to harm: each is refused with a sentence, and leaves the world and the process as they were."""

import random
import struct
import subprocess
import sys
import tracemalloc
from pathlib import Path

import msgpack
import numpy as np
import pytest
from state_attacks import WORDS, world as attacked

from libgz import Body, World
from libgz.base import encoding
from libgz.base.budget import VARIABLE
from libgz.base.encoding import FORMAT, decode, encode
from libgz.base.errors import ParameterError, StateError
from libgz.base.files import installed_worlds
from libgz.base.geometry import GzPose, GzVector
from libgz.physics import state as state_module
from libgz.physics.appearance import Appearance
from libgz.physics.engine import Engine
from libgz.physics.geom import Geom
from libgz.physics.saved import saved_names, saved_values
from libgz.physics.state import _assign
from libgz.simulation.state import encode as encode_state, get_state, set_state


def data(value):
    """The bytes of what msgpack writes."""
    return FORMAT + msgpack.packb(value)


def extension(code, *parts):
    """An extension of these parts."""
    return msgpack.ExtType(code, msgpack.packb(list(parts)))


def array(kind, shape, content):
    """An array that says so of itself."""
    return data(extension(encoding.ARRAY, kind, shape, content))


def nested(code, depth):
    """A value within itself."""
    value = None
    for _ in range(depth):
        value = extension(code, value)
    return value


FEW = 1 << 15  # values, that are too many where a test says so
TWISTER = encode(np.random.Generator(np.random.MT19937(1)))
ATTACKS = {
    "objects as bytes": lambda: array("|O", [1], b"\x10" * 8),
    "objects of 8 bytes": lambda: array("|O8", [1], b"\x10" * 8),
    "records": lambda: array("|V8", [1], b"\x10" * 8),
    "objects in records": lambda: array([("a", "|O")], [1], b"\x10" * 8),
    "a kind with commas": lambda: array("O,O", [1], b"\x10" * 16),
    "more numbers than bytes": lambda: array("<f8", [2**40], b""),
    "a product that overflows": lambda: array("<f8", [2**32, 2**32], b""),
    "a large size": lambda: array("<f8", [2**63], b""),
    "a shape of 33 sizes": lambda: array("<f8", [1] * 33, b"\0" * 8),
    "a size below zero": lambda: array("<f8", [-1, -1], b"\0" * 8),
    "texts of no letters": lambda: array("<U1", [1], b"\xff" * 4),
    "truth of 7": lambda: array("|b1", [1], b"\7"),
    "many empty texts": lambda: array("<U0", [2**40], b""),
    "a number of objects": lambda: data(extension(encoding.NUMBER, "|O", b"\x10" * 8)),
    "objects of another shape": lambda: data(extension(encoding.OBJECTS, [2**40], [])),
    "words behind the last": lambda: TWISTER.replace(b"\xa3pos\xcd\x02o", b"\xa3pos\xcd\xff\xff"),
    "words of another length": lambda: encode(np.random.Generator(np.random.SFC64(1))).replace(
        b"\x91\x04", b"\x91\x03"
    ),
    "a generator of another name": lambda: encode(np.random.default_rng(1)).replace(b"\xa5PCG64", b"\xa5__all"),
    "no words": lambda: data(msgpack.ExtType(encoding.NUMPY, msgpack.packb({"bit_generator": "MT19937", "state": {}}))),
    "Python's generator": lambda: data(extension(encoding.RANDOM, 3, [], None)),
    "a class": lambda: data(extension(encoding.STRUCT, "Model", 1)),
    "a class of another module": lambda: data(extension(encoding.STRUCT, "os.system", "true")),
    "a vector of texts": lambda: data(extension(encoding.STRUCT, "GzVector", "a", "b", "c")),
    "a vector of two": lambda: data(extension(encoding.STRUCT, "GzVector", 1.0, 2.0)),
    "a pose of 3 bytes": lambda: data(msgpack.ExtType(encoding.RAW, b"GzPose\0abc")),
    "a mass of 3 bytes": lambda: data(msgpack.ExtType(encoding.RAW, b"Mass\0abc")),
    "a mass of nothing": lambda: data(
        msgpack.ExtType(encoding.RAW, b"Mass\0" + struct.pack("17d", *[float("nan")] * 17))
    ),
    "a mesh of texts": lambda: data(extension(encoding.VALUE, "Mesh", "a")),
    "an unknown extension": lambda: data(msgpack.ExtType(99, b"")),
    "a deque that is longer than it may be": lambda: data(extension(encoding.DEQUE, 1, [1, 2])),
    "a set of lists": lambda: data(extension(encoding.SET, [1])),
    "a dict with lists as keys": lambda: FORMAT + b"\x81\x90\x01",
    "deep lists": lambda: FORMAT + b"\x91" * 100_000 + b"\xc0",
    "deep tuples": lambda: data(nested(encoding.TUPLE, 400)),
    "a list of 2^32": lambda: FORMAT + b"\xdd\xff\xff\xff\xff",
    "a list of 2^32 in each other": lambda: FORMAT + b"\xdd\xff\xff\xff\xff" * 400,
    "a dict of 2^32": lambda: FORMAT + b"\xdf\xff\xff\xff\xff",
    "many empty lists": lambda: FORMAT + b"\xdd" + struct.pack(">I", FEW) + b"\x90" * FEW,
    "many values in short lists": lambda: (
        FORMAT + b"\x95" + (b"\xdd" + struct.pack(">I", FEW // 4) + b"\xc0" * (FEW // 4)) * 5
    ),
    "a text of 2^32": lambda: FORMAT + b"\xdb\xff\xff\xff\xffa",
    "a broken text": lambda: FORMAT + b"\xa1\xff",
    "nothing": lambda: FORMAT,
    "two values": lambda: FORMAT + b"\xc0\xc0",
    "an older pickle": lambda: b"libgz state 7\n" + bytes(8) + b"\x80\x04cos\nsystem\n(S'true'\ntR.",
}


@pytest.fixture(scope="module")
def world():
    """A world with all kinds of joints."""
    with attacked() as made:
        for _ in range(5):
            made.step()
        yield made


def process():
    """What no state may change in this process."""
    return {kind: dict(vars(kind)) for kind in (GzVector, GzPose, type, encoding.Generated)}, random.getstate()


@pytest.mark.parametrize("name", ATTACKS)
def test_bytes_that_were_made_to_harm_are_refused(world, name, monkeypatch):
    if name.startswith("many"):  # each empty list takes 64 bytes
        assert 64 * encoding.MOST_ITEMS < 200e6
        monkeypatch.setattr(encoding, "MOST_ITEMS", FEW - 1)
    attack = ATTACKS[name]()
    before, state = process(), world.get_state()
    tracemalloc.start()
    try:
        with pytest.raises(StateError, match="state"):
            decode(attack)
        assert tracemalloc.get_traced_memory()[1] < 200e6
    finally:
        tracemalloc.stop()
    for outer in (attack, encode([world.era.digest, [], attack])):
        with pytest.raises(StateError):
            world.set_state(outer)
    assert (process(), world.get_state()) == (before, state)


def test_what_stands_in_place_of_a_part_is_refused(world):
    state = world.get_state()
    digest, names, parts = decode(state)
    inner = decode(parts)
    for part in inner:
        for value in (None, -1, 1e308, "x", b"x", [], {}, [None], {"a": 1}):
            if value == inner[part]:
                continue
            try:
                world.set_state(encode([digest, names, encode({**inner, part: value})]))
            except StateError:
                assert world.get_state() == state, (part, value)
            else:
                assert part in ("extensions", "interfaces"), value  # what is not in it stays as it is
                world.set_state(state)


def test_attributes_of_bodies_are_of_their_kind_and_none_where_they_may_be():
    body = Body(Engine())
    names, values = saved_names(body), list(saved_values(body))
    for name in names:
        for wrong in (None, 0.5, "x", (1.0,), [], GzVector()):
            try:
                _assign(body, [wrong if one == name else value for one, value in zip(names, values, strict=True)])
            except StateError:
                continue
            present = values[names.index(name)]
            if wrong is present:
                continue
            assert name == "bodyName" or isinstance(present, (bool, int)), name
            assert isinstance(wrong, (str, float, type(None)))
            _assign(body, values)  # what was there can return


def test_geoms_that_were_built_again_for_a_state_that_is_refused_keep_their_bodies(monkeypatch):
    """Contacts and orders find geoms by the rows that ODE has of them."""

    def refused_once(thing, values):
        if isinstance(thing, Geom):
            monkeypatch.undo()
            raise StateError("the state is damaged: a number is out of its range")
        return _assign(thing, values)

    with World.from_file(installed_worlds() / "pioneer2at.world") as robot:
        robot.step(5)
        before = robot.get_state()
        monkeypatch.setattr(state_module, "_assign", refused_once)
        with pytest.raises(StateError, match="out of its range"):
            robot.snapshots.restore(before, anew=True)
        assert robot.get_state() == before


def test_a_damaged_look_changes_nothing_and_all_of_it_returns():
    look = Appearance()
    packed, files, rest = look.saved()
    before = encode(look.saved())
    for wrong in (
        (packed, files[:1], rest),
        (packed, [1, None, None], rest),
        (packed, ["x", None, None], rest[:-1]),
        (packed, ["x", None, None], [1, *rest[1:]]),
        (packed, ["x", None, None], [*rest[:-1], True]),
    ):
        with pytest.raises(StateError, match="other looks"):
            look.restore(*wrong)
        assert encode(look.saved()) == before
    numbers = bytearray(packed)
    numbers[-1] ^= 0x80  # another sign
    look.restore(bytes(numbers), files, rest)
    assert encode(look.saved()) != before
    look.restore(packed, files, rest)
    assert encode(look.saved()) == before


def test_objects_of_models_are_not_replaced_in_lists():
    with World.from_file(installed_worlds() / "bandit.world") as bandit:
        robot = bandit.model("robot1")
        state = get_state(robot)
        assert len(state["servos"]) > 2
        servos = decode(encode_state(state["servos"]))
        for wrong in ([14, *servos[1:]], servos[:-1], [None, *servos[1:]], None, ()):
            with pytest.raises(StateError, match="in place of a JointServo"):
                set_state(robot, {**state, "servos": wrong})


def test_a_time_of_msgpack_is_a_number():
    assert type(decode(FORMAT + msgpack.packb(msgpack.Timestamp(1)))) is int


@pytest.mark.parametrize("engine_part", ["settings", "numbers", "quirks", "fresh", "dummies", "couplings", "contacts"])
def test_parts_of_an_engine_that_are_damaged_are_refused(world, engine_part):
    engine = world.engine
    state, before = engine.get_state(), world.get_state()
    for value in (None, 5, b"\xff" * 56, b"\xff" * 8, [float("nan")] * 11, [[10**9, [1.0]]], ["x", 1]):
        try:
            engine.set_state({**state, engine_part: value})
        except StateError:
            engine.set_state(state)
        else:
            assert value == state[engine_part] or engine_part in ("fresh", "quirks", "dummies", "contacts"), value
            engine.set_state(state)
        assert world.get_state() == before


def test_lists_of_an_engine_have_one_length(world):
    engine = world.engine
    state = engine.get_state()
    objects = decode(state["objects"])
    longer = {**objects, "feedback": [*objects["feedback"], False]}
    with pytest.raises(StateError, match="do not fit each other"):
        engine.set_state({**state, "objects": encode(longer)})


@pytest.mark.parametrize("name", WORDS)
def test_no_number_in_the_memory_of_ode_ends_the_process(name):
    done = subprocess.run(
        [sys.executable, str(Path(__file__).parents[1] / "state_attacks.py"), name, "7"],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    taken, refused = map(int, done.stdout.split())
    assert taken + refused > 80
    assert refused > 15


def test_large_numbers_are_refused(world):
    engine = world.engine
    state = engine.get_state()
    for body in engine.bodies.values():
        at = state["memory"].index(struct.pack("3d", *body.GetCoMPose().pos))
        for number in (-1e308, 1e12, float("nan"), float("inf")):
            memory = state["memory"][:at] + struct.pack("d", number) + state["memory"][at + 8 :]
            with pytest.raises(StateError, match="out of its range"):
                engine.set_state({**state, "memory": memory})
            assert engine.get_state() == state


def test_an_axis_about_which_a_body_turns_exactly_has_length_1(world):
    engine = world.engine
    body = next(iter(engine.bodies.values()))
    body.SetFiniteRotationAxis(0.0, 0.0, -1.0)
    state = engine.get_state()
    at = state["memory"].index(struct.pack("3d", 0.0, 0.0, -1.0))
    memory = state["memory"][:at] + struct.pack("d", 1e100) + state["memory"][at + 8 :]
    with pytest.raises(StateError, match="has not length 1"):
        engine.set_state({**state, "memory": memory})
    assert engine.get_state() == state


def test_states_have_the_limit_of_all_that_is_decompressed(monkeypatch):
    state = encode(bytes(2 << 20))
    monkeypatch.setenv(VARIABLE, "1")
    said = rf"2\.0 MiB; allowed are 1 MiB, or what {VARIABLE} \[MiB\] says"
    with pytest.raises(StateError, match=said):
        decode(state)
    with pytest.raises(ParameterError, match=said):
        encode(bytes(2 << 20))
    parts = msgpack.packb([msgpack.ExtType(6, bytes(600 << 10))] * 2)  # two bytearrays
    with pytest.raises(StateError):
        decode(FORMAT + parts)
    monkeypatch.setenv(VARIABLE, "2")
    assert len(decode(FORMAT + parts)) == 2


@pytest.mark.parametrize(
    "value",
    [
        {number * (2**61 - 1) + (1 << 70) * (2**61 - 1) for number in range(1000)},
        frozenset(complex(-1000003 * number, number) for number in range(1000)),
        {(number * (2**61 - 1),): 0 for number in range(1000)},
    ],
    ids=["set", "frozenset", "dict"],
)
def test_keys_of_one_hash_are_refused(value):
    with pytest.raises(StateError, match="1000 keys have the same hash"):
        decode(encode(value))


@pytest.mark.parametrize(
    ("at", "value"), [(3, "x"), (4, None), (8, ""), (12, "x"), (12, float("nan")), (15, None), (20, b"")]
)
def test_numbers_of_joints_are_numbers(world, at, value):
    """What was taken of a joint is used by plugins that are loaded for the next state, before that is set."""
    table = world.models[-1].sdf_joints
    count, rows = table.save()
    (name, number, saved), *others = rows
    described = [*saved[2]]
    described[at] = value
    with pytest.raises(ParameterError, match="finite numbers"):
        table.load((count, [(name, number, (*saved[:2], described, *saved[3:])), *others]))
    table.load((count, rows))
    assert table.save() == (count, rows)


def test_arrays_stay_arrays():
    """One that is lost could not take the values of a sound state."""
    with World.from_file(installed_worlds() / "gripper.world") as world:
        model = next(model for model in world.entities if type(model).__name__ == "Pioneer2Gripper")
        state = get_state(model)
        for value in (None, [], 0.0, b""):
            with pytest.raises(StateError, match="in place of a"):
                set_state(model, state | {"_values": value})
        set_state(model, decode(encode_state(state)))
