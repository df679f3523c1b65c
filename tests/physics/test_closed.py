"""What was closed changes nothing: its row belongs to another object soon. And ODE gets nothing but what it can use."""

import threading
import time

import numpy as np
import pytest

from libgz.base.errors import ClosedError, GazeboError, ParameterError
from libgz.base.geometry import GzPose, GzQuatern, GzVector
from libgz.ode.types import Surface
from libgz.physics.body import Body
from libgz.physics.engine import Engine
from libgz.physics.geoms import BoxGeom, LightGeom, SphereGeom
from libgz.physics.joint import HingeJoint, Joint, SliderJoint
from libgz.physics.mass import box_mass
from libgz.physics.space import Space
from libgz.physics.two_axes import Hinge2Joint

POSE = GzPose(GzVector(1, 2, 3), GzQuatern(1, 0, 0, 0))
OF_BODIES = {
    "SetPose": (POSE,),
    "SetLinearVel": ((1, 2, 3),),
    "AddForce": (1, 2, 3),
    "SetGravityMode": (False,),
    "set_auto_disable": (True,),
    "set_kinematic": (True,),
    "set_damping": (0.5, 0.5),
    "SetMassMatrix": (box_mass(1, 1, 1),),
    "Enable": (True,),
    "SetFiniteRotationMode": (1,),
    "UpdateCoM": (),
    "GetPose": (),
    "GetLinearAccel": (),
    "GetWeight": (),
    "GetMass": (),
    "IsEnabled": (),
}
OF_GEOMS = {
    "SetMass": (2.0,),
    "SetFriction": (0.1,),
    "SetBounce": (0.1,),
    "SetHardness": (10.0, 1.0),
    "set_surface": (Surface.MAX_VEL, 7.0),
    "surface": (Surface.KP,),
    "SetCategoryBits": (4,),
    "SetCollideBits": (4,),
    "bounds": (),
}
OF_JOINTS = {
    "SetParam": (2, 1.0),
    "SetAnchor": ((1, 1, 1),),
    "SetAxis": ((0, 1, 0),),
    "set_spring": (1.0, 1.0),
    "Detach": (),
    "reset_turns": (),
    "count_turns_from": (0, 5.0),
    "GetAngle": (),
    "GetParam": (2,),
}


@pytest.fixture
def engine():
    return Engine()


def hinged(engine):
    """Two bodies with a box each, at a hinge."""
    bodies = [Body(engine, name) for name in ("one", "two")]
    for number, body in enumerate(bodies):
        BoxGeom(body, engine.top, 1, 1, 1)
        body.SetPosition((3 * number, 0, 0))
    hinge = HingeJoint(engine)
    hinge.Attach(*bodies)
    hinge.SetAnchor((1, 0, 0))
    hinge.SetAxis((0, 0, 1))
    return bodies[0], bodies[0].geoms[0], hinge


@pytest.mark.parametrize(("part", "calls"), [(0, OF_BODIES), (1, OF_GEOMS), (2, OF_JOINTS)])
def test_a_closed_object_does_not_change_one_that_has_its_row(engine, part, calls):
    closed = hinged(engine)[part]
    engine.advance()
    for thing in reversed([*engine.bodies.values(), *engine.geoms.values(), *engine.joints.values()]):
        thing.close()
    new = hinged(engine)[part]
    assert new.row == closed.row
    engine.advance()
    before, tables = engine.get_state(), engine.tables
    surface, springs, ids = (np.array(t) for t in (tables.geoms.surface, tables.joints.springs, tables.joints.ids))
    for name, arguments in calls.items():
        with pytest.raises(ClosedError, match="was closed"):
            getattr(closed, name)(*arguments)
    after = engine.get_state()
    assert {key: value for key, value in before.items() if after[key] != value} == {}
    assert (tables.geoms.surface == surface).all()
    assert (tables.joints.springs == springs).all()
    assert (tables.joints.ids == ids).all()
    engine.wake()
    engine.advance()


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda engine, other, geom: HingeJoint(engine).Attach(geom, None), "bodies of its world; <BoxGeom"),
        (lambda engine, other, geom: HingeJoint(engine).Attach(Body(other), None), "bodies of its world; <Body"),
        (lambda engine, other, geom: HingeJoint(engine).Attach(geom.body, 3), "bodies of its world; 3 is none"),
        (lambda engine, other, geom: Hinge2Joint(engine).Attach(geom, geom.body), "bodies of its world; <BoxGeom"),
        (lambda engine, other, geom: Joint.AreConnected(geom, geom.body), "joints connect bodies; <BoxGeom"),
        (lambda engine, other, geom: BoxGeom(geom.body, geom.body, 1, 1, 1), "in a space of the world of its body"),
        (lambda engine, other, geom: SphereGeom(geom.body, Space(other), 1), "in a space of the world of its body"),
        (lambda engine, other, geom: BoxGeom(geom, engine.top, 1, 1, 1), "a geom belongs to a body; <BoxGeom"),
        (lambda engine, other, geom: geom.move_to(Space(other)), "can be moved to a space of its world"),
        (lambda engine, other, geom: geom.body.SetMassMatrix(5.0), "takes a mass matrix; 5.0 is none"),
        (lambda engine, other, geom: HingeJoint(engine).GetJointBody(2), "has the bodies 0 and 1"),
    ],
)
def test_what_ode_cannot_use_is_refused(engine, make, message):
    """ODE ends the process for a handle of another kind or world."""
    geom = BoxGeom(Body(engine, "body"), engine.top, 1, 1, 1)
    with pytest.raises(ParameterError, match=message):
        make(engine, Engine(), geom)
    engine.advance()


@pytest.mark.parametrize("dummy", [False, True])
def test_a_closed_body_gets_no_geom(engine, dummy):
    body = Body(engine, "body", dummy)
    body.close()
    for make in (lambda: BoxGeom(body, engine.top, 1, 1, 1), lambda: LightGeom(body, None), lambda: engine.wake()):
        try:
            make()
        except GazeboError as error:
            assert isinstance(error, ClosedError)
    assert not engine.geoms
    engine.get_state()


def test_turns_of_a_detached_joint_can_be_reset(engine):
    """ODE crashes where it is asked for the position of a slider without bodies."""
    body, slider = Body(engine, "body"), SliderJoint(engine)
    slider.Attach(body, None)
    slider.Detach()
    slider.reset_turns()
    engine.advance()
    assert slider.GetPosition() == 0.0


def test_a_stale_state_is_read_between_steps(engine):
    """While a thread steps, ODE has half of the new state."""
    body, geom, hinge = hinged(engine)
    reads = [body.GetPose, hinge.GetAngle, body.GetMass, geom.bounds, lambda: hinge.GetParam(2), hinge.GetAnchor]
    for read in reads:
        body.SetPosition((0, 0, 1))
        thread = threading.Thread(target=read)
        with engine.lock:
            thread.start()
            while not engine.lock.waiting and thread.is_alive():
                time.sleep(0.001)
            assert engine.lock.waiting
        thread.join()
