"""Ground and walls from files: terrain, road, floor plans."""

import logging
import math

import numpy as np
import pytest
from PIL import Image, ImageDraw

import libgz
from libgz.geometry import GzQuaternToEuler
from libgz.models.contours import outlines, simplified
from libgz.models.greyimage import read_grey
from libgz.models.gzb import read_gzb, write_gzb
from libgz.physics.body import Body
from libgz.physics.engine import Engine, Space
from libgz.physics.meshes import grid_strip, grid_triangles, triangle_normals, vertex_normals
from libgz.physics.surfaces import PointSetGeom, RoadGeom, TerrainGeom

HEAD = "<gz:world xmlns:gz='g' xmlns:model='m' xmlns:param='p'>"


def world_of(folder, body, settings=""):
    path = folder / "test.world"
    path.write_text(f"{HEAD}<param:Global>{settings}</param:Global>{body}</gz:world>")
    return libgz.World.from_file(path)


def heights_below(world, points, top=50.0):
    """Height of the first thing under each (x, y) [m]; NaN where there is nothing."""
    points = np.asarray(points, dtype=float)
    rays = np.zeros((len(points), 7))
    rays[:, :2], rays[:, 2], rays[:, 5], rays[:, 6] = points, top, -1.0, 2 * top
    ranges, rows = np.empty(len(points)), np.empty(len(points), dtype=np.int64)
    world.engine.scan(np.array([0, 0, 0, 1.0, 0, 0, 0]), rays, 0, ranges, rows)
    return np.where(rows >= 0, top - ranges, np.nan)


def ball(x, y, z, radius=0.2):
    return (
        f"<model:SimpleSolid><id>ball</id><xyz>{x} {y} {z}</xyz><shape>sphere</shape><size>{2 * radius}</size>"
        "<surfaceHardness>1e5 100</surfaceHardness></model:SimpleSolid>"
    )


# Meshes ----------------------------------------------------------------------------------------------------------


def strip_triangles(strip):
    """The triangles that a strip draws, those without area left out, each with its lowest corner first."""
    found = []
    for i in range(len(strip) - 2):
        a, b, c = (int(v) for v in strip[i : i + 3])
        if len({a, b, c}) == 3:
            a, b, c = (a, b, c) if i % 2 == 0 else (b, a, c)
            least = min(a, b, c)
            while a != least:
                a, b, c = b, c, a
            found.append((a, b, c))
    return sorted(found)


def test_a_grid_is_covered_once_from_above_by_triangles_and_strip():
    rows, columns = 3, 4
    vertices = np.array([(x, y, 0.0) for y in range(rows) for x in range(columns)])
    triangles = grid_triangles(rows, columns)
    strip = np.array(strip_triangles(grid_strip(rows, columns)))
    for corners in (triangles, strip):
        a, b, c = (vertices[corners[:, i]] for i in range(3))
        areas = np.cross(b - a, c - a)[:, 2] / 2.0
        assert areas == pytest.approx([0.5] * 2 * (rows - 1) * (columns - 1))
    assert triangle_normals(vertices, triangles) == pytest.approx(np.tile((0, 0, 1), (12, 1)))


def test_normals_of_a_sphere_point_outward():
    u, v = np.meshgrid(np.linspace(0.2, 1.2, 30), np.linspace(0, 1, 30))
    vertices = np.stack([np.cos(v) * np.cos(u), np.sin(v) * np.cos(u), np.sin(u)], axis=-1).reshape(-1, 3)
    normals = vertex_normals(vertices, grid_triangles(30, 30)[:, ::-1])
    inside = normals.reshape(30, 30, 3)[1:-1, 1:-1]
    assert np.einsum("ijk,ijk->ij", inside, vertices.reshape(30, 30, 3)[1:-1, 1:-1]).min() > 0.999


# Terrain ---------------------------------------------------------------------------------------------------------

COUNT, SPACING = 41, 0.5


def wave(x, y):
    return 1.5 + np.sin(x / 3.0) + 0.5 * np.cos(y / 2.0)


def packed_wave(slope=None):
    """(packed vertices, strip, triangles) of 20 x 20 m; a plane that rises by `slope` along x, or a wave."""
    y, x = (SPACING * axis for axis in np.mgrid[:COUNT, :COUNT])
    z = wave(x, y) if slope is None else slope * x
    packed = np.zeros((COUNT * COUNT, 12))
    packed[:, 9:] = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    packed[:, :2], packed[:, 2:6] = packed[:, 9:11] / 10.0, 1.0
    triangles = grid_triangles(COUNT, COUNT)
    packed[:, 6:9] = vertex_normals(packed[:, 9:], triangles)
    return packed, grid_strip(COUNT, COUNT), triangles


TERRAIN = "<model:Terrain><terrainFile>t.gzb</terrainFile><xyz>{}</xyz><rpy>{}</rpy></model:Terrain>"


def test_terrain_files_hold_what_was_written(tmp_path):
    packed, strip, triangles = packed_wave()
    packed[0, 0] = -2147483.648  # stands for no texture coordinate
    write_gzb(tmp_path / "t.gzb", packed, strip, triangles)
    data = (tmp_path / "t.gzb").read_bytes()
    assert [int.from_bytes(data[4 * i : 4 * i + 4], "big") for i in (0, 7, 8, 9)] == [
        500,
        len(packed),
        len(strip),
        triangles.size,
    ]
    (tmp_path / "t.gzb").write_bytes(data + b"trailing")
    terrain = read_gzb(tmp_path / "t.gzb")
    packed[0, 0] = 0.0
    assert terrain.vertices == pytest.approx(packed, abs=5.1e-4)
    assert np.array_equal(terrain.strip, strip)
    assert np.array_equal(terrain.triangles, triangles)
    assert terrain.damage == []


@pytest.mark.parametrize(("place", "turn"), [((0, 0, 0), 0), ((-10, 5, -0.1), 0), ((3, 4, 1), 90)])
def test_rays_find_the_terrain_where_its_formula_says(tmp_path, place, turn):
    write_gzb(tmp_path / "t.gzb", *packed_wave())
    with world_of(tmp_path, TERRAIN.format(" ".join(map(str, place)), f"0 0 {turn}")) as world:
        local = np.random.default_rng(1).integers(1, COUNT - 1, (200, 2)) * SPACING
        sine, cosine = round(math.sin(math.radians(turn))), round(math.cos(math.radians(turn)))
        there = np.stack([cosine * local[:, 0] - sine * local[:, 1], sine * local[:, 0] + cosine * local[:, 1]], axis=1)
        found = heights_below(world, there + np.array(place[:2]) + 1e-7)
        assert found == pytest.approx(wave(*local.T) + place[2], abs=1e-3)
        # Between vertices the mesh is off the wave by its sag, d^2 / 8 R.
        between = local + 0.2
        there = np.stack(
            [cosine * between[:, 0] - sine * between[:, 1], sine * between[:, 0] + cosine * between[:, 1]], axis=1
        )
        found = heights_below(world, there + np.array(place[:2]))
        assert found == pytest.approx(wave(*between.T) + place[2], abs=0.02)
        assert np.isnan(heights_below(world, np.array([place[:2]]) - 100.0)).all()


def test_a_ball_rolls_down_a_terrain_as_the_formula_says(tmp_path):
    slope = 0.1
    write_gzb(tmp_path / "t.gzb", *packed_wave(slope))
    angle = math.atan(slope)
    radius = 0.2
    start = (15.0, 10.0, slope * 15.0 + radius / math.cos(angle) - radius)
    with world_of(tmp_path, TERRAIN.format("0 0 0", "0 0 0") + ball(*start)) as world:
        world.run(2.0)
        travelled = (15.0 - world.body("ball").GetCoMPose().pos.x) / math.cos(angle)
        # A solid sphere that rolls: a = 5/7 g sin(angle).
        assert travelled == pytest.approx(0.5 * 5.0 / 7.0 * 9.8 * math.sin(angle) * 4.0, rel=0.03)
        centre = world.body("ball").GetCoMPose().pos
        assert centre.z == pytest.approx(slope * centre.x + radius / math.cos(angle), abs=5e-3)


def test_a_robot_stands_on_a_terrain_and_its_laser_sees_the_hill(tmp_path):
    write_gzb(tmp_path / "t.gzb", *packed_wave(0.0))
    wall = TERRAIN.format("14 0 0", "0 -60 0")
    laser = "<model:SickLMS200><id>laser1</id><xyz>0.1 0 0.311</xyz></model:SickLMS200>"
    robot = f"<model:Pioneer2AT><id>r</id><xyz>10 10 0.01</xyz>{laser}</model:Pioneer2AT>"
    with world_of(tmp_path, TERRAIN.format("0 0 0", "0 0 0") + wall + robot) as world:
        world.run(3.0)
        pose = world.model("r").GetPose().pos
        assert pose.z == pytest.approx(0.0, abs=5e-3)
        mount = world.model("laser1").GetPose()
        pitch, steep = GzQuaternToEuler(mount.rot).y, math.radians(60)  # the laser's weight tips the robot a little
        x, z = mount.pos.x + 0.07 * math.sin(pitch), mount.pos.z + 0.07 * math.cos(pitch)
        expected = ((14.0 - x) * math.sin(steep) + z * math.cos(steep)) / math.sin(steep + pitch)
        assert world.interface("laser", "laser1").ranges[90] == pytest.approx(expected, abs=1e-4)


def test_a_terrain_is_data_that_can_be_drawn(tmp_path):
    packed, strip, triangles = packed_wave()
    write_gzb(tmp_path / "t.gzb", packed, strip, triangles)
    with world_of(tmp_path, TERRAIN.format("0 0 0", "0 0 0")) as world:
        ground = world.models[0].ground
        assert ground.vertices.shape == ground.normals.shape == (COUNT * COUNT, 3)
        assert ground.texture_coordinates == pytest.approx(packed[:, :2], abs=1e-3)
        assert ground.colors.shape == (COUNT * COUNT, 4)
        assert np.array_equal(ground.strip, strip)
        assert ground.GetDiffuseColor() == libgz.GzColor(0.7, 0.7, 0.7)
        assert world.engine.surface[ground.row, :4].tolist() == [math.inf, 0, 1, 0]


def test_a_terrain_whose_bytes_were_converted_is_set_right(tmp_path, caplog):
    """Bytes 0D turned into 0A, as a conversion of line ends does."""
    packed, strip, triangles = packed_wave()
    path = tmp_path / "t.gzb"
    write_gzb(path, packed, strip, triangles)
    head = 40 + 48 * len(packed)
    data = path.read_bytes()
    path.write_bytes(data[:head] + data[head:].replace(b"\x0d", b"\x0a"))
    terrain = read_gzb(path)
    assert np.array_equal(terrain.triangles, triangles)
    assert len(terrain.damage) == 1
    with world_of(tmp_path, TERRAIN.format("0 0 0", "0 0 0")):
        assert [r.getMessage().count("is damaged: ") for r in caplog.records] == [1]
        assert "were set right" in caplog.text


def test_triangles_that_cannot_be_are_left_out(tmp_path, caplog):
    packed, strip, triangles = packed_wave()
    path = tmp_path / "t.gzb"
    write_gzb(path, packed, strip, triangles)
    data = bytearray(path.read_bytes())
    data[-4:] = (10**6).to_bytes(4, "big")  # names no vertex
    data[-16:-12] = data[-20:-16]  # has no area
    path.write_bytes(data)
    with world_of(tmp_path, TERRAIN.format("0 0 0", "0 0 0")) as world:
        assert len(world.models[0].ground.triangles) == len(triangles) - 2
    assert "1 triangles name a vertex that there is not" in caplog.text


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (lambda d: d[:-9], "does not fit its counts"),
        (lambda d: b"", "is no terrain file"),
        (lambda d: b"\x89PNG" + d, "is no terrain file"),
        (lambda d: d[:28] + b"\xff" * 4 + d[32:], "does not fit its counts"),
        (lambda d: d[:28] + b"\0" * 12, "needs at least one triangle"),
    ],
)
def test_a_damaged_terrain_is_one_warning_and_no_ground(tmp_path, caplog, damage, words):
    write_gzb(tmp_path / "t.gzb", *packed_wave())
    (tmp_path / "t.gzb").write_bytes(damage((tmp_path / "t.gzb").read_bytes()))
    with world_of(tmp_path, TERRAIN.format("0 0 0", "0 0 0") + ball(5, 5, 3)) as world:
        world.step(3)
        assert world.model("ball").GetPose().pos.z < 3.0
    assert [words in r.getMessage() and "no ground here" in r.getMessage() for r in caplog.records] == [True]


def test_a_terrain_needs_a_file(tmp_path, caplog):
    with pytest.raises(libgz.WorldFileError, match=r"a terrain needs a <terrainFile>"):
        world_of(tmp_path, "<model:Terrain/>")
    with world_of(tmp_path, "<model:Terrain><terrainFile>gone.gzb</terrainFile></model:Terrain>"):
        assert caplog.text.count("file 'gone.gzb' was not found") == 1


def test_a_height_map_is_ground_as_in_gazebo_04(tmp_path, caplog):
    y, x = np.mgrid[:30, :40]
    grey = (127 + 100 * np.sin(x / 6.0) * np.cos(y / 5.0)).astype(np.uint8)
    Image.fromarray(grey).save(tmp_path / "map.png")
    body = """<model:Terrain><id>t</id><dataFile>map.png</dataFile><elevationScale>5</elevationScale>
    <vertexSpacing>0.5</vertexSpacing><textureRepeat>4 3</textureRepeat><errorBound>2</errorBound></model:Terrain>"""
    with world_of(tmp_path, body) as world:
        column, row = np.random.default_rng(2).integers(1, 29, (2, 100))
        # The first row of the picture is at +y; its lower left pixel is the origin.
        found = heights_below(world, np.stack([0.5 * column, 0.5 * (29 - row)], axis=1) + 1e-7)
        assert found == pytest.approx(grey[row, column] / 255.0 * 5.0, abs=1e-5)
        coordinates = world.model("t").ground.texture_coordinates
        assert coordinates.max(axis=0) == pytest.approx((4, 3))
    assert caplog.text == ""


def test_slanting_rays_see_the_nearest_slope_of_a_height_map(tmp_path):
    grey = np.zeros((60, 60), dtype=np.uint8)
    grey[:, 20:25] = grey[:, 40:45] = 255  # two ridges across x
    Image.fromarray(grey).save(tmp_path / "map.png")
    body = "<model:Terrain><dataFile>map.png</dataFile><elevationScale>3</elevationScale></model:Terrain>"
    with world_of(tmp_path, body) as world:
        rays = np.array([[1.0, 30.0, z, 1.0, 0.0, 0.0, 60.0] for z in np.linspace(0.1, 2.9, 40)])
        ranges, rows = np.empty(40), np.empty(40, dtype=np.int64)
        world.engine.scan(np.array([0, 0, 0, 1.0, 0, 0, 0]), rays, 0, ranges, rows)
        assert ranges == pytest.approx(18.0 + rays[:, 2] / 3.0, abs=1e-5)


def test_grey_pictures_of_all_kinds(tmp_path):
    ramp = np.arange(256, dtype=np.uint8).reshape(16, 16)
    Image.fromarray(ramp).save(tmp_path / "8.png")
    Image.fromarray(ramp.astype(np.uint16) * 257).save(tmp_path / "16.png")
    Image.fromarray(np.stack([ramp] * 3, axis=-1)).save(tmp_path / "rgb.ppm")
    for name in ("8.png", "16.png", "rgb.ppm"):
        assert read_grey(tmp_path / name) == pytest.approx(ramp.astype(float)), name
    Image.new("RGBA", (4, 4), (0, 0, 0, 0)).save(tmp_path / "clear.png")
    assert (read_grey(tmp_path / "clear.png") == 255).all()
    (tmp_path / "no.png").write_text("no picture")
    with pytest.raises(libgz.ParameterError, match="cannot read picture"):
        read_grey(tmp_path / "no.png")
    Image.new("1", (2049, 2048)).save(tmp_path / "huge.png")
    with pytest.raises(libgz.ParameterError, match="pixels"):
        read_grey(tmp_path / "huge.png")


# Road ------------------------------------------------------------------------------------------------------------

OFFSET = (499000.0, 3846000.0)
PROFILE = [0.0, 0.0, 0.05, 0.1, 0.2, 0.25, 0.3, 0.3, 0.3, 0.25, 0.2, 0.1, 0.05, 0.0, 0.0]


def road_file(points, profile=PROFILE, waypoints=()):
    lines = [f"waypoint {s} {n} {x + OFFSET[0]} {y + OFFSET[1]} {z}" for s, n, x, y, z in waypoints]
    for s, x, y, z in points:
        heights = "  ".join(f"{p:.6f}" for p in profile)
        lines.append(f"track {s:.6f} 1 {x + OFFSET[0]:.6f} {y + OFFSET[1]:.6f} {z:.6f}  {len(profile)}  {heights}")
    return "\n".join(lines) + "\n"


ROAD = "<model:Road><id>road</id><roadFile>road.txt</roadFile>{}</model:Road>"
SETTINGS = f"<utmOffset>{OFFSET[0]} {OFFSET[1]}</utmOffset>"


def straight(count=40, rise=0.05):
    return [(2.0 * i, 2.0 * i, 0.0, rise * 2.0 * i + 1.0) for i in range(count)]


def test_a_straight_road_is_where_its_records_say(tmp_path):
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


def test_a_road_is_data_that_can_be_drawn(tmp_path):
    signs = [(0, 1, 0.0, 3.0, 2.1), (40, 2, 40.0, 3.0, 4.1)]
    (tmp_path / "road.txt").write_text(road_file(straight(20), waypoints=signs))
    with world_of(tmp_path, ROAD.format("<textureSize>4 2</textureSize>"), SETTINGS) as world:
        road = world.models[0].road
        assert [(tuple(place), text) for place, text in road.signs] == [((0, 3, 2.1), "1"), ((40, 3, 4.1), "2")]
        assert road.vertices.shape == road.normals.shape
        assert (road.normals[:, 2] > 0.0).all()
        assert road.texture_coordinates.shape == (len(road.vertices), 2)
        assert road.texture_coordinates.max(axis=0) == pytest.approx(((34 - 0.0) / 4, 16 / 2), abs=0.01)
        assert world.engine.surface[road.row, :4].tolist() == [1e4, 0, 1, 0]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "0 track points"),
        (road_file(straight(3)), "3 track points"),
        (road_file([*straight(5), (2.0, 12, 0, 0)]), "not beyond"),
    ],
)
def test_a_road_that_is_none_is_one_warning(tmp_path, caplog, text, words):
    (tmp_path / "road.txt").write_text(text)
    with world_of(tmp_path, ROAD.format(""), SETTINGS) as world:
        world.step(2)
    assert [words in r.getMessage() and "no road here" in r.getMessage() for r in caplog.records] == [True]


def test_lines_that_are_no_records_are_left_out_with_one_warning(tmp_path, caplog):
    text = (
        "# made by hand\nhello\ntrack 1 2\ntrack 1 1 nan 0 0 1 0\n" + road_file(straight()) + "track 9 1 0 0 0 3 1 2\n"
    )
    (tmp_path / "road.txt").write_text(text)
    with world_of(tmp_path, ROAD.format(""), SETTINGS) as world:
        assert not np.isnan(heights_below(world, [(20, 0)])).any()
    assert [r.getMessage().count("line 2 is neither") for r in caplog.records] == [1]
    assert "and 3 more" in caplog.text


def test_road_geoms_refuse_what_cannot_be():
    engine = Engine()
    road = RoadGeom(Body(engine, dummy=True), Space(engine))
    with pytest.raises(libgz.ParameterError, match="no track point 0"):
        road.AddProfilePoint(0, 1.0)
    with pytest.raises(libgz.ParameterError, match="finite"):
        road.AddTrackPoint((math.nan, 0, 0))
    for i in range(5):
        assert road.AddTrackPoint((5.0 * i, 0, 0)) == i
    road.UpdateMesh()  # points 5 m apart by default
    assert road.vertices[:, 0].min() == pytest.approx(5.0)
    road.AddTrackPoint((25, 0, 0))
    road.UpdateMesh((1, 2, 3))  # and anew
    assert road.vertices[:, 0].max() == pytest.approx(20.0)
    engine.close()


def test_point_sets_are_drawn_and_touch_nothing():
    engine = Engine()
    points = PointSetGeom(Body(engine, dummy=True), Space(engine), 2, [(0, 0, 0), (1, 2, 3)])
    assert points.points.tolist() == [[0, 0, 0], [1, 2, 3]]
    assert points.GetGeomId() == 0
    with pytest.raises(libgz.ParameterError, match="a point set of 3 was given 2"):
        PointSetGeom(points.body, None, 3, points.points)
    engine.close()


def test_a_terrain_geom_can_be_loaded_anew():
    engine = Engine()
    ground = TerrainGeom(Body(engine, dummy=True), Space(engine))
    ground.LoadGrid([[0, 0], [0, 0]], 1.0)
    first = ground.GetGeomId()
    ground.LoadGrid([[1, 1], [1, 1]], 1.0)
    assert ground.GetGeomId() != 0
    assert first
    rays, ranges, rows = np.array([[0.5, 0.4, 9, 0, 0, -1, 20.0]]), np.empty(1), np.empty(1, dtype=np.int64)
    engine.scan(np.array([0, 0, 0, 1.0, 0, 0, 0]), rays, 0, ranges, rows)
    assert ranges[0] == pytest.approx(8.0)
    for wrong in ([[1]], [1, 2], [[math.nan, 0], [0, 0]]):
        with pytest.raises(libgz.ParameterError):
            ground.LoadGrid(wrong, 1.0)
    engine.close()


# Floor plans -----------------------------------------------------------------------------------------------------


def test_outlines_of_a_small_picture():
    mask = np.zeros((6, 7), dtype=bool)
    mask[1:4, 2:5] = True
    mask[2, 3] = False  # a hole
    mask[4, 5] = True  # touches at a corner only
    found = [{tuple(corner) for corner in polygon.tolist()} for polygon in outlines(mask)]
    assert found == [
        {(1, 2), (1, 5), (4, 5), (4, 2)},
        {(2, 3), (2, 4), (3, 4), (3, 3)},
        {(4, 5), (4, 6), (5, 6), (5, 5)},
    ]
    assert [len(polygon) for polygon in outlines(np.ones((3, 4), dtype=bool))] == [4]
    assert outlines(np.zeros((3, 4), dtype=bool)) == []


def area(polygon):
    """By the shoelace formula; clockwise on the picture is positive."""
    rows, columns = np.array(polygon, dtype=float).T
    return 0.5 * float(np.sum(columns * np.roll(rows, -1) - rows * np.roll(columns, -1)))


@pytest.mark.parametrize("seed", range(5))
def test_outlines_enclose_what_is_solid(seed):
    mask = np.random.default_rng(seed).random((40, 50)) < 0.1 + 0.2 * seed
    assert sum(area(polygon) for polygon in outlines(mask)) == mask.sum()


@pytest.mark.parametrize("tolerance", [0.0, 1.0, 3.0])
def test_simplified_outlines_stay_within_the_tolerance(tolerance):
    y, x = np.mgrid[:200, :200]
    (polygon,) = outlines(np.hypot(x - 100, y - 100) < 80)
    corners = simplified(polygon, tolerance)
    if tolerance == 0.0:
        assert np.array_equal(corners, polygon)
    else:
        assert len(corners) < len(polygon) / 8
    ends = np.roll(corners, -1, axis=0)
    along = (ends - corners).astype(float)
    for point in polygon:
        share = np.clip(((point - corners) * along).sum(1) / (along**2).sum(1), 0, 1)
        assert np.linalg.norm(point - corners - share[:, None] * along, axis=1).min() <= tolerance + 1e-9


MAP = "<model:MapExtruder><id>map</id><imageFile>map.png</imageFile><xyz>{}</xyz>{}</model:MapExtruder>"


def test_walls_stand_on_the_outlines(tmp_path):
    image = Image.new("L", (100, 60), 255)
    ImageDraw.Draw(image).rectangle((60, 10, 79, 19), fill=199)
    ImageDraw.Draw(image).rectangle((10, 40, 19, 49), fill=200)  # not below the threshold
    image.save(tmp_path / "map.png")
    attributes = "<scale>0.1</scale><height>2</height><width>0.2</width><errBound>0.5</errBound><color>0 1 0</color>"
    with world_of(tmp_path, MAP.format("1 2 0", attributes)) as world:
        model = world.model("map")
        walls = np.array(model.walls)
        # The rectangle's corners, from the picture's middle: x 1 to 3, y 1 to 2.
        assert walls[..., 0].min() == pytest.approx(1.0)
        assert walls[..., 0].max() == pytest.approx(3.0)
        assert walls[..., 1].min() == pytest.approx(1.0)
        assert walls[..., 1].max() == pytest.approx(2.0)
        assert len(walls) == len(model.GetBody().geoms) == 4
        sizes = np.array(sorted(geom.size for geom in model.GetBody().geoms))
        assert sizes == pytest.approx(np.array([(1.2, 0.2, 2)] * 2 + [(2.2, 0.2, 2)] * 2))
        tops = heights_below(world, [(2.0, 3.5), (3.0, 3.05), (3.0, 3.95), (3.0, 3.5), (5.0, 5.0)])
        assert tops[[0, 1, 2]] == pytest.approx(2.0)
        assert np.isnan(tops[3:]).all()


def test_a_large_plan_becomes_walls_and_a_laser_sees_them(tmp_path):
    rng = np.random.default_rng(3)
    image = Image.new("L", (500, 500), 255)
    draw = ImageDraw.Draw(image)
    for _ in range(300):  # clutter round about
        x, y = rng.integers(0, 490, 2)
        draw.ellipse((x, y, x + rng.integers(3, 9), y + rng.integers(3, 9)), fill=int(rng.integers(0, 190)))
    draw.rectangle((170, 200, 330, 300), fill=0)
    draw.rectangle((180, 210, 320, 290), fill=255)  # a room of 141 x 81 pixels, its middle at pixel (250.5, 250.5)
    image.save(tmp_path / "map.png")
    attributes = "<scale>0.05</scale><width>0.02</width><errBound>1</errBound><height>1</height>"
    laser = "<model:SickLMS200><id>laser1</id><xyz>0 0 0.2</xyz><rangeMax>10</rangeMax></model:SickLMS200>"
    with world_of(tmp_path, MAP.format("0 0 0", attributes) + laser, "<gravity>0 0 0</gravity>") as world:
        assert len(world.model("map").walls) > 300
        world.step(6)
        rays = world.model("laser1").rays.ranges + 0.2  # from the eye; readings mix neighbours
        x_face, y_face = 71 * 0.05 - 0.01, 41 * 0.05 - 0.01  # right wall, and lower wall: -y
        up_face = 40 * 0.05 - 0.01
        for degrees in range(-90, 91, 2):
            angle = math.radians(degrees)
            to_x = x_face / math.cos(angle) if abs(degrees) < 90 else math.inf
            to_y = (up_face if degrees > 0 else y_face) / abs(math.sin(angle)) if degrees else math.inf
            assert rays[45 + degrees // 2] == pytest.approx(min(to_x, to_y), abs=1e-5), degrees


def test_a_space_closes_with_its_parts():
    engine = Engine()
    whole = Space(engine)
    part = Space(engine, parent=whole)
    geom = libgz.BoxGeom(Body(engine), part, 1, 1, 1)
    other = libgz.SphereGeom(Body(engine), Space(engine), 0.5)
    other.body.SetPosition((0, 0, 0.9))
    engine.step()
    assert engine.contact_count > 0  # what is in a part is touched
    geom.close()
    whole.close()
    with pytest.raises(libgz.ClosedError):
        _ = part.id
    engine.step()
    assert engine.contact_count == 0
    engine.close()


@pytest.mark.parametrize(
    ("content", "words"), [(None, "file 'map.png' was not found"), (b"no picture", "cannot read picture")]
)
def test_a_plan_that_cannot_be_read_is_one_warning_and_no_walls(tmp_path, caplog, content, words):
    if content is not None:
        (tmp_path / "map.png").write_bytes(content)
    with caplog.at_level(logging.WARNING), world_of(tmp_path, MAP.format("0 0 0", "")) as world:
        assert len(world.model("map").walls) == 0
    assert [words in r.getMessage() for r in caplog.records] == [True]


def test_a_plan_must_be_named(tmp_path):
    for model, words in (("MapExtruder", "needs an <imageFile>"), ("Road", "needs a <roadFile>")):
        with pytest.raises(libgz.WorldFileError, match=words):
            world_of(tmp_path, f"<model:{model}/>")


def test_robots_cannot_pass_walls(tmp_path):
    image = Image.new("L", (100, 100), 0)
    ImageDraw.Draw(image).rectangle((20, 20, 79, 79), fill=255)
    image.save(tmp_path / "map.png")
    robot = "<model:Pioneer2DX><id>r</id><xyz>0 0 .238</xyz></model:Pioneer2DX>"
    body = "<model:GroundPlane/>" + MAP.format("0 0 0", "<scale>0.05</scale>") + robot
    with world_of(tmp_path, body) as world:
        world.interface("position", "r").command(vx=0.5)
        world.run(6.0)
        assert 1.2 < world.model("r").GetPose().pos.x < 1.5
