"""Roads from files."""

import math

import numpy as np
import pytest
from ground_worlds import ball, heights_below, world_of

import libgz
from libgz.physics.body import Body
from libgz.physics.engine import Engine
from libgz.physics.space import Space
from libgz.physics.surfaces import RoadGeom

OFFSET = (499000.0, 3846000.0)
PROFILE = [0.0, 0.0, 0.05, 0.1, 0.2, 0.25, 0.3, 0.3, 0.3, 0.25, 0.2, 0.1, 0.05, 0.0, 0.0]


def road_file(points, profile=PROFILE, waypoints=()):
    lines = [f"waypoint {s} {n} {x + OFFSET[0]} {y + OFFSET[1]} {z}" for s, n, x, y, z in waypoints]
    for s, x, y, z in points:
        heights = "  ".join(f"{p:.6f}" for p in profile)
        lines.append(f"track {s:.6f} 1 {x + OFFSET[0]:.6f} {y + OFFSET[1]:.6f} {z:.6f}  {len(profile)}  {heights}")
    return "\n".join(lines) + "\n"


ROAD = "<model:Road><id>road</id><roadFile>road.txt</roadFile>{}</model:Road>"
SETTINGS = f"<utmOffset>{OFFSET[0]} {OFFSET[1]} 0</utmOffset>"


def straight(count=40, rise=0.05):
    return [(2.0 * i, 2.0 * i, 0.0, rise * 2.0 * i + 1.0) for i in range(count)]


def test_a_straight_road_follows_its_records(tmp_path):
    (tmp_path / "road.txt").write_text(road_file(straight()))
    with world_of(tmp_path, ROAD.format(""), SETTINGS) as world:
        for side in range(-5, 6):  # profile points lie a metre apart, right to left; the outermost two are drawn down
            found = heights_below(world, [(x, side - 1e-6 * side) for x in (4.1, 30.3, 60.7)])
            expected = [0.05 * x + 1.0 + PROFILE[7 + side] for x in (4.1, 30.3, 60.7)]
            if abs(side) < 5:
                assert found == pytest.approx(expected, abs=1e-4), side
        for side in (-7.9, -7.2, 7.2, 7.9):
            assert heights_below(world, [(20.0, side)]) == pytest.approx([-0.10], abs=0.06)
        # From the second record to the last but one, 16 m wide.
        ends = heights_below(world, [(1.9, 0), (2.1, 0), (75.9, 0), (76.1, 0), (20, 8.1), (20, -8.1)])
        assert np.isnan(ends).tolist() == [True, False, False, True, True, True]


def test_right_and_left_of_a_road_are_not_mixed_up(tmp_path):
    profile = [0.1 * i for i in range(15)]  # rises from right to left
    points = [(2.0 * i, 0.0, 2.0 * i, 1.0) for i in range(20)]  # northward: left is -x
    (tmp_path / "road.txt").write_text(road_file(points, profile))
    with world_of(tmp_path, ROAD.format(""), SETTINGS) as world:
        left, right = heights_below(world, [(-3.0, 20.0), (3.0, 20.0)])
        assert (left, right) == pytest.approx((2.0, 1.4), abs=1e-3)


def test_a_bend_follows_its_circle(tmp_path):
    radius = 50.0
    points = [(2.0 * i, radius * math.sin(i / 25), radius - radius * math.cos(i / 25), 2.0) for i in range(100)]
    (tmp_path / "road.txt").write_text(road_file(points))
    with world_of(tmp_path, ROAD.format(""), SETTINGS) as world:
        for angle in np.linspace(0.1, 3.8, 20):
            for offset in (-3.0, 0.0, 3.0):
                r = radius - offset  # left is inward
                place = (r * math.sin(angle), radius - r * math.cos(angle))
                assert heights_below(world, [place])[0] == pytest.approx(2.0 + PROFILE[7 + int(offset)], abs=0.02)


def test_a_ball_rolls_down_a_road_and_not_off_it(tmp_path):
    hollow = [0.0, 0.0, 0.5, 0.4, 0.3, 0.2, 0.1, 0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.0, 0.0]
    (tmp_path / "road.txt").write_text(road_file(straight(40, 0.1), hollow))
    hard = "<surfaceHardness>1e6 100</surfaceHardness>"
    with world_of(tmp_path, ROAD.format(hard) + ball(60.0, 0.0, 7.01), SETTINGS) as world:
        world.run(2.0)
        travelled = (60.0 - world.body("ball").GetCoMPose().pos.x) / math.cos(math.atan(0.1))
        assert travelled == pytest.approx(0.5 * 5.0 / 7.0 * 9.8 * math.sin(math.atan(0.1)) * 4.0, rel=0.05)
        assert world.body("ball").GetCoMPose().pos.y == pytest.approx(0.0, abs=0.05)


def test_track_spacing_stretches_the_parameter_not_the_road(tmp_path):
    (tmp_path / "road.txt").write_text(road_file(straight(20)))
    with (
        world_of(tmp_path, ROAD.format(""), SETTINGS) as own,
        world_of(tmp_path, ROAD.format("<roadSpacing>5 1</roadSpacing>"), SETTINGS) as old,
    ):
        for world in (own, old):
            assert heights_below(world, [(20.0, 0.0)]) == pytest.approx([2.3], abs=1e-3)
        assert len(old.models[0].road.vertices) == pytest.approx(2.5 * len(own.models[0].road.vertices), rel=0.02)


def test_a_road_can_be_rendered(tmp_path):
    signs = [(0, 1, 0.0, 3.0, 2.1), (40, 2, 40.0, 3.0, 4.1)]
    (tmp_path / "road.txt").write_text(road_file(straight(20), waypoints=signs))
    with world_of(tmp_path, ROAD.format("<textureSize>4 2</textureSize>"), SETTINGS) as world:
        road = world.models[0].road
        assert [(tuple(place), text) for place, text in road.signs] == [((0, 3, 2.1), "1"), ((40, 3, 4.1), "2")]
        assert road.vertices.shape == road.normals.shape
        assert (road.normals[:, 2] > 0.0).all()
        assert road.texture_coordinates.shape == (len(road.vertices), 2)
        assert road.texture_coordinates.max(axis=0) == pytest.approx(((34 - 0.0) / 4, 16 / 2), abs=0.01)
        assert world.engine.tables.geoms.surface[road.row, :4].tolist() == [1e4, 0, 1, 0]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "0 track points"),
        (road_file(straight(3)), "3 track points"),
        (road_file([*straight(5), (2.0, 12, 0, 0)]), "not beyond"),
    ],
)
def test_an_invalid_road_is_one_warning(tmp_path, caplog, text, words):
    (tmp_path / "road.txt").write_text(text)
    with world_of(tmp_path, ROAD.format(""), SETTINGS) as world:
        world.step(2)
    assert [words in r.getMessage() and "no road is built" in r.getMessage() for r in caplog.records] == [True]


def test_invalid_lines_are_ignored_with_one_warning(tmp_path, caplog):
    text = (
        "# made by hand\nhello\ntrack 1 2\ntrack 1 1 nan 0 0 1 0\n" + road_file(straight()) + "track 9 1 0 0 0 3 1 2\n"
    )
    (tmp_path / "road.txt").write_text(text)
    with world_of(tmp_path, ROAD.format(""), SETTINGS) as world:
        assert not np.isnan(heights_below(world, [(20, 0)])).any()
    assert [r.getMessage().count("line 2 is neither") for r in caplog.records] == [1]
    assert "and 3 more" in caplog.text


def test_road_geoms_reject_invalid_values():
    engine = Engine()
    road = RoadGeom(Body(engine, dummy=True), Space(engine))
    with pytest.raises(libgz.ParameterError, match="no track point 0"):
        road.AddProfilePoint(0, 1.0)
    with pytest.raises(libgz.ParameterError, match="finite"):
        road.AddTrackPoint((math.nan, 0, 0))
    for set_spacing in (road.SetTrackSpacing, road.SetProfileSpacing):
        with pytest.raises(libgz.ParameterError, match="it must be at least"):
            set_spacing(1e-320)
    for i in range(5):
        assert road.AddTrackPoint((5.0 * i, 0, 0)) == i
    road.UpdateMesh()  # points 5 m apart by default
    assert road.vertices[:, 0].min() == pytest.approx(5.0)
    road.AddTrackPoint((25, 0, 0))
    road.UpdateMesh((1, 2, 3))  # and anew
    assert road.vertices[:, 0].max() == pytest.approx(20.0)
    engine.close()
