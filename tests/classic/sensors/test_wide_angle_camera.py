"""Cameras with a wide angle: where lights of the horizon are shown, by the formulas of their projections."""

import math

import numpy as np
import pytest

from libgz import World
from libgz.classic.math import Vector3d
from libgz.classic.sensors import SensorManager

SIZE = 240
FORMULAS = {
    "gnomonical": math.tan,
    "stereographic": lambda angle: 2.0 * math.tan(angle / 2.0),
    "equidistant": lambda angle: angle,
    "equisolid_angle": lambda angle: 2.0 * math.sin(angle / 2.0),
    "orthographic": math.sin,
}
CUSTOM = "<custom_function><c1>1.1</c1><c2>1.5</c2><c3>0.1</c3><f>0.7</f><fun>sin</fun></custom_function>"


def ball(number, *place):
    return (
        f"<model name='ball{number}'><static>1</static><pose>{' '.join(map(str, place))} 0 0 0</pose><link name='l'>"
        "<visual name='v'><geometry><sphere><radius>0.4</radius></sphere></geometry>"
        "<material><emissive>1 0 0 1</emissive><diffuse>1 0 0 1</diffuse></material></visual></link></model>"
    )


@pytest.fixture
def load():
    worlds = []

    def loaded(*values, **options):
        worlds.append(world_of(*values, **options))
        return worlds[-1]

    yield loaded
    for world in worlds:
        world.close()


def world_of(lens, hfov, places=(), height=SIZE):
    """A world with a camera at the origin that looks along +x, and bright balls at angles (yaw, pitch) about it."""
    balls = "".join(
        ball(i, 10.0 * math.cos(p) * math.cos(y), 10.0 * math.cos(p) * math.sin(y), 10.0 * math.sin(p))
        for i, (y, p) in enumerate(places)
    )
    return World.from_string(
        "<sdf version='1.6'><world name='default'><scene><ambient>1 1 1 1</ambient><background>0 0 1 1</background>"
        f"<grid>0</grid></scene>{balls}<model name='m'><static>1</static><link name='l'>"
        f"<sensor name='s' type='wideanglecamera'><camera><horizontal_fov>{hfov}</horizontal_fov><image><width>{SIZE}"
        f"</width><height>{height}</height></image><clip><near>0.1</near><far>50</far></clip><lens>{lens}</lens></camera>"
        "<always_on>1</always_on><update_rate>10</update_rate></sensor></link></model></world></sdf>"
    )


def image_of(core):
    core.run(0.3)
    sensor = SensorManager.Instance().GetSensor("default::m::l::s")
    data = np.frombuffer(sensor.ImageData(), np.uint8).reshape(sensor.ImageHeight(), sensor.ImageWidth(), 3)
    return sensor, data.astype(int)


def middle_of_ball(image):
    rows, columns = np.nonzero(image[:, :, 0] > 100)
    return columns.mean() + 0.5, rows.mean() + 0.5


@pytest.mark.parametrize("kind", FORMULAS)
@pytest.mark.parametrize("angle", [0.4, 1.1])
def test_directions_are_shown_where_the_projection_says(load, kind, angle):
    hfov, formula = 2.6, FORMULAS[kind]
    lens = f"<type>{kind}</type><scale_to_hfov>true</scale_to_hfov><cutoff_angle>3</cutoff_angle>"
    sensor, image = image_of(load(lens, hfov, [(angle, 0.0)]))
    column, row = middle_of_ball(image)
    expected = SIZE / 2.0 * (1.0 - formula(angle) / formula(hfov / 2.0))  # to the left
    assert (column, row) == pytest.approx((expected, SIZE / 2.0), abs=1.2)
    place = sensor.Camera().Project(Vector3d(10.0 * math.cos(angle), 10.0 * math.sin(angle), 0.0))
    assert (place.X(), place.Y()) == (math.floor(expected), SIZE // 2)
    _, way = sensor.Camera().CameraToViewportRay(expected, SIZE / 2.0)
    assert tuple(way) == pytest.approx((math.cos(angle), math.sin(angle), 0.0), abs=1e-9)


def test_an_own_function_is_used_and_f_holds_without_scaling(load):
    lens = f"<type>custom</type>{CUSTOM}<scale_to_hfov>false</scale_to_hfov><cutoff_angle>1.5</cutoff_angle>"
    _, image = image_of(load(lens, 2.0, [(0.0, 0.6)]))
    radius = 1.1 * 0.7 * math.sin(0.6 / 1.5 + 0.1)
    assert middle_of_ball(image) == pytest.approx((SIZE / 2.0, SIZE / 2.0 * (1.0 - radius)), abs=1.2)


def test_what_is_behind_is_shown_and_nothing_beyond_the_cutoff(load):
    lens = "<type>equidistant</type><scale_to_hfov>true</scale_to_hfov><cutoff_angle>{}</cutoff_angle>"
    places = [(math.pi - 0.5, 0.0)]
    sensor, image = image_of(load(lens.format(3.1415), 2.0 * math.pi, places))
    share = (math.pi - 0.5) / math.pi
    assert middle_of_ball(image) == pytest.approx((SIZE / 2.0 * (1.0 - share), SIZE / 2.0), abs=1.5)
    assert image[0, 0].tolist() == [0, 0, 0]  # r is above 1 in the corners
    assert sensor.Camera().HFOV().Radian() == pytest.approx(2.0 * math.pi)


def test_the_cutoff_is_a_circle(load):
    lens = "<type>equidistant</type><scale_to_hfov>true</scale_to_hfov><cutoff_angle>1</cutoff_angle>"
    _, image = image_of(load(lens, 3.0, height=120))
    column, row = np.meshgrid(np.arange(SIZE) + 0.5 - SIZE / 2.0, np.arange(120) + 0.5 - 60.0)
    angle = np.hypot(column, row) / (SIZE / 2.0) * 1.5
    assert not image[angle > 1.02].any()
    assert (image[angle < 0.98].sum(axis=1) > 0).all()


@pytest.mark.parametrize(
    ("lens", "words"),
    [
        ("<type>wide</type>", "there is no lens 'wide'"),
        ("<type>custom</type>", "needs a <custom_function>"),
        ("<type>custom</type><custom_function><c1>0</c1></custom_function>", "not 0 but for c3"),
        ("<type>custom</type><custom_function><fun>exp</fun></custom_function>", "it must be one of tan, sin, id"),
        ("<type>gnomonical</type>", "a lens cannot show 4 rad by tan"),
    ],
)
def test_lenses_that_cannot_be_are_replaced_with_a_warning(load, caplog, lens, words):
    image_of(load(f"{lens}<scale_to_hfov>true</scale_to_hfov>", 4.0))
    assert words in caplog.text
    assert "stereographic is used" in caplog.text
