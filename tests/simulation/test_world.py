"""Worlds: loading, nesting, stepping, pause, reset, save, look-up, determinism."""

import logging
import math
import os
import subprocess
import sys
import textwrap

import pytest

import libgz
from libgz.base.errors import NotFoundError, ParameterError, WorldFileError
from libgz.base.geometry import GzPose, GzQuaternFromEuler, GzQuaternToEuler, GzVector, GzVectorSub

HEAD = """<gz:world xmlns:gz='g' xmlns:model='m' xmlns:param='p' xmlns:params='p'>"""


def world_of(body, **options):
    return libgz.World.from_string(f"{HEAD}{body}</gz:world>", **options)


SOLID = "<model:SimpleSolid><id>{0}</id><xyz>{1}</xyz>{2}</model:SimpleSolid>"
GROUND = "<model:GroundPlane><id>ground</id></model:GroundPlane>"


# Loading ---------------------------------------------------------------------------------------------------------


def test_global_settings():
    body = """<param:Global><speed>2</speed><stepTime>0.005</stepTime><gravity>0 0 -1.62</gravity><utmZone>11</utmZone>
    <fogDensity>0.1</fogDensity><skyColor>0 0 1</skyColor><dayTime>3600</dayTime></param:Global>"""
    with world_of(body) as world:
        assert world.engine.step_time == 0.005
        assert world.engine.gravity == (0, 0, -1.62)
        assert (world.simSpeed, world.utmZone.x, world.fogEnable, world.fogDensity) == (2, 11, True, 0.1)
        assert world.skyColor == libgz.GzColor(0, 0, 1)
        assert world.GetDayTime() == pytest.approx(3600, abs=5)


def test_defaults_without_settings():
    with world_of("") as world:
        assert (world.engine.step_time, world.engine.gravity) == (0.02, (0, 0, -9.8))
        assert world.fogEnable is False


def test_settings_of_04_and_their_order():
    with world_of(
        "<params:GlobalParams><gravity>0 0 -5</gravity><stepTime>0.005</stepTime></params:GlobalParams>"
    ) as world:
        assert (world.engine.gravity, world.engine.step_time) == ((0, 0, -5), 0.005)


def test_unknown_quirks_are_refused():
    with pytest.raises(WorldFileError, match="did you mean 'setMassZero'"):
        world_of("<param:Global><legacyQuirks>setMasZero noBounce</legacyQuirks></param:Global>")


def test_all_faults_of_a_world_at_once(caplog):
    body = textwrap.dedent("""
        <param:Global><stepTime>-1</stepTime></param:Global>
        <model:SimpleSolid><shape>blob</shape></model:SimpleSolid>
        <model:SimpleSolid><size>1 0 1</size></model:SimpleSolid>
        <model:Pioneer2AT><model:SickLMS200><parentBody>chasis</parentBody><rayCount>0</rayCount></model:SickLMS200></model:Pioneer2AT>
        <model:NoSuchThing/>
        <model:GroundPlane><texturFile>x.ppm</texturFile></model:GroundPlane>""")
    with pytest.raises(WorldFileError) as caught:
        world_of(body)
    lines = str(caught.value).splitlines()
    assert len(lines) == 5
    assert "<string>:2: <stepTime>: '-1' is not allowed; stepTime [s] must be above 0 and at most 1" in lines[0]
    assert "<string>:3: <shape>: 'blob' is not allowed; shape must be one of box, cylinder, sphere" in lines[1]
    assert "<string>:4: <size>: '1 0 1' is not allowed; size [m] must be above 0 each" in lines[2]
    assert "<string>:5: <model:SickLMS200>: body [chasis] not defined for model 'Pioneer2AT'" in lines[3]
    assert "<string>:5: <rayCount>: '0' is not allowed" in lines[4]
    assert "<model:NoSuchThing>: unknown model class" in caplog.text
    assert "<texturFile>: is not used by <model:GroundPlane>; did you mean 'textureFile'" in caplog.text


def test_a_model_that_is_skipped_is_an_element_all_the_same(caplog):
    with libgz.World.from_string("<w xmlns:model='m'><model:NoSuchThing/></w>"):
        assert "unknown model class" in caplog.text
        assert "there is no <model:...> element" not in caplog.text


def test_ids_and_names():
    with world_of(GROUND + "<model:Pioneer2AT><id> r </id></model:Pioneer2AT><model:SimpleSolid/>") as world:
        assert [m.GetId() for m in world.models] == ["ground", "r", "SimpleSolid"]
        assert world.model("r").GetName() == "Pioneer2AT"
        numbers = [m.GetIntId() for m in world.models]
        assert numbers == sorted(numbers)


def test_a_model_in_an_unknown_wrapper_is_top_level(caplog):
    with world_of(f"<group>{SOLID.format('a', '1 2 3', '')}</group>") as world:
        assert world.model("a").parent is None
    assert "<group>: is not used" in caplog.text


# Nesting ---------------------------------------------------------------------------------------------------------


def nested(extra=""):
    inner = "<model:SimpleSolid><id>inner</id><xyz>0 0 1</xyz><size>0.1 0.1 0.1</size></model:SimpleSolid>"
    middle = f"<model:SimpleSolid><id>middle</id><xyz>1 0 0</xyz><rpy>0 0 90</rpy>{inner}</model:SimpleSolid>"
    return world_of(
        f"<model:SimpleSolid><id>outer</id><xyz>0 0 5</xyz><rpy>0 0 90</rpy>{extra}{middle}</model:SimpleSolid>"
    )


def test_children_stand_in_their_parents_frame():
    with nested() as world:
        middle, inner = world.model("middle"), world.model("inner")
        assert tuple(middle.GetPose().pos) == pytest.approx((0, 1, 5))
        assert tuple(inner.GetPose().pos) == pytest.approx((0, 1, 6))
        assert GzQuaternToEuler(inner.GetPose().rot).z == pytest.approx(math.pi)
        assert (middle.parent.GetId(), inner.GetParentIntId()) == ("outer", middle.GetIntId())


def test_children_are_welded_and_fall_with_their_parent():
    with nested() as world:
        world.run(0.5)
        outer, inner = world.model("outer").GetPose(), world.model("inner").GetPose()
        assert outer.pos.z < 4.5
        assert tuple(inner.pos) == pytest.approx((outer.pos.x, outer.pos.y + 1, outer.pos.z + 1), abs=2e-3)


def test_moving_a_model_takes_its_children_along():
    with nested() as world:
        outer = world.model("outer")
        outer.GetBody().SetLinearVel((1, 1, 1))
        world.SetModelPose(outer, GzPose(GzVector(10, 0, 0), GzQuaternFromEuler(0, 0, 0)))
        assert tuple(world.model("inner").GetPose().pos) == pytest.approx((11, 0, 1))
        assert tuple(outer.GetBody().GetLinearVel()) == (0, 0, 0)


def test_moving_a_child_moves_its_weld():
    with nested() as world:
        world.SetModelPose(world.model("middle"), GzPose(GzVector(2, 0, 0)))
        world.run(0.3)
        offset = GzVectorSub(world.model("middle").GetPose().pos, world.model("outer").GetPose().pos)
        assert tuple(offset) == pytest.approx((0, 2, 0), abs=5e-3)


def test_a_dummy_child_follows_without_a_joint():
    light = "<model:LightSource><id>lamp</id><xyz>0 0 1</xyz></model:LightSource>"
    with world_of(f"<model:SimpleSolid><id>s</id><xyz>0 0 5</xyz>{light}</model:SimpleSolid>") as world:
        assert world.model("lamp").joint is None
        world.run(0.5)
        assert world.model("lamp").GetPose().pos.z == pytest.approx(world.model("s").GetPose().pos.z + 1)


def test_a_dummy_attached_at_run_time_follows():
    widget = "<model:TruthWidget><id>t</id><xyz>0 0 1</xyz></model:TruthWidget>"
    with world_of(widget + SOLID.format("s", "0 0 0", "<gravity>0</gravity>")) as world:
        truth, solid = world.model("t"), world.model("s")
        solid.GetBody().SetLinearVel((1.0, 0.0, 0.0))
        for steps in (5, 10):
            truth.SetParent(solid, solid.GetBody())
            truth.Attach()
            world.step(5)
            assert solid.GetPose().pos.x == pytest.approx(0.02 * steps)
            assert truth.GetPose().pos.x == pytest.approx(0.02 * steps)
            truth.Detach()
        world.step(5)
        assert truth.GetPose().pos.x == pytest.approx(0.2)


def test_a_model_attached_again_has_one_parent_and_one_weld():
    with world_of("".join(SOLID.format(name, f"{x} 0 5", "") for x, name in enumerate("abc", 1))) as world:
        a, b, c = (world.model(name) for name in "abc")
        before = len(world.engine.joints)
        for parent in (b, c, c):
            a.SetParent(parent, parent.GetBody())
            a.Attach()
            a.Attach()
        assert (b.children, c.children, len(world.engine.joints)) == ([], [a], before + 1)
        with pytest.raises(ParameterError, match=r"'c' cannot be attached to .*, which belongs to it"):
            c.SetParent(a, a.GetBody())
        with pytest.raises(ParameterError, match=r"'c' cannot be attached to .*, which belongs to it"):
            c.SetParent(c, c.GetBody())
        with pytest.raises(ParameterError, match="which is no body of <SimpleSolid"):
            c.SetParent(b, a.GetBody())
        world.set_state(world.get_state())


def test_parent_bodies_by_name():
    laser = "<model:SickLMS200><id>l</id><xyz>0 0 0.1</xyz><parentBody>head</parentBody></model:SickLMS200>"
    with world_of(f"<model:SonyVID30><id>c</id><xyz>0 0 1</xyz>{laser}</model:SonyVID30>") as world:
        assert world.model("l").parentBody is world.body("c", "head")
        assert world.model("l").joint.GetJointBody(1) is world.body("c", "head")


def test_gravity_and_enable_switches():
    body = SOLID.format("a", "0 0 5", "<gravity>false</gravity>") + SOLID.format("b", "3 0 5", "<enable>false</enable>")
    with world_of(body + SOLID.format("c", "6 0 5", "<enabled>0</enabled>") + SOLID.format("d", "9 0 5", "")) as world:
        world.run(0.5)
        heights = [world.model(i).GetPose().pos.z for i in "abcd"]
        assert heights[:3] == [5.0] * 3
        assert heights[3] < 4.0


def test_detach_lets_the_child_go():
    with nested() as world:
        inner = world.model("inner")
        inner.Detach()
        assert inner.parent is None
        inner.GetBody().SetLinearVel((3, 0, 0))
        world.run(0.2)
        assert inner.GetPose().pos.x == pytest.approx(0.6, abs=0.01)


# Time, pause, reset, save ----------------------------------------------------------------------------------------


def test_time_runs_by_steps():
    with world_of("") as world:
        world.step(100)
        assert world.GetSimTime() == pytest.approx(2.0)
        world.interface("sim", "default").paused = True
        world.step(10)
        assert (world.GetSimTime(), world.GetPauseTime()) == (pytest.approx(2.0), pytest.approx(0.2))
        sim = world.interface("sim", "default")
        assert (sim.sim_time, sim.pause_time) == (pytest.approx(2.0), pytest.approx(0.2))
        assert 0 < sim.real_time < 10


def test_a_paused_world_stands_still_and_calls_update_with_zero():
    seen = []

    class Watcher(libgz.Model):
        def Load(self, file, node):
            self.AddBody(libgz.Body(self.world), True)

        def Update(self, step):
            seen.append(step)

    libgz.GZ_REGISTER_STATIC("WatcherOfPauses", Watcher)
    with world_of("<param:Global><pause>true</pause></param:Global><model:WatcherOfPauses/>") as world:
        world.step(2)
        assert tuple(world.models[0].GetPose().pos) == (0, 0, 0)
        world.sim.data.pause = 0
        world.step(1)
    assert seen == [0.0, 0.0, 0.02]


def test_reset_puts_all_back_at_rest():
    with world_of(GROUND + SOLID.format("a", "0 0 3", "")) as world:
        world.run(0.4)
        assert world.model("a").GetPose().pos.z < 2.9
        world.interface("sim", "default").reset()
        world.step()
        assert world.model("a").GetPose().pos.z == pytest.approx(3 - 9.8 * 0.02**2)
        assert world.sim.data.reset == 0
        assert world.GetSimTime() == pytest.approx(0.42)


def test_reset_of_a_robot_with_a_laser_is_repeatable():
    text = (
        GROUND
        + "<model:Pioneer2AT><id>r</id><model:SickLMS200><xyz>.1 0 .311</xyz></model:SickLMS200></model:Pioneer2AT>"
    )
    with world_of(text) as world:
        world.interface("position", "r").command(vx=0.4, vyaw=0.3)
        world.run(3.0)
        world.reset()
        body = world.model("SickLMS200").GetPose()
        assert tuple(body.pos) == pytest.approx((0.1, 0, 0.311))
        world.run(1.0)
        assert tuple(world.model("SickLMS200").GetPose().rot) == pytest.approx(
            tuple(world.model("r").GetPose().rot), abs=1e-2
        )


SAVED = """<?xml version="1.0"?>
<gz:world xmlns:gz='g' xmlns:model='m'>
  <!-- the ground -->
  <model:GroundPlane/>
  <model:SimpleSolid>
    <id>falls</id>
    <xyz>1 2 0.5</xyz> <!-- high up -->
    <rpy>0 0 30</rpy>
    <model:SimpleSolid><id>child</id><xyz>0 0 0.5</xyz><size>.1 .1 .1</size></model:SimpleSolid>
  </model:SimpleSolid>
</gz:world>
"""


def test_models_are_moved_natively_as_in_python(monkeypatch):
    states = []
    for native in (True, False):
        with libgz.World.from_file("pioneer2at") as world:
            world.step(5)
            if not native:
                monkeypatch.setattr(world.engine, "carry_bodies", lambda *_: 0)
            pose = GzPose(GzVector(1.1, -0.7, 0.9), GzQuaternFromEuler(0.3, -0.2, 2.0))
            world.SetModelPose(world.model("robot1"), pose)
            states.append([world.get_state(), world.step(5), world.get_state()])
    assert states[0] == states[1]


def test_save_writes_poses_of_top_level_models(tmp_path):
    path = tmp_path / "w.world"
    path.write_text(SAVED)
    with libgz.World.from_file(path) as world:
        # Soft landing: the box's default springs would throw it about for a while.
        for model in world.models[1:]:
            model.geom.SetHardness(1e5, 1e3)
        world.run(4.0)
        world.interface("sim", "default").save()
        world.step()
        text = path.read_text()
        assert world.model("falls").initPose.pos.z == pytest.approx(0, abs=1e-3)
        world.Save()
        assert path.read_text() == text
    assert "<!-- high up -->" in text
    assert "<xyz>0 0 0.5</xyz><size>" in text  # children keep theirs
    again = libgz.World.from_file(path)
    assert tuple(again.model("falls").GetPose().pos) == pytest.approx((1, 2, 0), abs=2e-3)
    assert GzQuaternToEuler(again.model("falls").GetPose().rot).z == pytest.approx(math.radians(30), abs=1e-3)
    again.close()


def test_saving_an_old_file_keeps_its_origins(tmp_path):
    path = tmp_path / "old.world"
    path.write_text(
        f"{HEAD}<model:SimpleSolid><id>a</id><cfm>.01</cfm><gravity>0</gravity><xyz>1 0 0.25</xyz></model:SimpleSolid>"
        "</gz:world>"
    )
    with libgz.World.from_file(path) as world:
        assert world.model("a").GetPose().pos.z == pytest.approx(0.0)
        world.Save()
        assert "<xyz>1 0 0.25</xyz>" in path.read_text()  # it has not moved
        world.model("a").SetPose(libgz.GzPose((1.0 / 3.0, 0.0, 0.0)))
        world.Save()
    assert "<xyz>0.3333333333333333 0 0.25</xyz>" in path.read_text()
    assert "<xyz>1 0 0.25</xyz>" in path.with_name("old.world.bak").read_text()


ONE_MODEL = {
    "legacy": f"{HEAD}<model:SimpleSolid><id>a</id></model:SimpleSolid></gz:world>",
    "sdf": "<sdf version='1.6'><world name='w'><model name='a'><link name='l'/></model></world></sdf>",
}


@pytest.mark.parametrize("text", ONE_MODEL.values(), ids=ONE_MODEL)
@pytest.mark.parametrize("kind", ["link", "pipe"])
def test_what_has_the_name_of_the_backup_is_replaced(tmp_path, text, kind):
    """The folder may be a stranger's, whose link names a file of the user."""
    path, backup, own = tmp_path / "a.world", tmp_path / "a.world.bak", tmp_path / "own"
    path.write_text(text)
    own.write_text("mine")
    backup.symlink_to(own) if kind == "link" else os.mkfifo(backup)
    with libgz.World.from_file(path) as world:
        (model,) = world.models
        model.SetPose(GzPose(GzVector(3.0, 0.0, 0.5)))
        assert world.Save(whole=True) == 0
    assert own.read_text() == "mine"
    assert backup.read_text() == text
    assert not backup.is_symlink()
    assert path.read_text() != text


@pytest.mark.parametrize("text", ONE_MODEL.values(), ids=ONE_MODEL)
def test_a_pipe_in_place_of_the_file_is_not_written_to(tmp_path, text, caplog):
    """A server would wait until it is read."""
    path = tmp_path / "a.world"
    path.write_text(text)
    with libgz.World.from_file(path) as world:
        path.unlink()
        os.mkfifo(path)
        reading = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
        try:
            world.models[0].SetPose(GzPose(GzVector(3.0, 0.0, 0.5)))
            assert world.Save(whole=True) == -1
            assert os.read(reading, 100) == b""
        finally:
            os.close(reading)
    assert "ERROR" in caplog.text


def test_old_files_count_children_from_old_origins():
    body = """<model:Pioneer2AT><id>r</id><xyz>0 0 0.195</xyz>
    <model:SickLMS200><id>l</id><xyz>0.15 0 0.20</xyz><updatePeriod>0.1</updatePeriod></model:SickLMS200>
    </model:Pioneer2AT>"""
    with world_of(body) as world:
        assert world.model("r").GetPose().pos.z == pytest.approx(0.0)
        assert world.model("l").GetPose().pos.z == pytest.approx(0.295)


def test_saving_fails_in_words(tmp_path, caplog):
    path = tmp_path / "w.world"
    path.write_text(SAVED)
    with libgz.World.from_file(path) as world:
        path.unlink()
        tmp_path.joinpath("w.world").mkdir()
        assert world.Save() == -1
        assert "unable to save" in caplog.text
        world.step()


# Look-up ---------------------------------------------------------------------------------------------------------


def test_look_up():
    with world_of("<model:Pioneer2AT><id>robot1</id></model:Pioneer2AT>") as world:
        robot = world.model("robot1")
        assert world.body("robot1") is robot.GetBody("canonical") is robot.GetBody("chassis") is robot.GetBody()
        assert world.body("robot1", "left_rear").mass == pytest.approx(1.0)
        assert world.joint("robot1", "left_front").GetJointBody(1) is robot.GetBody()
        assert len(robot.joints) == 4
        with pytest.raises(NotFoundError, match="did you mean 'robot1'"):
            world.model("robt1")
        with pytest.raises(NotFoundError, match="did you mean 'left_rear'"):
            world.body("robot1", "left_reer")
        with pytest.raises(NotFoundError, match="did you mean 'right_rear'"):
            world.joint("robot1", "right_rer")
        with pytest.raises(libgz.InterfaceError, match=r"did you mean 'position\.robot1'"):
            world.interface("position", "robot")


def test_closing_twice_and_leaving_early():
    world = world_of(GROUND)
    world.step()
    world.close()
    world.close()
    with pytest.raises(libgz.ClosedError):
        world.step()


# Determinism -----------------------------------------------------------------------------------------------------

DETERMINISM = """
import sys, zlib, libgz
text = sys.stdin.read()
world = libgz.World.from_string(text, seed=5)
robot = world.interface("position", "robot1")
for k in range(50):
    robot.command(vx=0.1 * (k % 5), vyaw=0.2 * (k % 3 - 1))
    world.step(100)
laser = world.interface("laser", "laser1")
print(zlib.crc32(world.engine.states.tobytes()), zlib.crc32(laser.ranges.tobytes()))
"""


def test_same_world_same_bits_in_every_process():
    solids = "".join(
        SOLID.format(f"s{i}", f"{1 + i % 3} {i / 3 - 1} {0.2 * i}", "<size>.3 .3 .3</size>") for i in range(8)
    )
    body = """<model:Pioneer2AT><id>robot1</id><model:SickLMS200><id>laser1</id><xyz>0.1 0 0.311</xyz>
    </model:SickLMS200></model:Pioneer2AT>"""
    text = f"{HEAD}{GROUND}{body}{solids}</gz:world>"
    outcomes = set()
    for _ in range(2):
        done = subprocess.run(
            [sys.executable, "-c", DETERMINISM],
            input=text,
            capture_output=True,
            text=True,
            timeout=300,
            env={"PATH": "/usr/bin"},
        )
        assert done.returncode == 0, done.stderr
        outcomes.add(tuple(done.stdout.split()[:2]))
    assert len(outcomes) == 1


def test_warnings_are_logged_once_each(caplog):
    with caplog.at_level(logging.WARNING):
        world_of(SOLID.format("a", "1 x 2", "")).close()
    assert caplog.text.count("'x' is not a number") == 1


# Out of the world ------------------------------------------------------------------------------------------------


def test_a_body_that_falls_out_of_the_world_is_reported_once(caplog):
    solids = SOLID.format("falling", "0 0 -990", "") + SOLID.format("resting", "9 0 0.5", "<gravity>false</gravity>")
    with caplog.at_level(logging.WARNING, "libgz"), world_of(solids) as world:
        world.step(1000)
        (line,) = [record.getMessage() for record in caplog.records if "fell" in record.getMessage()]
        assert line == "falling::canonical fell below -1000 m: is there ground under it?"
        world.DeleteModel("falling")
        world.step(512)


def test_many_bodies_that_fall_are_one_message(caplog):
    solids = "".join(SOLID.format(f"s{i}", f"{2 * i} 0 -1100", "") for i in range(8))
    with caplog.at_level(logging.WARNING, "libgz"), world_of(solids) as world:
        world.step(1000)
        (line,) = [record.getMessage() for record in caplog.records if "fell" in record.getMessage()]
        assert "s4::canonical and 3 more bodies fell below" in line


def test_falls_of_a_world_that_is_reset_again_and_again_are_counted(caplog):
    with caplog.at_level(logging.WARNING, "libgz"), world_of(SOLID.format("s", "0 0 -1100", "")) as world:
        for _ in range(120):
            world.step(260)
            world.reset()
    lines = [record.getMessage() for record in caplog.records if "fell" in record.getMessage()]
    assert len(lines) == 2
    assert lines[1] == "s::canonical fell below -1000 m (100 times so far): is there ground under it?"


@pytest.mark.trial
def test_falls_of_ever_new_bodies_are_counted(caplog):
    with caplog.at_level(logging.WARNING, "libgz"), world_of("") as world:
        for number in range(150):
            world.InsertModel(SOLID.format(f"s{number}", "0 0 -1100", ""))
            world.step(256)
            world.DeleteModel(f"s{number}")
    assert len([record for record in caplog.records if "fell" in record.getMessage()]) <= 102


def test_changes_that_lead_to_others_without_an_end_are_left_out(caplog):
    done = []

    def again():
        done.append(1)
        world.after_step(again)

    with libgz.World.from_string("<sdf version='1.6'><world name='w'/></sdf>") as world:
        world.after_step(again)
        assert 50 < len(done) < 1000
        assert "changes lead to others without an end" in caplog.text
        world.after_step(lambda: done.clear())  # others are done as before
        assert not done
        world.step(1)
