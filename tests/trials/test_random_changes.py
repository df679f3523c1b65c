"""Random changes of an SDF world before and after states: what follows a restored state is equal to the bit."""

from __future__ import annotations

import contextlib
import logging
import os
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from classic_runs import Run, first_difference
from trials.table import trial

from libgz import World
from libgz.base.errors import GazeboError
from libgz.classic import server
from libgz.classic.math import PID, Pose3d, Rand, Vector3d
from libgz.simulation.state import decode, encode

pytestmark = pytest.mark.trial

SHARE = float(os.environ.get("TRIAL_SHARE") or 1.0)
EXAMPLES = Path(__file__).parents[2] / "examples"
STEPS = 20
SERVER = f"{server.WorldServer.__module__}.{server.WorldServer.__qualname__}"  # the name of its part of a state
SHAPES = ("<sphere><radius>0.2</radius></sphere>", "<box><size>0.3 0.3 0.3</size></box>")
PARTS = (
    "",
    "<sensor name='s' type='imu'><always_on>1</always_on><update_rate>100</update_rate></sensor>",
    """<sensor name='s' type='contact'><always_on>1</always_on><update_rate>90</update_rate>
<contact><collision>c</collision></contact></sensor>""",
)
MORE = """<link name='m'><pose>0.5 0 0 0 0 0</pose><collision name='c'><geometry><sphere><radius>0.1</radius></sphere>
</geometry></collision></link><joint name='j' type='{0}'><parent>l</parent><child>m</child><axis><xyz>0 1 0</xyz></axis>
<sensor name='force' type='force_torque'><always_on>1</always_on></sensor></joint>"""
KINDS = ("revolute", "fixed", "prismatic", "ball", "universal", "screw")


def some(rng: random.Random, things: Any) -> Any:
    """One of them; an IndexError if there is none."""
    return rng.choice(list(things))


def model_text(rng: random.Random, name: str) -> str:
    """A new model."""
    more = MORE.format(some(rng, KINDS)) if rng.random() < 0.5 else ""
    pose = " ".join(f"{rng.uniform(-1, 1):.2f}" for _ in range(2)) + f" {rng.uniform(0.5, 3):.2f} 0.1 0 0"
    return f"""<sdf version='1.6'><model name='{name}'><pose>{pose}</pose><link name='l'><collision name='c'><geometry>
{some(rng, SHAPES)}</geometry></collision>{some(rng, PARTS)}</link>{more}</model></sdf>"""


def vector(rng: random.Random) -> Vector3d:
    """A vector."""
    return Vector3d(*(rng.uniform(-1, 1) for _ in range(3)))


def replace(rng: random.Random, world: Any, model: Any) -> None:
    """Remove a model, and insert one of its name."""
    world.RemoveModel(model.GetName())
    world.InsertModelString(model_text(rng, model.GetName()))


def set_joint(rng: random.Random, model: Any) -> None:
    """Change one value of a joint."""
    joint = some(rng, model.GetJoints())
    values = {
        "Damping": 1,
        "Stiffness": 5,
        "LowerLimit": -1,
        "UpperLimit": 1,
        "Velocity": 1,
        "Force": 1,
        "Position": 0.5,
    }
    name = some(rng, values)
    getattr(joint, f"Set{name}")(0, rng.random() * values[name])


def control(rng: random.Random, model: Any) -> None:
    """Give a joint a target."""
    controller, name = model.GetJointController(), some(rng, model.GetJoints()).GetScopedName()
    controller.SetPositionTarget(name, rng.uniform(-0.5, 0.5))
    controller.SetPositionPID(name, PID(rng.uniform(0, 5)))


def links(rng: random.Random, model: Any) -> tuple[Any, Any]:
    """Two of its links."""
    return some(rng, model.GetLinks()), some(rng, model.GetLinks())


CHANGES: list[Callable[[random.Random, Any, Any], object]] = [
    lambda rng, world, _: world.InsertModelString(model_text(rng, f"n{rng.randrange(4)}")),
    lambda _, world, model: world.RemoveModel(model.GetName()),
    replace,
    lambda rng, _, model: model.SetName(f"r{rng.randrange(3)}"),
    lambda rng, _, model: model.SetWorldPose(Pose3d(*vector(rng), 0.0, 0.1, 0.2)),
    lambda rng, _, model: model.SetStatic(rng.random() < 0.5),
    lambda rng, _, model: model.SetScale(Vector3d(*[rng.uniform(0.7, 1.4)] * 3)),
    lambda rng, _, model: model.CreateJoint(f"c{rng.randrange(3)}", some(rng, KINDS), *links(rng, model)),
    lambda rng, _, model: model.CreateLink(f"l{rng.randrange(3)}"),
    lambda rng, _, model: model.RemoveJoint(some(rng, model.GetJoints()).GetName()),
    lambda rng, _, model: some(rng, model.GetJoints()).Detach(),
    lambda rng, _, model: some(rng, model.GetJoints()).Attach(*links(rng, model)),
    lambda rng, _, model: set_joint(rng, model),
    lambda rng, _, model: control(rng, model),
    lambda rng, _, model: some(rng, model.GetLinks()).SetSelfCollide(rng.random() < 0.5),
    lambda rng, _, model: some(rng, model.GetLinks()).SetKinematic(rng.random() < 0.5),
    lambda rng, _, model: some(rng, model.GetLinks()).SetEnabled(rng.random() < 0.5),
    lambda rng, _, model: some(rng, model.GetLinks()).AddForce(vector(rng) * 20.0),
    lambda rng, _, model: some(rng, model.GetLinks()).SetLinearVel(vector(rng)),
    lambda rng, world, _: world.SetGravity(vector(rng) * 9.0),
    lambda _, world, __: world.core.get_state(),
    lambda _, world, __: world.core.reset(),
]


class Changing(Run):
    """A run in which a world is changed at random.

    Attributes:
        part: which changes; the same number gives the same ones in equal worlds.
    """

    part = 0

    def command(self, number: int) -> None:
        """Change something in every other step; what does not fit raises, and is left out."""
        rng = random.Random(f"{self.seed} {self.part} {number}")
        models = [model for model in self.view.all_models() if not model.IsStatic()]
        for _ in range(rng.choice((0, 0, 1, 3))):
            with contextlib.suppress(GazeboError, IndexError):
                some(rng, CHANGES)(rng, self.view, some(rng, models))

    def changed(self, part: int) -> list[bytes]:
        """Steps with the changes of a part."""
        self.part = part
        return self.steps(STEPS)

    def steps(self, count: int, *, every: int = 1) -> list[bytes]:
        """As `Run.steps`, with numbers that do not depend on the clock, which a reset sets back."""
        self.messages.clear()
        record = []
        for number in range(count):
            self.command(number)
            self.world.Step()
            record.append(self.digest())
        return record


def without_plugins(state: bytes) -> dict[str, Any]:
    """The parts of a state but that of the plugins, which a reset does not load again, but calls."""
    _, _, encoded = decode(state)
    parts: dict[str, Any] = decode(encoded)
    kept = parts["companions"]
    parts["companions"] = {**kept, SERVER: kept[SERVER][: server.PARTS.index("plugins")]}
    parts["engine"] = encode(parts["engine"])
    return parts


def check(path: Path, seed: int) -> str | None:
    """What differs after a restore; None if nothing does."""
    Rand.Seed(5)
    with World.from_file(path) as world:
        run = Changing(world, seed)
        fresh = world.get_state()
        run.activate()
        run.changed(1)
        state = world.get_state()
        first = run.changed(2)
        for others in (None, 3):
            if others is not None:
                run.changed(others)
            world.set_state(state)
            if world.get_state() != state:
                return f"the state that was set is not the state, after changes {others}"
            at = first_difference(first, run.changed(2))
            if at is not None:
                return f"differs in step {at}, after changes {others}"
        world.set_state(state)
        with world.clone() as clone:
            if clone.get_state() != state:
                return "the clone has another state"
        world.reset()
        return (
            None
            if without_plugins(world.get_state()) == without_plugins(fresh)
            else "the state after a reset is not that at the start"
        )


def test_random_changes_are_in_states():
    logging.disable(logging.CRITICAL)
    try:
        with trial("states around random changes") as row:
            paths = [*sorted((EXAMPLES / "sdf").glob("*.world")), *sorted((EXAMPLES / "plugins").glob("*/*.world"))]
            failures = {}
            for number in range(max(4, round(200 * SHARE))):
                path, seed = paths[number % len(paths)], row.seed + number
                if (found := check(path, seed)) is not None:
                    failures[path.stem, seed] = found
                row.count += 1
            row.result = f"{len(failures)} differ"
            assert not failures
    finally:
        logging.disable(logging.NOTSET)
