"""Lights of Gazebo classic, and what a scene adds: ambient light, fog, sky, grid."""

import math

import numpy as np
import pytest
from classic_scenes import AMBIENT, BEHIND, middle, model, red, see, visual

from libgz.classic import rendering
from libgz.classic.math import Color

DARK = "<scene><ambient>0 0 0 1</ambient><background>0 0 0 1</background></scene>"


def light(kind, inside="", pose="0 0 0 0 0 0"):
    return (
        f"<light name='l' type='{kind}'><pose>{pose}</pose><diffuse>1 1 1 1</diffuse><specular>0 0 0 1</specular>"
        f"<direction>1 0 0</direction>{inside}</light>"
    )


def white(world, **options):
    return middle(see(world, **options))[0]


def test_ambient_light_is_the_scene_s(world_of):
    world = world_of(model(), scene=DARK)
    scene = rendering.get_scene()
    assert white(world) == 0
    scene.SetAmbientColor(Color(0.5, 0.5, 0.5))
    assert white(world) == pytest.approx(127, abs=1)
    scene.SetBackgroundColor(Color(0, 1, 0))
    assert tuple(see(world)[0, 0]) == (0, 255, 0)
    assert (scene.AmbientColor(), scene.GetBackgroundColor()) == (Color(0.5, 0.5, 0.5), Color(0, 1, 0))


def test_directional_light_falls_by_the_cosine(world_of):
    angle = 0.9
    world = world_of(model(pose=f"3 0 0 0 0 {angle}"), light("directional", pose="50 50 50 0 0 0"), scene=DARK)
    pixels = see(world)
    assert np.ptp(pixels, axis=2).max() == 0
    assert np.unique(pixels) == pytest.approx([0, 255 * math.cos(angle), 255 * math.sin(angle)], abs=1)


def test_a_light_without_attenuation_fades_as_in_gazebo(world_of):
    """By 1 / (1 + distance), up to 10 m: the defaults of SDF."""
    wall = visual(geometry="<box><size>.02 .02 .02</size></box>")
    near = {"pose": (2.9, 0, 0, 0, 0, 0), "near": 0.01}
    for distance, bright in ((2.0, 255 / 3.0), (11.0, 0.0)):
        world = world_of(model(inside=wall), light("point", pose=f"{2.99 - distance} 0 0 0 0 0"), scene=DARK)
        assert white(world, **near) == pytest.approx(bright, abs=2)


def test_point_light_fades_and_ends_at_its_range(world_of):
    wall = visual(geometry="<box><size>.02 .02 .02</size></box>")
    fading = "<constant>1</constant><linear>.5</linear><quadratic>.25</quadratic>"
    fading = f"<attenuation><range>{{}}</range>{fading}</attenuation>"
    near = {"pose": (2.9, 0, 0, 0, 0, 0), "near": 0.01}
    world = world_of(model(inside=wall), light("point", fading.format(10), pose="0.99 0 0 0 0 0"), scene=DARK)
    assert white(world, **near) == pytest.approx(255 / (1 + 0.5 * 2 + 0.25 * 4), abs=2)
    world = world_of(model(inside=wall), light("point", fading.format(1.5), pose="0.99 0 0 0 0 0"), scene=DARK)
    assert white(world, **near) == 0
    lamp = rendering.scene.scene_of(world).LightByName("l")
    lamp.SetRange(3.0)
    lamp.SetAttenuation(1.0, 0.0, 0.0)
    assert white(world, **near) == pytest.approx(255, abs=2)
    lamp.SetVisible(False)
    assert white(world, **near) == 0


def test_a_spot_lights_its_cone_only(world_of):
    cone = "<spot><inner_angle>.4</inner_angle><outer_angle>.8</outer_angle><falloff>1</falloff></spot>"
    plane = visual(geometry="<plane><normal>-1 0 0</normal><size>8 8</size></plane>")
    steady = "<attenuation><range>100</range><linear>0</linear></attenuation>"
    world = world_of(model(inside=plane), light("spot", steady + cone), scene=DARK)
    pixels = see(world, hfov=2.0)[24, :, 0].astype(int)
    assert pixels[32] > 240
    angle = np.abs(np.arctan((np.arange(64) + 0.5 - 32) / (32 / math.tan(1.0))))
    assert (pixels[angle > 0.6] == 0).all()
    assert (pixels[angle < 0.1] > 200).all()


def test_a_spot_without_a_cone_lights_nothing_as_in_gazebo(world_of, caplog):
    plane = visual(geometry="<plane><normal>-1 0 0</normal><size>8 8</size></plane>")
    world = world_of(model(inside=plane), light("spot"), scene=DARK)
    assert (see(world, hfov=2.0) == 0).all()
    assert "no <spot>" in caplog.text


def test_several_lights_add_up(world_of):
    both = light("directional").replace("1 1 1 1", "1 0 0 1")
    both += light("directional").replace("1 1 1 1", "0 0 1 1").replace("name='l'", "name='k'")
    world = world_of(model(), both, scene=DARK)
    assert middle(see(world)) == (255, 0, 255)
    scene = rendering.get_scene()
    assert scene.LightCount() == 2
    scene.GetLight("k").SetDiffuseColor(Color(0, 1, 0))
    assert middle(see(world)) == (255, 255, 0)


@pytest.mark.parametrize(
    ("fog", "share"),
    [
        ("<type>linear</type><start>1</start><end>5</end>", (5 - 2.5) / 4),
        ("<type>exp</type><density>.3</density>", math.exp(-0.3 * 2.5)),
        ("<type>exp2</type><density>.3</density>", math.exp(-((0.3 * 2.5) ** 2))),
        ("<type>none</type><density>9</density>", 1.0),
    ],
)
def test_fog(world_of, fog, share):
    scene = AMBIENT.replace("</scene>", f"<fog><color>0 1 0 1</color>{fog}</fog></scene>")
    pixels = see(world_of(model(inside=red()), scene=scene))
    assert middle(pixels) == pytest.approx((255 * share, 255 * (1 - share), 0), abs=3)


def test_a_sky_is_drawn_by_the_time_of_day(world_of):
    noon = see(world_of(scene="<scene><sky><time>12</time></sky></scene>"), pose=(0, 0, 0, 0, -0.5, 0))
    night = see(world_of(scene="<scene><sky><time>0</time></sky></scene>"), pose=(0, 0, 0, 0, -0.5, 0))
    assert noon[0, 0][2] > 150 > 60 > night[0, 0][2]
    assert noon[0, 0][2] > noon[0, 0][0]


def test_only_users_see_the_grid(world_of):
    world = world_of()
    above = {"pose": (0.5, 0.5, 5, 0, math.pi / 2, 0)}
    assert (see(world, **above) == BEHIND).all()
    assert not (see(world, kind=rendering.UserCamera, **above) == BEHIND).all()
    rendering.get_scene().SetGrid(False)
    assert (see(world, kind=rendering.UserCamera, **above) == BEHIND).all()
