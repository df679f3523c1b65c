"""Native updates: every row gives what its twin in Python gives, to the bit, whatever happens meanwhile."""

import fcntl
import math
import os
import random
import re
import time
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

import libgz
from libgz.base.records import Kind, numbers
from libgz.interfaces.power import Power
from libgz.legacy.model import Model
from libgz.models.bandit import JointServo
from libgz.models.pioneer2at import Pioneer2AT
from libgz.simulation.stepping import Stepping

HEAD = "<gz:world xmlns:gz='g' xmlns:model='m' xmlns:param='p'>"
SICK = "<model:SickLMS200><id>{}</id><xyz>0.1 0 {}</xyz><rangeCount>{}</rangeCount></model:SickLMS200>"
ROBOTS = (
    f"<model:Pioneer2AT><id>at</id><xyz>0 0 0</xyz>{SICK.format('l1', 0.311, 181)}"
    "<model:GarminGPS><id>gps</id><xyz>-0.15 0 0.311</xyz></model:GarminGPS></model:Pioneer2AT>",
    f"<model:Pioneer2DX><id>dx</id><xyz>2 0 0.24</xyz>{SICK.format('l2', 0.01, 90)}"
    "<model:TruthWidget><id>truth</id></model:TruthWidget>"
    "<model:Pioneer2Gripper><id>grip</id><xyz>0.14003 0 -0.0975</xyz></model:Pioneer2Gripper></model:Pioneer2DX>",
    "<model:PeopleBot><id>people</id><xyz>4 0 0</xyz></model:PeopleBot>",
    "<model:B21R><id>b21r</id><xyz>6 0 0</xyz></model:B21R>",
    "<model:Atrv><id>atrv</id><xyz>0 3 0</xyz></model:Atrv>",
    "<model:Roomba><id>roomba</id><xyz>2 3 0</xyz><updateRate>7</updateRate></model:Roomba>",
    "<model:SegwayRMP><id>segway</id><xyz>4 3 0</xyz></model:SegwayRMP>",
    "<model:ClodBuster><id>clod</id><xyz>6 3 0</xyz></model:ClodBuster>",
    "<model:ClodBuster><id>raw</id><xyz>8 3 0</xyz><rawEncoder>true</rawEncoder></model:ClodBuster>",
    "<model:Shrimp><id>shrimp</id><xyz>0 6 0.2</xyz></model:Shrimp>",
    "<model:WheelChair><id>chair</id><xyz>2 6 1.2</xyz></model:WheelChair>",
    "<model:CarChassis><id>car</id><xyz>5 6 0</xyz></model:CarChassis>",
    "<model:Blimp><id>blimp</id><xyz>9 6 10</xyz></model:Blimp>",
    "<model:Bandit><id>bandit</id><xyz>9 0 0.8</xyz></model:Bandit>",
    "<model:SimpleSolid><id>post</id><xyz>1.5 0.2 0.5</xyz><size>0.2 0.2 1</size></model:SimpleSolid>",
    "<model:Pioneer2AT><id>old</id><xyz>0 -4 0</xyz><model:Pioneer2Sonars><id>ring</id></model:Pioneer2Sonars>"
    "<model:WiFi><id>w1</id></model:WiFi></model:Pioneer2AT><model:WiFi><id>w2</id><xyz>0 -6 1</xyz></model:WiFi>",
    "<model:SimpleSolid><id>mark</id><xyz>3.4 0 0.5</xyz><shape>box</shape><size>0.2 1 1</size>"
    "<fiducial>7</fiducial><retro>1</retro></model:SimpleSolid>",
)
NEW = f"<model:Pioneer2AT><id>new</id><xyz>-3 0 0</xyz>{SICK.format('l9', 0.311, 20)}</model:Pioneer2AT>"
WORLD = f"{HEAD}<model:GroundPlane/>{''.join(ROBOTS)}</gz:world>"
DRIVEN = ("at", "dx", "people", "b21r", "atrv", "roomba", "segway", "clod", "raw", "shrimp", "chair", "car", "blimp")


def pose_at(x, y, z):
    return libgz.GzPose(libgz.GzVector(x, y, z), libgz.GzQuatern(1, 0, 0, 0))


@contextmanager
def pair(text, **settings):
    """Two worlds of one text: native, and all in Python."""
    with libgz.World.from_string(text, **settings) as native:
        settings = {**settings, "server_id": settings["server_id"] + 1} if "server_id" in settings else settings
        with libgz.World.from_string(text, **settings) as twin:
            twin.rows.enabled = False
            assert native.rows.native
            assert not twin.rows.native
            yield native, twin


def contents(world):
    """The bytes of all interfaces, without real time; those of stale memory included."""
    found = {key: interface.get_bytes() for key, interface in world.gz_server.interfaces.items()}
    at = type(world.sim.data).real_time.offset
    sim = found["sim", "default"]
    found["sim", "default"] = sim[:at] + sim[at + 8 :]
    return found


def compare(worlds):
    """Both worlds are equal to the bit."""
    native, twin = worlds
    ours, theirs = contents(native), contents(twin)
    different = [key for key in ours.keys() | theirs.keys() if ours.get(key) != theirs.get(key)]
    assert different == [], f"at {native.clock.sim_time}"
    assert native.engine.states.tobytes() == twin.engine.states.tobytes()
    assert native.clock.sim_time == twin.clock.sim_time
    assert native.clock.iterations == twin.clock.iterations


def together(worlds, action):
    for world in worlds:
        action(world)


def file_of(world, name):
    """The file of an interface."""
    return Path(f"{world.gz_server.path}/{name}").open("r+b", buffering=0)


def kinds(world):
    """How many rows there are of each kind."""
    world.step()
    return {kind: sum(row.kind == kind for row in world.rows._rows) for kind in Kind}


def test_all_robots_do_the_same_for_ten_seconds_whatever_clients_write():
    rng = random.Random(5)
    with pair(WORLD) as worlds:
        states, seen = [], set()
        for step in range(520):
            if rng.random() < 0.08:
                name, values = rng.choice(DRIVEN), [rng.uniform(-0.5, 0.5) for _ in range(2)]
                if rng.random() < 0.25:
                    values[rng.randrange(2)] = rng.choice((math.nan, math.inf, -math.inf, 1e9, -0.0))
                enabled = rng.choice((0, 1, 1, 1, 7))

                def write(world, name=name, values=values, enabled=enabled):
                    data = world.interface("position", name).data
                    data.cmd_vel_pos[0], data.cmd_vel_rot[2] = values
                    data.cmd_enable_motors = enabled

                together(worlds, write)
            if rng.random() < 0.02:
                scan = (-rng.uniform(0.1, 2.0), rng.uniform(0.1, 2.0), rng.uniform(1.0, 9.0), rng.randrange(1, 400))
                together(worlds, lambda world, scan=scan: world.interface("laser", "l1").configure(*scan))
            if rng.random() < 0.05:
                angles = [rng.choice((rng.uniform(-1, 1), math.nan)) for _ in range(11)]

                def bend(world, angles=angles):
                    for joint, angle in zip(world.interface("joint", "bandit").data.joints, angles, strict=False):
                        joint.cmd_angle = joint.cmd_angle2 = angle

                together(worlds, bend)
            if step % 97 == 50:
                pose = libgz.GzPose(
                    libgz.GzVector(rng.uniform(-1, 1), rng.uniform(-1, 1), 0.2), libgz.GzQuatern(1, 0, 0, 0)
                )
                together(worlds, lambda world, pose=pose: world.SetModelPose(world.model("at"), pose))
            if step == 200:
                together(worlds, lambda world: setattr(world, "paused", True))
            if step == 210:
                together(worlds, lambda world: setattr(world, "paused", False))
            if step == 300:
                together(worlds, lambda world: setattr(world.sim.data, "reset", 1))
            together(worlds, lambda world: world.step())
            compare(worlds)
            seen.update(worlds[0].interface("laser", "l2").intensities.tolist())
            if step % 100 == 37:
                states.append([world.get_state() for world in worlds])
                assert states[-1][0] == states[-1][1]
        native, twin = worlds
        native.set_state(states[1][1])  # and each takes the other's
        twin.set_state(states[1][0])
        for _ in range(60):
            together(worlds, lambda world: world.step())
            compare(worlds)
        assert native.get_state() == twin.get_state()
        assert seen == {0, 1}, "no laser detects the reflector, or one always does"


def python_of(world, monkeypatch):
    """The models whose rows Python does from now on, as a list that grows."""
    called, own = [], world._stepping._call

    def call(entity, update, step):
        called.append(entity.GetId())
        return own(entity, update, step)

    monkeypatch.setattr(world._stepping, "_call", call)
    return called


@pytest.mark.parametrize("version", [0x060, 0x050])
def test_a_truth_widget_publishes_natively_and_moves_its_robot(version, monkeypatch):
    rng = random.Random(8)
    truth = "<model:TruthWidget><id>{}</id></model:TruthWidget>"
    text = (
        f"{HEAD}<model:GroundPlane/>{truth.format('own')}<model:SimpleSolid><id>ball</id><xyz>3 0 1</xyz>"
        f"{truth.format('t')}</model:SimpleSolid></gz:world>"
    )
    with pair(text, wire_version=version) as worlds:
        together(worlds, lambda world: world.step())
        called = python_of(worlds[0], monkeypatch)
        for step in range(300):
            if step % 7 == 0:
                new, name = rng.choice((0, 1, 1, 2, -5)), rng.choice(("t", "own"))
                numbers = [rng.choice((rng.uniform(-2, 2), math.nan if step > 200 else 0.5)) for _ in range(7)]

                def write(world, new=new, numbers=numbers, name=name):
                    data = world.interface("truth", name).data
                    data.cmd_pos[:], data.cmd_rot[:] = numbers[:3], numbers[3 : 3 + len(data.cmd_rot)]
                    data.cmd_new = new

                together(worlds, write)
            together(worlds, lambda world: world.step())
            compare(worlds)
        together(worlds, lambda world: world.step(5))
        called.clear()
        together(worlds, lambda world: world.step(20))
        assert called == ["own"] * 20, "the place of a dummy is Python's"
        ball = worlds[0].model("ball")
        assert worlds[0].interface("truth", "t").data.pos[0] == pytest.approx(ball.GetPose().pos.x, abs=1e-3)


def test_overwritten_requests_of_a_truth_widget_are_counted_natively(monkeypatch, caplog):
    truth = "<model:TruthWidget><id>t</id></model:TruthWidget>"
    robot = ROBOTS[3].replace("</model:B21R>", f"{truth}</model:B21R>")
    with libgz.World.from_string(f"{HEAD}{robot}</gz:world>") as world:
        world.step()
        called, data = python_of(world, monkeypatch), world.interface("truth", "t").data
        for number in range(2, 152):
            data.cmd_new = number
            world.step()
            assert data.cmd_new == 0
        assert called.count("t") == 2
    logged = [message for message in caplog.messages if "cmd_new" in message]
    assert len(logged) == 2
    assert logged[1].endswith("(100 times so far)")


def test_a_truth_widget_that_gets_another_parent_publishes_its_pose():
    solid = "<model:SimpleSolid><id>{0}</id><xyz>{1} 0 0.5</xyz>{2}</model:SimpleSolid>"
    truth = "<model:TruthWidget><id>t</id></model:TruthWidget>"
    with libgz.World.from_string(f"{HEAD}{solid.format('a', 0, truth)}{solid.format('b', 5, '')}</gz:world>") as world:
        world.step(2)
        widget, other = world.model("t"), world.model("b")
        widget.SetParent(other, other.GetBody())
        world.step(2)
        assert world.interface("truth", "t").data.pos[0] == pytest.approx(5)


def test_a_factory_reads_texts_natively_until_one_is_whole(monkeypatch):
    text = f"{HEAD}<model:GroundPlane/><model:Factory><id>f</id></model:Factory></gz:world>"
    solid = "<model:SimpleSolid><id>s{}</id><xyz>{} 0 1</xyz></model:SimpleSolid>"
    writes = {3: b"<model:Sim", 4: b"<model:SimpleSol", 5: solid.format(1, 1).encode(), 20: solid.format(2, 2).encode()}
    writes |= {21: b"", 22: solid.format(2, 2).encode(), 30: b"x" * 4096, 40: b"<delete>s1</delete>"}
    with pair(text) as worlds:
        together(worlds, lambda world: world.step())
        called, states = python_of(worlds[0], monkeypatch), []
        for step in range(60):
            if step in writes:

                def write(world, content=writes[step]):
                    string = world.interface("factory", "f").string
                    string[:] = list(content.ljust(len(string), b"\0"))

                together(worlds, write)
            together(worlds, lambda world: world.step())
            compare(worlds)
            assert [len(world.models) for world in worlds] == [len(worlds[1].models)] * 2
            if step in (3, 10, 20):
                states.append([world.get_state() for world in worlds])
                assert states[-1][0] == states[-1][1]
        assert called == ["f"] * 4, "for texts that have not changed"
        assert [model.GetId() for model in worlds[0].models] == ["GroundPlane", "f", "s2"]
        together(worlds, lambda world: world.set_state(states[2][0]))
        together(worlds, lambda world: world.step())
        compare(worlds)
        assert [world.model("s2").GetId() for world in worlds] == ["s2", "s2"], "the text was seen before"


@pytest.mark.parametrize("quirks", ["", "<legacyQuirks>gripperState</legacyQuirks>"])
@pytest.mark.parametrize("later", ["false", "true"])
def test_a_gripper_takes_and_publishes_natively(quirks, later, wire):
    settings = f"<param:Global>{quirks}</param:Global>"
    robot = ROBOTS[1].replace("<id>grip</id>", f"<id>grip</id><laterInterface>{later}</laterInterface>")
    with pair(f"{HEAD}{settings}<model:GroundPlane/>{robot}</gz:world>", server_id=wire) as worlds, ExitStack() as held:
        rng = random.Random(6)
        for step in range(200):
            if step % 25 == 3:
                command = rng.choice((1, 2, 2, 3, 4, 5, 7, 8, 99, -1))
                together(worlds, lambda world, command=command: world.interface("gripper", "grip").command(command))
            if step == 105:
                for world in worlds:
                    fcntl.flock(held.enter_context(file_of(world, "gripper.grip")), fcntl.LOCK_EX)
            if step == 115:
                held.close()
            together(worlds, lambda world: world.step())
            compare(worlds)
        found = kinds(worlds[0])
        assert found[Kind.PYTHON] == 2, "what it measures; a follower"


def test_the_rows_of_a_robot_are_native():
    with libgz.World.from_string(f"{HEAD}<model:GroundPlane/>{ROBOTS[0]}</gz:world>") as world:
        found = kinds(world)
        assert (found[Kind.CAST], found[Kind.PYTHON]) == (2, 1), "only the receiver's fix is Python"
        assert (
            found[Kind.LAW] == 2 + 2 + 3 + 3
        )  # of sim; measure, drive; position, power, sonar; requests, scan, fiducials
        assert [world.model("at"), world.model("l1"), world.model("gps")] == world.rows.updating, "not the ground"
    with libgz.World.from_string(f"{HEAD}<model:GroundPlane/>{ROBOTS[11]}</gz:world>") as world:
        found = kinds(world)
        assert found[Kind.PYTHON] == 0
    with libgz.World.from_string(f"{HEAD}<model:GroundPlane/>{ROBOTS[9]}</gz:world>") as world:
        found = kinds(world)
        assert found[Kind.PYTHON] == 0


@pytest.mark.parametrize(
    ("name", "height", "in_python"),
    [("SegwayRMP", 0, 0), ("Bandit", 0.8, 0), ("Blimp", 10, 0)],
)
def test_controllers_and_joints_need_no_python_in_a_step(name, height, in_python):
    text = f"{HEAD}<model:GroundPlane/><model:{name}><id>r</id><xyz>0 0 {height}</xyz></model:{name}></gz:world>"
    with libgz.World.from_string(text) as world:
        assert kinds(world)[Kind.PYTHON] == in_python
        world.step(10)  # in which the first command is taken
        lines, called = world.rows._lines, []
        for number in range(world.rows.begin, world.rows.end):
            if world.rows._rows[number].kind != Kind.PYTHON:
                lines[number] = lines[number]._replace(twin=called.append)
        world.step(20)
        assert called == []


def test_models_come_and_go_while_the_worlds_run():
    with pair(f"{HEAD}<model:GroundPlane/>{''.join(ROBOTS[:2])}</gz:world>") as worlds:
        together(worlds, lambda world: world.interface("position", "dx").command(vx=0.3, vyaw=0.2))
        for step in range(120):
            if step == 30:
                text = (
                    f"<model:Pioneer2AT><id>new</id><xyz>-3 0 0</xyz>{SICK.format('l9', 0.311, 20)}</model:Pioneer2AT>"
                )
                together(worlds, lambda world, text=text: world.InsertModel(text))
                together(worlds, lambda world: world.interface("position", "new").command(vx=0.2))
            if step == 60:
                together(worlds, lambda world: world.DeleteModel("at"))
            if step == 90:
                together(worlds, lambda world: world.reset())
            together(worlds, lambda world: world.step())
            compare(worlds)
        assert worlds[0].get_state() == worlds[1].get_state()


def made(text, **kinds):
    """A world of a text with model classes of its own, not initialized."""
    world, file = libgz.World(), libgz.WorldFile()
    for name, kind in kinds.items():
        world.factory.RegisterModel("plugin", name, kind)
    file.LoadString(f"{HEAD}<model:GroundPlane/>{text}</gz:world>")
    world.Load(file)
    return world


@pytest.mark.parametrize("part", ["Update", "measure", "publish", "drive", "run", "act", "wheel_rates"])
@pytest.mark.parametrize("when", ["class", "object", "running"])
def test_a_part_that_is_replaced_is_called(part, when):
    calls = []
    before = getattr(Pioneer2AT, part)

    def replacement(self, *values):
        calls.append(part)
        if part == "wheel_rates":
            left, right = before(self, *values)
            return 2.0 * left, right
        return before(self, *values)

    kind = type("Own", (Pioneer2AT,), {part: replacement, "STATE": ()} if when == "class" else {"STATE": ()})

    def install(world):
        robot = world.model("r")
        setattr(robot, part, lambda *values: replacement(robot, *values))

    def make():
        world = made("<model:Own><id>r</id></model:Own>", Own=kind)
        if when == "object":
            install(world)
        world.Initialize()
        return world

    with make() as native, make() as twin:
        twin.rows.enabled = False
        count = 0
        for step in range(60):
            if step == 20:
                together((native, twin), lambda world: world.interface("position", "r").command(vx=0.3, vyaw=0.1))
            if step == 10 and when == "running":
                together((native, twin), install)
            calls.clear()
            native.step()
            ours = list(calls)
            calls.clear()
            twin.step()
            assert ours == calls
            count += len(ours)
            compare((native, twin))
        assert count > (0 if part == "run" else 5), "the replacement is not called"


def test_parts_can_be_exchanged_while_the_world_runs():
    with pair(f"{HEAD}<model:GroundPlane/>{ROBOTS[0]}{ROBOTS[11]}</gz:world>") as worlds:
        together(worlds, lambda world: world.interface("position", "at").command(vx=0.3))
        changes = [
            lambda world: setattr(world.model("at"), "rate", libgz.UpdateRate(23.0)),
            lambda world: setattr(world.model("at"), "wheelDiam", 0.3),
            lambda world: setattr(world.model("at"), "normaliseYaw", True),
            lambda world: setattr(world.model("at").odometry, "pose", (0.0, 0.0, 9.0)),
            lambda world: setattr(world.model("at").battery, "level", 0.001),
            lambda world: world.model("at").odometry.pose.__setitem__(1, 5.0),
            lambda world: setattr(world.model("at"), "battery", None),
            lambda world: setattr(world.model("at").position, "command", (0.1, 0.1)),
            lambda world: setattr(world.model("at").position, "wanted", (0.1, 0.1)),
            lambda world: setattr(world.model("l1"), "rangeMax", 3.0),
            lambda world: setattr(world.model("l1"), "rate", libgz.UpdateRate(17.0)),
            lambda world: setattr(world.model("at"), "logPoses", True),
            lambda world: setattr(world.engine, "step_time", 0.013),
            lambda world: world.clock.set(3.0),
        ]
        for change in changes:
            together(worlds, change)
            for _ in range(9):
                together(worlds, lambda world: world.step())
                compare(worlds)
        assert worlds[0].interface("position", "at").data.pos[1] > 4.0


class Meddler(Model):
    """Changes what comes after it in the order of a step, in the middle of a step."""

    STATE = ()

    def Load(self, file, node):
        self.AddBody(libgz.Body(self.world, dummy=True), True)

    def Update(self, step):
        count = self.world.iterations
        if count == 11:
            self.world.model("at").rate = libgz.UpdateRate(31.0)
        if count == 20:
            self.world.model("at").SetPose(pose_at(0.5, 0.5, 0.1))
        if count == 31:
            self.world.DeleteModel("dx")
        if count == 40:
            self.world.interface("sonar", "at").destroy()


def test_a_model_may_change_what_is_updated_after_it():
    def make():
        world = made(f"<model:Meddler/>{''.join(ROBOTS[:2])}", Meddler=Meddler)
        world.Initialize()
        world.interface("position", "at").command(vx=0.3)
        return world

    with make() as native, make() as twin:
        twin.rows.enabled = False
        for _ in range(60):
            together((native, twin), lambda world: world.step())
            compare((native, twin))
        assert "sonar.at is not open" in str(native.errors[0])
        assert len(native.errors) == len(twin.errors) == 1


def test_a_failing_part_stops_its_model_only():
    def fail(step):
        raise ValueError("no")

    with pair(f"{HEAD}<model:GroundPlane/>{''.join(ROBOTS[:2])}</gz:world>") as worlds:
        together(worlds, lambda world: world.interface("position", "dx").command(vx=0.3))
        together(worlds, lambda world: world.step(20))
        together(worlds, lambda world: setattr(world.model("at"), "measure", fail))
        for _ in range(20):
            together(worlds, lambda world: world.step())
            compare(worlds)
        assert isinstance(worlds[0].model("at").failed, ValueError)
        assert worlds[0].model("dx").failed is None


def test_served_worlds_are_equal_while_clients_lock_overwrite_and_truncate(wire):
    text = f"{HEAD}<model:GroundPlane/>{''.join(ROBOTS[:2])}</gz:world>"
    with pair(text, server_id=wire) as worlds:
        together(worlds, lambda world: world.step(3))

        held = []
        for step in range(150):
            if step == 20:
                held = [file_of(world, "position.at") for world in worlds]
                for file in held:
                    fcntl.flock(file, fcntl.LOCK_EX)
            if step == 45:
                for file in held:
                    file.close()
            if step == 60:
                for world in worlds:
                    with file_of(world, "laser.l1") as file:
                        file.truncate(100)
            if step == 80:
                for world in worlds:
                    with file_of(world, "power.at") as file:
                        file.write(b"\xff" * 152)
            if step == 100:
                together(worlds, lambda world: world.interface("position", "at").command(vx=0.2))
            if step == 105:
                time.sleep(0.06)  # after that commands are kept, with the next exchange
            if step == 117:
                for world in worlds:
                    with file_of(world, "position.at") as file:
                        file.write(b"\xff" * 312)
            together(worlds, lambda world: world.step())
            if step < 60 or step > 75:  # the moment in which a truncated file is found depends on the clock
                compare(worlds)
        assert worlds[0].model("at").position.command == (0.2, 0.0)


def test_locks_that_clients_keep_and_heads_that_they_overwrite_cost_little_python(wire, monkeypatch, caplog):
    text = f"{HEAD}<model:GroundPlane/><model:SickLMS200><id>l</id></model:SickLMS200>{ROBOTS[13]}</gz:world>"
    with libgz.World.from_string(text, server_id=wire) as world:
        world.step(20)
        served = {name: Path(f"{world.gz_server.path}/{name}") for name in ("joint.bandit", "laser.l")}
        called, own = [], Stepping._call

        def call(entity, update, step):
            called.append(entity.GetId())
            return own(entity, update, step)

        monkeypatch.setattr(Stepping, "_call", staticmethod(call))
        with served["joint.bandit"].open("rb") as one, served["laser.l"].open("rb") as other:
            for file in (one, other):
                fcntl.flock(file, fcntl.LOCK_EX)
            world.step(20)
            assert set(called) == {"bandit", "l"}, "it does not wait for locks"
            called.clear()
            world.step(40)
            assert called == []
        bandit, laser = world.interface("joint", "bandit"), world.interface("laser", "l")
        before = world.GetSimTime()
        world.step(10)
        assert called == []
        assert min(bandit.data.time, laser.data.time) > before
        monkeypatch.setattr(JointServo, "publish", lambda *_: pytest.fail("written in Python"))
        for path in served.values():
            with path.open("r+b", buffering=0) as file:
                file.write(b"\xff" * 152)
        before = world.GetSimTime()
        world.step(10)
        assert set(called) == {"bandit", "l"}, "it does not repair heads"
        assert bandit.data.head.version == laser.data.head.version == 0x60
        assert min(bandit.data.time, laser.data.time) > before
        called.clear()
        caplog.clear()
        with served["joint.bandit"].open("r+b", buffering=0) as file:
            for number in range(2, 105):
                os.pwrite(file.fileno(), b"\xff" * 152, 0)
                world.step(10)
                assert bandit.data.head.version == 0x60, number
        assert called == ["bandit"], "native code repairs heads, but for those that are logged"
        assert [record.message for record in caplog.records] == [
            "a client overwrote the head of joint.bandit; it was restored (100 times so far)"
        ]


def test_a_world_that_is_paused_stays_so_while_a_client_keeps_the_lock(wire, monkeypatch):
    with libgz.World.from_string(f"{HEAD}<model:GroundPlane/></gz:world>", server_id=wire) as world:
        buttons, own = [], world.sim.lock
        monkeypatch.setattr(world.sim, "lock", lambda: buttons.append(1) or own())
        with Path(f"{world.gz_server.path}/sim.default").open("rb") as file:
            for paused in (True, False):
                world.paused = paused
                world.step(2)
                fcntl.flock(file, fcntl.LOCK_EX)
                world.step(5)
                buttons.clear()
                before = world.GetSimTime(), world.GetPauseTime()
                world.step(20)
                after = world.GetSimTime(), world.GetPauseTime()
                assert (after[0] > before[0], after[1] > before[1]) == (not paused, paused)
                assert bool(buttons) == paused, "a world that is not paused needs no Python while it waits for the lock"
                fcntl.flock(file, fcntl.LOCK_UN)


def test_other_processes_see_every_step_of_a_native_world(wire):
    with libgz.World.from_string(f"{HEAD}<model:GroundPlane/>{ROBOTS[0]}</gz:world>", server_id=wire) as world:
        world.step(2)
        with libgz.Observer(wire) as observer, libgz.Client(wire) as client:
            position = client.position("at")
            for step in range(12):
                if step == 6:
                    with position.locked() as data:
                        data.cmd_vel_pos[0] = 0.4
                world.step()
                assert client.wait(timeout=1.0)
                assert observer.pose("at").pos == world.model("at").GetPose().pos
                assert observer.state().sim_time == world.GetSimTime() == client.sim().data.sim_time
            assert world.model("at").position.command == (0.4, 0.0)
            world.model("at").SetPose(pose_at(3, 0, 0.1))
            world.step()
            assert observer.pose("at").pos == world.model("at").GetPose().pos


def test_a_plugin_can_use_the_rows():
    class Own(Model):
        """A sensor that publishes the sim time and a count natively."""

        STATE = ()

        def Load(self, file, node):
            self.AddBody(libgz.Body(self.world, dummy=True), True)
            self.rate = libgz.UpdateRate(10.0)
            self.level = numbers(1)(3.5)

        def Init(self, file, node):
            self.power = Power()
            self.power.create(self.world.gz_server, self.GetId())

        def plan_update(self, plan):
            with plan.due(self.rate):
                plan.exchange(self.power, self.publish)

        @libgz.law
        def publish(self, data):
            data.time, data.levels[0] = self.world.GetSimTime(), self.level[0]

    world = made("<model:Own><id>own</id></model:Own>", Own=Own)
    world.Initialize()
    with world:
        world.step(6)
        assert world.interface("power", "own").data.time == pytest.approx(0.1)
        assert world.interface("power", "own").level == 3.5
        assert kinds(world)[Kind.PYTHON] == 0


class Hover(Model):
    """Holds a height by a law of its own."""

    STATE = ("wanted", "noted", "gain")
    wanted, noted, gain = libgz.Number(1.0), libgz.Number(), libgz.Number(20.0)

    def Load(self, file, node):
        body = libgz.Body(self.world)
        self.AddBody(body, True)
        libgz.BoxGeom(body, self.modelSpaceId, 0.2, 0.3, 0.1).SetMass(2.0)

    def plan_update(self, plan):
        plan.do(self.control)

    @libgz.law
    def control(self, step):
        if not libgz.usually(self.gain >= 0.5):
            return
        body = self.GetBody()
        speed = (body.GetPose().pos.z - self.noted) / step
        self.noted = body.GetPose().pos.z
        effort = libgz.clamp(self.gain * (self.wanted - self.noted) / 0.5 - 3.0 * speed, 40.0)
        body.AddRelForce(0.0, 0.0, libgz.where(self.wanted > 0.0, effort, 0.0))


def test_a_plugin_can_have_a_control_law_of_its_own():
    """The law is one function; computed in Python and natively it gives the same bits, also where it cannot act."""
    worlds = [made("<model:Hover><id>h</id><xyz>0 0 1</xyz></model:Hover>", Hover=Hover) for _ in range(2)]
    native, twin = worlds
    twin.rows.enabled = False
    for world in worlds:
        world.Initialize()
    with native, twin:
        assert kinds(native)[Kind.PYTHON] == 0
        together([twin], lambda world: world.step())
        for number in range(90):
            if number == 30:
                together(worlds, lambda world: setattr(world.model("h"), "gain", 0.1))  # below what is native
            if number == 45:
                together(worlds, lambda world: setattr(world.model("h"), "gain", 30.0))
            if number == 60:
                together(worlds, lambda world: world.model("h").GetBody().set_auto_disable(True))
            together(worlds, lambda world: world.step())
            compare(worlds)
            assert native.model("h").noted == twin.model("h").noted
        assert native.model("h").noted != 0.0
        assert native.get_state() == twin.get_state()


def test_a_constant_of_a_law_may_be_set_while_the_world_runs():
    class Heavy(Hover):
        STATE = ("push",)

        def Load(self, file, node):
            super().Load(file, node)
            self.push = 1.0

        @libgz.law
        def control(self, step):
            self.GetBody().AddRelForce(0.0, 0.0, self.push * step)
            self.noted = self.push

    world = made("<model:Heavy><id>h</id></model:Heavy>", Heavy=Heavy)
    world.Initialize()
    with world:
        world.step(2)
        world.model("h").push = 7.0
        world.step()
        assert world.model("h").noted == 7.0


@pytest.mark.parametrize("part", ["due", "Update"])
def test_parts_of_models_that_are_replaced_are_called(part):
    """Rates, and parts of a robot that are no models, are asked where something replaces their methods."""
    calls = []

    class Rate(libgz.UpdateRate):
        def due(self, now):
            calls.append("due")
            return super().due(now)

    with libgz.World.from_string(f"{HEAD}<model:GroundPlane/>{ROBOTS[2]}</gz:world>") as world:
        robot = world.model("people")
        if part == "due":
            robot.rate = Rate(1000.0)
        else:
            own = robot.battery.Update
            robot.battery.Update = lambda now: calls.append("Update") or own(now)
            world.update_rows_changed()
        world.step(10)
        assert len(calls) == (10 if part == "due" else 2)
        assert world.interface("power", "people").data.time > 0.0


def test_devices_may_come_and_go_while_the_world_runs():
    class Part:
        def __init__(self):
            self.times = []

        def Update(self, now):
            self.times.append(now)

        def Fini(self):
            pass

    part = Part()
    with libgz.World.from_string(f"{HEAD}<model:GroundPlane/>{ROBOTS[2]}</gz:world>") as world:
        robot = world.model("people")
        world.step(10)
        robot.devices.append(part)
        world.step(10)
        assert len(part.times) == 2
        robot.devices.remove(part)
        world.step(10)
        assert len(part.times) == 2
        robot.devices = (*robot.devices, part)
        world.step(10)
        assert len(part.times) == 4
        del robot.devices[:]
        world.step(10)
        assert len(part.times) == 4


def test_a_plan_that_cannot_be_stops_its_model_only():
    class Wrong(Model):
        STATE = ()

        def Load(self, file, node):
            self.AddBody(libgz.Body(self.world, dummy=True), True)
            self.level = numbers(1)()

        def Init(self, file, node):
            self.power = Power()
            self.power.create(self.world.gz_server, "p")

        def plan_update(self, plan):
            plan.exchange(self.power, None, unless=self.expect)

        def expect(self, exchange):
            exchange.expect("level", 0, self.level)

    with made(f"<model:Wrong><id>wrong</id></model:Wrong>{ROBOTS[2]}", Wrong=Wrong) as world:
        world.Initialize()
        world.step(7)
        message = "power.p has no field 'level'.*did you mean 'levels'"
        assert isinstance(world.model("wrong").failed, libgz.GazeboError)
        assert re.search(message, str(world.model("wrong").failed))
        assert world.interface("position", "people").data.time == pytest.approx(0.1)


def test_an_update_may_connect_to_an_event_of_the_same_step():
    class Connecting(Model):
        STATE = ()

        def Load(self, file, node):
            self.AddBody(libgz.Body(self.world, dummy=True), True)
            self.seen = []

        def Update(self, step):
            if self.world.iterations == 3:
                end = self.world.events["WorldUpdateEnd"]
                self.connection = end.Connect(lambda: self.seen.append(self.world.iterations))

    with made("<model:Connecting><id>c</id></model:Connecting>", Connecting=Connecting) as world:
        world.Initialize()
        world.step(5)
        assert world.model("c").seen == [3, 4, 5]


MOVED = f"{HEAD}<model:GroundPlane/>{ROBOTS[0]}{ROBOTS[6]}</gz:world>"


def test_native_code_reads_what_was_moved(monkeypatch):
    """Bodies and joints of which the tables do not know yet where they are: after a pose is set, and after a reset."""
    with pair(MOVED) as worlds:
        together(worlds, lambda world: world.interface("position", "at").command(vx=0.3, vyaw=0.2))
        together(worlds, lambda world: world.step(40))
        called = python_of(worlds[0], monkeypatch)
        for moved in (
            lambda world: [world.SetModelPose(world.model(name), pose_at(1, 2, 0.1)) for name in ("at", "segway")],
            lambda world: world.body("at").SetLinearVel((0.1, 0.2, 0.0)),
        ):
            together(worlds, moved)
            together(worlds, lambda world: world.step(7))
            compare(worlds)
        assert {*called} == {"gps"}  # which publishes by Python
        together(worlds, lambda world: world.reset())
        together(worlds, lambda world: world.step(20))
        compare(worlds)
        assert worlds[0].get_state() == worlds[1].get_state()


def test_a_reset_keeps_rows_whose_laws_hold():
    with libgz.World.from_string(MOVED) as world:
        world.step(10)
        builds, start = world.rows.builds, world.engine.states.tobytes()
        for _ in range(2):
            world.Reset()
            world.step(10)
            assert (world.rows.builds, world.engine.states.tobytes()) == (builds, start)
        wheels = world.model("at", Pioneer2AT).wheels
        wheels.left.reverse()  # a list, which does not report it
        world.Reset()
        world.step(10)
        assert world.rows.builds == builds + 1
        world.set_state(world.get_state())
        world.step()
        assert world.rows.builds == builds + 1


def test_a_reset_builds_the_rows_of_users_models_again():
    """Nobody knows what their plans depend on."""
    world = made("<model:Hover><id>h</id></model:Hover>", Hover=Hover)
    world.Initialize()
    with world:
        world.step(2)
        builds = world.rows.builds
        world.Reset()
        world.step(2)
        assert world.rows.builds == builds + 1
