"""Shapes of SDF: meshes of files, height maps, outlines, and how many contacts they make."""

import gc
import math
import os
import struct
import tracemalloc
import weakref

import numpy as np
import pytest
from PIL import Image
from sdf_worlds import GROUND, collision, friction, inertial, link, model, place, world

from libgz.base.geometry import GzPosePointAt, GzVector
from libgz.ode.types import Surface
from libgz.physics.geoms import TriMeshGeom
from libgz.physics.image_files import open_image
from libgz.rendering.camera import Camera
from libgz.sdfworld.terrain import MOST_IMAGES, Cover, _Layer

CUBE = [(x, y, z) for z in (-0.5, 0.5) for y in (-0.5, 0.5) for x in (-0.5, 0.5)]
QUADS = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]


def write_obj(path):
    path.with_suffix(".mtl").write_text("newmtl red\nKd 1 0 0\n")
    lines = [f"mtllib {path.stem}.mtl", *(f"v {x} {y} {z}" for x, y, z in CUBE), "o cube", "usemtl red"]
    lines += ["f " + " ".join(f"{i + 1}//1" for i in quad) for quad in QUADS]
    path.write_text("\n".join(lines))


def write_stl(path, *, binary):
    faces = [[CUBE[q[i]] for i in (0, k, k + 1)] for q in QUADS for k in (1, 2)]
    if binary:
        rows = b"".join(struct.pack("<12fH", 0, 0, 0, *sum(face, ()), 0) for face in faces)
        path.write_bytes(b"\0" * 80 + struct.pack("<I", len(faces)) + rows)
        return
    text = "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join("vertex {} {} {}\n".format(*v) for v in face)
        + "endloop\nendfacet\n"
        for face in faces
    )
    path.write_text(f"solid cube\n{text}endsolid cube\n")


def write_dae(path):
    points = " ".join(f"{10 * v}" for corner in CUBE for v in corner)
    corners = " ".join(f"{i} 0" for quad in QUADS for i in quad)
    path.write_text(
        "<COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema' version='1.4.1'>"
        "<asset><unit meter='0.1'/><up_axis>Z_UP</up_axis></asset>"
        "<library_effects><effect id='e'><profile_COMMON><technique sid='t'><lambert><diffuse>"
        "<color>0 1 0 1</color></diffuse></lambert></technique></profile_COMMON></effect></library_effects>"
        "<library_materials><material id='green'><instance_effect url='#e'/></material></library_materials>"
        "<library_geometries><geometry id='g'><mesh><source id='p'><float_array id='pa' count='24'>"
        f"{points}</float_array></source><vertices id='v'><input semantic='POSITION' source='#p'/></vertices>"
        "<polylist count='6' material='m'><input semantic='VERTEX' source='#v' offset='0'/>"
        f"<input semantic='NORMAL' source='#p' offset='1'/><vcount>4 4 4 4 4 4</vcount><p>{corners}</p></polylist>"
        "</mesh></geometry></library_geometries><library_visual_scenes><visual_scene id='s'>"
        "<node name='away'><translate>30 0 0</translate><instance_geometry url='#g'><bind_material>"
        "<technique_common><instance_material symbol='m' target='#green'/></technique_common></bind_material>"
        "</instance_geometry></node></visual_scene></library_visual_scenes></COLLADA>"
    )


def mesh(uri, more=""):
    return f"<mesh><uri>{uri}</uri>{more}</mesh>"


@pytest.mark.parametrize("kind", ["obj", "stl", "ascii.stl", "dae"])
def test_meshes_fall_and_rest(load, tmp_path, kind):
    path, more = tmp_path / f"cube.{kind}", ""
    if kind == "obj":
        write_obj(path)
    elif kind == "dae":
        write_dae(path)
        more = "<submesh><name>away</name><center>1</center></submesh>"
    else:
        write_stl(path, binary=kind == "stl")
    shape = mesh(path.name, f"<scale>2 2 1</scale>{more}")
    made = load(world(GROUND, model("m", link("l", collision(shape)), pose="0 0 1 0 0 0")))
    made.run(1.5)
    assert place(made.body("m")) == pytest.approx((0, 0, 0.5), abs=2e-3)
    geom = made.body("m").geoms[0]
    assert np.ptp(geom.vertices, axis=0) == pytest.approx((2, 2, 1))
    assert len(geom.triangles) == 12


def test_visuals_of_meshes_have_the_colours_of_their_files(load, tmp_path):
    write_obj(tmp_path / "cube.obj")
    write_dae(tmp_path / "cube.dae")
    visuals = "".join(
        f"<visual name='{name}'><geometry>{mesh('file://' + str(tmp_path / name))}</geometry></visual>"
        for name in ("cube.obj", "cube.dae")
    )
    made = load(world(model("m", link("l", visuals))))
    drawn = made.body("m").geoms
    assert [tuple(geom.GetDiffuseColor())[:3] for geom in drawn] == [(1, 0, 0), (0, 1, 0)]
    assert drawn[1].vertices[:, 0].mean() == pytest.approx(3.0)


def test_what_is_missing_or_broken_is_told_and_left_out(load, tmp_path, caplog):
    (tmp_path / "broken.obj").write_text("v 0 0 0\nf 1 2 3\n")
    write_dae(tmp_path / "cube.dae")
    shapes = [mesh("no.dae"), mesh("broken.obj"), mesh("cube.dae", "<submesh><name>awya</name></submesh>")]
    parts = [collision(shape, name=f"c{i}") for i, shape in enumerate(shapes)]
    made = load(world(model("m", link("l", *parts))))
    made.step()
    assert made.body("m").geoms == []
    assert "Unable to find uri[no.dae]; looked for" in caplog.text
    assert "broken.obj cannot be read" in caplog.text
    assert "has no submesh 'awya'; it has away; did you mean 'away'" in caplog.text


def test_a_height_map_takes_little_more_than_its_heights_until_it_is_shown(load, tmp_path):
    side = 300
    Image.fromarray(np.arange(side * side, dtype=np.uint32).reshape(side, side).astype(np.uint8)).save(
        tmp_path / "h.png"
    )
    shape = "<heightmap><uri>h.png</uri><size>8 8 2</size><sampling>1</sampling></heightmap>"
    look = f"<visual name='v'><geometry>{shape}</geometry></visual>"
    ground = model("ground", "<static>1</static>", link("l", collision(shape) + look))
    load(world(model("first", link("l", look.replace("h.png", "none.png")))))  # imports
    tracemalloc.start()
    try:
        made = load(world(ground))
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 80 * side * side + 2_000_000  # bytes
    geom = next(geom for geom in made.body("ground", "l").geoms if isinstance(geom, TriMeshGeom))
    assert geom.triangles.shape == (2 * (side - 1) ** 2, 3)
    assert geom.vertices[-1].tolist() == [4.0, 4.0, 2.0 * 43 / 255]
    assert geom.normals.shape == geom.vertices.shape == (side * side, 3)


def test_a_height_map_carries(load, tmp_path, caplog):
    slope = np.tile(np.linspace(0, 255, 17), (17, 1)).astype(np.uint8)
    Image.fromarray(slope).save(tmp_path / "slope.png")
    shape = "<heightmap><uri>slope.png</uri><size>8 8 2</size><pos>0 0 1</pos></heightmap>"
    ground = model("ground", "<static>1</static>", link("l", collision(shape)))
    balls = [
        model(f"b{i}", link("l", inertial(1.0, (0.1,) * 3), collision("sphere")), pose=f"{x} 0 {z} 0 0 0")
        for i, (x, z) in enumerate(((-2.0, 2.05), (2.0, 3.05)))
    ]
    made = load(world(ground, *balls))
    made.run(0.6)
    assert made.body("b1").GetPosition().z - made.body("b0").GetPosition().z == pytest.approx(1.0, abs=0.05)
    geom = made.model("ground").bodies[0].geoms[0]
    assert geom.GetPose().pos.z == 1.0
    assert [geom.heights.min(), geom.heights.max()] == pytest.approx([0.0, 2.0])
    assert made.engine.tables.geoms.surface[geom.row, Surface.MAX_VEL] == 0.0
    load(world(model("m", link("l", collision("<heightmap/>")))))
    assert "<heightmap>: it has no <uri>; the shape is left out" in caplog.text


def test_a_height_map_is_read_once(load, tmp_path, monkeypatch):
    Image.fromarray(np.arange(81, dtype=np.uint8).reshape(9, 9)).save(tmp_path / "h.png")
    Image.new("RGB", (8, 8), (90, 60, 30)).save(tmp_path / "soil.png")
    read = []
    noted = lambda path, *more: read.append(path) or open_image(path, *more)  # noqa: E731
    monkeypatch.setattr("libgz.sdfworld.terrain.open_image", noted)
    texture = f"<texture><diffuse>file://{tmp_path}/soil.png</diffuse><size>2</size></texture>"
    shape = f"<heightmap><uri>file://{tmp_path}/h.png</uri><size>8 8 2</size>{texture}</heightmap>"
    shown = f"<visual name='v'><geometry>{shape}</geometry></visual>"
    load(world(model("m", "<static>1</static>", link("l", collision(shape), shown))))
    assert sorted(path.name for path in read) == ["h.png", "soil.png"]
    Image.fromarray(np.zeros((9, 9), dtype=np.uint8)).save(tmp_path / "h.png")
    os.utime(tmp_path / "h.png", (1.0, 1.0))
    read.clear()
    load(world(model("m", "<static>1</static>", link("l", collision(shape)))))
    assert [path.name for path in read] == ["h.png"]


def test_the_top_of_a_picture_lies_at_plus_y(load, tmp_path):
    picture = np.zeros((9, 9), dtype=np.uint8)
    picture[0, :] = 255
    Image.fromarray(picture).save(tmp_path / "edge.png")
    shape = "<heightmap><uri>edge.png</uri><size>8 8 1</size></heightmap>"
    made = load(world(model("g", "<static>1</static>", link("l", collision(shape)))))
    heights = made.model("g").bodies[0].geoms[0].heights
    assert (np.nonzero((heights > 0.5).any(axis=1))[0] == len(heights) - 1).all()
    turned = load(world(model("g", "<static>1</static>", link("l", collision(shape)), pose="0 0 0 0 0 .5")))
    vertices = turned.model("g").bodies[0].geoms[0].vertices
    assert set(vertices[vertices[:, 2] > 0.5][:, 1]) == {4.0}


def test_ground_has_vertices_between_pixels(load, tmp_path):
    Image.fromarray(np.array([[0, 100], [200, 200]], dtype=np.uint8)).save(tmp_path / "h.png")
    for sampling, side in (
        ("", 3),
        ("<sampling>1</sampling>", 2),
        ("<sampling>4</sampling>", 5),
        ("<sampling>3</sampling>", 3),
    ):
        shape = f"<heightmap><uri>h.png</uri><size>8 8 1</size>{sampling}</heightmap>"
        made = load(world(model("g", "<static>1</static>", link("l", collision(shape)))))
        heights = made.model("g").bodies[0].geoms[0].heights
        assert heights.shape == (side, side)
        assert heights[side // 2, side // 2] == pytest.approx(0.625 if side > 2 else 0.5)


GAZEBO_BOWL = (1.283828, 0.107573, 0.150349)  # [m] after 1,000 iterations in the real Gazebo 11.1


def test_balls_roll_on_ground_as_in_gazebo(load, tmp_path):
    """Down a bowl; and up, where one begins in the ground."""
    side = np.linspace(-0.5, 0.5, 33)
    bowl = np.minimum(1.0, 2.0 * (side[:, None] ** 2 + side**2)) * 255
    Image.fromarray(bowl.astype(np.uint8)).save(tmp_path / "bowl.png")
    Image.fromarray(np.full((17, 17), 127, dtype=np.uint8)).save(tmp_path / "flat.png")
    ball = lambda z, x=1.57, y=0.13: model(  # noqa: E731
        "b",
        link("l", inertial(1.0, (0.004,) * 3), collision("<sphere><radius>.1</radius></sphere>")),
        pose=f"{x} {y} {z} 0 0 0",
    )
    for name, z, wanted in (("bowl", 1.0, GAZEBO_BOWL), ("flat", 0.6, (1.57, 0.13, 0.9))):
        shape = f"<heightmap><uri>{name}.png</uri><size>8 8 1</size></heightmap>"
        made = load(world(model("g", "<static>1</static>", link("l", collision(shape))), ball(z)))
        made.step(1000)
        assert tuple(made.body("b").GetPosition()) == pytest.approx(wanted, abs=3e-4)


def points(*corners):
    return "".join(f"<point>{x} {y}</point>" for x, y in corners)


def test_outlines_are_solids_with_holes(load, caplog):
    outer = points((0, 0), (2, 0), (2, 2), (1, 1), (0, 2), (0, 0))
    hole = points((0.8, 0.3), (1.2, 0.3), (1.2, 0.6), (0.8, 0.6))
    shape = f"<polyline>{outer}<height>0.5</height></polyline><polyline>{hole}<height>0.5</height></polyline>"
    made = load(world(model("m", "<static>1</static>", link("l", collision(shape)))))
    geom = made.model("m").bodies[0].geoms[0]
    a, b, c = (geom.vertices[geom.triangles[:, i]] for i in range(3))
    volume = float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum()) / 6
    assert volume == pytest.approx(0.5 * (3.0 - 0.12))
    ranges, rows = np.empty(3), np.empty(3, dtype=np.int64)
    rays = np.array([[x, y, 5, 0, 0, -1, 20] for x, y in ((0.5, 0.5), (1.0, 0.45), (1.0, 1.5))], dtype=float)
    made.engine.scan(np.array([0, 0, 0, 1.0, 0, 0, 0]), rays, 0, ranges, rows)
    assert ranges[0] == pytest.approx(4.5)
    assert list(rows[1:]) == [-1, -1]
    crossed = points((0, 0), (2, 2), (2, 0), (0, 2))
    load(world(model("m", link("l", collision(f"<polyline>{crossed}<height>1</height></polyline>")))))
    assert "span an area; the shape is left out" in caplog.text


def test_more_contacts_than_ten_on_request(load, tmp_path):
    """A ring of teeth touches the ground at many points."""
    ring = [(math.cos(a), math.sin(a)) for a in np.linspace(0, 2 * math.pi, 24, endpoint=False)]
    rows = [f"v {x} {y} {z}" for z in (0, 1) for x, y in ring]
    rows += [
        f"f {i + 1} {(i + 1) % 24 + 1} {(i + 1) % 24 + 25}\nf {i + 1} {(i + 1) % 24 + 25} {i + 25}" for i in range(24)
    ]
    (tmp_path / "ring.obj").write_text("\n".join(rows))
    for own, all_, expected in ((10, 20, 10), (18, 20, 18), (100, 20, 20), (100, 24, 24)):
        most = f"<max_contacts>{own}</max_contacts>"
        ground = collision("<plane/>", more="<max_contacts>100</max_contacts>")
        made = load(
            world(
                model("g", "<static>1</static>", link("l", ground)),
                model("m", link("l", collision(mesh("ring.obj"), more=most)), pose="0 0 -0.001 0 0 0"),
                physics=f"<max_contacts>{all_}</max_contacts>",
            )
        )
        made.step()
        assert made.engine.contact_count == expected


def volume(geom):
    a, b, c = (geom.vertices[geom.triangles[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum()) / 6


def test_outlines_in_any_order_are_solids_and_holes_by_turns(load):
    def square(x, y, size):
        corners = points((x, y), (x + size, y), (x + size, y + size), (x, y + size))
        return f"<polyline>{corners}<height>1</height></polyline>"

    island, hole, outer, other = square(2, 2, 1), square(1, 1, 3), square(0, 0, 5), square(8, 0, 2)
    made = load(world(model("m", "<static>1</static>", link("l", collision(island + hole + outer + other)))))
    assert volume(made.model("m").bodies[0].geoms[0]) == pytest.approx(25 - 9 + 1 + 4)


def test_an_ellipsoid_is_nearly_its_volume_and_stands_on_its_pole(load):
    egg = "<ellipsoid><radii>0.3 0.2 0.5</radii></ellipsoid>"
    made = load(world(GROUND, model("m", link("l", inertial(1.0, (0.1,) * 3), collision(egg)), pose="0 0 0.51 0 0 0")))
    geom = made.model("m").bodies[0].geoms[0]
    assert volume(geom) == pytest.approx(4 / 3 * math.pi * 0.3 * 0.2 * 0.5, rel=0.05)
    assert geom.vertices.max(axis=0) == pytest.approx((0.3, 0.2, 0.5), rel=1e-3)
    made.run(0.3)
    assert made.body("m").GetPosition().z == pytest.approx(0.5, abs=0.005)


def test_a_plane_has_normals_of_any_length_and_friction_by_direction(load):
    """At mu 0 along the slope, which is along the direction, a block slides at g sin; across it nothing moves."""
    slope = math.atan(0.4)

    def plane(y):
        shape = "<plane><normal>0.8 0 2</normal></plane>"
        return model("p", "<static>1</static>", link("l", collision(shape, friction(0, 10))), pose=f"0 {y} 3 0 0 0")

    def block(y, direction):
        surface = friction(10, 10, f"<fdir1>{direction}</fdir1>")
        shape = collision("<box><size>.4 .4 .2</size></box>", surface)
        place = f"{0.1 * math.sin(slope)} {y} {3 + 0.1 * math.cos(slope)} 0 {slope} 0"
        return model(f"b{y}", link("l", inertial(1.0, (0.02, 0.02, 0.02)), shape), pose=place)

    for direction, mode in (("1 0 0", "slides"), ("0 1 0", "holds")):
        made = load(world(plane(0), block(0, direction)))
        made.step(200)
        speed = math.hypot(*made.body("b0").GetLinearVel())
        expected = 0.2 * 9.8 * math.sin(slope) if mode == "slides" else 0.0
        assert speed == pytest.approx(expected, rel=0.02, abs=1e-3)
        x, _, z = made.body("b0").GetPosition()
        assert math.sin(slope) * x + math.cos(slope) * (z - 3.0) == pytest.approx(0.1, abs=1e-4)


@pytest.mark.parametrize(
    "shape",
    [
        "<box><size>0 0 0</size></box>",
        "<box><size>1 1 0</size></box>",
        "<sphere><radius>0</radius></sphere>",
        "<cylinder><radius>0.5</radius><length>0</length></cylinder>",
    ],
)
def test_a_shape_with_a_length_of_0_falls_through_the_ground_as_in_gazebo(load, caplog, shape):
    made = load(world(GROUND, model("m", link("l", inertial(), collision(shape)), pose="0 0 0.5 0 0 0")))
    made.step(1000)
    assert made.body("m").GetPosition().z == pytest.approx(0.5 - 4.9, abs=0.01)
    assert "touches nothing" in caplog.text


def test_images_of_terrains_are_kept_while_the_terrains_are_and_a_few_at_most():
    covers = [Cover(np.zeros((2, 2)), (8.0, 8.0), (_Layer(None, 1.0),)) for _ in range(MOST_IMAGES + 2)]
    images = [weakref.ref(cover.image()) for cover in covers]
    assert covers[-1].image() is images[-1]()
    gc.collect()
    assert sum(image() is not None for image in images) == MOST_IMAGES
    covers.clear()
    gc.collect()
    assert not any(image() is not None for image in images)


def terrain(shape):
    visual = f"<visual name='v'><geometry>{shape}</geometry></visual>"
    return f"<model name='m'><static>1</static><link name='l'>{visual}</link></model>"


def test_a_height_map_has_its_textures_mixed_by_height(load, tmp_path):
    steps = Image.new("L", (5, 5))
    steps.putdata([0, 0, 0, 255, 255] * 5)
    steps.save(tmp_path / "steps.png")
    for name, color in (("low", (200, 0, 0)), ("high", (0, 0, 200))):
        Image.new("RGB", (8, 8), color).save(tmp_path / f"{name}.png")
    layers = "".join(
        f"<texture><diffuse>file://{tmp_path}/{name}.png</diffuse><size>1</size></texture>" for name in ("low", "high")
    )
    blend = "<blend><min_height>0.5</min_height><fade_dist>1</fade_dist></blend>"
    shape = f"<heightmap><uri>file://{tmp_path}/steps.png</uri><size>8 8 2</size>{layers}{blend}</heightmap>"
    made = load(world(terrain(shape)))
    [geom] = made.body("m", "l").geoms
    image = geom.image()
    side = len(image)
    assert tuple(image[side // 2, side // 8]) == (200, 0, 0)  # at -x: below
    assert tuple(image[side // 2, -side // 8]) == (0, 0, 200)
    assert image[side // 2, round(side * 0.625)].tolist() == pytest.approx([100, 0, 100], abs=15)  # 1 m high
    assert geom.texture_coordinates[[0, -1]].tolist() == [[0, 0], [1, 1]]
    with Camera(made, 32, 24) as camera:
        for x, ahead, behind in ((-2, 0, 2), (3, 2, 0)):
            camera.SetPose(GzPosePointAt(GzVector(x, 0, 6), GzVector(x + 0.1, 0, 0), GzVector(0, 0, 1)))
            middle = camera.Update()[12, 16].astype(int)
            assert middle[ahead] > 2 * middle[behind]


@pytest.mark.parametrize(
    ("inside", "text"),
    [
        ("<texture><diffuse>file://nowhere.png</diffuse></texture>", "nowhere.png"),
        ("<texture><size>2</size></texture>", "no <diffuse>"),
        ("<texture><diffuse>file://PATH/h.png</diffuse></texture>" * 2, "texture 2 has no <blend>"),
        ("<texture><diffuse>file://PATH/h.png</diffuse><size>0</size></texture>", "texture size"),
    ],
)
def test_a_texture_of_a_height_map_that_cannot_be_used_is_a_warning(load, inside, text, tmp_path, caplog):
    Image.new("L", (5, 5), 9).save(tmp_path / "h.png")
    inside = inside.replace("PATH", str(tmp_path))
    shape = f"<heightmap><uri>file://{tmp_path}/h.png</uri><size>8 8 2</size>{inside}</heightmap>"
    load(world(terrain(shape)))
    assert text in caplog.text


@pytest.mark.parametrize("more", ["", collision("sphere", name="ball", pose="0 0 9 0 0 0")])
def test_a_plane_of_a_moving_model_falls_with_it(load, more):
    plane = collision("<plane><normal>0 0 1</normal></plane>")
    box = model("box", link("l", inertial(), collision()), pose="5 0 3 0 0 0")
    made = load(world(GROUND, box, model("m", link("l", plane, more))))
    made.step(30)
    for name, start in (("m", 0.0), ("box", 3.0)):
        assert place(made.body(name))[2] == pytest.approx(start - 9.8e-6 * 30 * 31 / 2)
