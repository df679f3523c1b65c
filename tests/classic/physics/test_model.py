"""Model: poses, velocities, links, joints and nested models of a model."""

import pytest
from plugin_worlds import body

from libgz.base.errors import ClosedError, ParameterError
from libgz.classic.math import Pose3d, Vector3d
from libgz.classic.physics import Base

INNER = "<model name='inner'><pose>0 0 1 0 0 0</pose><link name='tip'/></model>"
FIXED = "<joint name='hook' type='fixed'><parent>link</parent><child>inner::tip</child></joint>"


@pytest.fixture
def model(run):
    """A model with one link and a nested model that is fixed to it."""
    _, view = run(body("outer", pose="1 0 0 0 0 0", gravity="false", inside=INNER + FIXED), version="1.7")
    return view.ModelByName("outer")


def test_no_link_can_be_added_to_a_removed_model(run):
    _, view = run(body("box"))
    box = view.ModelByName("box")
    view.RemoveModel(box)
    with pytest.raises(ClosedError, match="was removed from the world"):
        box.CreateLink("more")


def test_a_view_is_always_the_same_object(model):
    world = model.GetWorld()
    assert world.ModelByName("outer") is model is world.ModelByIndex(0) is world.GetModel("outer")
    assert model.GetLink("link") is model.GetLink() is model.GetChild("link")
    assert model.NestedModel("inner").GetParent() is model
    assert model.core.facade is model
    assert model.GetLink().body.facade is model.GetLink()


def test_nested_models_move_with_their_parent(model):
    inner = model.NestedModel("inner")
    model.SetWorldPose(Pose3d(5, 0, 0, 0, 0, 0))
    assert tuple(inner.WorldPose().Pos()) == pytest.approx((5, 0, 1))
    assert tuple(inner.RelativePose().Pos()) == pytest.approx((0, 0, 1))
    model.SetLinkWorldPose(Pose3d(0, 0, 3, 0, 0, 0), "inner::tip")
    assert tuple(model.WorldPose().Pos()) == pytest.approx((0, 0, 2))


def test_velocities_are_those_of_its_own_links(model):
    model.SetLinearVel((1, 0, 0))
    model.SetAngularVel((0, 0, 2))
    for link in model.family_links():
        own = link.GetModel() is model
        expected = (Vector3d(1, 0, 0), Vector3d(0, 0, 2)) if own else (Vector3d(), Vector3d())
        assert (link.WorldCoGLinearVel(), link.WorldAngularVel()) == expected
    assert model.GetWorldEnergyKinetic() == pytest.approx(
        sum(link.GetWorldEnergyKinetic() for link in model.GetLinks())
    )
    model.ResetPhysicsStates()
    assert model.GetWorldEnergyKinetic() == 0.0


def test_names_in_a_model(model):
    assert [link.GetScopedName() for link in model.family_links()] == ["outer::link", "outer::inner::tip"]
    assert model.GetLink("inner::tip") is model.NestedModel("inner").GetLink("tip")
    assert model.GetJoint("hook").GetScopedName(True) == "default::outer::hook"
    assert model.GetByName("tip") is model.GetLink("inner::tip")
    assert model.GetLink("nothing") is model.GetJoint("nothing") is model.NestedModel("nothing") is None
    assert model.Print() == "outer\n  link\n  hook\n  inner\n    tip\n"


def test_a_reset_restores_the_initial_pose(model):
    model.SetInitialRelativePose(Pose3d(0, 7, 0, 0, 0, 0))
    model.SetLinearVel((1, 2, 3))
    model.Reset()
    assert tuple(model.WorldPose().Pos()) == pytest.approx((0, 7, 0))
    assert tuple(model.NestedModel("inner").InitialRelativePose().Pos()) == pytest.approx((0, 0, 1))
    assert model.WorldLinearVel() == Vector3d()


TIP = (
    "<link name='tip'><pose>0 0 1 0 0 0</pose></link><joint name='swing' type='revolute'><parent>link</parent>"
    "<child>tip</child><axis><xyz>1 0 0</xyz></axis></joint>"
)
RESETS = {
    "model": (lambda view: view.ModelByName("arm").Reset(), 0.5),
    "all models": (lambda view: view.ResetEntities(Base.MODEL), 0.5),
    "everything": (lambda view: view.ResetEntities(), 0.0),
}


@pytest.mark.parametrize("how", RESETS)
def test_joints_keep_their_positions_where_models_alone_are_reset(run, how):
    reset, angle = RESETS[how]
    _, view = run(body("arm", pose="1 0 2 0 0 0.3", gravity="false", inside=TIP))
    arm = view.ModelByName("arm")
    swing, tip = arm.GetJoint("swing"), arm.GetLink("tip")
    swing.SetPosition(0, 0.5)
    arm.SetWorldPose(Pose3d(3, 2, 5, 0, 0, 1))
    arm.SetLinearVel((1, 2, 3))
    reset(view)
    assert tuple(arm.WorldPose().Pos()) == pytest.approx((1, 0, 2))
    assert swing.Position(0) == pytest.approx(angle, abs=1e-9)
    assert tip.RelativePose().Rot().Roll() == pytest.approx(angle, abs=1e-9)
    assert tip.WorldLinearVel() == arm.WorldLinearVel() == Vector3d()


def test_an_attached_model_moves_with_the_other(run):
    core, view = run(body("cart", "0 0 9 0 0 0", gravity="false"), body("load", "5 5 9 0 0 0"))
    cart, load = view.ModelByName("cart"), view.ModelByName("load")
    cart.AttachStaticModel(load, Pose3d(0, 0, 1, 0, 0, 0))
    cart.SetLinearVel((1, 0, 0))
    core.step(100)
    before = cart.WorldPose().Pos()
    assert tuple(load.WorldPose().Pos()) == pytest.approx((before.x, before.y, before.z + 1.0), abs=2e-3)
    cart.DetachStaticModel("load")
    core.step(100)
    assert cart.WorldPose().Pos().X() > before.x + 0.05
    assert load.WorldPose().Pos().X() < before.x + 0.01


def test_a_model_is_detached_where_it_cannot_be_placed(run, caplog):
    core, view = run(*(body(name, f"{x} 0 9 0 0 0", gravity="false") for x, name in enumerate("ab")))
    view.ModelByName("a").AttachStaticModel(view.ModelByName("b"), Pose3d(1e9, 0, 0, 0, 0, 0))
    view.ModelByName("a").SetWorldPose(Pose3d(1e9, 0, 0, 0, 0, 0))
    core.step(2)
    assert caplog.text.count("model b is not attached to a any more: position [m] is") == 1


def test_a_model_moves_with_one_that_is_there_and_does_not_lead_it(run):
    core, view = run(*(body(name, f"{x} 0 9 0 0 0", gravity="false") for x, name in enumerate("abc")))
    a, b, c = (view.ModelByName(name) for name in "abc")
    a.AttachStaticModel(b, Pose3d())
    b.AttachStaticModel(c, Pose3d())
    for leader, model in ((a, a), (c, a), (c, b)):
        with pytest.raises(ParameterError, match=f"model '{model.GetName()}' cannot move with '{leader.GetName()}'"):
            leader.AttachStaticModel(model, Pose3d())
    view.RemoveModel(a)
    for leader, model in ((a, b), (b, a)):
        with pytest.raises(ClosedError):
            leader.AttachStaticModel(model, Pose3d())
    core.step(2)


def test_a_profile_takes_what_physics_takes(run):
    core, view = run(body("box"))
    presets = view.PresetMgr()
    for key, value in (("iters", "many"), ("iters", -float("inf")), ("sor", -1.0), ("other", 1), ("iters", object())):
        with pytest.raises(ParameterError):
            presets.SetCurrentProfileParam(key, value)
    assert presets.CurrentProfileParam("iters") == 50
    presets.CreateProfile("mine")
    with pytest.raises(ParameterError):
        presets.SetProfileParam("mine", "iters", object())
    core.set_state(core.get_state())
    assert presets.CurrentProfile("mine")


def test_a_joint_has_forces_on_two_links(model):
    with pytest.raises(ParameterError, match=r"joint 'hook' has links 0, the parent, and 1, the child; not 2"):
        model.GetJoint("hook").LinkForce(2)
    with pytest.raises(ParameterError):
        model.GetJoint("hook").LinkTorque(-1)
