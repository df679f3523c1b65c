"""Names of Gazebo's that act on joints, rays, contacts, trees of entities and animations."""

import sys

import pytest
from plugin_worlds import GROUND, HINGE, body, collision

from libgz.base.errors import ParameterError
from libgz.classic import ModelPlugin, PluginType, common
from libgz.classic.math import Pose3d, Vector3d

BOX = "<box><size>1 1 1</size></box>"


@pytest.fixture
def world(run):
    core, view = run(
        GROUND,
        body("box", "0 0 0.5 0 0 0", link=collision(BOX)),
        body("arm", "5 0 2 0 0 0", inside=HINGE.format(name="j")),
    )
    view.core_world = core
    return view


def test_rays_are_added_to_a_multiray(world):
    shape = world.Physics().CreateShape("multiray", world.ModelByName("box").GetLink().GetCollision(0))
    assert shape.RayCount() == 0
    shape.AddRay((0, 0, 1), (0, 0, 3))
    shape.AddRay((2, 0, 0), (2, 0, -3))
    shape.Update()
    assert shape.RayCount() == 2
    assert shape.GetRange(1) == pytest.approx(0.5, abs=1e-6)
    with pytest.raises(ParameterError, match="a ray has no length"):
        shape.AddRay((1, 1, 1), (1, 1, 1))
    alone = world.Physics().CreateShape("multiray")  # as in Gazebo 11: in the world frame
    alone.AddRay((0, 0, 3), (0, 0, 0))
    alone.AddRay((2, 0, 3), (2, 0, 1))
    alone.Update()
    assert [alone.GetRange(i) for i in range(2)] == pytest.approx([2.0, sys.float_info.max], abs=1e-6)


def test_the_count_of_contacts_is_reset(world):
    contacts = world.Physics().GetContactManager()
    contacts.GetContacts()
    world.core_world.step(3)
    assert contacts.GetContactCount() == 1
    contacts.ResetCount()
    assert contacts.GetContactCount() == 0
    world.core_world.step()
    assert contacts.GetContactCount() == 1


def test_children_are_removed(world):
    arm = world.ModelByName("arm")
    arm.RemoveChild("j")
    assert arm.GetJointCount() == 0
    arm.RemoveChild("nothing")
    with pytest.raises(ParameterError, match="models, lights and joints can be removed"):
        arm.RemoveChild("link")
    world.RemoveChild("box")
    world.core_world.step()
    assert world.ModelByName("box") is None


def test_plugins_have_classic_s_fields():
    assert [kind.value for kind in PluginType] == [0, 1, 2, 3, 4, 5]
    assert (ModelPlugin.filename, ModelPlugin.handleName) == ("", "")


def test_tension_makes_a_path_straight():
    def middle(tension):
        animation = common.PoseAnimation("walk", 3.0, False, tension)
        for time, x in enumerate((0.0, 0.0, 1.0, 0.0)):
            animation.CreateKeyFrame(float(time)).Translation(Vector3d(x, 0, 0))
        animation.SetTime(1.25)
        return animation.GetInterpolatedKeyFrame().translation.x

    assert middle(1.0) == pytest.approx(0.15625)  # 3 t^2 - 2 t^3 of a quarter: no slope at the key frames
    assert middle(0.0) > middle(1.0)
    with pytest.raises(ParameterError, match=r"tension is 2\.0; it must be 0 to 1"):
        common.PoseAnimation("walk", 3.0, False, 2.0)


def test_parameters_that_ode_has_not_are_kept(world):
    physics = world.Physics()
    assert physics.GetParam("sor_lcp_tolerance") == physics.GetParam("rms_error_tolerance") == -1.0
    for key, value in (("sor_lcp_tolerance", 0.01), ("contact_residual_smoothing", 0.5), ("contact_sor_scale", 0.9)):
        physics.SetParam(key, value)
        assert physics.GetParam(key) == value


def test_set_position_stops_the_links(world):
    joint = world.ModelByName("arm").GetJoint("j")
    for keeps in (False, True):
        joint.SetVelocity(0, 2.0)
        joint.SetPosition(0, 0.5, keeps)
        assert joint.GetVelocity(0) == pytest.approx(2.0 if keeps else 0.0)


def test_initial_poses_of_lights_and_collisions(world):
    part = world.ModelByName("box").GetLink().GetCollision(0)
    part.SetInitialRelativePose(Pose3d(1, 2, 3, 0, 0, 0))
    assert part.InitialRelativePose() == Pose3d(1, 2, 3, 0, 0, 0)
    assert isinstance(world.ModelByName("box").GetLink().Visuals(), dict)
