"""Images on meshes: what OBJ and COLLADA files name, where it is looked for, and what takes its place."""

import io
import os
import re

import numpy as np
import pytest
from PIL import Image
from sdf_worlds import collision, link, model, world

from libgz.base.geometry import GzPosePointAt, GzVector
from libgz.physics.mesh_files import read_mesh
from libgz.rendering.camera import Camera
from libgz.simulation.description import describe_body
from libgz.view.assets import Assets
from libgz.view.local import LocalSource

SQUARE = [(0, -1, -1), (0, 1, -1), (0, 1, 1), (0, -1, 1)]  # facing +x, its left edge at -y
CORNERS = [(0, 0), (1, 0), (1, 1), (0, 1)]
RED, GREEN, BLUE, WHITE = (255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 255)  # top row, then bottom row


def write_image(path):
    path.parent.mkdir(parents=True, exist_ok=True)
    pixels = np.array([[RED, GREEN], [BLUE, WHITE]], dtype=np.uint8).repeat(16, axis=0).repeat(16, axis=1)
    Image.fromarray(pixels).save(path)


def write_obj(path, library="map_Kd four.png", face="f 1/1 2/2 3/3 4/4", corners=CORNERS):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.with_suffix(".mtl").write_text(f"newmtl look\nKd 1 1 1\n{library}\n")
    lines = [f"mtllib {path.stem}.mtl", *("v {} {} {}".format(*p) for p in SQUARE)]
    lines += [*("vt {} {}".format(*c) for c in corners), "usemtl look", face]
    path.write_text("\n".join(lines))


# Images of COLLADA files, and the effects that show them.
OF_1_4 = "<init_from>four.png</init_from>"
SAMPLED = (
    "<newparam sid='a'><surface type='2D'><init_from>image</init_from></surface></newparam>"
    "<newparam sid='b'><sampler2D><source>a</source></sampler2D></newparam>"
)
SAMPLED_1_5 = "<newparam sid='b'><sampler2D><instance_image url='#image'/></sampler2D></newparam>"


def write_dae(path, image=OF_1_4, parameters=SAMPLED, texture="b", corners=CORNERS):
    path.parent.mkdir(parents=True, exist_ok=True)
    points = " ".join(str(x) for p in SQUARE for x in p)
    rows = " ".join(f"{s} {t} 9" for s, t in corners)
    path.write_text(
        "<COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema' version='1.4.1'>"
        f"<library_images><image id='image'>{image}</image></library_images>"
        f"<library_effects><effect id='e'><profile_COMMON>{parameters}<technique sid='t'><lambert><diffuse>"
        f"<texture texture='{texture}' texcoord='UV'/></diffuse></lambert></technique></profile_COMMON></effect>"
        "</library_effects><library_materials><material id='look'><instance_effect url='#e'/></material>"
        "</library_materials><library_geometries><geometry id='g'><mesh>"
        f"<source id='p'><float_array>{points}</float_array></source>"
        "<source id='other'><float_array>0 0 0</float_array></source>"
        f"<source id='c'><float_array>{rows}</float_array><technique_common><accessor stride='3'/></technique_common>"
        "</source><vertices id='v'><input semantic='POSITION' source='#p'/></vertices>"
        "<polylist count='1' material='m'><input semantic='VERTEX' source='#v' offset='0'/>"
        "<input semantic='TEXCOORD' source='#other' offset='2' set='0'/>"
        "<input semantic='TEXCOORD' source='#c' offset='1' set='1'/><vcount>4</vcount>"
        "<p>0 0 0 1 1 0 2 2 0 3 3 0</p></polylist></mesh></geometry></library_geometries><library_visual_scenes>"
        "<visual_scene id='s'><node name='n'><instance_geometry url='#g'><bind_material><technique_common>"
        "<instance_material symbol='m' target='#look'>"
        "<bind_vertex_input semantic='UV' input_semantic='TEXCOORD' input_set='1'/></instance_material>"
        "</technique_common></bind_material></instance_geometry></node></visual_scene></library_visual_scenes></COLLADA>"
    )


def visual(uri, more="", scale="1 1 1"):
    mesh = f"<mesh><uri>{uri}</uri><scale>{scale}</scale></mesh>"
    return f"<visual name='v'><geometry>{mesh}</geometry>{more}</visual>"


def loaded(load, *parts):
    return load(world(model("m", "<static>1</static>", link("l", *parts))))


def quarters(made, x=4.0):
    """The strongest channel of the image's quarters: top left, top right, bottom left, bottom right; 3: none."""
    with Camera(made, 32, 32) as camera:
        camera.SetPose(GzPosePointAt(GzVector(x, 0, 0), GzVector(0, 0, 0), GzVector(0, 0, 1)))
        pixels = camera.Update().astype(int)
    found = [pixels[row, column] for row in (13, 18) for column in (13, 18)]
    return [int(np.argmax(p)) if np.ptp(p) > 5 else 3 for p in found]


@pytest.mark.parametrize("kind", ["obj", "dae", "dae 1.5", "dae direct"])
def test_meshes_show_their_images(load, tmp_path, kind):
    path = tmp_path / f"square.{kind[:3]}"
    write_image(tmp_path / "four.png")
    if kind == "obj":
        write_obj(path)
    elif kind == "dae 1.5":
        write_dae(path, "<init_from><ref>four.png</ref></init_from>", SAMPLED_1_5)
    elif kind == "dae direct":
        write_dae(path, parameters="", texture="image")
    else:
        write_dae(path)
    assert quarters(loaded(load, visual(path.name))) == [0, 1, 2, 3]


def test_a_mirrored_mesh_shows_its_image_mirrored(load, tmp_path):
    write_image(tmp_path / "four.png")
    write_obj(tmp_path / "square.obj")
    assert quarters(loaded(load, visual("square.obj", scale="1 -1 1"))) == [1, 0, 3, 2]


@pytest.mark.parametrize(
    ("folder", "written"),
    [
        ("meshes", "map_Kd four.png"),
        ("materials/textures", "map_Kd four.png"),
        ("materials/textures", "map_Kd -s 1 1 1 -bm 0.5 -clamp off four.png"),
        ("materials/textures", "map_Kd C:\\Users\\me\\four.png"),
        ("elsewhere", "map_Kd ../elsewhere/four.png"),
        ("elsewhere", "map_Kd model://car/elsewhere/four.png"),
        ("meshes/my images", "map_Kd my images/four.png"),
        ("meshes/my images", "map_Kd my%20images/four.png"),
    ],
)
def test_images_are_found_where_models_have_them(load, tmp_path, folder, written, caplog):
    write_image(tmp_path / "car" / folder / "four.png")
    write_obj(tmp_path / "car" / "meshes" / "square.obj", written)
    made = loaded(load, visual("model://car/meshes/square.obj"))
    [geom] = made.body("m").geoms
    assert geom.appearance.texture_file.samefile(tmp_path / "car" / folder / "four.png")
    assert not caplog.records


@pytest.mark.parametrize(
    ("material", "kept"),
    [
        ("<script><name>Gazebo/Blue</name></script>", False),
        ("<diffuse>0 0 1 1</diffuse>", False),
        ("<lighting>1</lighting>", True),
    ],
)
def test_the_material_of_a_visual_replaces_the_image(load, tmp_path, material, kept, caplog):
    write_image(tmp_path / "four.png")
    write_obj(tmp_path / "square.obj")
    made = loaded(load, visual("square.obj", f"<material>{material}</material>"))
    [look] = [geom.appearance for geom in made.body("m").geoms]
    assert (look.texture_file is not None) == kept
    assert tuple(look.diffuse) == ((1, 1, 1, 1) if kept else (0, 0, 1, 1))
    (tmp_path / "four.png").unlink()
    loaded(load, visual("square.obj", f"<material>{material}</material>"))
    assert ("four.png" in caplog.text) == kept


@pytest.mark.parametrize("workflow", ["metal", "specular"])
def test_an_albedo_map_is_shown(load, tmp_path, workflow, caplog):
    write_image(tmp_path / "four.png")
    pbr = f"<pbr><{workflow}><albedo_map>four.png</albedo_map><roughness>0.3</roughness></{workflow}></pbr>"
    shape = "<geometry><box><size>1 1 1</size></box></geometry>"
    text = f"<visual name='v'>{shape}<material><diffuse>1 0.5 1 1</diffuse>{pbr}</material></visual>"
    [look] = [geom.appearance for geom in loaded(load, text).body("m").geoms]
    assert look.texture_file == tmp_path / "four.png"
    assert tuple(look.diffuse) == (1, 0.5, 1, 1)
    assert "reflections are shown in pages only" in caplog.text
    [look] = [geom.appearance for geom in loaded(load, text.replace("four", "lost")).body("m").geoms]
    assert look.texture_file is None
    assert "lost.png" in caplog.text


def test_a_surface_is_described_for_pages(load, tmp_path, caplog):
    write_image(tmp_path / "bumps.png")
    pbr = "<pbr><metal><normal_map>bumps.png</normal_map><roughness>7</roughness><metalness>0.1</metalness>"
    pbr += "<roughness_map>lost.png</roughness_map></metal></pbr>"
    shape = "<geometry><box><size>1 1 1</size></box></geometry>"
    made = loaded(load, f"<visual name='v'>{shape}<material>{pbr}</material></visual>")
    described = describe_body(made.body("m"), 0, {}, lambda arrays: {})["shapes"][0]["pbr"]
    assert described == {
        "metalness": 0.1,
        "roughness": 1.0,
        "normal_map": tmp_path / "bumps.png",
        "metalness_map": None,
        "roughness_map": None,
        "emissive_map": None,
    }
    assert "lost.png" in caplog.text


def test_a_missing_image_is_one_warning(load, tmp_path, caplog):
    write_obj(tmp_path / "meshes" / "square.obj", "Kd 0 1 0\nmap_Kd four.png", "f 1/1 2/2 3/3\ng b\nf 1/1 3/3 4/4")
    made = loaded(load, visual("meshes/square.obj"))
    [record] = caplog.records
    places = (tmp_path / "meshes" / "four.png", tmp_path / "materials" / "textures" / "four.png")
    for text in ("square.mtl", *map(str, places), ".world:"):
        assert text in record.getMessage()
    assert quarters(made) == [1, 1, 1, 1]


def test_a_damaged_image_is_a_warning(load, tmp_path, caplog):
    (tmp_path / "four.png").write_bytes(b"\x89PNG no image")
    write_obj(tmp_path / "square.obj", "Kd 0 1 0\nmap_Kd four.png")
    assert quarters(loaded(load, visual("square.obj"))) == [1, 1, 1, 1]
    assert "four.png cannot be read" in caplog.text


@pytest.mark.parametrize(
    ("face", "corners"),
    [
        ("f 1 2 3 4", CORNERS),
        ("f 1//1 2//1 3//1 4//1", CORNERS),
        ("f 1/9 2/2 3/3 4/4", CORNERS),
        ("f 1/x 2/2 3/3 4/4", CORNERS),
        ("f 1/-9 2/2 3/3 4/4", CORNERS),
        ("f 1/1 2/2 3/3 4/4", [("nan", 0)] * 4),
        ("f 1/1 2/2 3/3 4/4", [("x", 0)] * 4),
        ("f 1/1 2/2 3/3 4/4", [("1e300", 0)] * 4),
        ("f 1/1 2/2 3/3 4/4", []),
    ],
)
def test_damaged_texture_coordinates_leave_the_colour(load, tmp_path, face, corners, caplog):
    write_image(tmp_path / "four.png")
    write_obj(tmp_path / "square.obj", "Kd 0 1 0\nmap_Kd four.png", face, corners)
    made = loaded(load, visual("square.obj"))
    assert len(caplog.records) == 1
    assert "no usable texture coordinates for image four.png" in caplog.text
    assert made.body("m").geoms[0].appearance.texture_file is None


def test_corners_count_back_and_may_have_no_coordinates(tmp_path):
    write_obj(tmp_path / "square.obj", face="f -4/-4 -3/-3 3/3 4")
    [part] = read_mesh(tmp_path / "square.obj")
    assert part.texture.coordinates.tolist() == [[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 0]]]


@pytest.mark.parametrize("corners", [[("x", 0)] * 4, CORNERS[:3]])
def test_damaged_coordinates_of_collada_leave_the_mesh(tmp_path, corners):
    write_dae(tmp_path / "square.dae", corners=corners)
    [part] = read_mesh(tmp_path / "square.dae")
    assert len(part.triangles) == 2
    assert part.texture.coordinates is None


def test_collisions_are_the_same_with_and_without_images(load, tmp_path):
    found = []
    write_image(tmp_path / "four.png")
    for name, library in (("plain", ""), ("square", "map_Kd four.png")):
        write_obj(tmp_path / f"{name}.obj", library)
        geom = loaded(load, collision(f"<mesh><uri>{name}.obj</uri></mesh>")).body("m").geoms[0]
        found.append((geom.vertices.tobytes(), geom.triangles.tobytes(), geom.texture_coordinates))
    assert found[0] == found[1]


def test_the_page_shows_the_image(load, tmp_path):
    write_image(tmp_path / "four.png")
    write_obj(tmp_path / "square.obj")
    made = loaded(load, visual("square.obj"))
    source = LocalSource(made)
    [shape] = source.scene["entities"][0]["bodies"][0]["shapes"]
    arrays = source.data(shape["data"])
    assets = Assets(source)
    asset = assets.get(assets.of_scene(source.scene)[shape["texture"]["file"]])
    pixels = np.asarray(Image.open(io.BytesIO(asset.body)).convert("RGB"))
    assert pixels[4, 4].tolist() == pytest.approx(RED, abs=40)
    low = arrays["texture_coordinates"].reshape(-1, 2)[np.argmin(arrays["vertices"] @ (0, 1, 1))]
    assert tuple(low) == pytest.approx((0, 0))


def test_a_changed_material_library_is_read_again(tmp_path):
    write_obj(tmp_path / "square.obj")
    assert read_mesh(tmp_path / "square.obj")[0].color == (1, 1, 1, 1)
    library = tmp_path / "square.mtl"
    library.write_text("newmtl look\nKd 0 0 1\n")
    os.utime(library, ns=(0, 0))
    assert read_mesh(tmp_path / "square.obj")[0].color == (0, 0, 1, 1)


@pytest.mark.parametrize("names", ["one.mtl two.mtl", "one two.mtl"])
def test_one_line_names_several_libraries_or_one_with_spaces(tmp_path, names):
    write_obj(tmp_path / "square.obj")
    text = (tmp_path / "square.obj").read_text().replace("square.mtl", names)
    (tmp_path / "square.obj").write_text(text)
    (tmp_path / "one.mtl").write_text("newmtl other\nKd 1 0 0\n")
    (tmp_path / ("two.mtl" if names.startswith("one.mtl") else "one two.mtl")).write_text("newmtl look\nKd 0.5\n")
    assert read_mesh(tmp_path / "square.obj")[0].color == (0.5, 0.5, 0.5, 1)


@pytest.mark.parametrize("color", ["1 0", "1 nan 0", "1e400 0 0", "red", ""])
def test_a_damaged_colour_is_passed_over_with_library_and_line(tmp_path, color, caplog):
    write_obj(tmp_path / "square.obj")
    (tmp_path / "square.mtl").write_text(f"newmtl look\nKd {color}\n")
    assert read_mesh(tmp_path / "square.obj")[0].color is None
    assert re.search(r"material library .*square\.mtl:2: 'Kd.*' is not Kd RED GREEN BLUE", caplog.text)
