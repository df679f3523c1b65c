"""Random changes of legacy worlds before and after states: what follows a restored state is equal to the bit.

As a program, it sets a state in a process of its own, and prints the digest of what follows.

python test_random_legacy_changes.py WORLD STATE SEED
"""

from __future__ import annotations

import contextlib
import hashlib
import inspect
import logging
import os
import random
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

if __name__ == "__main__":  # beside its neighbours
    sys.path.insert(0, str(Path(__file__).parents[1]))

from state_runs import command, digest, look
from trials.table import trial

from libgz import World
from libgz.base.errors import GazeboError, StateError
from libgz.base.files import installed_worlds
from libgz.base.geometry import GzColor, GzPose, GzQuatern, GzVector
from libgz.physics.joint import BallJoint, FixedJoint, HingeJoint, SliderJoint
from libgz.physics.two_axes import Hinge2Joint, UniversalJoint

pytestmark = pytest.mark.trial

SHARE = float(os.environ.get("TRIAL_SHARE") or 1.0)
STEPS = 20
NEW = (
    "<model:SimpleSolid><id>{0}</id><shape>{2}</shape><size>0.3 0.3 0.3</size><xyz>{1} 2</xyz></model:SimpleSolid>",
    "<model:Pioneer2DX><id>{0}</id><xyz>{1} 0.3</xyz><model:SickLMS200><id>{0}laser</id><xyz>0 0 0.3</xyz>"
    "</model:SickLMS200></model:Pioneer2DX>",
    "<model:SegwayRMP><id>{0}</id><xyz>{1} 0.5</xyz></model:SegwayRMP>",
    "<model:TruthWidget><id>{0}</id><xyz>{1} 1</xyz></model:TruthWidget>",
)
SETTERS = ("Set", "set_", "Add", "Enable")
NOT_CALLED = {"SetParent", "AddBody", "SetTexture2DFile", "SetSkinFile", "SetId", "SetName", "SetMassMatrix"}
JOINTS = (BallJoint, FixedJoint, HingeJoint, SliderJoint, Hinge2Joint, UniversalJoint)


def some(rng: random.Random, things: Any) -> Any:
    """One of them; an IndexError if there is none."""
    return rng.choice(list(things))


def vector(rng: random.Random, height: float = 0.0) -> GzVector:
    """A vector."""
    return GzVector(rng.uniform(-1, 1), rng.uniform(-1, 1), height + rng.uniform(-1, 1))


def value_for(rng: random.Random, parameter: inspect.Parameter) -> Any:
    """Some value for a parameter of a method."""
    kind = str(parameter.annotation)
    if "Pose" in kind:
        return GzPose(vector(rng, 1.5), GzQuatern(1.0, 0.1, 0.0, 0.2))
    if "Quatern" in kind:
        return GzQuatern(1.0, rng.uniform(-0.3, 0.3), 0.0, 0.1)
    if "Vector" in kind:
        return vector(rng)
    if "Color" in kind:
        return GzColor(*(rng.random() for _ in range(4)))
    if "bool" in kind:
        return rng.random() < 0.5
    if "int" in kind:
        return rng.randrange(16)
    if "float" in kind:
        return rng.choice((rng.uniform(-1, 1), rng.random(), 5 * rng.random()))
    raise TypeError(kind)


def setters(kind: Any) -> list[str]:
    """The methods of a class that set something."""
    names = (name for name, _ in inspect.getmembers(kind, callable) if name.startswith(SETTERS))
    return [name for name in names if name not in NOT_CALLED]


def call_setter(rng: random.Random, thing: Any) -> None:
    """Call a method of an object that sets something."""
    method = getattr(thing, some(rng, setters(type(thing))))
    given = inspect.signature(method).parameters.values()
    method(*(value_for(rng, one) for one in given if one.kind is one.POSITIONAL_OR_KEYWORD))


def bodies(world: World) -> Iterator[Any]:
    """All bodies of models, dummies included."""
    return (body for model in world.models for body in model.bodies)


def attach(rng: random.Random, world: World) -> None:
    """Attach a model to another one, or take it off."""
    model = some(rng, world.models)
    if rng.random() < 0.4:
        model.Detach()
        return
    parent = some(rng, world.models)
    model.SetParent(parent, some(rng, parent.bodies))
    model.Attach()


def insert(rng: random.Random, world: World) -> None:
    """Insert a model."""
    place = f"{rng.uniform(-2, 2):.2f} {rng.uniform(-2, 2):.2f}"
    world.InsertModel(some(rng, NEW).format(f"n{rng.randrange(100)}", place, some(rng, ("sphere", "box", "cylinder"))))


def join(rng: random.Random, world: World) -> None:
    """Make a joint, which a state needs in the world that it is set in."""
    joint = some(rng, JOINTS)(world)
    joint.Attach(some(rng, bodies(world)), some(rng, [None, *bodies(world)]))
    if hasattr(joint, "SetAnchor"):
        joint.SetAnchor(vector(rng))
    if hasattr(joint, "SetAxis"):
        joint.SetAxis((0.0, 1.0, 0.0))
    HELD.append(joint)


HELD: list[Any] = []  # joints, which a program that makes them holds


def rejoin(rng: random.Random, world: World) -> None:
    """Detach a joint, or attach it to other bodies of its model: with another one it would end if that is deleted."""
    model = some(rng, world.models)
    joint = some(rng, model.joints)
    if rng.random() < 0.5:
        joint.Detach()
    else:
        joint.Attach(some(rng, model.bodies), some(rng, model.bodies))


def set_world(rng: random.Random, world: World) -> None:
    """Change a setting of the world."""
    number = rng.random()
    some(
        rng,
        (
            lambda: setattr(world.engine, "gravity", (number, -number, -9 * number)),
            lambda: setattr(world.engine, "step_time", 0.01 + 0.01 * number),
            lambda: setattr(world, "paused", number < 0.3),
            lambda: setattr(world, "physics_enabled", number < 0.7),
            lambda: setattr(world, "fogDensity", number),
            lambda: world.set_sim_time(10 * number),
            lambda: world.engine.set_constraints(0.1 + 0.5 * number, 1e-5, 10.0),
            lambda: world.reseed(rng.randrange(100)),
            lambda: world.random.spawn(1),
        ),
    )()


CHANGES: list[Callable[[random.Random, World], object]] = [
    insert,
    insert,
    lambda rng, world: world.DeleteModel(some(rng, world.models)),
    attach,
    rejoin,
    set_world,
    lambda rng, world: call_setter(rng, some(rng, world.models)),
    *[lambda rng, world: call_setter(rng, some(rng, bodies(world)))] * 3,
    *[lambda rng, world: call_setter(rng, some(rng, world.engine.geoms.values()))] * 2,
    *[lambda rng, world: call_setter(rng, some(rng, world.engine.joints.values()))] * 3,
    lambda rng, world: world.SetModelPose(some(rng, world.models), GzPose(vector(rng, 1.0))),
    lambda rng, world: command(world, rng),
    lambda _, world: world.ResetModelPoses(),
    lambda _, world: world.get_state(),
    lambda _, world: world.reset(),
]


def changed(world: World, seed: object, *, joints: bool) -> list[bytes]:
    """Steps with changes; what was seen after each of them."""
    record = []
    for number in range(STEPS):
        rng = random.Random(f"{seed} {number}")
        for _ in range(rng.choice((0, 0, 1, 3))):
            change = join if joints and rng.random() < 0.05 else some(rng, CHANGES)
            with contextlib.suppress(GazeboError, IndexError, TypeError):  # what does not fit is left out
                change(rng, world)
        command(world, rng)
        world.Step()
        seen = look(world)
        record.append(hashlib.blake2b(repr(sorted(seen.items())).encode(), digest_size=8).digest())
    return record


def difference(one: list[bytes], other: list[bytes]) -> int | None:
    """The first step that differs."""
    return next((i for i, (a, b) in enumerate(zip(one, other, strict=True)) if a != b), None)


def check(path: Path, seed: int, *, joints: bool, folder: Path | None) -> str | None:
    """What differs after a restore; None if nothing does."""
    HELD.clear()
    try:
        return _check(path, seed, joints=joints, folder=folder)
    except StateError as error:
        return None if joints and "what the world has not" in str(error) else f"{error}"  # code cannot be repeated


def _check(path: Path, seed: int, *, joints: bool, folder: Path | None) -> str | None:
    with World.from_file(path) as world:
        fresh = world.get_state()
        changed(world, f"{seed} 1", joints=joints)
        state = world.get_state()
        first = changed(world, f"{seed} 2", joints=joints)
        for others in (None, 3):
            if others is not None:
                changed(world, f"{seed} 3", joints=joints)
            world.set_state(state)
            if world.get_state() != state:
                return f"the state that was set is not the state, after changes {others}"
            at = difference(first, changed(world, f"{seed} 2", joints=joints))
            if at is not None:
                return f"differs in step {at}, after changes {others}"
        world.set_state(state)
        if not joints:
            with world.clone() as clone:
                if clone.get_state() != state:
                    return "the clone has another state"
                if look(clone) != look(world):
                    return "the clone is seen as another world"
        if folder is not None:
            (folder / "state").write_bytes(state)
            words = [sys.executable, __file__, str(path), str(folder / "state"), f"{seed} 2"]
            done = subprocess.run(words, capture_output=True, text=True, check=False)
            if done.stdout.strip() != digest(first):
                return f"differs in another process: {done.stderr[-500:]}"
        world.reset()
        return None if world.get_state() == fresh else "the state after a reset is not that at the start"


def test_random_changes_are_in_states(tmp_path):
    logging.disable(logging.CRITICAL)
    try:
        with trial("states around changes of legacy worlds") as row:
            paths = sorted(installed_worlds().glob("*.world"))
            failures = {}
            for number in range(max(6, round(400 * SHARE))):
                path, seed, joints = paths[number % len(paths)], row.seed + number, number % 3 == 0
                folder = tmp_path if number % 12 == 1 else None
                if (found := check(path, seed, joints=joints, folder=folder)) is not None:
                    failures[path.stem, seed, joints] = found
                row.count += 1
            row.result = f"{len(failures)} differ"
            assert not failures
    finally:
        logging.disable(logging.NOTSET)


if __name__ == "__main__":
    logging.disable(logging.CRITICAL)
    with World.from_file(sys.argv[1]) as found:
        found.set_state(Path(sys.argv[2]).read_bytes())
        print(digest(changed(found, sys.argv[3], joints=False)))
