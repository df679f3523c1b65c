"""Ranges read from rendered depths, compared with formulas."""

import math

import numpy as np
import pytest
from sdf_worlds import link, model, world

from libgz.base.geometry import GzPose, GzQuaternFromEuler, GzVector, rotate
from libgz.rendering.depth_scan import DepthScan

BOX = "<geometry><box><size>{} {} {}</size></box></geometry>"


def visual(name, size, pose):
    return f"<visual name='{name}'><pose>{pose}</pose>{BOX.format(*size)}</visual>"


def room(half):
    """Six plates around the origin: a cube of twice this size inside."""
    plates = []
    for axis in range(3):
        for side in (-1, 1):
            size = [2 * half + 1] * 3
            size[axis] = 0.1
            place = [0.0, 0.0, 0.0]
            place[axis] = side * (half + 0.05)
            plates.append(visual(f"v{axis}{side}", size, " ".join(map(str, [*place, 0, 0, 0]))))
    return model("room", "<static>1</static>", link("l", *plates))


def sphere(count, seed):
    found = np.random.default_rng(seed).normal(size=(count, 3))
    return found / np.linalg.norm(found, axis=1, keepdims=True)


@pytest.mark.parametrize("spacing", [0.05, 0.005])
@pytest.mark.parametrize("angles", [(0, 0, 0), (0.4, -0.7, 2.0)])
def test_all_around_a_room(load, spacing, angles):
    made = load(world(room(3.0)))
    directions, turn = sphere(500, 1), GzQuaternFromEuler(*angles)
    place = np.array((0.5, -1.0, 0.2))
    with DepthScan(made, directions, spacing, 0.1, 30.0) as scan:
        ranges = scan.ranges(GzPose(GzVector(*place), turn))
    ahead = np.array([tuple(rotate(turn, row)) for row in directions])
    expected = np.min((3.0 * np.sign(ahead) - place) / ahead, axis=1)
    off = np.abs(ranges / expected - 1.0)
    assert np.quantile(off, 0.9) < 1e-4
    assert off.max() < 4.0 * spacing  # where two walls meet


def test_a_level_row_sees_edges_to_half_its_spacing(load):
    made = load(world(model("m", "<static>1</static>", link("l", visual("v", (0.2, 1, 2), "5 0 0 0 0 0")))))
    yaws = np.linspace(-0.3, 0.3, 121)
    directions = np.stack([np.cos(yaws), np.sin(yaws), np.zeros(121)], axis=1)
    with DepthScan(made, directions, 0.005, 0.1, 30.0) as scan:
        ranges = scan.ranges(GzPose())
        assert np.isinf(scan.ranges(GzPose(GzVector(9, 0, 0)))).all()
    edge = math.atan2(0.5, 4.9)
    inside, outside = np.abs(yaws) < edge - 0.0025, np.abs(yaws) > edge + 0.0025
    assert ranges[inside] == pytest.approx(4.9 / np.cos(yaws[inside]), rel=1e-4)
    assert np.isinf(ranges[outside]).all()


def test_what_is_nearer_is_not_seen(load):
    near, far = visual("near", (0.1, 1, 1), "0.3 0 0 0 0 0"), visual("far", (0.1, 9, 9), "3.05 0 0 0 0 0")
    made = load(world(model("m", "<static>1</static>", link("l", near, far))))
    with DepthScan(made, [(1.0, 0.0, 0.0)], 0.1, 0.5, 30.0) as scan:
        assert scan.ranges(GzPose()) == pytest.approx([3.0], rel=1e-4)
