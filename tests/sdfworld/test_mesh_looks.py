"""Looks of meshes from files: normals, transparency, images of skins, and colours that replace all of them."""

import io
import re
from importlib.resources import files

import numpy as np
import pytest
from PIL import Image
from sdf_worlds import link, model, world

from libgz.classic import rendering
from libgz.classic.math import Color
from libgz.classic.server import attach
from libgz.physics.appearance import RENDER_TRANSPARENT
from libgz.physics.mesh_files import Collada, read_mesh
from libgz.view.assets import Assets
from libgz.view.local import LocalSource

# Two triangles that meet at the z axis at a right angle.
BENT = "v 0 -1 0\nv 1 0 0\nv 0 1 0\nv 1 0 1\n"
SQUARE = "v 0 -1 -1\nv 0 1 -1\nv 0 1 1\nv 0 -1 1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
DAE = """<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<library_effects><effect id="e"><profile_COMMON><technique sid="t"><lambert>
<diffuse><color>0.2 0.4 0.6 1</color></diffuse>{transparent}</lambert></technique></profile_COMMON></effect>
</library_effects><library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>
<library_geometries><geometry id="g"><mesh><source id="p"><float_array>0 0 0 1 0 0 0 1 0</float_array></source>
<source id="n"><float_array>{normals}</float_array><technique_common><accessor stride="3"/></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/>{shared}</vertices><triangles count="1" material="s">
<input semantic="VERTEX" source="#v" offset="0"/>{own}<p>{corners}</p></triangles></mesh></geometry>
</library_geometries>
<library_visual_scenes><visual_scene id="s"><node>{frame}<instance_geometry url="#g"><bind_material>
<technique_common><instance_material symbol="s" target="#m"/></technique_common></bind_material></instance_geometry>
</node></visual_scene></library_visual_scenes></COLLADA>"""
PLAIN = {"transparent": "", "normals": "0 0 1", "shared": "", "own": "", "corners": "0 1 2", "frame": ""}
OWN = {"own": '<input semantic="NORMAL" source="#n" offset="1"/>', "corners": "0 0 1 0 2 0"}


def parts_of(path, text):
    path.write_text(text)
    return read_mesh(path)


def normals_of(geom):
    return np.round(geom.normals[geom.triangles.ravel()], 3)


def shown(load, uri, more="", scale="1 1 1"):
    mesh = f"<mesh><uri>{uri}</uri><scale>{scale}</scale></mesh>"
    return load(
        world(
            model("m", "<static>1</static>", link("l", f"<visual name='v'><geometry>{mesh}</geometry>{more}</visual>"))
        )
    )


# Normals -----------------------------------------------------------------------------------------------------------


def test_corners_have_the_normals_of_an_obj_file(load, tmp_path):
    (tmp_path / "a.obj").write_text(f"{BENT}vn 2 0 0\nvn 0 0 5\nf 1//1 2//1 4//2\nf 2//-1 3 4\n")
    [geom] = shown(load, "a.obj").body("m").geoms
    assert normals_of(geom)[:4].tolist() == [[1, 0, 0], [1, 0, 0], [0, 0, 1], [0, 0, 1]]
    flat = np.cross((-1, 1, 0), (0, 0, 1)) / np.sqrt(2)
    assert normals_of(geom)[4:] == pytest.approx(np.array([flat, flat]), abs=1e-3)  # where the file has none


def test_normals_of_a_stretched_and_of_a_mirrored_mesh_stay_perpendicular(load, tmp_path):
    (tmp_path / "a.obj").write_text(f"{BENT}vn 1 -1 0\nf 1//1 2//1 4//1\n")
    [geom] = shown(load, "a.obj", scale="3 1 1").body("m").geoms
    assert normals_of(geom)[0] == pytest.approx(np.array((1, -3, 0)) / np.sqrt(10), abs=1e-3)
    [geom] = shown(load, "a.obj", scale="-1 1 1").body("m").geoms
    a, b, c = geom.vertices[geom.triangles[0]]
    assert normals_of(geom)[0] == pytest.approx(np.array((-1, -1, 0)) / np.sqrt(2), abs=1e-3)
    assert np.dot(np.cross(b - a, c - a), geom.normals[0]) > 0.0


@pytest.mark.parametrize(
    "values", [OWN, {"shared": '<input semantic="NORMAL" source="#n"/>', "normals": "1 0 1 1 0 1 1 0 1"}]
)
def test_corners_have_the_normals_of_a_collada_file(tmp_path, values):
    turned = {"normals": "1 0 1"} | values | {"frame": "<rotate>0 0 1 90</rotate><scale>1 1 2</scale>"}
    [part] = parts_of(tmp_path / "a.dae", DAE.format(**PLAIN | turned))
    assert part.normals == pytest.approx(np.tile(np.array((0, 2, 1)) / np.sqrt(5), (1, 3, 1)), abs=1e-6)


@pytest.mark.parametrize("normals", ["", "nan 0 1", "0 0 x", "0 0"])
def test_damaged_normals_are_computed_from_the_triangles(load, tmp_path, normals):
    (tmp_path / "a.dae").write_text(DAE.format(**PLAIN | OWN | {"normals": normals}))
    [geom] = shown(load, "a.dae").body("m").geoms
    assert np.isfinite(geom.normals if geom.normals is not None else 0.0).all()
    [part] = parts_of(tmp_path / "b.obj", f"{BENT}vn {normals or 'x'}\nf 1//1 2//7 4//x\n")
    assert part.normals is None


def test_stl_files_are_flat(load, tmp_path):
    corners = ["0 0 0", "1 0 0", "1 1 0.1", "0 0 0", "1 1 0.1", "0 1 0"]
    text = "".join(f"vertex {corner}\n" for corner in corners)
    (tmp_path / "a.stl").write_text(f"solid a\n{text}endsolid\n")
    [geom] = shown(load, "a.stl").body("m").geoms
    first, second = normals_of(geom).reshape(2, 3, 3)
    assert (first == first[0]).all()
    assert (second == second[0]).all()
    assert (first[0] != second[0]).any()


# Transparency ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("library", "alpha"),
    [("Kd 1 0 0\nd 0.25", 0.25), ("Kd 1 0 0\nTr 0.25", 0.75), ("d -halo 0.5", 0.5), ("Kd 1 0 0\nd 7", 1.0)],
)
def test_obj_files_may_be_transparent(load, tmp_path, library, alpha):
    (tmp_path / "a.mtl").write_text(f"newmtl look\n{library}\n")
    (tmp_path / "a.obj").write_text(f"mtllib a.mtl\n{SQUARE}usemtl look\nf 1 2 3 4\n")
    [geom] = shown(load, "a.obj").body("m").geoms
    assert geom.appearance.diffuse.a == pytest.approx(alpha)
    assert (geom.appearance.render_order == RENDER_TRANSPARENT) == (alpha < 1.0)


def test_the_page_shows_normals_and_transparency(load, tmp_path):
    (tmp_path / "a.mtl").write_text("newmtl look\nKd 1 0 0\nd 0.25\n")
    (tmp_path / "a.obj").write_text(f"mtllib a.mtl\n{BENT}vn 0 0 1\nusemtl look\nf 1//1 2//1 4//1\n")
    source = LocalSource(shown(load, "a.obj"))
    [shape] = source.scene["entities"][0]["bodies"][0]["shapes"]
    assert shape["material"]["opacity"] == 0.25
    assert np.array_equal(source.data(shape["data"])["normals"], np.tile((0, 0, 1), (3, 1)))


@pytest.mark.parametrize(
    ("mode", "color", "factor", "opacity"),
    [
        ("A_ONE", "1 1 1 0.5", "0.5", 0.25),
        ("A_ONE", "1 1 1 0.5", None, 0.5),
        ("A_ZERO", "1 1 1 0.5", "0.5", 0.75),
        ("RGB_ZERO", "0.5 0.5 0.5 1", "1", 0.5),
        ("RGB_ONE", "0 1 0 1", "1", 0.71516),
        (None, "1 1 1 1", "0", 1.0),  # as some programs write opaque materials
        ("A_ONE", "1 1", "0.5", 1.0),
        ("A_ONE", "1 1 1 1", "nan", 1.0),
    ],
)
def test_collada_files_may_be_transparent(tmp_path, mode, color, factor, opacity):
    opaque = f" opaque='{mode}'" if mode else ""
    share = f"<transparency><float>{factor}</float></transparency>" if factor else ""
    text = f"<transparent{opaque}><color>{color}</color></transparent>{share}"
    [part] = parts_of(tmp_path / "a.dae", DAE.format(**PLAIN | {"transparent": text}))
    assert part.color == pytest.approx((0.2, 0.4, 0.6, opacity))


def test_an_effect_is_read_once_for_all_groups(tmp_path, monkeypatch):
    read = []
    monkeypatch.setattr(Collada, "opacity", lambda _self, effect: read.append(effect) or 1.0)
    group = DAE[DAE.index("<triangles") : DAE.index("</mesh>")]
    [first, second] = parts_of(tmp_path / "a.dae", DAE.replace(group, 2 * group).format(**PLAIN))
    assert first.color == second.color == (0.2, 0.4, 0.6, 1.0)
    assert len(read) == 1


# Colours that replace a file's look ----------------------------------------------------------------------------------


@pytest.fixture
def textured(tmp_path):
    Image.new("RGB", (8, 8), (255, 0, 0)).save(tmp_path / "red.png")
    (tmp_path / "a.mtl").write_text("newmtl look\nKd 0.5 0.5 0.5\nmap_Kd red.png\n")
    (tmp_path / "a.obj").write_text(f"mtllib a.mtl\n{SQUARE}usemtl look\nf 1/1 2/2 3/3 4/4\n")


def test_a_colour_that_a_plugin_sets_replaces_the_images_of_a_mesh(load, textured):
    core = shown(load, "a.obj")
    attach(core)
    [geom] = core.body("m").geoms
    assert geom.appearance.texture_file is not None
    visual = rendering.get_scene().GetVisual("m::l::v")
    before = core.get_state()
    visual.SetAmbient(Color(0, 0, 1, 1))
    look = geom.appearance
    assert look.texture_file is None
    assert (tuple(look.ambient)[:3], tuple(look.diffuse)[:3]) == ((0, 0, 1), (1, 1, 1))
    visual.SetDiffuse(Color(0, 1, 0, 1))
    assert tuple(look.ambient)[:3] == (0, 0, 1)  # the second one changes nothing else
    core.set_state(before)
    assert geom.appearance.texture_file is not None
    visual.SetMaterial("Gazebo/Red")
    assert geom.appearance.texture_file is None


def test_one_colour_of_a_material_replaces_all_of_a_mesh(load, textured):
    [geom] = shown(load, "a.obj", "<material><ambient>0 0 1 1</ambient></material>").body("m").geoms
    assert geom.appearance.texture_file is None
    assert tuple(geom.appearance.diffuse)[:3] == (1, 1, 1)


# Skins -------------------------------------------------------------------------------------------------------------


def test_skins_of_actors_show_their_images(load, tmp_path):
    Image.new("RGB", (8, 8), (255, 0, 0)).save(tmp_path / "red.png")
    text = (files("libgz") / "sdf/media/models/walk.dae").read_text()
    points = re.search(r'id="body-positions-array"[^>]*>([^<]*)', text)[1].split()
    rows = " ".join(f"{float(x):.3f}" for i, x in enumerate(points) if i % 3)
    vertex = '<input semantic="VERTEX" source="#body-vertices" offset="0"/>'
    text = text.replace(vertex, f'{vertex}<input semantic="TEXCOORD" source="#uv" offset="0"/>')
    text = text.replace("<vertices", f'<source id="uv"><float_array>{rows}</float_array></source><vertices', 1)
    image = '<library_images><image id="i"><init_from>red.png</init_from></image></library_images><library_effects>'
    text = text.replace("<library_effects>", image)
    shirt = re.compile(r'(<effect id="shirt-effect">.*?<diffuse>)<color.*?</color>')
    (tmp_path / "a.dae").write_text(shirt.sub(r'\1<texture texture="i" texcoord="UV"/>', text))
    clip = "<filename>a.dae</filename>"
    made = load(world(f"<actor name='a'><skin>{clip}</skin><animation name='walk'>{clip}</animation></actor>"))
    skins = next(entity for entity in made.entities if entity.name == "a").skins
    [shirt_geom] = [skin for skin in skins if skin.appearance.texture_file is not None]
    made.step(100)
    shirt_geom.bend()
    assert len(shirt_geom.vertices) == len(shirt_geom.normals) == len(shirt_geom.texture_coordinates)
    assert np.linalg.norm(shirt_geom.normals, axis=1) == pytest.approx(1.0)
    source = LocalSource(made)
    bodies = [body for entity in source.scene["entities"] for body in entity["bodies"]]
    shape = next(shape for body in bodies for shape in body["shapes"] if shape["texture"])
    assets = Assets(source)
    asset = assets.get(assets.of_scene(source.scene)[shape["texture"]["file"]])
    pixels = np.asarray(Image.open(io.BytesIO(asset.body)).convert("RGB")).reshape(-1, 3)
    assert pixels.mean(axis=0) == pytest.approx((255, 0, 0), abs=12)
