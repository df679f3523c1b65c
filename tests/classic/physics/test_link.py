"""Link: motion, forces, mass and switches of a link, and its collisions."""

import itertools
import math

import pytest
from plugin_worlds import body, collision

from libgz.base.errors import ParameterError
from libgz.base.geometry import GzPose, GzVector
from libgz.classic import msgs, physics
from libgz.classic.math import Inertiald, MassMatrix3d, Pose3d, Quaterniond, Vector3d
from libgz.classic.physics import Inertial
from libgz.classic.sdf import SDF
from libgz.physics.mass import given_mass

BOX = collision("<box><size>1 2 3</size></box>")
BATTERY = "<battery name='main'><voltage>12</voltage></battery>"


@pytest.fixture
def link(run):
    """A link of 2 kg at z = 5 m, turned by a right angle about z, without gravity."""
    pose = f"0 0 5 0 0 {math.pi / 2}"
    _, view = run(body("box", pose, mass=2.0, link=BOX + BATTERY, gravity="false"))
    return view.ModelByName("box").GetLink()


def test_collide_modes_restore_the_bits_that_were_set(run):
    _, view = run(body("box", link=BOX))
    shape = view.ModelByName("box").GetLink().GetCollision(0)
    shape.GetSurface().collideBitmask = 2
    shape.SetCollideMode("none")
    shape.SetCollideMode("all")
    assert shape.GetSurface().collideBitmask == 2


def test_forces_in_the_frames_of_world_and_link(link):
    link.AddForce((1, 0, 0))
    link.AddRelativeForce((1, 0, 0))  # the link's x is the world's y
    assert link.WorldForce() == Vector3d()  # it is that of the last step
    link.GetWorld().Step(1)
    assert tuple(link.WorldForce()) == pytest.approx((1, 1, 0))
    assert tuple(link.RelativeForce()) == pytest.approx((1, -1, 0))
    assert tuple(link.WorldLinearVel()) == pytest.approx((0.0005, 0.0005, 0))
    assert tuple(link.RelativeLinearVel()) == pytest.approx((0.0005, -0.0005, 0))
    assert tuple(link.WorldLinearAccel()) == pytest.approx((0.5, 0.5, 0))
    link.GetWorld().Step(1)
    assert link.WorldForce() == link.WorldLinearAccel() == Vector3d()


def test_forces_at_points_give_torques(link):
    def torque():
        link.GetWorld().Step(1)
        link.SetAngularVel((0, 0, 0))
        return tuple(link.WorldTorque())

    link.AddForceAtWorldPosition((0, 0, 1), (1, 0, 5))
    assert torque() == pytest.approx((0, -1, 0))
    link.AddForceAtRelativePosition((0, 0, 1), (1, 0, 0))  # that point is on the world's y
    assert torque() == pytest.approx((1, 0, 0), abs=1e-3)
    assert tuple(link.RelativeTorque()) == pytest.approx((0, -1, 0), abs=1e-3)
    link.AddLinkForce((0, 0, 1), (1, 0, 0))
    assert torque() == pytest.approx((1, 0, 0), abs=1e-3)
    link.AddLinkForce((0, 0, 1), (1, 0, 0))
    link.AddTorque((0, 0, 2))
    link.AddRelativeTorque((2, 0, 0))
    assert torque() == pytest.approx((1, 2, 2), abs=1e-3)
    assert torque() == (0, 0, 0)


def test_acceleration_and_force_are_those_of_the_last_step(run):
    core, view = run(body("box", "0 0 5 0 0 0", mass=2.0, link=BOX, gravity="true"))
    link = view.ModelByName("box").GetLink()
    assert link.WorldLinearAccel() == link.WorldAngularAccel() == link.WorldForce() == Vector3d()
    core.step(3)
    assert tuple(link.WorldLinearAccel()) == pytest.approx((0, 0, -9.8))
    assert tuple(link.WorldForce()) == pytest.approx((0, 0, -19.6))
    link.SetLinearVel((5, 0, 0))  # which is no acceleration
    link.AddForce((4, 0, 0))
    link.AddTorque((0, 0, 1))
    assert tuple(link.GetCollision(0).WorldLinearAccel()) == pytest.approx((0, 0, -9.8))
    core.step(1)
    assert tuple(link.WorldLinearAccel()) == pytest.approx((2, 0, -9.8))
    assert tuple(link.WorldAngularAccel()) == pytest.approx((0, 0, 1))
    assert tuple(link.WorldForce()) == pytest.approx((4, 0, -19.6))
    assert tuple(link.WorldTorque()) == pytest.approx((0, 0, 1))
    view.Reset()
    assert link.WorldLinearAccel() == link.WorldForce() == Vector3d()


def test_the_velocity_of_a_point(link):
    link.SetWorldTwist((1, 0, 0), (0, 0, 2))
    assert tuple(link.WorldLinearVel(Vector3d(1, 0, 0))) == pytest.approx((-1, 0, 0))
    assert link.GetWorldEnergyKinetic() == pytest.approx(0.5 * 2.0 * 1.0 + 0.5 * 4.0)


def test_inertia_acts_at_update_mass(link):
    inertial = link.GetInertial()
    inertial.SetMass(4.0)
    inertial.SetInertiaMatrix(1.0, 2.0, 3.0, 0.0, 0.0, 0.0)
    assert (inertial.Mass(), link.body.mass) == (4.0, 2.0)
    link.UpdateMass()
    assert link.body.mass == 4.0
    turned = link.WorldInertiaMatrix()
    assert [turned.m[i][i] for i in range(3)] == pytest.approx([2.0, 1.0, 3.0])
    inertial.SetCoG(0, 0, 1)
    link.UpdateMass()
    assert tuple(link.WorldCoGPose().Pos()) == pytest.approx((0, 0, 6))
    assert link.GetInertial() is inertial
    assert (inertial.CoG(), inertial.Mass()) == (Vector3d(0, 0, 1), 4.0)
    link.SetInertial(physics.Inertial())
    assert (inertial.Mass(), inertial.PrincipalMoments(), link.body.mass) == (1.0, Vector3d(1, 1, 1), 1.0)


@pytest.mark.parametrize("key", ["ixx", "mass"])
def test_values_that_no_body_can_have_are_those_it_got(run, key):
    wrong = body("odd", mass=2.0).replace("<ixx>1</ixx>" if key == "ixx" else "<mass>2.0</mass>", f"<{key}>0</{key}>")
    _, view = run(wrong)
    inertial = view.ModelByName("odd").GetLink().GetInertial()
    assert (inertial.Mass(), inertial.IXX()) == ((2.0, 1.0) if key == "ixx" else (1.0, 1.0))


@pytest.mark.parametrize("order", [*itertools.permutations(("IXY", "IXX", "IYY"))])
def test_moments_are_set_in_any_order(link, order):
    inertial, values = link.GetInertial(), {"IXY": 1.5, "IXX": 3.0, "IYY": 3.0}
    for name in order:
        getattr(inertial, f"Set{name}")(values[name])
    link.UpdateMass()
    assert tuple(inertial.PrincipalMoments()) == (3.0, 3.0, 1.0)  # the diagonal, as in Gazebo
    held = link.body.GetMass().I
    assert (held[0], held[1], held[5], held[10]) == (3.0, 1.5, 3.0, 1.0)


def test_moments_that_no_body_can_have_are_refused_at_update_mass(link):
    inertial = link.GetInertial()
    inertial.SetIXY(1.5)
    inertial.SetCoG(Pose3d(1, 2, 3, 0.1, 0.2, 0.3))
    with pytest.raises(ParameterError, match="not positive definite"):
        link.UpdateMass()
    assert (inertial.IXY(), inertial.Pose(), link.body.GetMass().I[1]) == (0.0, Pose3d(), 0.0)
    link.UpdateMass()


def test_view_and_engine_have_the_same_mass(link):
    inertial = link.GetInertial()
    link.body.SetMassMatrix(given_mass(7.0, (3, 4, 5, 0, 0, 0), GzPose(GzVector(0.5, 0, 0))))
    assert (inertial.Mass(), inertial.CoG(), inertial.IYY()) == (7.0, Vector3d(0.5, 0, 0), pytest.approx(4.0))


def test_moments_are_along_the_axes_of_the_inertial_frame(run):
    moments = "<inertia><ixx>1.5</ixx><iyy>2</iyy><izz>2.5</izz></inertia>"
    inertial = f"<inertial><pose>1 0 0 0 {math.pi / 4} 0</pose><mass>2</mass>{moments}</inertial>"
    _, view = run(f"<model name='m'><link name='l'>{inertial}</link></model>")
    link = view.ModelByName("m").GetLink()
    assert link.GetInertial().PrincipalMoments() == Vector3d(1.5, 2, 2.5)
    assert link.GetInertial().IXX() == 1.5
    in_link = link.GetInertial().MOI(Pose3d(1, 0, 0, 0, 0, 0))
    assert [in_link.m[i][i] for i in range(3)] == pytest.approx([2, 2, 2])
    assert [link.WorldInertiaMatrix().m[i][i] for i in range(3)] == pytest.approx([2, 2, 2])
    assert tuple(link.WorldInertialPose().Rot().GetAsEuler()) == pytest.approx((0, math.pi / 4, 0))
    link.GetInertial().SetMass(3.0)
    link.UpdateMass()
    assert link.body.GetMass().I[2] == pytest.approx(0.5)
    link.GetInertial().SetCoG(Pose3d(1, 0, 0, 0, 0, 0))
    link.GetInertial().SetInertiaMatrix(2, 2, 2, 0, 0.5, 0)
    link.UpdateMass()
    assert tuple(link.GetInertial().PrincipalMoments()) == (2, 2, 2)


def test_inertials_are_values_that_are_added_moved_and_turned_as_in_gazebo(link):
    assert physics.Inertial(2.5).Mass() == 2.5
    one = physics.Inertial(
        Inertiald(MassMatrix3d(3, (1, 2, 2.5), (0.1, 0.2, 0.3)), Pose3d(0.1, 0.2, 0.3, 0.4, 0.5, 0.6))
    )
    other = physics.Inertial(one)
    other.SetMass(1)
    other.SetCoG(-0.5, 0, 1)
    assert one.Mass() == 3
    assert one.CoG() == Vector3d(0.1, 0.2, 0.3)
    # What follows was printed by Gazebo 11.1.
    both = one + other
    assert both.Mass() == 4
    assert tuple(both.CoG()) == pytest.approx((-0.05, 0.15, 0.475))
    assert tuple(both.PrincipalMoments()) == pytest.approx((3.66565176401, 4.21975733152, 4.44959090447))
    assert tuple(both.ProductsOfInertia()) == pytest.approx((-0.346554851148, 1.63086072131, 1.05180835564))
    for offset in (Vector3d(1, 2, 3), Pose3d(1, 2, 3, 0.1, 0.2, 0.3)):
        moved = one(offset)
        assert tuple(moved.CoG()) == pytest.approx((-0.9, -1.8, -2.7))
        assert moved.Pose().rot == one.Pose().rot
        assert tuple(moved.PrincipalMoments()) == pytest.approx((40.634075882, 31.7911286658, 17.0747954522))
        assert tuple(moved.ProductsOfInertia()) == pytest.approx((-6.12827742557, -8.34206963934, -17.5265958222))
    one.Rotate(Quaterniond(0.3, 0.1, -0.2))
    assert tuple(one.CoG()) == pytest.approx((0.151687954111, 0.0737454915083, 0.333994561422))
    assert tuple(one.Pose().rot) == pytest.approx((0.902651752724, 0.290228543482, 0.267127266905, 0.172134334541))
    assert one.IXX() == 1
    with pytest.raises(TypeError):
        one + 1.0
    copied = physics.Inertial(link.GetInertial())
    copied.SetMass(link.GetInertial().Mass() + 1)
    assert link.GetInertial().Mass() != copied.Mass()


def test_a_kinematic_link_is_not_moved_by_forces(link):
    link.SetKinematic(True)
    link.SetLinearVel((0, 0, 1))
    link.AddForce((100, 0, 0))
    link.GetWorld().Step(100)
    assert link.GetKinematic()
    link.body.set_kinematic(False)
    assert not link.GetKinematic()
    link.body.set_kinematic(True)
    assert link.GetKinematic()
    assert tuple(link.WorldPose().Pos()) == pytest.approx((0, 0, 5.1))
    link.SetStatic(True)
    link.GetWorld().Step(100)
    assert tuple(link.WorldPose().Pos()) == pytest.approx((0, 0, 5.1))


def test_gravity_and_damping_are_switched(link):
    world = link.GetWorld()
    link.SetGravityMode(True)
    world.Step(1)
    assert link.WorldLinearVel().Z() == pytest.approx(-0.0098)
    link.SetGravityMode(False)
    link.SetLinearVel((1, 0, 0))
    link.SetLinearDamping(0.1)
    world.Step(1)
    assert link.WorldLinearVel().X() == pytest.approx(0.9)


def test_the_bounding_box_is_turned_with_the_link(link):
    box = link.BoundingBox()
    assert tuple(box.Size()) == pytest.approx((2, 1, 3))
    assert tuple(box.Min()) == pytest.approx((-1, -0.5, 3.5))


def test_a_battery_whose_voltage_is_invalid_has_none(run, caplog):
    core, view = run(body("m", link=BATTERY.replace("12", "-1")))
    core.step(2)
    assert view.ModelByName("m").GetLink("link").Battery("main").Voltage() == 0.0
    assert caplog.text.count(":1: <battery>: voltage [V] is -1; it must not be negative; battery 'main' has 0 V") == 1


def test_collisions_batteries_and_sensors_by_name_and_index(link):
    (shape,) = link.GetCollisions()
    assert link.GetCollision("c") is link.GetCollision(0) is link.GetChild(0) is shape
    assert link.GetCollision("d") is link.GetCollision(1) is link.Battery("spare") is link.Battery(1) is None
    assert link.Battery("main") is link.Battery(0) is link.batteries[0]
    assert (link.BatteryCount(), link.GetSensorCount(), link.GetSensorName(0)) == (1, 0, "")


def test_an_entity_is_put_on_the_one_below(run):
    _, view = run(body("table", "0 0 1 0 0 0", link=BOX), body("cup", "0 0 9 0 0 0", link=BOX))
    cup = view.ModelByName("cup")
    assert cup.GetNearestEntityBelow() == (pytest.approx(5.0, abs=1e-4), "table::link::c")
    cup.PlaceOnNearestEntityBelow()
    assert cup.WorldPose().Pos().Z() == pytest.approx(4.0, abs=1e-4)
    assert cup.RelativePose() == cup.WorldPose() == Pose3d(cup.WorldPose())


def test_own_inertials_take_elements_and_messages():
    own = Inertial(0.0)  # as in Gazebo, which refuses nothing
    assert (own.Mass(), own.PrincipalMoments()) == (0.0, Vector3d(1, 1, 1))
    assert ((own + own).Mass(), (own + own).CoG()) == (0.0, Vector3d())
    text = "<mass>2</mass><pose>1 2 3 0 0 .5</pose><inertia><ixx>3</ixx><iyy>4</iyy><izz>5</izz><ixy>.1</ixy></inertia>"
    document = SDF()
    model = f"<model name='m'><link name='l'><inertial>{text}</inertial></link></model>"
    document.SetFromString(f"<sdf version='1.6'>{model}</sdf>")
    own.Load(document.Root().GetElement("model").GetElement("link").GetElement("inertial"))
    assert (own.Mass(), own.CoG(), own.Pose().Yaw()) == (2.0, Vector3d(1, 2, 3), 0.5)
    assert (own.IXX(), own.IYY(), own.IZZ(), own.IXY()) == (3.0, 4.0, 5.0, 0.1)
    message = msgs.Inertial(mass=7, iyz=0.25)
    message.pose.position.x, message.pose.position.y, message.pose.position.z = 4, 5, 6
    own.ProcessMsg(message)
    assert (own.Mass(), own.CoG(), own.Pose().Yaw(), own.IYZ(), own.IXX()) == (7.0, Vector3d(4, 5, 6), 0.5, 0.25, 3.0)
    own.Reset()
    assert (own.Mass(), own.CoG(), own.IYZ(), own.IXX()) == (2.0, Vector3d(), 0.0, 3.0)
    other = Inertial(5.0)
    other.Reset()
    assert (other.Mass(), other.IXX()) == (1.0, 1.0)
