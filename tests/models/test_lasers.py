"""Observers and lasers while models that they look at are deleted."""

import pytest
from camera_worlds import HEAD
from sensor_worlds import model, ray, sensor, world_of as sdf_world

import libgz

CAMERA = (
    "<model:ObserverCam><id>o</id><xyz>-3 0 3</xyz><rpy>0 40 0</rpy><imageSize>80 60</imageSize>"
    "<updateRate>50</updateRate>{}</model:ObserverCam>"
)
LASER = "<model:SickLMS200><id>{}</id><xyz>0 {} 0.3</xyz></model:SickLMS200>"


def world_of(*parts):
    return libgz.World.from_string(f"{HEAD.format('')}{''.join(parts)}</gz:world>")


@pytest.mark.parametrize(
    ("kind", "inside"),
    [
        ("SickLMS200", ""),
        ("Pioneer2AT", ""),
        ("Pioneer2DX", "<model:Pioneer2Sonars/><model:Pioneer2Gripper/>"),
        ("Pioneer2AT", LASER.format("own", 0)),
        ("B21R", ""),
    ],
)
def test_an_observer_that_shows_rays_goes_on_after_a_deletion(kind, inside, caplog):
    deleted = f"<model:{kind}><id>gone</id>{inside}</model:{kind}>"
    with world_of(CAMERA.format("<displayRays>true</displayRays>"), deleted, LASER.format("stays", 4)) as world:
        kept = None  # a reference, as a plugin may have
        world.step(10)
        kept = set(world.engine.ray_bundles)
        guicam = world.interface("guicam", "o")
        before = guicam.sim_time
        world.DeleteModel("gone")
        world.step(20)
        assert guicam.sim_time == pytest.approx(before + 0.4)
        assert [bundle.body.model.GetId() for bundle in world.engine.ray_bundles] == ["stays"]
        assert len(kept) > 1
    assert not [record for record in caplog.records if record.levelname == "ERROR"]


def test_rays_of_a_deleted_sdf_model_are_not_shown():
    laser = sensor("ray", ray(3, (-1, 1)), more="<visualize>true</visualize>")
    with sdf_world(model("m", laser)) as world:
        world.step(3)
        kept = set(world.engine.ray_bundles)
        assert len(kept) == 1
        world.DeleteModel("m")
        world.step(3)
        assert not world.engine.ray_bundles


def test_readings_of_a_laser_outlive_what_it_saw():
    marks = "<retro>1</retro><fiducial>7</fiducial>"
    solid = f"<model:SimpleSolid><id>s</id><xyz>2 0 0</xyz><size>.5 2 1</size>{marks}</model:SimpleSolid>"
    with world_of(LASER.format("l", 0), solid) as world:
        world.step(12)
        laser = world.model("l")
        assert laser.fiducials()[0][0] == 7
        world.DeleteModel("s")
        world.step(1)  # which is not one of the laser's
        assert laser.fiducials() == []
        assert {laser.rays.GetRetro(i) for i in range(91)} == {0.0}
        assert {laser.rays.GetFiducial(i) for i in range(91)} == {-1}


@pytest.mark.parametrize(
    ("quirks", "bright"), [("", [0, 1, 1, 1]), ("wholeRetro", [0, 0, 0, 1]), ("true", [0, 0, 0, 1])]
)
def test_intensity_of_a_fraction_of_retro(quirks, bright):
    found = []
    for retro in (0.49, 0.5, 0.99, 1.0):
        solid = f"<model:SimpleSolid><xyz>2 0 0</xyz><size>.5 2 1</size><retro>{retro}</retro></model:SimpleSolid>"
        with world_of(
            f"<param:Global><legacyQuirks>{quirks}</legacyQuirks></param:Global>", LASER.format("l", 0), solid
        ) as world:
            world.step(12)
            found.append(world.interface("laser", "l").all_intensities[90])
    assert found == bright


def test_neighbours_with_one_number_are_one_object():
    solid = "<model:SimpleSolid><xyz>2 {} 0</xyz><size>.2 .4 1</size><fiducial>{}</fiducial></model:SimpleSolid>"
    solids = [solid.format(y, number) for y, number in ((-0.8, 3), (-0.4, 4), (0.0, 4), (0.4, 5), (1.2, 5))]
    with world_of(LASER.format("l", 0), *solids) as world:
        world.step(12)
        laser = world.model("l")
        runs = laser.rays.hits()
        assert [first for first, _, _ in runs] + [91] == [0, *(end for _, end, _ in runs)]
        assert sum(geom is not None for _, _, geom in runs) == 5
        assert [(number, round(y, 1)) for number, _, y, _ in laser.fiducials()] == [
            (3, -0.8),
            (4, -0.2),
            (5, 0.4),
            (5, 1.2),
        ]
