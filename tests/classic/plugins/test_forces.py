"""The plugins that push, pull and lift, each against a formula."""

import logging
import math

import pytest
from plugin_worlds import HINGE, body, collision, plugin

from libgz.classic.math import Vector3d


def test_initial_velocity_is_set_again_after_a_reset(run):
    extra = plugin("InitialVelocityPlugin", linear="1 2 0", angular="0 0 3")
    core, world = run(body("stone", "0 0 5 0 0 0", inside=extra, gravity="false"))
    stone = world.ModelByName("stone")
    for _ in range(2):
        core.run(0.5)
        assert tuple(stone.WorldPose().Pos()) == pytest.approx((0.5, 1.0, 5.0), abs=1e-9)
        assert stone.WorldPose().Yaw() == pytest.approx(1.5, abs=1e-3)
        core.Reset()


def test_joint_trajectory_follows_the_cosine(run):
    joint = HINGE.format(name="j")
    joint = joint.replace("0 0 1", "0 1 0").replace("<parent>", "<pose>-1 0 0 0 0 0</pose><parent>")
    core, world = run(body("arm", inside=joint + plugin("JointTrajectoryPlugin", joint="j")))
    for _ in range(3):
        core.run(2.0)
        now, joint = core.GetSimTime(), world.ModelByName("arm").GetJoint("j")
        # The step after it was set has taken the joint on.
        assert joint.Position(0) == pytest.approx(math.cos(now + 0.001), abs=1e-5)
        assert joint.GetVelocity(0) == pytest.approx(-math.sin(now), abs=1e-2)


WING = {"link_name": "link", "a0": 0.1, "cla": 4.0, "cda": 0.2, "alpha_stall": 0.3, "cla_stall": -2.0, "cda_stall": 1.5,
        "area": 0.5, "air_density": 1.2, "forward": "1 0 0", "upward": "0 0 1"}  # fmt: skip


@pytest.mark.parametrize(
    ("velocity", "alpha", "cl", "cd"),
    [
        ((10.0, 0.0, 0.0), 0.1, 0.4, 0.02),
        ((10.0, 0.0, -1.0), 0.1 + math.atan(0.1), 4.0 * (0.1 + math.atan(0.1)), 0.2 * (0.1 + math.atan(0.1))),
        ((10.0, 0.0, 2.0), 0.1 - math.atan(0.2), 4.0 * (0.1 - math.atan(0.2)), 0.2 * (math.atan(0.2) - 0.1)),
        ((10.0, 0.0, -4.0), None, None, None),  # beyond the stall
    ],
)
def test_lift_and_drag_are_those_of_the_formula(velocity, alpha, cl, cd, run):
    core, world = run(body("plane", inside=plugin("LiftDragPlugin", **WING), gravity="false"))
    plane = world.ModelByName("plane")
    plane.SetLinearVel(velocity)
    core.step()
    force = (plane.GetLink().WorldCoGLinearVel() - Vector3d(*velocity)) / 0.001
    if alpha is None:
        alpha = 0.1 + math.atan(0.4)
        cl = 4.0 * 0.3 - 2.0 * (alpha - 0.3)
        cd = 0.2 * 0.3 + 1.5 * (alpha - 0.3)
    speed2 = sum(v * v for v in velocity)
    pressure = 0.5 * 1.2 * speed2 * 0.5
    along = Vector3d(*velocity) / math.sqrt(speed2)
    across = Vector3d(-along.Z(), 0.0, along.X())  # up for a wing that flies forward
    assert tuple(force) == pytest.approx(tuple(across * (cl * pressure) - along * (cd * pressure)), abs=1e-6)


@pytest.mark.parametrize("side", [10.0, -10.0])
def test_lift_acts_at_the_centre_of_pressure_and_shrinks_with_sweep(side, run):
    """Air from the side changes the velocity that counts by 1 - sin(sweep), as in Gazebo."""
    wing = {**WING, "a0": 0.0, "cda": 0.0, "cp": "0 1 0"}
    core, world = run(body("plane", inside=plugin("LiftDragPlugin", **wing), gravity="false"))
    plane = world.ModelByName("plane")
    velocity = Vector3d(10.0, side, -1.0)
    plane.SetLinearVel(velocity)
    core.step()
    link = plane.GetLink()
    alpha = math.atan(0.1)
    sine = -side / velocity.Length()  # forward x upward is -y
    flow = velocity.Length() * (1.0 - sine)
    lift = 4.0 * alpha * (1.0 - sine * sine) * 0.5 * 1.2 * flow * flow * 0.5
    along = Vector3d(10.0, 0.0, -1.0) / math.sqrt(101.0)
    force = (link.WorldCoGLinearVel() - velocity) / 0.001
    assert tuple(force) == pytest.approx(tuple(Vector3d(-along.Z(), 0.0, along.X()) * lift), abs=1e-6)
    # Torque: (0, 1, 0) x force, on unit moments of inertia.
    assert tuple(link.WorldAngularVel() / 0.001) == pytest.approx((force.Z(), 0.0, -force.X()), abs=1e-3)


def test_lift_acts_from_the_centre_of_mass(run):
    """As in Gazebo, where a wing whose centre of mass is not the link's origin is not turned by a `cp` of zero."""
    made = body("plane", inside=plugin("LiftDragPlugin", **WING), gravity="false")
    core, world = run(made.replace("<inertial>", "<inertial><pose>0.3 0.1 0 0 0 0</pose>", 1))
    plane = world.ModelByName("plane")
    plane.SetLinearVel((10.0, 0.0, -1.0))
    core.step()
    assert plane.GetLink().WorldCoGLinearVel().Z() > -1.0
    assert tuple(plane.GetLink().WorldAngularVel()) == (0.0, 0.0, 0.0)


def test_a_flap_adds_lift(run):
    flap = (
        "<link name='flap'><gravity>false</gravity><inertial><mass>0.001</mass></inertial></link>"
        "<joint name='flap_joint' type='revolute'><parent>link</parent><child>flap</child>"
        "<axis><xyz>0 1 0</xyz></axis></joint>"
    )
    wing = {**WING, "a0": 0.0, "cda": 0.0, "control_joint_name": "flap_joint", "control_joint_rad_to_cl": 3.0}
    core, world = run(body("plane", inside=flap + plugin("LiftDragPlugin", **wing), gravity="false"))
    plane = world.ModelByName("plane")
    plane.GetJoint("flap_joint").SetPosition(0, 0.2)
    plane.SetLinearVel((10.0, 0.0, 0.0))
    core.step()
    lift = 3.0 * 0.2 * 0.5 * 1.2 * 100.0 * 0.5
    assert plane.WorldLinearVel().Z() / 0.001 == pytest.approx(lift / 1.001, rel=1e-3)


def test_a_body_of_revolution_has_lift_in_all_directions(run):
    wing = {**WING, "a0": 0.0, "cda": 0.0, "radial_symmetry": "true"}
    core, world = run(body("rocket", inside=plugin("LiftDragPlugin", **wing), gravity="false"))
    rocket = world.ModelByName("rocket")
    lift = 4.0 * math.atan(0.1) * 0.5 * 1.2 * 101.0 * 0.5 / math.sqrt(1.01)
    for velocity, side in (((10.0, 1.0, 0.0), (-0.1, 1.0, 0.0)), ((10.0, 0.0, -1.0), (-0.1, 0.0, -1.0))):
        rocket.SetLinearVel(velocity)
        core.step()
        force = (rocket.GetLink().WorldCoGLinearVel() - Vector3d(*velocity)) / 0.001
        # Against the motion to the side, across the velocity.
        assert tuple(force) == pytest.approx(tuple(Vector3d(*side) * -lift), abs=1e-6)


@pytest.mark.parametrize(
    ("shape", "volume"),
    [
        ("<box><size>1 2 0.5</size></box>", 1.0),
        ("<sphere><radius>0.5</radius></sphere>", math.pi / 6.0),
        ("<cylinder><radius>0.5</radius><length>2</length></cylinder>", math.pi / 2.0),
    ],
)
def test_buoyancy_is_the_weight_of_the_fluid(shape, volume, run):
    extra = plugin("BuoyancyPlugin", fluid_density=1000)
    core, world = run(body("float", "0 0 9 0.4 0 0", 500.0, extra, collision(shape)))
    core.step(10)
    g = (1000.0 * volume / 500.0 - 1.0) * 9.8
    assert world.ModelByName("float").WorldLinearVel().Z() == pytest.approx(g * 0.01, rel=1e-6)


def test_buoyancy_acts_at_the_centre_of_volume(run):
    shapes = collision("<box><size>1 1 1</size></box>", "1 0 0 0 0 0") + collision(
        "<box><size>1 1 1</size></box>", "2 0 0 0 0 0", "d"
    )
    extra = plugin("BuoyancyPlugin", fluid_density=2.0)
    core, world = run(body("float", "0 0 9 0 0 1.0", 4.0, extra, shapes))
    core.step()
    link = world.ModelByName("float").GetLink()
    assert link.WorldCoGLinearVel().Length() == pytest.approx(0.0, abs=1e-12)
    # Centre of volume at x 1.5 of the link, which is turned about z; 4 N/g up there turns it about its own -y.
    turn = link.RelativeAngularVel() / 0.001
    assert tuple(turn) == pytest.approx((0.0, -1.5 * 4.0 * 9.8, 0.0), abs=1e-6)


def test_buoyancy_uses_the_volumes_of_the_file(run, caplog):
    given = "<link name='link'><volume>2</volume><center_of_volume>0 0 0</center_of_volume></link>"
    text = plugin("BuoyancyPlugin", fluid_density=1.0).replace("</plugin>", f"{given}<link name='keel'/></plugin>")
    caplog.set_level(logging.WARNING)
    core, world = run(body("float", "0 0 9 0 0 0", 2.0, text))
    core.step(5)
    assert world.ModelByName("float").WorldLinearVel().Z() == pytest.approx(0.0, abs=1e-12)
    assert "Specified link [keel] not found." in caplog.text
