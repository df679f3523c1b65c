"""Names of physics that plugins use beside the common ones: states, links that are loaded, frames of joints, shapes."""

import math

import numpy as np
import pytest
from PIL import Image
from plugin_worlds import GROUND, HINGE, body, collision

import libgz
from libgz.base.errors import GazeboError, NotFoundError, ParameterError
from libgz.classic import physics, sdf
from libgz.classic.common import Time
from libgz.classic.math import Pose3d, Quaterniond, Vector3d
from libgz.classic.physics import Base, JointState, JointWrench, LinkState, ModelState, WorldState

BOX = "<box><size>1 1 1</size></box>"


def test_states_hold_poses_and_motion_and_set_them(run):
    core, world = run(body("flyer", pose="1 2 3 0 0 0", gravity="false", inside=HINGE.format(name="h")), body("rock"))
    model, joint = world.ModelByName("flyer"), world.ModelByName("flyer").GetJoint("h")
    joint.SetVelocity(0, 0.5)
    core.run(1.0)
    state = ModelState(model)
    assert state.GetJointState("h").Position(0) == pytest.approx(0.5, abs=1e-6)
    assert JointState(joint).Positions() == pytest.approx([joint.Position(0)])
    link = state.GetLinkState("link")
    assert link.Pose() == model.GetLink().WorldPose()
    assert link.Velocity().Rot().Yaw() == pytest.approx(0.5, abs=1e-6)
    assert list(state.GetLinkStates()) == ["link"]
    assert list(state.GetJointStates()) == ["h"]
    assert state.NestedModelStates() == {}
    whole = WorldState(world)
    assert (whole.GetModelStateCount(), sorted(whole.GetModelStates())) == (2, ["flyer", "rock"])
    assert whole.GetModelState("rock").IsZero() is False  # gravity is a force
    model.SetWorldPose(Pose3d(0, 0, 9, 0, 0, 0))
    model.ResetPhysicsStates()
    world.SetState(whole)
    assert model.GetLink().WorldPose().Pos().Equal(Vector3d(1, 2, 3), 1e-9)
    assert model.WorldAngularVel().Z() == pytest.approx(0.5, abs=1e-6)
    with pytest.raises(NotFoundError, match="has no link 'lnk'; did you mean 'link'"):
        state.GetLinkState("lnk")
    with pytest.raises(ParameterError, match="has no axis 1"):
        state.GetJointState("h").Position(1)


def test_states_are_empty_until_they_are_loaded(run):
    core, world = run(body("flyer", pose="1 2 3 0 0 0", gravity="false", inside=HINGE.format(name="h")))
    core.run(0.01)
    model = world.ModelByName("flyer")
    whole, state, link, joint = WorldState(), ModelState(), LinkState(), JointState()
    assert all(empty.IsZero() for empty in (whole, state, link, joint))
    assert (whole.GetModelStateCount(), state.GetLinkStateCount(), joint.GetAngleCount()) == (0, 0, 0)
    whole.Load(world)
    assert (whole.GetModelState("flyer").Pose(), whole.GetSimTime()) == (model.WorldPose(), world.SimTime())
    state.Load(model, Time(3.0), Time(2.0), 7)
    joint.Load(model.GetJoint("h"), Time(3.0), Time(2.0))
    for one in (state, state.GetLinkState("link"), joint):
        assert (one.GetRealTime(), one.GetSimTime()) == (Time(3.0), Time(2.0))
    assert (state.GetIterations(), joint.GetIterations()) == (7, world.Iterations())
    link.Load(model.GetLink())
    assert (link.GetName(), link.Pose()) == ("link", model.GetLink().WorldPose())


def test_a_link_state_is_that_of_one_link(run):
    _, world = run(body("a"), body("b", pose="0 0 5 0 0 0"))
    LinkState(world.ModelByName("b").GetLink()).apply(world.ModelByName("a").GetLink())
    assert world.ModelByName("a").GetLink().WorldPose().Pos().Z() == pytest.approx(5.0)


def test_a_created_link_is_loaded_from_an_element(run):
    core, world = run(body("base", gravity="false"), GROUND)
    model = world.ModelByName("base")
    link = model.CreateLink("more")
    element = sdf.Element()
    sdf.initFile("link.sdf", element)
    assert sdf.readString(
        f"<link name='more'><pose>0 0 2 0 0 0</pose><inertial><mass>3</mass></inertial>{collision(BOX)}</link>", element
    )
    link.Load(element)
    link.Init()
    assert link.GetInertial().Mass() == pytest.approx(3.0)
    assert link.RelativePose().Pos().Z() == pytest.approx(2.0)
    assert link.GetCollision("c").GetShape().HasType(Base.BOX_SHAPE)
    core.run(2.0)
    assert link.WorldPose().Pos().Z() == pytest.approx(0.5, abs=2e-3)  # its box fell onto the ground
    world.Reset()
    core.run(0.001)
    with pytest.raises(ParameterError, match="one of the model's file"):
        model.GetLink("link").Load(element)


def test_initial_poses_of_links(run):
    core, world = run(body("base", gravity="true"))
    link = world.ModelByName("base").GetLink()
    core.run(0.5)
    assert link.WorldPose().Pos().Z() < -1.0
    assert link.InitialRelativePose().Pos().Z() == 0.0
    link.MoveFrame(Pose3d(0, 0, 0, 0, 0, 0), Pose3d(1, 0, 0, 0, 0, 0))
    assert link.WorldPose().Pos().X() == pytest.approx(1.0)
    assert link.WorldCoGLinearVel() == Vector3d()
    assert link.IsCanonicalLink()


def test_links_of_one_model_touch_each_other_on_request(run):
    """The upper box rests on the lower one with self-collision, and falls through it without."""

    def box(name, z):
        return f"<link name='{name}'><pose>0 0 {z} 0 0 0</pose>{collision(BOX)}</link>"

    core, world = run(f"<model name='pair'>{box('low', 0.5)}{box('high', 1.6)}</model>", GROUND)
    model = world.ModelByName("pair")
    high = model.GetLink("high")
    state = core.get_state()
    assert not model.GetSelfCollide()
    core.run(1.0)
    assert high.WorldPose().Pos().Z() == pytest.approx(0.5, abs=2e-3)
    core.set_state(state)
    high.SetSelfCollide(True)
    assert high.GetSelfCollide()
    colliding = core.get_state()
    core.run(1.0)
    assert high.WorldPose().Pos().Z() == pytest.approx(1.5, abs=2e-3)
    world.Reset()
    assert not high.GetSelfCollide()
    core.run(1.0)
    assert high.WorldPose().Pos().Z() == pytest.approx(0.5, abs=2e-3)
    core.set_state(colliding)
    core.run(1.0)
    assert high.WorldPose().Pos().Z() == pytest.approx(1.5, abs=2e-3)


def test_frames_of_joints(run):
    joint = (
        "<joint name='h' type='revolute'><pose>0 0 0.5 0 0 0</pose><parent>world</parent><child>link</child>"
        "<axis><xyz>0 0 1</xyz></axis></joint>"
    )
    core, world = run(body("arm", pose="1 0 0 0 0 0", gravity="false", inside=joint))
    hinge = world.ModelByName("arm").GetJoint("h")
    hinge.SetVelocity(0, 1.0)
    core.run(0.5)
    assert hinge.InitialAnchorPose() == Pose3d(0, 0, 0.5, 0, 0, 0)
    assert hinge.WorldPose().Pos().Equal(Vector3d(1, 0, 0.5), 1e-6)
    assert hinge.WorldPose().Rot().Yaw() == pytest.approx(0.5, abs=1e-5)
    assert hinge.ParentWorldPose().Rot().Yaw() == pytest.approx(0.0, abs=1e-9)
    assert hinge.AnchorErrorPose().Rot().Yaw() == pytest.approx(hinge.Position(0), abs=1e-6)
    assert hinge.AxisFrame(0).Yaw() == pytest.approx(0.5, abs=1e-5)
    assert hinge.HasType(Base.HINGE_JOINT)
    assert hinge.GetType() == Base.JOINT | Base.HINGE_JOINT
    assert hinge.GetJointLink(0) is world.ModelByName("arm").GetLink()
    hinge.SetStiffnessDamping(0, 4.0, 0.0, 0.0)
    assert hinge.GetWorldEnergyPotentialSpring(0) == pytest.approx(2.0 * hinge.Position(0) ** 2)
    hinge.SetMaxForce(0, 7.0)
    assert hinge.GetMaxForce(0) == hinge.GetParam("fmax", 0) == 7.0


def test_the_parents_frame_of_a_joint_is_part_of_states(run):
    core, world = run(body("arm", gravity="false", inside=HINGE.format(name="h")))
    hinge = world.ModelByName("arm").GetJoint("h")
    hinge.SetVelocity(0, 1.0)
    core.run(0.5)
    state, before = core.get_state(), hinge.AnchorErrorPose()
    hinge.Detach()
    hinge.Attach(None, world.ModelByName("arm").GetLink())
    assert hinge.AnchorErrorPose().Rot().Yaw() == pytest.approx(0.0, abs=1e-9)
    core.set_state(state)
    assert hinge.AnchorErrorPose().Equal(before, 1e-12)


def test_shapes_have_types_and_sizes(run, tmp_path):
    Image.fromarray(np.array([[0, 64, 128], [0, 64, 128], [255, 64, 128]], dtype=np.uint8)).save(tmp_path / "hills.png")
    hills = f"<heightmap><uri>file://{tmp_path}/hills.png</uri><size>4 2 5</size><pos>0 0 1</pos></heightmap>"
    ball = collision("<sphere><radius>0.5</radius></sphere>", name="ball")
    _, world = run(body("land", link=collision(hills) + ball, gravity="false"))
    land, round_one = (world.ModelByName("land").GetLink().GetCollision(name).GetShape() for name in ("c", "ball"))
    assert round_one.HasType(Base.SPHERE_SHAPE)
    assert round_one.HasType(Base.SHAPE)
    assert not round_one.HasType(Base.BOX_SHAPE)
    assert world.ModelByName("land").GetLink().GetCollision("ball").GetShapeType() == round_one.GetType()
    assert isinstance(land, physics.HeightmapShape)
    assert land.HasType(Base.HEIGHTMAP_SHAPE)
    assert (land.VertexCount().X(), land.VertexCount().Y()) == (3, 3)
    assert land.GetSubSampling() == 1  # what may move is a mesh with a vertex for each pixel
    assert land.Size() == Vector3d(4, 2, 5)
    assert land.GetHeight(0, 2) == land.GetMaxHeight() == pytest.approx(6.0)  # the lower left pixel is at -x, -y
    assert land.GetHeight(0, 0) == land.GetMinHeight() == pytest.approx(1.0)
    assert land.GetImage().GetPixel(0, 0).R() == 1.0  # y counts upwards there
    assert land.GetHeight(3, 1) == land.GetHeight(0, 2)  # behind a row is the next one, as in Gazebo
    assert land.GetHeight(3, 2) == land.GetHeight(-1, 1) == land.GetHeight(1, -1) == 0.0


def test_a_collision_keeps_its_surface_and_shape(run):
    _, world = run(body("box", link=collision(BOX)))
    kept = world.ModelByName("box").GetLink().GetCollision("c")
    assert kept.GetSurface() is kept.GetSurface()  # a weak pointer of C++ to one lasts
    assert kept.GetSurface().FrictionPyramid() is kept.GetSurface().FrictionPyramid()
    assert kept.GetShape() is kept.GetShape()


def test_contacts_without_collision_have_a_bitmask_of_their_own(run):
    core, world = run(body("ghost", pose="0 0 0.5 0 0 0", link=collision(BOX)), GROUND)
    surface = world.ModelByName("ghost").GetLink().GetCollision("c").GetSurface()
    surface.collideWithoutContact = True
    surface.collideWithoutContactBitmask = 2
    assert (surface.collideWithoutContact, surface.collideWithoutContactBitmask) == (True, 2)
    ground = world.ModelByName("ground_plane").GetLink().GetCollisions()[0].GetSurface()
    manager = world.Physics().GetContactManager()
    ground.collideWithoutContactBitmask = 1
    manager.GetContacts()
    core.run(0.01)
    assert manager.GetContactCount() == 0
    ground.collideWithoutContactBitmask = 3
    core.run(0.001)
    assert manager.GetContactCount() == 1
    core.run(1.0)
    assert world.ModelByName("ghost").WorldPose().Pos().Z() < -1.0  # no force


def test_friction_has_a_direction_and_a_patch(run):
    _, world = run(body("box", link=collision(BOX)))
    friction = world.ModelByName("box").GetLink().GetCollision("c").GetSurface().FrictionPyramid()
    friction.direction1 = (0, 1, 0)
    friction.SetPatchRadius(0.2)
    friction.SetSurfaceRadius(0.3)
    friction.SetUsePatchRadius(False)
    assert friction.direction1 == Vector3d(0, 1, 0)
    assert (friction.PatchRadius(), friction.SurfaceRadius(), friction.UsePatchRadius()) == (0.2, 0.3, False)


def test_the_physics_mutex_is_the_worlds_lock(run):
    core, world = run(body("box"))
    with world.Physics().GetPhysicsUpdateMutex():
        assert core.lock.owned()
    assert not core.lock.owned()
    assert world.WorldPoseMutex() is core.lock


def test_models_by_place_and_new_names(run):
    _, world = run(body("box", pose="0 0 1 0 0 0", link=collision(BOX)), body("box_0"), GROUND)
    assert world.ModelBelowPoint((0, 0, 5)).GetName() == "box"
    assert world.GetModelBelowPoint((7, 0, 5)).GetName() == "ground_plane"
    assert world.UniqueModelName("box") == "box_1"
    assert world.UniqueModelName("ball") == "ball"
    assert world.StripWorldName("default::box") == "box"
    world.ModelByName("box").SetLinearVel((1, 0, 0))
    world.ResetPhysicsStates()
    assert world.ModelByName("box").WorldLinearVel() == Vector3d()
    world.DisableAllModels()
    assert not world.ModelByName("box").GetLink().GetEnabled()
    world.EnableAllModels()
    assert world.ModelByName("box").GetLink().GetEnabled()


def test_worlds_are_paused_and_stopped_by_functions(run):
    _, world = run(body("box"))
    physics.pause_world(world, True)
    assert world.IsPaused()
    physics.pause_worlds(False)
    assert not world.IsPaused()
    assert physics.worlds_running()
    physics.stop_worlds()
    assert not physics.worlds_running()
    assert physics.getUniqueId() < physics.getUniqueId()


def test_the_solver_has_methods_of_its_own(run):
    _, world = run(body("box"))
    engine = world.Physics()
    for name, value in (("SORPGSIters", 77), ("SORPGSW", 1.1), ("WorldERP", 0.3), ("WorldCFM", 0.01)):
        getattr(engine, f"Set{name}")(value)
        assert getattr(engine, f"Get{name}")() == value
    assert engine.GetParam("iters") == 77
    engine.SetMaxContacts(4)
    assert engine.GetParam("max_contacts") == engine.GetMaxContacts() == 4
    assert engine.GetSDF().GetName() == "physics"


def test_momentum_and_damping_of_links(run):
    _, world = run(body("top", gravity="false"))
    link = world.ModelByName("top").GetLink()
    link.SetAngularVel((0, 0, 3))
    assert link.WorldAngularMomentum() == Vector3d(0, 0, 3)  # its moments are 1 kg m^2
    link.SetLinearDamping(0.1)
    link.SetAngularDamping(0.2)
    assert (link.GetLinearDamping(), link.GetAngularDamping()) == (0.1, 0.2)
    collisions = link.GetCollisions()
    assert [link.GetCollisionById(part.GetId()) for part in collisions] == collisions
    assert world.ModelByName("top").GetChildLink("link") is link


def test_errors_have_the_accessors_of_classic(run):
    from libgz.classic import common

    _, world = run(body("box"))
    with pytest.raises(common.Exception, match="pyhsics") as caught:
        world.Physics().SetParam("pyhsics", 1)
    assert common.Exception is GazeboError
    assert caught.value.GetErrorStr() == str(caught.value)
    assert caught.value.GetErrorFile().endswith("engine.py")


def test_the_difference_of_two_states_is_what_has_changed():
    text = """<sdf version='1.6'><world name='w'><model name='m'><pose>0 0 9 0 0 0.3</pose><link name='a'/>
        <link name='b'><gravity>0</gravity></link>
        <joint name='j' type='revolute'><parent>a</parent><child>b</child><axis><xyz>0 0 1</xyz></axis>
        </joint></model><light name='l' type='point'><pose>0 0 3 0 0 0</pose></light></world></sdf>"""
    with libgz.World.from_string(text) as core:
        core.attach_era()
        world = core.facade
        old = WorldState(world)
        assert (old - old).IsZero()
        world.ModelByName("m").GetJoint("j").SetVelocity(0, 2.0)
        world.LightByName("l").SetWorldPose(Pose3d(1, 0, 3, 0, 0, 0))
        core.run(0.1)
        new = WorldState(world)
        change = new - old
        model = change.GetModelState("m")
        assert model.Pose().Z() == pytest.approx(new.GetModelState("m").Pose().Z() - 9.0)
        assert model.GetJointState("j").Position(0) == pytest.approx(0.2, abs=0.01)
        assert change.GetLightState("l").Pose().X() == 1.0
        again = old + change
        assert not change.IsZero()
        for link in ("a", "b"):
            one, two = (state.GetModelState("m").GetLinkState(link) for state in (again, new))
            assert one.Pose().Pos().Equal(two.Pose().Pos(), 1e-12)
            assert one.Pose().Rot().Equal(two.Pose().Rot(), 1e-12)
            assert one.Velocity().Pos().Equal(two.Velocity().Pos(), 1e-12)
        with pytest.raises(TypeError):
            new - model


def test_the_tree_of_a_world_ends_at_the_world(run):
    inner = body("inner", pose="0 0 2 0 0 0", link=collision(BOX))
    _, world = run(body("outer", inside=inner))
    outer = world.ModelByName("outer")
    nested = outer.NestedModel("inner")
    link = nested.GetLink("link")
    assert outer.GetParent() is world
    assert (world.GetParent(), world.GetParentModel()) == (None, None)
    assert world.BaseByName(world.Name()) is world
    assert (outer.GetParentId(), world.GetParentId()) == (world.GetId(), 0)
    assert outer.GetParent().GetChild("outer") is outer
    # Of parts, Gazebo finds the model around all nested ones.
    assert (nested.GetParentModel(), link.GetParentModel(), link.GetModel()) == (nested, outer, nested)
    assert link.GetCollision(0).GetParentModel() is outer
    assert (outer.GetLink().IsCanonicalLink(), link.IsCanonicalLink()) == (True, False)
    up, names = link, []
    while up.GetParent():
        up = up.GetParent()
        names.append(up.GetName())
    assert names[-1] == world.Name()


def test_a_point_s_velocity_by_an_offset_in_any_frame(run):
    _, world = run(body("top", pose="0 0 1 0 0 1.5707963267948966", gravity="false"))
    link = world.ModelByName("top").GetLink()
    link.SetLinearVel((0.1, 0.0, 0.0))
    link.SetAngularVel((0.0, 0.0, 2.0))
    assert link.WorldLinearVel((0.5, 0, 0)).Equal(Vector3d(-0.9, 0, 0), 1e-9)
    assert link.WorldLinearVel((0.5, 0, 0), Quaterniond.Identity).Equal(Vector3d(0.1, 1, 0), 1e-9)
    assert link.GetWorldLinearVel((0.5, 0, 0), Quaterniond(0, 0, -math.pi / 2)).Equal(Vector3d(1.1, 0, 0), 1e-9)


def test_wrenches_are_added_and_subtracted():
    one = JointWrench(Vector3d(1, 2, 3), Vector3d(4, 5, 6), Vector3d(7, 8, 9), Vector3d(1, 1, 1))
    both = one + one
    assert (both.body1Force, both.body2Torque) == (Vector3d(2, 4, 6), Vector3d(2, 2, 2))
    assert both - one == one
    with pytest.raises(TypeError):
        one + 1
