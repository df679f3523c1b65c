"""What Gazebo's own tests expect of names and numbers."""

import math

import pytest
from sensor_worlds import box, get, model, sensor, world_of

from libgz.classic.server import attach

CAMERA = (
    "<logical_camera><near>0.55</near><far>2.5</far><aspect_ratio>1.8</aspect_ratio>"
    "<horizontal_fov>1.05</horizontal_fov></logical_camera>"
)


def view_of(core):
    return attach(core).world


def test_a_logical_camera_names_nested_models_by_their_scoped_names():
    inner = "<model name='nested'><pose>0 0 1 0 0 0</pose><link name='link'>{}</link></model>"
    shape = "<collision name='c'><geometry><box><size>1 1 1</size></box></geometry></collision>"
    outer = model("base", shape, "1 0 0.5 0 0 0", True, inner.format(shape))
    with world_of(model("post", sensor("logical_camera", CAMERA), "0 0 2 0 0 0") + outer) as core:
        core.step(1)
        assert [one.name for one in get("s").Image().model] == ["base", "base::nested"]


KINDS = ("revolute", "revolute2", "prismatic", "universal", "ball", "screw", "gearbox", "fixed")


@pytest.mark.parametrize(("number", "kind"), list(enumerate(KINDS, 1)))
def test_the_type_of_a_joint_is_the_number_of_its_message(number, kind):
    with world_of(box("a", "0 0 1 0 0 0", static=False) + box("b", "3 0 1 0 0 0", static=False)) as core:
        joint = view_of(core).Physics().CreateJoint(kind)
        assert joint.GetMsgType() == number


SHAPES = {
    "<box><size>1 2 3</size></box>": 6.0,
    "<sphere><radius>0.5</radius></sphere>": math.pi / 6,
    "<cylinder><radius>0.5</radius><length>2</length></cylinder>": math.pi / 2,
    "<plane><normal>0 0 1</normal></plane>": 0.0,
    "<polyline><point>0 0</point><point>2 0</point><point>0 1</point><height>3</height></polyline>": 6.0,  # its box
}


@pytest.mark.parametrize(("shape", "volume"), list(SHAPES.items()))
def test_volumes_of_shapes(shape, volume):
    content = f"<collision name='c'><geometry>{shape}</geometry></collision>"
    with world_of(model("m", content)) as core:
        collision = view_of(core).ModelByName("m").GetLink("link").GetCollision("c")
        assert collision.GetShape().ComputeVolume() == pytest.approx(volume, rel=1e-9)


def test_a_preset_has_its_reduction_of_inertia_ratios():
    with world_of("") as core:
        engine = view_of(core).Physics()
        for name in ("inertia_ratio_reduction", "use_dynamic_moi_rescaling"):
            for value in (True, False):
                engine.SetParam(name, value)
                assert engine.GetParam("inertia_ratio_reduction") is value
                assert engine.GetParam("use_dynamic_moi_rescaling") is value


def test_force_and_torque_under_an_applied_force_without_averaging():
    """Two servoed joints in a column of three links; each step of the last half second is within 2 N or 2 N m."""
    inertia = "<inertial><pose>{}</pose><mass>{}</mass></inertial>"
    links = "".join(
        f"<link name='{name}'><pose>{i} 0 {i} 0 0 0</pose>{inertia.format(pose, mass)}</link>"
        for i, (name, pose, mass) in enumerate(
            [("one", ".5 0 .5 0 0 0", 100), ("two", ".5 0 .5 0 0 0", 5), ("three", ".5 .5 .5 0 0 0", 1)]
        )
    )
    joint = "<joint name='{}' type='revolute'><parent>{}</parent><child>{}</child><axis><xyz>0 1 0</xyz>"
    joint += "<dynamics><damping>100</damping></dynamics></axis>"
    joint += "<physics><provide_feedback>true</provide_feedback></physics></joint>"
    joints = joint.format("j1", "one", "two") + joint.format("j2", "two", "three")
    foot = "<joint name='foot' type='fixed'><parent>world</parent><child>one</child></joint>"
    with world_of(f"<model name='m'>{links}{joints}{foot}</model>", gravity="0 0 -50") as core:
        arm = view_of(core).ModelByName("m")
        first, second = arm.GetJoint("j1"), arm.GetJoint("j2")
        for i in range(3500):
            first.SetForce(0, -50000.0 * first.Position(0))
            second.SetForce(0, 10000.0 * (-math.pi / 4 - second.Position(0)))
            core.step(1)
            if i > 3000:
                one, two = first.GetForceTorque(0), second.GetForceTorque(0)
                assert tuple(one.body1Force) == pytest.approx((0, 0, 300), abs=2)
                assert tuple(one.body1Torque) == pytest.approx((25, -175, 0), abs=2)
                assert tuple(two.body1Force) == pytest.approx((0, 0, 50), abs=2)
                assert tuple(two.body1Torque) == pytest.approx((25, 0, 0), abs=2)
                assert tuple(two.body2Torque) == pytest.approx((-17.678, 0, 17.678), abs=2)
