"""The ready plugins where worlds use them in unusual ways, or wrongly."""

import json

import pytest
from plugin_worlds import HINGE, body, collision, plugin

from libgz.base.errors import ClosedError
from libgz.classic import msgs, transport


def listen(topic, received):
    node = transport.Node()
    node.Init("default")
    return node, node.Subscribe(topic, received.append)


# Events --------------------------------------------------------------------------------------------------------------


def sim_events(*events):
    region = "<region><name>r</name><volume><min>1 1 1</min><max>-1 -1 -1</max></volume></region>"
    inside = "".join(f"<event><name>e</name>{event}</event>" for event in events)
    return f"<plugin name='events' filename='libSimEventsPlugin.so'>{region}{inside}</plugin>"


def test_a_removed_light_is_not_reported_as_a_model(run):
    core, world = run(body("stone"), "<light name='lamp' type='point'/>", sim_events("<type>existence</type>"))
    received = []
    kept = listen("/gazebo/sim_events", received)
    for name in ("lamp", "stone"):
        world.RemoveModel(name)
        core.step()
    assert [json.loads(message.data)["model"] for message in received] == ["stone"]
    del kept


def test_corners_of_a_region_in_any_order(run):
    event = "<type>inclusion</type><model>stone</model><region>r</region>"
    core, _ = run(body("stone", gravity="false"), sim_events(event))
    received = []
    kept = listen("/gazebo/sim_events", received)
    core.step(2)
    assert [json.loads(message.data)["state"] for message in received] == ["inside"]
    del kept


@pytest.mark.parametrize(
    ("event", "tag"),
    [
        ("<type>inclusion</type><region>r</region>", "model"),
        ("<type>joint</type><joint>j</joint><range><type>position</type></range>", "model"),
        ("<type>joint</type><model>stone</model><range><type>position</type></range>", "joint"),
        ("<type>occupied</type><region>r</region><msg_data>yes</msg_data>", "topic"),
    ],
)
def test_missing_elements_of_an_event_are_reported(event, tag, run, caplog):
    run(body("stone"), sim_events(event))
    assert f"and requires a <{tag}>" in caplog.text


# Sensors -------------------------------------------------------------------------------------------------------------


def test_hooks_tell_that_a_sensor_is_not_theirs(run, caplog):
    for kind, name in (("imu", "CameraPlugin"), ("sonar", "ForceTorquePlugin"), ("imu", "ContactPlugin")):
        caplog.clear()
        run(body("thing", link=f"<sensor name='s' type='{kind}'>{plugin(name)}</sensor>"))
        assert f"{name} is for sensors of type" in caplog.text
        assert f"default::thing::link::s is of type {kind}" in caplog.text


FRAMES = """
from libgz.classic import GZ_REGISTER_SENSOR_PLUGIN
from libgz.classic.plugins.hooks import {base}

class Frames({base}):
    def {hook}(self, data, width, height, depth, image_format):
        print(len(data) // (width * height), width, height, image_format)

GZ_REGISTER_SENSOR_PLUGIN(Frames)
"""
SIZE = "<image><width>8</width><height>6</height></image>"
ROW = "<scan><horizontal><samples>5</samples></horizontal></scan><range><min>0.1</min><max>9</max></range>"


@pytest.mark.parametrize(
    ("kind", "base", "hook", "inside", "found"),
    [
        ("depth", "DepthCameraPlugin", "OnNewRGBPointCloud", f"<camera>{SIZE}</camera>", "4 8 6 RGBPOINTS"),
        ("gpu_ray", "GpuRayPlugin", "OnNewLaserFrame", f"<ray>{ROW}</ray>", "3 5 1 FLOAT32_RGB"),
    ],
)
def test_clouds_and_laser_frames_are_made_if_a_callback_uses_them(
    kind, base, hook, inside, found, run, tmp_path, monkeypatch, capsys
):
    (tmp_path / "frames.py").write_text(FRAMES.format(base=base, hook=hook))
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", str(tmp_path))
    core, _ = run(body("eye", link=f"<sensor name='s' type='{kind}'>{inside}{plugin('frames')}</sensor>"))
    core.step()
    assert capsys.readouterr().out.strip() == found


# Wings ---------------------------------------------------------------------------------------------------------------


def test_parallel_directions_of_a_wing_are_reported(run, caplog):
    run(body("plane", inside=plugin("LiftDragPlugin", link_name="link", upward="2 0 0")))
    assert "<forward> and <upward> must be two directions" in caplog.text


@pytest.mark.parametrize(
    ("given", "force", "words"),
    [
        ("<volume>-1</volume>", 0.5, "<volume> is -1 m^3; it must be positive"),
        ("<center_of_volume>0 0 1</center_of_volume>", 0.5, "<volume> is 0 m^3"),
        ("<volume>2</volume>", 2.0, ""),
    ],
)
def test_missing_volumes_of_a_link_are_those_of_its_collisions(given, force, words, run, caplog):
    shape = collision("<box><size>1 1 0.5</size></box>", pose="0 0.2 0 0 0 0")
    text = plugin("BuoyancyPlugin", fluid_density=10).replace("</plugin>", f"<link name='link'>{given}</link></plugin>")
    core, world = run(body("raft", mass=1.0, link=shape, inside=text))
    core.step()
    assert world.ModelByName("raft").WorldLinearVel().Z() == pytest.approx((force * 10.0 - 1.0) * 9.8e-3, abs=1e-6)
    assert words in caplog.text
    if given == "<volume>2</volume>":  # at the middle of the box
        assert world.ModelByName("raft").WorldAngularVel().X() == pytest.approx(0.2 * 20.0 * 9.8e-3, abs=1e-6)


# Names and ends ------------------------------------------------------------------------------------------------------


def test_a_model_is_not_mistaken_for_a_part_of_another_one(run):
    shape = collision("<box><size>1 1 1</size></box>", name="crate")
    core, world = run(body("cart", link=shape), body("crate"), body("wheel", inside=HINGE.format(name="cart")))
    assert world.EntityByName("crate") is world.ModelByName("crate")
    assert world.BaseByName("cart") is world.ModelByName("cart")
    node = transport.Node()
    node.Init("default")
    publisher = node.Advertise(msgs.Request, "~/request")
    publisher.Publish(msgs.Request(id=1, request="entity_delete", data="crate"))
    core.step(2)
    assert [model.GetName() for model in world.Models()] == ["cart", "wheel"]
    assert world.EntityByName("crate").GetScopedName() == "cart::link::crate"


def test_a_world_of_a_moment_ends_without_a_word(run, caplog):
    for _ in range(5):
        core, _ = run(body("stone"))
        core.close()
    assert not caplog.records


def test_what_was_removed_is_not_taken_for_what_came_after_it(run):
    core, world = run(body("old", "1 0 0 0 0 0", inside=HINGE.format(name="j"), gravity="false"))
    link, joint = world.ModelByName("old").GetLink(), world.ModelByName("old").GetJoint("j")
    world.RemoveModel("old")
    text = body("new", "7 0 0 0 0 0", inside=HINGE.format(name="j"), gravity="false")
    world.InsertModelString(f"<sdf version='1.6'>{text}</sdf>")
    world.ModelByName("new").GetJoint("j").SetPosition(0, 0.5)
    core.step()
    with pytest.raises(ClosedError, match="'link' was closed"):
        link.WorldPose()
    assert joint.Position(0) == 0.0
