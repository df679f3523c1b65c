"""Lenses: where pinholes and distortions show points, compared with their formulas."""

import math

import numpy as np
import pytest
from sdf_worlds import link, model, world

from libgz.base.errors import ParameterError
from libgz.base.geometry import GzPose
from libgz.rendering.camera import Camera
from libgz.rendering.lens import Distortion, Intrinsics, Lens

HFOV = 2.0 * math.atan(0.5)
FOCAL = 200.0  # of 200 px with this field of view


def box(x, y, size=0.1):
    shape = f"<geometry><box><size>{size} {size} {size}</size></box></geometry>"
    red = "<material><ambient>1 0 0 1</ambient><diffuse>1 0 0 1</diffuse></material>"
    return f"<visual name='v'><pose>{1.0 + size / 2} {-x} {-y} 0 0 0</pose>{shape}{red}</visual>"


def seen(load, lens, place, size=0.1):
    """(column, row, width, height) of the front of a box at (right, down) of the plane at distance 1 [px]."""
    made = load(world(model("m", "<static>1</static>", link("l", box(*place, size)))))
    with Camera(made, 200, 150, HFOV, near=0.05) as camera:
        camera.lens = lens
        camera.SetPose(GzPose())
        image = camera.Update().astype(int)
        depth = camera.depth
    red = (image[..., 0] > image[..., 1] + 40) & (depth < 1.01)
    rows, columns = np.nonzero(red)
    return columns.mean() + 0.5, rows.mean() + 0.5, np.ptp(columns) + 1, np.ptp(rows) + 1


@pytest.mark.parametrize(
    ("pinhole", "place"),
    [
        (Intrinsics(200, 200, 100, 75), (0.0, 0.0)),
        (Intrinsics(200, 200, 120, 60), (0.0, 0.0)),
        (Intrinsics(150, 300, 80.5, 90.25), (0.1, -0.05)),
        (Intrinsics(200, 200, 100, 75, 50), (0.0, 0.2)),
    ],
)
def test_a_pinhole_shows_points_where_its_matrix_says(load, pinhole, place):
    column, row, width, height = seen(load, Lens(200, 150, HFOV, pinhole, None), place)
    x, y = place
    assert column == pytest.approx(pinhole.fx * x + pinhole.s * y + pinhole.cx, abs=0.6)
    assert row == pytest.approx(pinhole.fy * y + pinhole.cy, abs=0.6)
    assert height == pytest.approx(0.1 * pinhole.fy, abs=1.1)
    if not pinhole.s:
        assert width == pytest.approx(0.1 * pinhole.fx, abs=1.1)


@pytest.mark.parametrize("bent", [Distortion(k1=0.3), Distortion(k1=0.1, k2=-0.2, p1=0.02, p2=-0.03), Distortion()])
def test_a_distortion_moves_points_as_its_formula_says(load, bent):
    column, row, _, _ = seen(load, Lens(200, 150, HFOV, None, bent), (0.25, 0.15), size=0.03)
    shown = bent.forward(np.array([FOCAL * 0.25 / 200]), np.array([FOCAL * 0.15 / 150]))
    assert column == pytest.approx(100 + 200 * shown[0][0], abs=0.8)
    assert row == pytest.approx(75 + 150 * shown[1][0], abs=0.8)


# Three boxes of 0.1 m, 2 m before a camera of 400 x 300 pixels and 1.5 rad: where the real Gazebo 11.1 shows them [px].
PLACES = ((0.0, 0.0), (-0.75, 0.0), (0.5, -0.5))
BESIDE = [
    (Distortion(), [(199.5, 149.5), (37.8, 149.5), (307.0, 42.0)]),
    (Distortion(0.2), [(199.5, 149.5), (32.9, 149.5), (311.4, 37.7)]),
    (Distortion(-0.25), [(199.5, 149.5), (22.5, 149.5), (316.1, 32.7)]),
    (Distortion(-0.25, 0.12, 0.0, -0.0003, -0.0003), [(199.5, 149.5), (27.7, 149.5), (312.9, 36.3)]),
    (Distortion(-0.25, 0.12, 0.0, 0.02, 0.01, (0.5, 0.4)), [(200.0, 149.9), (30.7, 149.0), (313.6, 36.2)]),
]


@pytest.mark.parametrize(("bent", "places"), BESIDE)
def test_a_distortion_shows_points_where_gazebo_does(bent, places):
    lens = Lens(400, 300, 1.5, None, bent)
    rows, columns = np.mgrid[: lens.height, : lens.width]
    focal = lens.width / (2.0 * math.tan(0.5 * lens.hfov))
    across, down = ((v - 0.5 * side + 0.5) / focal for v, side in ((columns, lens.width), (rows, lens.height)))
    for (x, y), place in zip(PLACES, places, strict=True):
        plain = np.hypot((across - x) / 0.025, (down - y) / 0.025) < 1.0
        shown = np.nonzero(lens.nearest(plain, 0.0))[::-1]
        assert [one.mean() for one in shown] == pytest.approx(place, abs=1.0)


def test_backward_inverts_forward():
    bent = Distortion(-0.25, 0.12, -0.01, 0.001, -0.002)
    x, y = np.meshgrid(np.linspace(-0.6, 0.6, 13), np.linspace(-0.4, 0.4, 9))
    back = bent.backward(*bent.forward(x, y))
    assert back[0] == pytest.approx(x, abs=1e-5)
    assert back[1] == pytest.approx(y, abs=1e-5)


def test_barrel_distortion_leaves_no_black_corners(load):
    made = load(world(model("m", "<static>1</static>", link("l", box(0, 0, 0.5)))))
    with Camera(made, 200, 150, HFOV, near=0.05) as camera:
        camera.lens = Lens(200, 150, HFOV, None, Distortion(k1=-0.3))
        image = camera.Update()
    assert (image[[0, 0, -1, -1], [0, -1, 0, -1]].sum(axis=1) > 0).all()


@pytest.mark.parametrize("pinhole", [Intrinsics(0, 1, 1, 1), Intrinsics(1, -1, 1, 1), Intrinsics(1, 1, math.inf, 1)])
def test_impossible_pinholes_are_errors(pinhole):
    with pytest.raises(ParameterError, match="intrinsics are"):
        Lens(10, 10, 1.0, pinhole, None)


def test_extreme_lenses_have_bounded_images():
    for pinhole in (Intrinsics(1e9, 1e9, 5, 5), Intrinsics(1e-6, 1e-6, 5, 5), Intrinsics(10, 10, 1e9, -1e9)):
        for bent in (None, Distortion(k1=1e9, p1=-1e9), Distortion(k1=-1e9)):
            with np.errstate(all="ignore"):
                lens = Lens(10, 10, 1.0, pinhole, bent)
            assert max(lens.width, lens.height) <= 4096
