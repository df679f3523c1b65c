"""Roads of SDF worlds are shown where their points are, and touch nothing."""

import logging

import numpy as np
import pytest

import libgz
from libgz.sdfworld.road import road_mesh

WORLD = """<sdf version="1.6"><world name="w"><road name="street"><width>4</width>{}</road>
<model name="ball"><pose>5 0 3 0 0 0</pose><link name="link"><collision name="c"><geometry><sphere><radius>0.5</radius>
</sphere></geometry></collision></link></model></world></sdf>"""


def points(*places):
    return "".join(f"<point>{' '.join(map(str, place))}</point>" for place in places)


def test_a_straight_road_has_its_width_and_repeats_its_image():
    vertices, triangles, coordinates = road_mesh(np.array([(0.0, 0, 1), (10, 0, 1), (20, 0, 3)]), 4.0)
    assert vertices[:, 1] == pytest.approx([2, -2] * 3)
    assert vertices[:, 2] == pytest.approx([1, 1, 1, 1, 3, 3])
    corners = vertices[triangles]
    assert np.all(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] > 0.0)  # seen from above
    assert coordinates[:, 1] == pytest.approx([0, 0, 2.5, 2.5, 5, 5])


def test_a_bend_keeps_the_width_of_both_sides():
    vertices, _, _ = road_mesh(np.array([(0.0, 0, 0), (10, 0, 0), (10, 10, 0)]), 2.0)
    assert vertices[2:4, :2] == pytest.approx(np.array([(9, 1), (11, -1)]))
    turned, _, _ = road_mesh(np.array([(0.0, 0, 0), (10, 0, 0), (0, 0, 0)]), 2.0)  # back on itself
    assert np.abs(turned).max() < 20.0


def test_a_road_is_rendered_and_touches_nothing():
    with libgz.World.from_string(WORLD.format(points((0, 0, 1), (10, 0, 1), (10, 0, 1)))) as world:
        world.step(1000)
        assert world.model("ball").GetPose().pos.z < 0.0
        found = [geom for geom in world.engine.geoms.values() if len(getattr(geom, "vertices", ())) == 4]
        assert len(found) == 1
        assert found[0].appearance.visible
        world.Reset()
        assert world.model("ball").GetPose().pos.z == pytest.approx(3.0)


def test_a_road_without_length_is_a_warning(caplog):
    with (
        caplog.at_level(logging.WARNING),
        libgz.World.from_string(WORLD.format(points((1, 1, 0), (1, 1, 0)))),
    ):
        assert "a road of 1 different points and width 4 m is left out" in caplog.text
