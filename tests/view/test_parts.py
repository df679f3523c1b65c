"""What users of the page move, without a browser: interfaces, joints and lights of models."""

import json
import math

import numpy as np
import pytest

import libgz
from libgz.apps.world_control import WorldControl
from libgz.base.errors import GazeboError, NotFoundError, ParameterError
from libgz.base.files import installed_worlds
from libgz.classic.gui import GUI
from libgz.transport.control import Request
from libgz.view.parts import interface_parts

LIGHT = """<light name="lamp" type="point"><pose>0 0 3 0 0 0</pose><diffuse>0.8 0.4 0.2 1</diffuse></light>"""
ARM = f"""<sdf version="1.6"><world name="w"><gravity>0 0 -9.8</gravity>{LIGHT}<model name="arm">
<link name="base"><inertial><mass>5</mass></inertial></link><link name="upper">
<pose>0.5 0 0 0 0 0</pose></link><joint name="fixed" type="fixed"><parent>world</parent>
<child>base</child></joint><joint name="elbow" type="revolute"><parent>base</parent><child>upper</child>
<pose>-0.5 0 0 0 0 0</pose><axis><xyz>0 1 0</xyz><limit><lower>-1</lower><upper>1</upper></limit></axis>
</joint></model></world></sdf>"""


@pytest.fixture
def world():
    with libgz.World.from_string(ARM) as found:
        yield found


def send(control, verb, **content):
    answer = control.obey(Request(verb, "-", json.dumps(content).encode()))
    return json.loads(answer) if answer else None


def test_joint_interfaces_have_sliders():
    with libgz.World.from_file(installed_worlds() / "bandit.world") as world:
        joints = world.interface("joint", "robot1")
        world.step(60)
        parts = interface_parts(joints)
        labels = {part.label: part for part in parts}
        assert len(labels) == 14  # 11 joints, of which 3 have two axes
        labels["robot1 joint 4"].action(0.3)
        labels["robot1 joint 4 axis 2"].action(0.2)
        world.step(150)
        assert joints.joints[4]["angle"] == pytest.approx(0.3, abs=0.1)
        assert joints.joints[4]["angle2"] == pytest.approx(0.2, abs=0.1)


def test_images_and_plots_that_cannot_be_shown_are_refused():
    overlay = GUI("status")
    with pytest.raises(ParameterError, match=r"it must be \(height, width\)"):
        overlay.SetImage("camera", np.zeros((4, 6, 2)))
    with pytest.raises(ParameterError, match=r"'z' \(2,\)"):
        overlay.SetPlot("height", [0, 1, 2], {"z": [3, 4]})
    with pytest.raises(ParameterError, match="it got none"):
        overlay.SetPlot("height", [0, 1, 2])


def test_a_joint_is_moved_held_and_released(world):
    control = WorldControl(world)

    def run(steps):
        for _ in range(steps):
            control.stepped()
            world.step()

    elbow = world.model("arm").sdf_joints["elbow"]
    send(control, "joint", name="arm", joint="elbow", axis=0, position=-0.7)
    run(3000)
    assert elbow.position() == pytest.approx(-0.7, abs=0.01)  # against gravity
    send(control, "joint", name="arm", joint="elbow", axis=0, position=9.0)
    run(3000)
    assert elbow.position() == pytest.approx(1.0, abs=0.02)  # its limit
    send(control, "joint", name="arm", joint="elbow", axis=0, position=0.0)
    run(3000)
    send(control, "release", name="arm")
    run(1000)
    assert elbow.position() > 0.5  # it fell
    with pytest.raises(NotFoundError, match="did you mean 'elbow'"):
        send(control, "joint", name="arm", joint="elbov", axis=0, position=0.0)
    for wrong in ({"axis": 1}, {"position": math.inf}, {"joint": "fixed"}, {"position": "far"}):
        with pytest.raises(GazeboError):
            send(control, "joint", **({"name": "arm", "joint": "elbow", "axis": 0, "position": 0.0} | wrong))


def test_the_colour_of_a_light(world):
    control = WorldControl(world)
    send(control, "light", name="lamp", color=[0.1, 0.2, 0.3])
    (light,) = [geom for body in world.model("lamp").bodies for geom in body.geoms]
    assert tuple(light.GetDiffuseColor())[:3] == pytest.approx((0.1, 0.2, 0.3))
    with pytest.raises(ParameterError, match="three numbers from 0 to 1"):
        send(control, "light", name="lamp", color=[2, 0, 0])
    with pytest.raises(NotFoundError, match="has no light"):
        send(control, "light", name="arm", color=[0, 0, 0])


def test_new_models_stand_on_the_ground():
    with libgz.World.from_file("pioneer2at") as world:
        control = WorldControl(world)
        for name in ("Shrimp", "Pioneer2DX", "Roomba"):
            (new, *_) = send(control, "insert", model=name, pose=[10, 10, 0, 1, 0, 0, 0])
            world.step(100)
            assert world.model(new).GetPose().rot.u == pytest.approx(1.0, abs=1e-3)
            send(control, "delete", name=new)
