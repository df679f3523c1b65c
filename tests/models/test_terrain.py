"""Terrain from files and height maps."""

import math

import numpy as np
import pytest
from ground_worlds import ball, heights_below, world_of
from PIL import Image

import libgz
from libgz.base.geometry import GzQuaternToEuler
from libgz.models.greyimage import read_grey
from libgz.models.gzb import read_gzb, write_gzb
from libgz.physics.body import Body
from libgz.physics.engine import Engine
from libgz.physics.meshes import grid_strip, grid_triangles, vertex_normals
from libgz.physics.space import Space
from libgz.physics.surfaces import TerrainGeom

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


def test_terrain_files_are_read_as_written(tmp_path):
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
def test_rays_hit_the_terrain_at_the_heights_of_its_formula(tmp_path, place, turn):
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


def test_a_ball_rolls_down_a_terrain_by_the_formula(tmp_path):
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


def test_a_terrain_can_be_rendered(tmp_path):
    packed, strip, triangles = packed_wave()
    write_gzb(tmp_path / "t.gzb", packed, strip, triangles)
    with world_of(tmp_path, TERRAIN.format("0 0 0", "0 0 0")) as world:
        ground = world.models[0].ground
        assert ground.vertices.shape == ground.normals.shape == (COUNT * COUNT, 3)
        assert ground.texture_coordinates == pytest.approx(packed[:, :2], abs=1e-3)
        assert ground.colors.shape == (COUNT * COUNT, 4)
        assert np.array_equal(ground.strip, strip)
        assert ground.GetDiffuseColor() == libgz.GzColor(0.7, 0.7, 0.7)
        assert world.engine.tables.geoms.surface[ground.row, :4].tolist() == [math.inf, 0, 1, 0]


def test_a_terrain_with_converted_line_ends_is_repaired(tmp_path, caplog):
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
        assert "were repaired" in caplog.text


def test_invalid_triangles_are_ignored(tmp_path, caplog):
    packed, strip, triangles = packed_wave()
    path = tmp_path / "t.gzb"
    write_gzb(path, packed, strip, triangles)
    data = bytearray(path.read_bytes())
    data[-4:] = (10**6).to_bytes(4, "big")  # names no vertex
    data[-16:-12] = data[-20:-16]  # has no area
    path.write_bytes(data)
    with world_of(tmp_path, TERRAIN.format("0 0 0", "0 0 0")) as world:
        assert len(world.models[0].ground.triangles) == len(triangles) - 2
    assert "1 triangles refer to a vertex that does not exist" in caplog.text


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (lambda d: d[:-9], "; its counts, "),
        (lambda d: b"", "is not a terrain file"),
        (lambda d: b"\x89PNG" + d, "is not a terrain file"),
        (lambda d: d[:28] + b"\xff" * 4 + d[32:], "; its counts, "),
        (lambda d: d[:28] + b"\0" * 12, "needs at least one triangle"),
    ],
)
def test_a_damaged_terrain_is_one_warning_and_no_ground(tmp_path, caplog, damage, words):
    write_gzb(tmp_path / "t.gzb", *packed_wave())
    (tmp_path / "t.gzb").write_bytes(damage((tmp_path / "t.gzb").read_bytes()))
    with world_of(tmp_path, TERRAIN.format("0 0 0", "0 0 0") + ball(5, 5, 3)) as world:
        world.step(3)
        assert world.model("ball").GetPose().pos.z < 3.0
    assert [words in r.getMessage() and "no ground is built" in r.getMessage() for r in caplog.records] == [True]


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
        # The first row of the picture is at +y; its middle is the origin.
        found = heights_below(world, np.stack([0.5 * (column - 19.5), 0.5 * (14.5 - row)], axis=1) + 1e-7)
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
        rays = np.array([[1.0 - 29.5, 0.5, z, 1.0, 0.0, 0.0, 60.0] for z in np.linspace(0.1, 2.9, 40)])
        ranges, rows = np.empty(40), np.empty(40, dtype=np.int64)
        world.engine.scan(np.array([0, 0, 0, 1.0, 0, 0, 0]), rays, 0, ranges, rows)
        assert ranges == pytest.approx(18.0 + rays[:, 2] / 3.0, abs=1e-5)


def test_grey_values_of_all_image_modes(tmp_path):
    ramp = np.arange(256, dtype=np.uint8).reshape(16, 16)
    Image.fromarray(ramp).save(tmp_path / "8.png")
    Image.fromarray(ramp.astype(np.uint16) * 257).save(tmp_path / "16.png")
    Image.fromarray(np.stack([ramp] * 3, axis=-1)).save(tmp_path / "rgb.ppm")
    for name in ("8.png", "16.png", "rgb.ppm"):
        assert read_grey(tmp_path / name) == pytest.approx(ramp.astype(float)), name
    Image.new("RGBA", (4, 4), (0, 0, 0, 0)).save(tmp_path / "clear.png")
    assert (read_grey(tmp_path / "clear.png") == 255).all()
    (tmp_path / "no.png").write_text("no picture")
    with pytest.raises(libgz.ParameterError, match="cannot be read"):
        read_grey(tmp_path / "no.png")
    Image.new("1", (2049, 2048)).save(tmp_path / "huge.png")
    with pytest.raises(libgz.ParameterError, match="pixels"):
        read_grey(tmp_path / "huge.png")


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
