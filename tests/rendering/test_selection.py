"""Levels of detail of round geoms that are near: as many segments as the error of depth asks for, within bounds."""

import math

import numpy as np
import pytest

import libgz
from libgz.base.geometry import GzPose
from libgz.rendering.camera import Camera
from libgz.rendering.library import MOST_FINE, Compiled, Look, Table
from libgz.rendering.native import find_native
from libgz.rendering.selection import DEPTH_ERROR, FINE, LEVELS, Rounds, Selector
from libgz.rendering.shot import Content, Item, View

LAST = len(LEVELS) - 1


def segments(radius, gap, fov, near=0.05, finest=LAST, half=0.0):
    """Segments of a round geom ahead of a camera of 200 x 200 pixels."""
    rounds = Rounds(Content(()))
    rounds.items, rounds.radii, rounds.slacks = np.array([0]), np.array([float(radius)]), np.array([1.0])
    rounds.centres, rounds.halves, rounds.finest = np.zeros((1, 3)), np.array([[0.0, 0.0, half]]), np.array([finest])
    view = View(GzPose(), 200, 200, fov, near, 100.0)
    states = np.array([[radius + gap, 0, 0, 1, 0, 0, 0]], dtype=np.float64)
    selectors = [Selector(np.array([float(radius + half)]), rounds, form) for form in (find_native(), None)]
    native, here = (LEVELS[form.select(view, view.eye(), states, ()).levels[0]] for form in selectors)
    assert native == here
    return native


def enough(radius, gap, fov):
    """Segments with which depth is right in all pixels of a sphere that are farther than one pixel from its limb.

    On a ray at an angle to the normal of cosine c, r pi^2 / (2 n^2) of the mesh is that over c of the range.
    """
    focal, away = 100.0 / math.tan(fov / 2.0), radius + gap
    u, v = np.meshgrid(*2 * [np.abs(np.arange(200) - 99.5)])
    pixels = np.hypot(u, v)
    pixels = pixels[pixels < focal * radius / math.sqrt(away**2 - radius**2) - 1.0]
    cosine = np.cos(np.arctan(pixels / focal))
    facing = np.sqrt(1.0 - (away / radius) ** 2 * (1.0 - cosine**2))
    least = ((away * cosine - radius * facing) * facing).min()
    return math.pi * math.sqrt(radius / (2.0 * DEPTH_ERROR * least))


@pytest.mark.parametrize("half", [0.0, 10.0])
@pytest.mark.parametrize(
    ("radius", "gap", "fov"), [(20, 0.3, 1.5), (100, 3, 1.5), (2, 0.2, 2.0), (20, 1, 1.5), (5, 0.5, 1.0), (1, 0.3, 2.5)]
)
def test_near_shapes_have_as_many_segments_as_the_formula_asks_for(radius, gap, fov, half):
    least = enough(radius, gap, fov)
    assert least <= segments(radius, gap, fov, half=half) < (2.0 if half == 0.0 else 3.0) * least


def test_shapes_that_are_farther_than_their_diameter_have_what_the_nearest_point_and_the_limb_ask_for():
    places = (0.5, 2.5), (0.5, 9.5), (0.1, 5.0), (2.0, 8.0), (1.0, 2.0)
    assert [segments(radius, gap, 1.047) for radius, gap in places] == [96, 32, 16, 96, 128]


def test_detail_has_a_limit():
    assert segments(1e3, 0.1, 1.0, finest=14) == 1024
    assert segments(1e3, 0.1, 1.0) == LEVELS[-1]
    # All that faces the camera is nearer than the near plane.
    assert segments(0.1, 1e-4, 1.0, near=0.1) == 192


def sdf(count, kind):
    size = "" if kind == "sphere" else "<length>1</length>"
    visuals = "".join(
        f"<visual name='v{i}'><geometry><{kind}><radius>.5</radius>{size}</{kind}></geometry></visual>"
        for i in range(count)
    )
    model = f"<model name='m'><static>1</static><link name='l'>{visuals}</link></model>"
    return f"<sdf version='1.6'><world name='w'>{model}</world></sdf>"


@pytest.mark.parametrize(
    ("count", "kind", "finest"),
    [(1, "sphere", 1024), (2, "sphere", 512), (5, "capsule", 384), (3, "cylinder", 4096)],
)
def test_the_facets_of_an_item_are_bounded(count, kind, finest):
    with libgz.World.from_string(sdf(count, kind)) as world, Camera(world, 8, 8) as camera:
        camera.Update()
        rounds = Rounds(camera._scene._content)
        assert {LEVELS[level] for level in rounds.finest.tolist()} == {finest}


class Lists:
    """A library that notes which lists there are."""

    def __init__(self):
        self.found = set()

    def item(self, item, look, segments, plain):
        self.found.add((item.key, segments))
        return Compiled(1000 * segments + item.key[0], 1.0)

    def forget(self, item, look, segments, plain):
        self.found.remove((item.key, segments))


def test_large_lists_that_are_not_used_for_long_are_deleted():
    lists, fine = Lists(), FINE + 1
    table = Table(lists, Content(tuple(Item((), i, (i,)) for i in range(10))), Look(True, True, True, False), False)

    def use(*places, level=fine):
        found = table.lists(np.array(places), np.full(len(places), level))
        assert found.tolist() == [1000 * LEVELS[level] + place for place in places]
        return sorted(key[0] for key, segments in lists.found if segments > LEVELS[FINE])

    assert use(*range(6)) == [0, 1, 2, 3, 4, 5]  # all that one image has are kept
    assert use(*range(10), level=FINE) == [0, 1, 2, 3, 4, 5]
    assert MOST_FINE == 4
    assert use(9) == [3, 4, 5, 9]
    assert use(3) == [3, 4, 5, 9]
    assert use(0) == [0, 3, 5, 9]
    assert use(0, 1, 2, 4, 5) == [0, 1, 2, 4, 5]
