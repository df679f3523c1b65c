"""What Gazebo's own tests expect of names and numbers."""

import math

import pytest
from sensor_worlds import box, get, model, sensor, world_of

import libgz
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
        # A model's box is that of its own links: the base lies below the view.
        assert [one.name for one in get("s").Image().model] == ["base::nested"]


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
    "<capsule><radius>0.5</radius><length>2</length></capsule>": math.pi / 6 + math.pi / 2,
    "<ellipsoid><radii>0.5 1 1.5</radii></ellipsoid>": 6.0,  # its box, as of all meshes
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


def with_layer(layer, content, gravity=-9.8):
    solver = "<solver><iters>1000</iters><sor>1</sor></solver>"
    physics = f"<ode>{solver}<constraints><contact_surface_layer>{layer}</contact_surface_layer></constraints></ode>"
    settings = f"<gravity>0 0 {gravity}</gravity><physics type='ode'>{physics}</physics>"
    ground = "<include><uri>model://ground_plane</uri></include>"
    return libgz.World.from_string(
        f"<sdf version='1.6'><world name='default'>{settings}{ground}{content}</world></sdf>"
    )


@pytest.mark.parametrize(("layer", "depth"), [(0.0, 0.0), (0.001, 0.003), (0.01, 0.0), (0.01, 0.003)])
def test_a_body_is_pushed_out_up_to_its_min_depth_whatever_the_surface_layer(layer, depth):
    """In Gazebo 11.1, boxes and spheres rest at the same depths with a layer of 1 mm and of 10 mm."""
    surface = f"<surface><contact><ode><min_depth>{depth}</min_depth></ode></contact></surface>"
    shape = f"<collision name='c'><geometry><box><size>1 1 1</size></box></geometry>{surface}</collision>"
    with with_layer(layer, model("box", shape, static=False)) as core:
        box_ = view_of(core).ModelByName("box")
        pose = box_.WorldPose()
        pose.Pos().Z(0.495)  # 5 mm deep
        box_.SetWorldPose(pose)
        core.step(1500)
        assert 0.5 - box_.WorldPose().Pos().Z() == pytest.approx(depth, abs=1e-5)
        assert box_.WorldLinearAccel().Length() < 1e-2
        assert view_of(core).Physics().GetParam("contact_surface_layer") == layer


def test_row_17_an_imu_that_falls_on_a_ramp_and_rolls_onto_the_ground():
    """Free fall, the ramp, and the ground from 1.85 s on, with a layer of 1 cm: to 8e-5 in all three."""
    slip = "<surface><friction><ode><mu>0</mu><mu2>0</mu2></ode></friction></surface>"
    ramp = model(
        "ramp",
        "<collision name='c'><geometry><box><size>5 5 0.01</size></box></geometry></collision>",
        "3 0 1 0 0.5 0",
    )
    sphere = f"<collision name='c'><geometry><sphere><radius>0.3</radius></sphere></geometry>{slip}</collision>"
    mass = "<inertial><mass>5</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>"
    ball = model("ball", mass + sphere + sensor("imu", ""), "2 0.5 10 0 0 0", False)
    with with_layer(0.01, ramp + ball, -9.81) as core:
        link = view_of(core).ModelByName("ball").GetLink("link")
        seen = {"falls": 0, "slides": 0, "rests": 0}
        while core.GetSimTime() < 2.5:
            core.step(1)
            time = core.GetSimTime()
            felt, moved = get("s").LinearAcceleration().Length(), link.WorldLinearAccel().Length()
            if time < 1.2:
                seen["falls"] += 1
                assert (felt, moved) == pytest.approx((0.0, 9.81), abs=8e-5)
            elif 1.45 < time < 1.7:
                seen["slides"] += 1
                assert (felt, moved) == pytest.approx((9.81 * math.cos(0.5), 9.81 * math.sin(0.5)), abs=8e-5)
            elif time > 1.85:
                seen["rests"] += 1
                assert (felt, moved) == pytest.approx((9.81, 0.0), abs=8e-5)
        assert min(seen.values()) > 200


def test_lift_and_drag_on_sliders():
    """Accelerations of a wing that two sliders hold upright, by its lift and drag in each step, to 1e-6."""
    weigh = "<inertial><mass>{}</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>"
    slider = (
        "<joint name='{0}' type='prismatic'><parent>{1}</parent><child>{2}</child><axis><xyz>{3}</xyz></axis></joint>"
    )
    wing = (
        "<plugin name='w' filename='libLiftDragPlugin.so'><link_name>wing</link_name><a0>0.1</a0><cla>4</cla>"
        "<cda>0.2</cda><alpha_stall>1</alpha_stall><area>0.5</area><air_density>1.2</air_density><cp>0.1 0 0</cp>"
        "<forward>1 0 0</forward><upward>0 0 1</upward></plugin>"
    )
    links = f"<link name='cart'>{weigh.format(3)}</link><link name='wing'>{weigh.format(2)}</link>"
    joints = slider.format("x", "world", "cart", "1 0 0") + slider.format("z", "cart", "wing", "0 0 1")
    with world_of(f"<model name='m'>{links}{joints}{wing}</model>", gravity="0 0 0") as core:
        body = view_of(core).ModelByName("m")
        body.SetLinearVel((10, 0, 0))
        link = body.GetLink("wing")
        for _ in range(300):
            before = link.WorldLinearVel()
            core.step(1)
            found = (link.WorldLinearVel() - before) / 0.001
            speed = math.hypot(before.X(), before.Z())
            alpha = 0.1 - math.atan2(before.Z(), before.X())
            lift, drag = (c * alpha * 0.5 * 1.2 * speed**2 * 0.5 for c in (4.0, 0.2))
            along, up = before.X() / speed, before.Z() / speed
            assert found.X() == pytest.approx((-drag * along - lift * up) / 5.0, abs=1e-6)
            assert found.Z() == pytest.approx((-drag * up + lift * along) / 2.0, abs=1e-6)


def test_applied_force():
    """A torque on a hinge: its acceleration, the effort, and what the joint of a tilted arm feels that is held."""
    arm = (
        "<model name='arm'><link name='arm'><pose>0 0 1 0 0 0</pose><inertial><pose>0 0 0.5 0 0 0</pose><mass>10</mass>"
        "<inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.1</izz></inertia></inertial></link>"
        "<joint name='hinge' type='revolute'><parent>world</parent><child>arm</child><axis><xyz>1 0 0</xyz></axis>"
        "<physics><provide_feedback>true</provide_feedback></physics></joint></model>"
    )
    with world_of(arm, gravity="0 0 0") as core:
        joint = view_of(core).ModelByName("arm").GetJoint("hinge")
        link = joint.GetChild()
        joint.SetForce(0, 1.3)
        core.step(1)
        assert link.WorldAngularAccel().X() == pytest.approx(1.3 / (0.1 + 10 * 0.25), abs=1e-6)
        assert joint.GetForce(0) == 1.3
    with world_of(arm, gravity="0 0 -10") as core:
        joint = view_of(core).ModelByName("arm").GetJoint("hinge")
        for step in range(4000):
            effort = -2000.0 * (joint.Position(0) - 0.5) - 200.0 * joint.GetVelocity(0)
            joint.SetForce(0, effort)
            core.step(1)
            if step > 3000:
                angle, wrench = joint.Position(0), joint.GetForceTorque(0)
                weight = 10 * 10 * 0.5 * math.sin(angle)  # [N m] about the hinge
                assert effort == pytest.approx(-weight, abs=1e-3)
                assert wrench.body2Torque.X() == pytest.approx(weight, abs=1e-3)
                force = wrench.body2Force  # what the hinge does to the arm, in the arm's frame
                assert force.Length() == pytest.approx(100.0, abs=1e-3)
