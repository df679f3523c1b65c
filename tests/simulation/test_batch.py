"""Batch: commands and readings of many interfaces as two arrays."""

import fcntl
from pathlib import Path

import numpy as np
import pytest

import libgz
from libgz.base.errors import ClosedError, NotFoundError, ParameterError

SICK = "<model:SickLMS200><id>l{}</id><xyz>0.1 0 0.311</xyz></model:SickLMS200>"
TEXT = "<gz:world xmlns:gz='g' xmlns:model='m'><model:GroundPlane/>{}</gz:world>"
COMMANDS = [("position.*", "cmd_vel_pos[0]", "cmd_vel_rot[2]"), ("position.r1", "cmd_enable_motors")]
READINGS = [("position.*", "pos", "rot[2]", "time"), ("laser.*", "ranges", "range_count"), ("sonar.r1", "sonar_pos[3]")]


def text(count=2):
    robots = (
        f"<model:Pioneer2AT><id>r{i}</id><xyz>{3 * i} {i} 0</xyz>{SICK.format(i)}</model:Pioneer2AT>"
        for i in range(count)
    )
    return TEXT.format("".join(robots))


def by_hand(world, values):
    """What a batch does, interface by interface."""
    for i in range(2):
        data = world.interface("position", f"r{i}").data
        data.cmd_vel_pos[0], data.cmd_vel_rot[2] = values[2 * i : 2 * i + 2]
    world.interface("position", "r1").data.cmd_enable_motors = int(values[4])
    world.step(5)
    found = []
    for i in range(2):
        data = world.interface("position", f"r{i}").data
        found += [*data.pos, data.rot[2], data.time]
    for i in range(2):
        laser = world.interface("laser", f"l{i}")
        found += [*laser.ranges, laser.data.range_count]
    return [*found, *world.interface("sonar", "r1").data.sonar_pos[3]]


@pytest.mark.parametrize("native", [True, False], ids=["native", "python"])
def test_a_batch_is_equal_to_the_interfaces_one_by_one(native):
    rng = np.random.default_rng(1)
    with libgz.World.from_string(text()) as one, libgz.World.from_string(text()) as other:
        one.rows.enabled = native
        one.step(6)
        other.step(6)
        batch = one.batch(COMMANDS, READINGS)
        assert batch.command_names[:3] == [
            f"position.{name}" for name in ("r0.cmd_vel_pos[0]", "r0.cmd_vel_rot[2]", "r1.cmd_vel_pos[0]")
        ]
        assert batch.reading_names[:5] == [
            f"position.r0.{name}" for name in ("pos[0]", "pos[1]", "pos[2]", "rot[2]", "time")
        ]
        assert batch.commands.tolist() == [0, 0, 0, 0, 1], "what is there"
        for _ in range(6):
            values = [*rng.uniform(-0.5, 0.5, 4), rng.integers(2)]
            assert batch.step(values, steps=5).tolist() == by_hand(other, values)
        batch.commands[0] = 0.25
        batch.step()
        assert one.interface("position", "r0").data.cmd_vel_pos[0] == 0.25
        assert one.interface("position", "r0").data.cmd_vel_rot[2] == values[1]
        assert batch.step(np.zeros((5, 1))) is batch.readings


@pytest.mark.parametrize(
    ("commands", "readings", "error", "message"),
    [
        ([("position.r9", "cmd_vel_pos")], [], NotFoundError, "nothing serves 'position.r9'.*did you mean"),
        ([("position.r0", "pos")], [], ParameterError, "position.r0.pos is no command; its commands are cmd_enable"),
        ([("position.r0", "cmd_vel_pos[3]")], [], ParameterError, r"has the shape \(3,\), so no cmd_vel_pos\[3\]"),
        ([("position.r0",)], [], ParameterError, "comes without fields"),
        ([], [("position.r0", "pso")], ParameterError, "has no numbers 'pso'.*did you mean 'pos'"),
        ([], [("position.r0", "head")], ParameterError, "has no numbers 'head'"),
        ([], [("laser.l0", "ranges")], ParameterError, "laser.l0 has no ranges yet: let the world make steps first"),
    ],
)
def test_what_does_not_exist_is_named(commands, readings, error, message):
    with libgz.World.from_string(text(1)) as world, pytest.raises(error, match=message):
        world.batch(commands, readings)


def test_commands_are_checked():
    with libgz.World.from_string(text(1)) as world:
        batch = world.batch([("position.*", "cmd_vel_pos")])
        with pytest.raises(ParameterError, match="2 commands were given; there are 3"):
            batch.step([0.0, 0.0])
        with pytest.raises(ParameterError, match=r"command position.r0.cmd_vel_pos\[1\] is nan"):
            batch.step([0.0, np.nan, 0.0])
        assert world.iterations == 0
    with pytest.raises(ClosedError):
        world.batch()


def test_a_batch_of_a_served_world_takes_the_locks(wire):
    with libgz.World.from_string(text(1), server_id=wire) as world, libgz.Client(wire) as client:
        world.step(6)
        batch = world.batch([("position.r0", "cmd_vel_pos[0]")], [("position.r0", "time", "pos[0]")])
        position = client.position("r0")
        assert batch.step([0.3], steps=10).tolist() == [position.data.time, position.data.pos[0]]
        assert position.data.cmd_vel_pos[0] == 0.3
        with Path(f"{world.gz_server.path}/position.r0").open("rb") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            before = batch.readings.tolist()
            assert batch.step([0.1], steps=10).tolist() == before, "nothing is read without the lock"
            assert position.data.cmd_vel_pos[0] == 0.3
        assert batch.step([0.1], steps=10)[0] > before[0]
        assert position.data.cmd_vel_pos[0] == 0.1


def test_a_batch_outlives_its_interfaces_and_its_world():
    with libgz.World.from_string(text(2)) as world:
        world.step(6)
        batch = world.batch([("position.*", "cmd_vel_pos[0]")], [("laser.*", "ranges")])
        world.DeleteModel("r1")
        with pytest.raises(ClosedError, match=r"position.r1 is not open"):
            batch.step([0.1, 0.1])
    with pytest.raises(ClosedError):
        batch.read()
