"""Worlds at rest: steps that would change nothing are left out, and nobody sees a difference."""

import pytest

import libgz

BOX = (
    "<model name='b{0}'><pose>{0} 0 {1} 0 0 0</pose><link name='link'><collision name='c'><geometry>"
    "<box><size>.5 .5 .5</size></box></geometry></collision></link></model>"
)
TEXT = (
    "<sdf version='1.6'><world name='w'><include><uri>model://ground_plane</uri></include>"
    f"{BOX.format(0, 0.25)}{BOX.format(1, 0.25)}{BOX.format(2, 0.26)}</world></sdf>"
)
ASLEEP = 2  # `resting` of a world whose steps are left out


def push(world):
    world.body("b0", "link").AddForce(200.0, 0.0, 0.0)


def lift(world):
    world.body("b1", "link").SetPosition((1.0, 0.0, 1.0))


def throw(world):
    world.body("b2", "link").SetLinearVel((-1.0, 0.0, 2.0))


def drop(world):
    body = libgz.Body(world)
    libgz.SphereGeom(body, world.GetSpaceId(), 0.1).SetMass(1.0)
    body.SetPosition((0.0, 0.0, 2.0))


def turn_gravity(world):
    world.engine.gravity = (0.0, 2.0, -9.8)


def wake_past_the_tables(world):
    from libgz.ode.lib import ode

    ode().dBodyEnable(world.body("b1", "link").id)


def push_without_waking(world):
    """A disabled body that does not sleep by itself collects efforts until it is enabled."""
    body = world.body("b1", "link")
    body.set_auto_disable(False)
    body.Enable(False)
    world.step(4)
    body.AddForce(0.0, 50.0, 0.0)
    world.step(3)
    body.Enable(True)


def rewind(world):
    state = world.get_state()
    push(world)
    world.step(5)
    world.set_state(state)


@pytest.mark.parametrize(
    "change", [push, lift, throw, drop, turn_gravity, wake_past_the_tables, push_without_waking, rewind]
)
def test_a_world_at_rest_wakes_as_one_that_computes_every_step(change):
    with libgz.World.from_string(TEXT) as world, libgz.World.from_string(TEXT) as other:
        for one in (world, other):
            one.step(1300)
            assert not any(body.IsEnabled() for body in one.engine.bodies.values())
            one.step(3)
        assert world.engine._context.resting == ASLEEP
        for number in range(60):
            if number == 10:
                change(world)
                change(other)
            other.engine.tables.disturb()
            world.step()
            other.step()
            assert world.engine.states.tobytes() == other.engine.states.tobytes(), number
            assert world.engine.steps == other.engine.steps
        assert world.get_state() == other.get_state()


def test_springs_and_contact_records_keep_a_world_stepping():
    with libgz.World.from_string(TEXT) as world:
        world.step(1300)
        world.engine.record_contacts = True
        world.step(2)
        assert len(world.engine.contacts) > 0
        world.engine.record_contacts = False
        one, two = (world.body(name, "link") for name in ("b0", "b1"))
        hinge = libgz.HingeJoint(world)
        hinge.Attach(one, two)
        hinge.SetAnchor((0.5, 0.0, 0.5))
        hinge.SetAxis((0.0, 1.0, 0.0))
        hinge.set_spring(100.0, 1.0)
        for body in world.engine.bodies.values():
            body.Enable(False)
        world.step(5)
        assert world.engine._context.resting == 0
