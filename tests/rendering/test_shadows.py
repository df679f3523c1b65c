"""Shadows: where they fall, what casts them, and images against golden ones.

To write new golden images, then check them:  LIBGZ_NEW_GOLDENS=1 .venv/bin/pytest tests/rendering/test_shadows.py
"""

import logging
import math

import numpy as np
import pytest
from golden_images import assert_golden

import libgz
from libgz.base.errors import LibraryError, ParameterError
from libgz.base.files import installed_worlds
from libgz.base.geometry import GzPose, GzPosePointAt, GzQuaternFromEuler, GzVector
from libgz.rendering import renderer
from libgz.rendering.camera import Camera
from libgz.rendering.context import CONTEXTS
from libgz.rendering.framing import framed, visible_points

SUN = (
    "<light name='sun' type='directional'><cast_shadows>{}</cast_shadows><diffuse>.8 .8 .8 1</diffuse>"
    "<specular>.2 .2 .2 1</specular><direction>1 0 -1</direction></light>"
)
SPOT = (
    "<light name='spot' type='spot'><pose>0 -3 3 0 0 0</pose><cast_shadows>1</cast_shadows>"
    "<diffuse>.6 .6 .5 1</diffuse><direction>0 1 -1</direction>"
    "<attenuation><range>100</range><linear>0</linear></attenuation>"
    "<spot><inner_angle>.6</inner_angle><outer_angle>1</outer_angle><falloff>1</falloff>"
    "</spot></light>"
)
GROUND = (
    "<model name='g'><static>1</static><link name='l'><visual name='v'><cast_shadows>0</cast_shadows><geometry><plane>"
    "<normal>0 0 1</normal><size>40 40</size></plane></geometry><material><ambient>.4 .4 .4 1</ambient>"
    "<diffuse>.4 .4 .4 1</diffuse></material></visual></link></model>"
)


def shape(geometry, pose, inside="", color="1 .5 .2"):
    return (
        f"<model name='m{pose}'><static>1</static><pose>{pose} 0 0 0</pose><link name='l'><visual name='v'>{inside}"
        f"<geometry>{geometry}</geometry><material><ambient>{color} 1</ambient><diffuse>{color} 1</diffuse></material>"
        "</visual></link></model>"
    )


def box(inside=""):
    """A box whose shadow, with the sun's, is the square from x = 1.5 to 2.5."""
    return shape("<box><size>1 1 .01</size></box>", "0 0 2", inside)


def sdf(*inside, shadows=None, ambient=".3 .3 .3 1"):
    asked = "" if shadows is None else f"<shadows>{shadows}</shadows>"
    scene = f"<scene><ambient>{ambient}</ambient><background>.6 .7 .8 1</background>{asked}</scene>"
    return libgz.World.from_string(f"<sdf version='1.6'><world name='w'>{scene}{''.join(inside)}</world></sdf>")


def from_above(world, shadows=None, at=(2.0, 0.0), size=(80, 60), **options):
    """An image of the ground from a height of 1.5 m, 1 m wide."""
    with Camera(world, *size, hfov=2.0 * math.atan(1.0 / 3.0), near=0.1, **options) as camera:
        camera.options.shadows = shadows
        camera.SetPose(GzPose(GzVector(*at, 1.5), GzQuaternFromEuler(0.0, math.pi / 2.0, 0.0)))
        return camera.Update().copy()


def light_at(world, shadows=True, at=(2.0, 0.0)):
    return int(from_above(world, shadows, at)[30, 40, 0])


@pytest.mark.parametrize("context", CONTEXTS)
def test_a_shadow_is_where_the_sun_puts_it_and_soft_at_its_edge(context, monkeypatch):
    monkeypatch.setenv("LIBGZ_GL", context)
    with sdf(SUN.format(1), GROUND, box()) as world:
        lit, dark = light_at(world, at=(4, 0)), light_at(world)
        assert dark < 0.7 * lit
        # x grows upwards in the image; across the edge at x = 1.5, with 12.5 mm a pixel
        edge = from_above(world, True, at=(1.5, 0.0))[:, 40, 0].astype(int)
        assert edge[:26].max() <= dark + 2
        assert edge[34:].min() >= lit - 2
        steps = np.diff(edge)
        assert (steps >= 0).all()
        assert steps.max() < 0.8 * (lit - dark)
        assert np.ptp(from_above(world, True, at=(4, 0)).astype(int), axis=(0, 1)).max() <= 3  # no acne on the ground


def test_what_casts_shadows():
    with sdf(SUN.format(1), GROUND) as world:
        lit = light_at(world)
    cases = {
        "the light does not": (SUN.format(0), box()),
        "the visual does not": (SUN.format(1), box("<cast_shadows>0</cast_shadows>")),
        "the visual is transparent": (SUN.format(1), box("<transparency>.5</transparency>")),
    }
    for case, (sun, thing) in cases.items():
        with sdf(sun, GROUND, thing) as world:
            assert light_at(world) == pytest.approx(lit, abs=1), case


def test_who_gets_shadows():
    dark = {}
    for asked in (None, 1, 0):
        with sdf(SUN.format(1), GROUND, box(), shadows=asked) as world:
            for wanted in (None, True, False):
                dark[asked, wanted] = light_at(world, wanted) < 0.7 * light_at(world, wanted, at=(4, 0))
    expected = {(None, True), (1, None), (1, True)}
    assert {key for key, value in dark.items() if value} == expected


def test_images_without_shadows_are_the_same_after_one_with():
    with sdf(SUN.format(1), SPOT, GROUND, box(), shape("<sphere><radius>.5</radius></sphere>", "2 0 .5")) as world:
        before = from_above(world, size=(160, 120))
        with Camera(world, 160, 120, hfov=2.0 * math.atan(1.0 / 3.0), near=0.1) as camera:
            camera.SetPose(GzPose(GzVector(2, 0, 1.5), GzQuaternFromEuler(0.0, math.pi / 2.0, 0.0)))
            plain, depth = camera.Update().copy(), camera.depth
            shaded = camera.shaded()
            camera.options.shadows = True
            again = camera.Update().copy()
            assert np.array_equal(camera.depth, depth)
            camera.options.shadows = None
            assert np.array_equal(camera.Update(), plain)
        assert np.array_equal(before, plain)
        assert np.array_equal(shaded, again)
        assert not np.array_equal(shaded, plain)


def test_legacy_cameras_have_none_but_can_be_asked():
    with libgz.World.from_file(installed_worlds() / "pioneer2at.world") as world:
        world.step(50)
        seen = {}
        with Camera(world, 160, 120) as camera:
            camera.SetPose(GzPosePointAt(GzVector(-2, 1.5, 1.5), GzVector(0, 0, 0.2), GzVector(0, 0, 1)))
            for wanted in (None, True):
                camera.options.shadows = wanted
                seen[wanted] = camera.Update().astype(int)
        assert world.backdrop.shadows is None
        assert (np.abs(seen[True] - seen[None]) > 30).any()


def test_faces_without_light_are_not_black_but_a_dark_world_is():
    wall = shape("<box><size>.2 9 9</size></box>", "3 0 0", color="1 1 1")
    with (
        sdf(SUN.format(1).replace("1 0 -1", "-1 0 -1"), wall, ambient="0 0 0 1") as world,
        Camera(world, 8, 6) as camera,
    ):
        camera.options.shadows = True
        assert camera.Update()[3, 4].min() > 25
    with sdf(wall, ambient="0 0 0 1") as world, Camera(world, 8, 6) as camera:
        camera.options.shadows = True
        assert camera.Update()[3, 4].max() == 0


def test_without_shaders_there_are_images_without_shadows_and_one_warning(monkeypatch, caplog):
    def fail(gl):
        raise LibraryError("this OpenGL has no function glCreateProgram")

    monkeypatch.setattr(renderer, "Shading", fail)
    caplog.set_level(logging.WARNING)
    with sdf(SUN.format(1), GROUND, box()) as world, Camera(world, 80, 60) as camera:
        camera.options.shadows = False
        plain = camera.Update().copy()
        camera.options.shadows = True
        for _ in range(3):
            assert np.array_equal(camera.Update(), plain)
    assert [r.message for r in caplog.records if "shadows" in r.message] == [
        "images have no shadows: this OpenGL has no function glCreateProgram"
    ]


def scene():
    things = (
        shape("<box><size>.6 .6 .6</size></box>", "0 0 .3"),
        shape("<sphere><radius>.3</radius></sphere>", "0.9 0.6 .3", color=".3 .5 .9"),
        shape("<cylinder><radius>.2</radius><length>.8</length></cylinder>", "0 -1 .4", color=".4 .8 .4"),
    )
    return sdf(SUN.format(1), SPOT, GROUND, *things, shadows=1)


def legacy():
    return libgz.World.from_file(installed_worlds() / "ptz.world")


CASES = {
    "sun_and_spot": (scene, (-2.2, 1.6, 1.8), (0.3, -0.1, 0.2)),
    "lamp": (legacy, (-1.6, 1.8, 1.5), (1.0, 0.0, 0.2)),
}


@pytest.mark.parametrize("context", CONTEXTS)
@pytest.mark.parametrize("case", CASES)
def test_golden_images(case, context, monkeypatch):
    monkeypatch.setenv("LIBGZ_GL", context)
    build, place, at = CASES[case]
    with build() as world:
        world.step()
        with Camera(world, 160, 120, near=0.1, far=100.0) as camera:
            camera.options.shadows = True
            camera.SetPose(GzPosePointAt(GzVector(*place), GzVector(*at), GzVector(0, 0, 1)))
            actual = camera.Update().copy()
    assert_golden(actual, f"shadows_{case}", context, mean=1.0, limit=24)


# Framing ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("azimuth", "elevation"), [(0.0, 0.0), (2.0, 0.6), (-1.0, 1.2)])
def test_a_framed_body_fills_the_image(azimuth, elevation):
    with sdf(shape("<box><size>2 .3 .5</size></box>", "5 -3 1")) as world:
        points = visible_points(world.model("m5 -3 1").bodies)
        with Camera(world, 80, 60) as camera:
            camera.SetPose(framed(points, azimuth, elevation, (80, 60), camera.hfov, 0.8))
            camera.Update()
            rows, columns = np.nonzero(camera.segmentation)
        wide, high = (np.ptp(columns) + 1) / 80, (np.ptp(rows) + 1) / 60
        assert max(wide, high) == pytest.approx(0.8, abs=0.04)
        assert (columns.min() + columns.max()) / 2 == pytest.approx(39.5, abs=1.5)
        assert (rows.min() + rows.max()) / 2 == pytest.approx(29.5, abs=1.5)


def test_nothing_cannot_be_framed():
    with pytest.raises(ParameterError, match="no points"):
        framed(np.zeros((0, 3)), 0.0, 0.0, (80, 60))
