"""What is left out of the search for touching geoms: what does not move, and that nothing movable is near."""

import pytest

import libgz
from libgz.ode.lib import ode

SHAPE = "<geometry><box><size>{0} {0} {0}</size></box></geometry>"


def box(name, place, static, shapes=1):
    parts = "".join(
        f"<collision name='c{i}'><pose>0 0 {i} 0 0 0</pose>{SHAPE.format(1.0)}</collision>" for i in range(shapes)
    )
    return (
        f"<model name='{name}'><static>{int(static)}</static><pose>{place}</pose><link name='l'>{parts}</link></model>"
    )


def world_of(far, movers):
    near = "".join(box(f"under{i}", f"{3 * i} 0 0 0 0 0", True, 1 + i % 2) for i in range(movers))
    moving = "".join(box(f"m{i}", f"{3 * i} 0.2 2.6 0.1 0.2 0", False) for i in range(movers))
    away = "".join(box(f"far{i}", f"{3 * i} 40 0 0 0 0", True, 1 + i % 2) for i in range(far))
    return libgz.World.from_string(f"<sdf version='1.6'><world name='w'>{near}{away}{moving}</world></sdf>")


def states(world, steps=700):
    found = []
    for _ in range(steps // 50):
        world.step(50)
        moving = [body for body in world.engine.bodies.values() if body.model.name.startswith("m")]
        found.append([(*b.GetPose().pos, *b.GetPose().rot, *b.GetLinearVel(), b.IsEnabled()) for b in moving])
    return found


@pytest.mark.parametrize("movers", [3, 70])
def test_what_is_far_changes_nothing(movers):
    """To the bit, whether boxes around each body count or, of many, the one around all."""
    with world_of(0, movers) as alone, world_of(90, movers) as beside:
        few = states(alone, 700 if movers < 10 else 300)
        assert few == states(beside, 700 if movers < 10 else 300)
        assert few[0] != few[-1]


def test_rays_and_bodies_that_come_find_what_was_far():
    with world_of(60, 1) as world:
        world.step(10)
        geoms = [geom for geom in world.engine.geoms.values() if geom.id]
        assert len(geoms) > 60
        assert all(ode().dGeomIsEnabled(geom.id) for geom in geoms)
        (body,) = (body for body in world.engine.bodies.values() if body.model.name == "m0")
        body.SetPose(libgz.GzPose(libgz.GzVector(6.0, 40.0, 1.2), libgz.GzQuatern()))
        body.SetLinearVel((0.0, 0.0, 0.0))
        body.SetAngularVel((0.0, 0.0, 0.0))
        world.step(1000)
        assert body.GetPose().pos.z == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("boxes", [2, 5])
def test_few_that_meet_now_and_then_touch_as_with_the_whole_search(boxes):
    """To the bit: without the two far ones that always meet, steps in which nothing meets do without ODE's search."""
    falling = "".join(box(f"m{i}", f"0.{i} 0.{i}1 {2.6 + 1.5 * i} 0.1 0.{i} 0", False) for i in range(boxes))
    below = box("ground", "0 0 0 0 0 0", True)
    found = []
    for distance in (0.5, 1.5):
        far = "".join(box(f"far{i}", f"{900 + distance * i} 0 0 0 0 0", True) for i in range(2))
        with libgz.World.from_string(
            f"<sdf version='1.6'><world name='w'>{far}{below}{falling}</world></sdf>"
        ) as world:
            found.append(states(world, 1500))
    assert found[0] == found[1]
    assert found[0][0] != found[0][-1]
