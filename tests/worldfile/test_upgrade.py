"""libgz upgrade: the newer spelling has the same meaning and keeps the layout of the old file."""

import dataclasses
import itertools

import numpy as np
import pytest
from commands import run_libgz

import libgz
from libgz.base.files import installed_worlds
from libgz.legacy.settings import read_global
from libgz.worldfile.attributes import read
from libgz.worldfile.file import WorldFile
from libgz.worldfile.upgrade import upgrade

HEAD = """<?xml version="1.0"?>
<gz:world
  xmlns:gz='http://playerstage.sourceforge.net/gazebo/xmlschema/#gz'
  xmlns:model='http://playerstage.sourceforge.net/gazebo/xmlschema/#model'
  xmlns:params='http://playerstage.sourceforge.net/gazebo/xmlschema/#params'>
"""
OLD = (
    HEAD
    + """
  <params:GlobalParams>
    <gravity>0 0 -9.0</gravity> <!-- a lighter planet -->
    <stepTime>0.01</stepTime>
  </params:GlobalParams>

  <!-- the watcher -->
  <model:ObserverCam>
    <id>watcher</id>
    <updatePeriod>.100<!-- ten a second --></updatePeriod>
    <shadeModel>flat</shadeModel>
    <polygonMode>fill</polygonMode>
    <displayLaser>true</displayLaser>
    <lens>
      <hfov>70</hfov>
      <vfov>60</vfov> <!-- follows from hfov -->
      <nearClip>0.2</nearClip>
    </lens>
    <window>
      <title>Watcher</title>
      <size>640 480</size>
      <xyz>0 0</xyz>
    </window>
  </model:ObserverCam>

  <model:GroundPlane><id>ground</id><cfm>0.01</cfm></model:GroundPlane>

  <model:Pioneer2AT>
    <id>robot</id>
    <xyz>1 2 0.3</xyz>
    <rpy>0 10 45</rpy>
    <model:SickLMS200>
      <id>laser</id>
      <xyz>0.15 0 0.20</xyz>
      <rpy>5 0 0</rpy>
      <model:SonyVID30>
        <id>camera</id>
        <xyz>0 0 .1</xyz>
        <imgSize>320 200</imgSize>
        <imageSize>160 120</imageSize>
        <lens><hfov>50</hfov><farClip>20.0</farClip></lens>
      </model:SonyVID30>
    </model:SickLMS200>
  </model:Pioneer2AT>

  <model:SimpleSolid>
    <id>box</id>
    <xyz> 2.0 0.0 .25 </xyz>
    <size>1.10 1.10 .5</size>
    <cfm>1e-4</cfm>
    <canBeGrip>yes</canBeGrip>
    <model:SimpleSolid><id>ball</id>
      <shape>sphere</shape><size>.2</size><pos>0 0 .35</pos><rot>0 0 90</rot></model:SimpleSolid>
  </model:SimpleSolid>

  <model:SickLMS200/>
</gz:world>
"""
)


def file_of(text, name="old.world"):
    file = WorldFile()
    file.LoadString(text, name)
    return file


def upgraded(text):
    new, changes = upgrade(file_of(text))
    return new.decode(), changes


def meaning(text):
    """(settings, for each model its kind, id, pose and attributes)."""
    file = file_of(text)
    with libgz.World() as world:
        world.Load(file)
        models = [
            (m.GetName(), m.GetId(), m.GetPose(), dataclasses.asdict(read(m.attributes, m.node))) for m in world.models
        ]
    return read_global(file), models, file


def assert_same_meaning(old, new):
    (settings, models, _), (new_settings, new_models, new_file) = meaning(old), meaning(new)
    assert settings == new_settings
    assert len(models) == len(new_models)
    for (kind, id_, pose, values), (new_kind, new_id, new_pose, new_values) in zip(models, new_models, strict=True):
        assert (kind, id_) == (new_kind, new_id)
        assert tuple(new_pose.pos) == pytest.approx(tuple(pose.pos), abs=1e-8), id_
        assert tuple(new_pose.rot) == pytest.approx(tuple(pose.rot), abs=1e-12), id_
        assert values == new_values, id_
    assert not new_file.is_old
    assert not new_file.diagnostics.found


def test_poses_and_attributes_are_the_same():
    new, _ = upgraded(OLD)
    assert_same_meaning(OLD, new)


def test_the_newer_spelling_replaces_the_old_one_in_place():
    new, changes = upgraded(OLD)
    lines = [line.strip() for line in new.splitlines()]
    start = lines.index("<model:ObserverCam>")
    assert lines[start : start + 12] == [
        "<model:ObserverCam>",
        "<id>watcher</id>",
        "<updateRate>10.0 <!-- ten a second --></updateRate>",
        "<shadeSmooth>false</shadeSmooth>",
        "<polygonFill>true</polygonFill>",
        "<displayRays>true</displayRays>",
        "<hfov>70</hfov>",
        "<!-- follows from hfov -->",
        "<nearClip>0.2</nearClip>",
        "<imageSize>640 480</imageSize>",
        "</model:ObserverCam>",
        "",
    ]
    assert "\n    <hfov>70</hfov>\n" in new  # indented as <lens> was
    assert "<gravity>0 0 -9.0</gravity> <!-- a lighter planet -->" in new
    assert "<param:Global>" in new
    assert "xmlns:param='http" in new
    assert "params" not in new.replace("#params", "")
    assert "<xyz> 2.0 0.0 0 </xyz>" in new
    assert "<imageSize>160 120</imageSize>" in new
    assert new.count("surfaceHardness") == 2
    assert "cfm" not in new
    assert "<xyz>0 0 -0.1</xyz>" in new  # the laser that had no xyz
    for comment in ("<!-- the watcher -->", "<!-- ten a second -->", "<!-- follows from hfov -->"):
        assert comment in new
    notes = [str(change) for change in changes]
    assert any(line.startswith("old.world:15: <updatePeriod>: ") and "<updateRate> 10.0" in line for line in notes)
    assert [change.line for change in changes] == sorted(change.line for change in changes)


def test_upgrading_twice_changes_nothing_more():
    new, _ = upgraded(OLD)
    assert upgraded(new) == (new, [])


def test_ready_worlds_need_no_change():
    for path in installed_worlds().glob("*.world"):
        file = WorldFile.from_file(path)
        assert upgrade(file) == (path.read_bytes(), [])


SNIPPETS = (
    "<lens><hfov>50</hfov></lens>",
    "<lens>\n<!-- why --><nearClip>1</nearClip></lens>",
    "<window><title>t</title></window>",
    "<window><size>64 48</size><oddity>1</oddity></window>",
    "<imgSize>32 24</imgSize>",
    "<updatePeriod>0.5</updatePeriod><updatePeriod>0.25</updatePeriod>",
    "<updateRate>7</updateRate>",
    "<xyz>1 2 3</xyz>",
    "<displayLaser>false</displayLaser>",
)


@pytest.mark.parametrize("count", [0, 1, 2, pytest.param(3, marks=pytest.mark.trial)])
def test_all_mixtures_have_the_same_meaning(count):
    for some in itertools.combinations(SNIPPETS, count):
        body = "".join(some)
        models = f"<model:SonyVID30>{body}</model:SonyVID30><model:SickLMS200 xyz='0 0 1'>{body}</model:SickLMS200>"
        text = f"{HEAD}{models}</gz:world>"
        new, _ = upgraded(text)
        (_, models, _), (_, new_models, file) = meaning(text), meaning(new)
        assert not file.is_old
        assert [m[3] for m in models] == [m[3] for m in new_models], some
        for old, fresh in zip(models, new_models, strict=True):
            assert tuple(fresh[2].pos) == pytest.approx(tuple(old[2].pos), abs=1e-8), some


RULES = {
    "origin of a solid": "<model:SimpleSolid><xyz>0 0 1</xyz><rpy>9 8 7</rpy><size>.3 .4 .7</size></model:SimpleSolid>",
    "origins of parents": "<model:Pioneer2AT><xyz>0.1 5 0.11</xyz><rpy>0 5 77</rpy><model:SickLMS200><xyz>.1 0 .1</xyz>"
    "<model:SimpleSolid><xyz>0 0 0.7</xyz><size>1 1 1</size></model:SimpleSolid></model:SickLMS200></model:Pioneer2AT>",
    "places of 0.3": "<model:SimpleSolid><pos>0 1 0.77</pos><rot>0 0 30</rot><shape>sphere</shape></model:SimpleSolid>",
    "softness": "<model:SimpleSolid><cfm>.003</cfm><xyz>0 0 .6</xyz></model:SimpleSolid>",
    "softness of nothing": "<model:SimpleSolid><cfm>0</cfm><xyz>0 0 .6</xyz></model:SimpleSolid>",
    "landing": "<model:SegwayRMP><xyz>0 0 0.2</xyz></model:SegwayRMP>",
    "no landing": "<model:SegwayRMP><softLanding>false</softLanding><xyz>0 0 0.2</xyz></model:SegwayRMP>",
    "rate": "<model:Pioneer2DX><updatePeriod>0.3</updatePeriod></model:Pioneer2DX>",
    "model of a plugin on a moved one": "<model:Pioneer2AT>"
    "<model:Ball><plugin>Ball.py</plugin><xyz>0 0 1</xyz></model:Ball></model:Pioneer2AT>",
}
BALL = """
from libgz import Body, GZ_REGISTER_PLUGIN, Model, SphereGeom
class Ball(Model):
    def Load(self, file, node):
        body = Body(self.world)
        self.AddBody(body, True)
        SphereGeom(body, self.modelSpaceId, 0.1).SetMass(1.0)
GZ_REGISTER_PLUGIN("Ball", Ball)
"""


def motion(path, text):
    """Places and velocities of all bodies in 60 steps, to the bit; -0 is 0."""
    path.write_text(text)
    with libgz.World.from_file(path) as world:
        frames = []
        for _ in range(6):
            world.step(10)
            for body in world.engine.bodies.values():
                frames.append([*body.GetPose().pos, *body.GetPose().rot, *body.GetLinearVel(), *body.GetAngularVel()])
        return (np.array(frames) + 0.0).tobytes()


@pytest.mark.parametrize("rule", RULES)
def test_an_upgraded_file_moves_as_before_to_the_bit(rule, tmp_path):
    (tmp_path / "Ball.py").write_text(BALL)
    text = f"""<gz:world xmlns:gz='g' xmlns:model='m' version='0.4'><model:GroundPlane><id>g</id></model:GroundPlane>
{RULES[rule]}</gz:world>"""
    new, changes = upgraded(text)
    assert changes
    assert not file_of(new).is_old
    assert motion(tmp_path / "old.world", text) == motion(tmp_path / "new.world", new)


def test_how_a_segway_lands_is_written_into_the_file(tmp_path):
    text = f"{HEAD}<model:GroundPlane/>{RULES['landing']}</gz:world>"
    new, _ = upgraded(text.replace("<gz:world", "<gz:world version='0.4'"))
    written = "<softLanding>true</softLanding>"
    assert written in new
    assert motion(tmp_path / "a.world", new) != motion(tmp_path / "a.world", new.replace(written, ""))


def test_a_file_whose_models_ended_with_0_4_is_marked():
    text = f"{HEAD}<model:MapExtruder/><model:SimpleSolid><id>box</id><xyz>0 0 1</xyz></model:SimpleSolid></gz:world>"
    new, changes = upgraded(text)
    assert ' version="0.5">' in new
    assert "<xyz>0 0 0.75</xyz>" in new
    assert any("marked as version" in str(change) for change in changes)
    assert not file_of(new).is_old
    assert upgraded(new)[1] == []


def test_an_older_mark_is_replaced():
    head = """<gz:world xmlns:gz='g' xmlns:model='m' note=' version="1"' version='0.4'>"""
    new, _ = upgraded(f"{head}<model:SimpleSolid><xyz>0 0 1</xyz></model:SimpleSolid></gz:world>")
    assert new.startswith(head.replace("0.4", "0.5"))
    assert "<xyz>0 0 0.75</xyz>" in new
    assert not file_of(new).is_old


def test_a_place_is_added_before_what_is_removed_beside_it():
    text = (
        f"{HEAD}<model:SickLMS200 xyz='0 0 1'><updatePeriod>1</updatePeriod>"
        "<model:GroundPlane><cfm>.01</cfm></model:GroundPlane></model:SickLMS200></gz:world>"
    )
    new, _ = upgraded(text)
    assert "<model:GroundPlane><xyz>0 0 0.1</xyz></model:GroundPlane>" in new


def test_models_of_plugins_stay_as_they_are():
    text = (
        f"{HEAD}<model:Ball><plugin>Ball.py</plugin><lens><hfov>3</hfov></lens><xyz>0 0 1</xyz></model:Ball></gz:world>"
    )
    new, changes = upgraded(text)
    assert "<lens><hfov>3</hfov></lens><xyz>0 0 1</xyz>" in new
    assert not file_of(new).is_old
    assert len(changes) <= 1


def test_the_command(tmp_path):
    old, new = tmp_path / "old.world", tmp_path / "new.world"
    old.write_text(OLD)
    printed = run_libgz("upgrade", old)
    assert printed.returncode == 0
    assert f"{old}:7: <params:GlobalParams>: renamed to <param:Global>" in printed.stderr
    assert run_libgz("upgrade", old, "-o", new).returncode == 0
    assert new.read_text() == printed.stdout
    assert old.read_text() == OLD
    assert run_libgz("upgrade", old, "--in-place").returncode == 0
    assert old.read_text() == printed.stdout
    assert "nothing to change" in run_libgz("upgrade", old, "--in-place").stderr
    assert "cannot write" in run_libgz("upgrade", old, "-o", tmp_path / "no" / "new.world").stderr
    assert run_libgz("upgrade", old, "-o", new, "--in-place").returncode == 2


def test_an_empty_element_gets_its_new_value_inside():
    new, _ = upgraded(f"{HEAD}<model:MonoCam><updatePeriod/></model:MonoCam></gz:world>")
    assert "<updateRate>0</updateRate>" in new
