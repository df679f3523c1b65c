"""Audit: no attribute of a model or of its parts changes while a world runs and stays changed after `set_state`."""

import ctypes
import math
import random
from collections import deque

import numpy as np
import pytest
from state_runs import command

import libgz
import libgz.front  # registers the built-in models
from libgz.base.files import installed_worlds
from libgz.legacy.factory import ModelFactory
from libgz.models import MODELS
from libgz.physics.body import Body
from libgz.physics.engine import Engine
from libgz.physics.geom import Geom
from libgz.physics.joint import Joint
from libgz.physics.space import Space
from libgz.rendering.camera import Camera
from libgz.simulation.problems import Problems
from libgz.simulation.publication import Publication
from libgz.simulation.snapshot import Snapshots
from libgz.simulation.updates import UpdateRows
from libgz.simulation.world import World
from libgz.transport.interface import Interface
from libgz.transport.server import LocalServer
from libgz.transport.tally import Tally
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

HEAD = "<gz:world xmlns:gz='g' xmlns:model='m' xmlns:param='p'>"
# What has its state elsewhere: in the engine, in the bytes of interfaces; or has none that matters to what happens.
ELSEWHERE = (
    *(Body, Engine, Geom, Joint, Space),
    *(Interface, LocalServer),
    *(Camera, Problems, Tally, WorldFile, WorldFileNode),
    *(Publication, Snapshots, UpdateRows),
)
PLAIN = (bool, int, float, complex, str, bytes, type(None))
# Attributes that may differ: (class, attribute) -> reason.
ALLOWED = {
    ("World", "_fallen"): "numbers of bodies of this process",
    ("World", "lock"): "of threads",
    ("World", "_rewind"): "what is kept is not in a state",
    ("World", "_start"): "what is kept is not in a state",
    ("World", "events"): "connections are not in a state",
    ("FrameSaver", "_failed"): "whether an error of the disk was logged",
    ("Clock", "_start"): "of the wall clock",
    ("RayProximity", "_frame"): "set before each use",
    ("_Expected", "settled"): "whether native code can exchange the position; Python gives the same",
}


def walk(thing, path, seen, found):
    """Collect the plain values below an object, by their paths."""
    if isinstance(thing, PLAIN):
        found[path] = repr(thing)
    elif isinstance(thing, np.ndarray):
        found[path] = thing.tobytes()
    elif isinstance(thing, np.random.Generator):
        found[path] = repr(thing.bit_generator.state)
    elif isinstance(thing, ctypes.Array):
        walk(list(thing), path, seen, found)
    elif isinstance(thing, ELSEWHERE) or callable(thing) or id(thing) in seen:
        return
    elif isinstance(thing, dict):
        found[f"{path}#"] = repr([key for key in thing if isinstance(key, PLAIN)])
        for key, value in thing.items():
            if isinstance(key, PLAIN):
                walk(value, f"{path}[{key!r}]", seen, found)
    elif isinstance(thing, list | tuple | deque | set | frozenset):
        found[f"{path}#"] = str(len(thing))
        for i, value in enumerate(thing):
            walk(value, f"{path}[{i}]", seen, found)
    elif hasattr(thing, "__dict__"):
        seen.add(id(thing))
        shared = [field for kind in type(thing).__mro__ for field, *_ in vars(kind).get("_fields_", ())]
        for name, value in {**vars(thing), **{name: getattr(thing, name) for name in shared}}.items():
            if not any((kind.__name__, name) in ALLOWED for kind in type(thing).__mro__):
                walk(value, f"{path}.{name}", seen, found)
    # Others, such as locks of threads, have no attributes of their own.


def graph(world):
    """All plain values of a world and its entities."""
    found = {}
    seen = set()
    for i, entity in enumerate(world.entities):
        walk(entity, f"{i}:{type(entity).__name__}", seen, found)
    walk(world, "world", seen, found)
    return found


def examples():
    """A world for each built-in model."""
    factory = ModelFactory()
    for name in sorted(MODELS):
        kind = factory.find(name)
        yield name, kind.example or f"<model:{name}><id>it</id></model:{name}>"


def text_of(example):
    """A world with an example, on the ground, with a light for cameras and something to see."""
    return (
        f"{HEAD}<model:GroundPlane><id>ground</id></model:GroundPlane>{example}"
        "<model:SimpleSolid><id>box</id><xyz>1 0.3 1</xyz></model:SimpleSolid></gz:world>"
    )


@pytest.mark.parametrize(("name", "example"), list(examples()), ids=lambda value: value if len(value) < 20 else "")
def test_no_attribute_is_forgotten(name, example, monkeypatch):
    monkeypatch.chdir(installed_worlds())
    rng = random.Random(name)
    with libgz.World.from_string(text_of(example)) as world:
        for _ in range(4):
            command(world, rng)
            world.step(7)
        state, before = world.get_state(), graph(world)
        assert isinstance(world, World)
        for _ in range(4):
            command(world, rng)
            world.step(11)
        world.paused = True
        world.step(3)
        changed = {path for path, value in graph(world).items() if before.get(path) != value}
        assert any("clock" in path for path in changed), "the audit sees nothing"
        world.set_state(state)
        after = graph(world)
        different = sorted(path for path in before.keys() | after.keys() if before.get(path) != after.get(path))
        assert different == [], f"{name} changes these, and does not declare them in STATE"
        assert world.get_state() == state


def test_the_audit_finds_what_is_not_declared(tmp_path):
    plugin = tmp_path / "Forgetful.py"
    plugin.write_text(
        "from libgz import Body, Model, GZ_REGISTER_PLUGIN\n"
        "class Part:\n"
        "    def __init__(self):\n"
        "        self.count = 0\n"
        "class Forgetful(Model):\n"
        "    STATE = ('declared',)\n"
        "    def Load(self, file, node):\n"
        "        self.AddBody(Body(self.world), True)\n"
        "        self.declared, self.part = 0, Part()\n"
        "    def Update(self, step):\n"
        "        self.declared += 1\n"
        "        self.part.count += 1\n"
        "GZ_REGISTER_PLUGIN('Forgetful', Forgetful)\n"
    )
    with libgz.World.from_string(text_of(f"<model:Forgetful><plugin>{plugin}</plugin></model:Forgetful>")) as world:
        world.step(2)
        state, before = world.get_state(), graph(world)
        world.step(2)
        world.set_state(state)
        after = graph(world)
        different = [path for path in before if before[path] != after[path]]
        assert len(different) == 1
        assert different[0].endswith("part.count")
        assert math.isclose(world.GetSimTime(), 0.04)
