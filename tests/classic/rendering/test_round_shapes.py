"""Round shapes in depth images: within 1e-3 of the range inside their silhouettes, whatever their size in the image."""

import math

import numpy as np
import pytest

import libgz
from libgz.classic import sensors

FOV = 1.047


def depth_image(geometry, x, width, height, visual="", fov=FOV, near=0.05):
    model = f"<visual name='v'>{visual}<geometry>{geometry}</geometry></visual>"
    camera = f"""<sensor name='eye' type='depth'><always_on>1</always_on><camera>
      <horizontal_fov>{fov}</horizontal_fov><image><width>{width}</width><height>{height}</height></image>
      <clip><near>{near}</near><far>50</far></clip></camera></sensor>"""
    parts = "".join(
        f"<model name='m{i}'><static>1</static><pose>{at} 0 0 0 0 0</pose><link name='l'>{inside}</link></model>"
        for i, (at, inside) in enumerate(((x, model), (0, camera)))
    )
    with libgz.World.from_string(f"<sdf version='1.6'><world name='default'>{parts}</world></sdf>") as world:
        world.step(2)
        found = sensors.get_sensor("eye").DepthCamera().DepthData()
        return np.array(found, dtype=float).reshape(height, width)


def rays(width, height, fov=FOV):
    """Across and up, of a ray that goes 1 m ahead."""
    focal = width / (2.0 * math.tan(fov / 2.0))
    u, v = (np.arange(width) + 0.5 - width / 2) / focal, (np.arange(height) + 0.5 - height / 2) / focal
    return np.meshgrid(u, -v)


def first_root(a, half_b, c):
    square = half_b * half_b - a * c
    return np.where(square >= 0.0, (half_b - np.sqrt(np.maximum(square, 0.0))) / a, np.inf)


def sphere_depth(radius, x, width, height, fov=FOV):
    u, v = rays(width, height, fov)
    return first_root(1.0 + u * u + v * v, x, x * x - radius * radius)


def cylinder_depth(radius, length, x, width, height, fov=FOV):
    u, v = rays(width, height, fov)
    found = first_root(1.0 + u * u, x, x * x - radius * radius)
    with np.errstate(invalid="ignore"):
        return np.where(np.abs(found * v) < length / 2, found, np.inf)


def check(found, expected):
    hit = np.pad(np.isfinite(expected), 1)
    inside = hit[1:-1, 1:-1] & hit[:-2, 1:-1] & hit[2:, 1:-1] & hit[1:-1, :-2] & hit[1:-1, 2:]
    assert inside.any()
    assert np.abs(found[inside] / expected[inside] - 1.0).max() < 1e-3
    # A silhouette may be off by a fraction of a pixel.
    wide = hit[1:-1, 1:-1] | hit[:-2, 1:-1] | hit[2:, 1:-1] | hit[1:-1, :-2] | hit[1:-1, 2:]
    assert not np.isfinite(found[~wide]).any()


@pytest.mark.parametrize("size", [(320, 240), (640, 480)])
@pytest.mark.parametrize(("radius", "x"), [(0.5, 3.0), (0.5, 1.0), (0.5, 0.62), (2.0, 10.0), (0.1, 5.0), (0.05, 5.0)])
def test_depth_of_spheres(radius, x, size):
    found = depth_image(f"<sphere><radius>{radius}</radius></sphere>", x, *size)
    check(found, sphere_depth(radius, x, *size))


@pytest.mark.parametrize(("radius", "length", "x"), [(0.5, 1.0, 3.0), (0.2, 1.0, 1.0), (0.1, 0.5, 6.0)])
def test_depth_of_cylinders(radius, length, x):
    text = f"<cylinder><radius>{radius}</radius><length>{length}</length></cylinder>"
    check(depth_image(text, x, 640, 480), cylinder_depth(radius, length, x, 640, 480))


def test_depth_of_a_sphere_away_from_the_origin_of_its_link():
    found = depth_image("<sphere><radius>0.5</radius></sphere>", 1.0, 320, 240, "<pose>2 0 0 0 0 0</pose>")
    check(found, sphere_depth(0.5, 3.0, 320, 240))


def near_depths(kind, radius, gap, fov):
    """A shape in front of the camera: found, and expected."""
    x, length = radius + gap, "" if kind == "sphere" else "<length>200</length>"
    found = depth_image(f"<{kind}><radius>{radius}</radius>{length}</{kind}>", x, 200, 200, fov=fov)
    if kind == "sphere":
        return found, sphere_depth(radius, x, 200, 200, fov)
    return found, cylinder_depth(radius, 200.0, x, 200, 200, fov)


@pytest.mark.parametrize(
    ("kind", "radius", "gap", "fov"),
    [("sphere", 20.0, 0.3, 1.5), ("sphere", 100.0, 3.0, 1.5), ("sphere", 2.0, 0.2, 2.0), ("cylinder", 20.0, 0.3, 1.5),
     ("capsule", 2.0, 0.2, 2.0)],
)  # fmt: skip
def test_depth_of_shapes_that_are_near(kind, radius, gap, fov):
    check(*near_depths(kind, radius, gap, fov))


def test_a_sphere_that_touches_the_near_plane_is_cut_within_the_error_of_depth():
    found, expected = near_depths("sphere", 1.0, 0.05, 1.0)
    assert expected[~np.isfinite(found)].max() < 0.05 * 1.001
    seen = np.isfinite(found)
    check(np.where(seen, found, expected), expected)


def tilted_depth(radius, half, x, pitch, width, height, fov):
    """Depth of a cylinder whose axis is turned about y: of its side or of its ends."""
    u, v = rays(width, height, fov)
    # The ray and the camera's place, in the frame of the cylinder.
    ahead = np.cos(pitch) - v * np.sin(pitch), -x * np.cos(pitch)
    along = np.sin(pitch) + v * np.cos(pitch), -x * np.sin(pitch)
    square = ahead[0] ** 2 + u**2
    side = first_root(square, -ahead[0] * ahead[1], ahead[1] ** 2 - radius**2)
    with np.errstate(invalid="ignore"):
        found = np.where(np.abs(along[1] + side * along[0]) < half, side, np.inf)
    for end in (-half, half):
        depth = (end - along[1]) / along[0]
        inside = (ahead[1] + depth * ahead[0]) ** 2 + (depth * u) ** 2 < radius**2
        found = np.where(inside & (depth > 0.0), np.minimum(found, depth), found)
    return found


@pytest.mark.parametrize("pitch", [0.6, 1.0, 1.3, 1.45])
@pytest.mark.parametrize(
    ("radius", "half", "x", "fov"),
    [(0.5, 2.0, 3.0, 1.0), (0.5, 1.0, 2.0, 2.0), (2.0, 5.0, 9.0, 1.5), (0.1, 0.5, 1.0, 0.5)],
)
def test_depth_of_cylinders_whose_end_is_near(radius, half, x, fov, pitch):
    text = f"<cylinder><radius>{radius}</radius><length>{2.0 * half}</length></cylinder>"
    found = depth_image(text, x, 400, 300, f"<pose>0 0 0 0 {pitch} 0</pose>", fov)
    check(found, tilted_depth(radius, half, x, pitch, 400, 300, fov))
