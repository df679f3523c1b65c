"""Mesh files: what formats allow and programs write is read; what a scene instantiates is bounded."""

import json
import os
import struct

import numpy as np
import pytest
from sample_files import gltf, sample

from libgz.base.errors import GazeboError
from libgz.physics import faces, mesh_files
from libgz.physics.mesh_files import read_mesh
from libgz.rendering.skin import read_skin

NODE = '<node id="n">'
FAN = "".join(f'<node id="n{i}">{f"""<instance_node url="#n{i + 1}"/>""" * 10}</node>' for i in range(8))


@pytest.fixture
def read(tmp_path):
    def reader(old, new):
        path = tmp_path / "scene.dae"
        path.write_text(sample("dae", 0).decode().replace(old, new))
        return read_mesh(path)

    return reader


def test_a_node_may_be_instantiated_twice(read):
    once, twice = read(NODE, NODE), read('<instance_node url="#n"/>', '<instance_node url="#n"/>' * 2)
    assert sum(len(part.triangles) for part in twice) > sum(len(part.triangles) for part in once)
    assert np.isfinite(np.concatenate([part.vertices for part in twice])).all()


def test_a_node_that_contains_itself_is_an_error(read):
    with pytest.raises(GazeboError, match=r"scene.dae cannot be read: .*node 'n' contains itself"):
        read(NODE, f'{NODE}<node><instance_node url="#n"/></node>')


def test_a_scene_that_grows_by_powers_of_ten_is_an_error(read, monkeypatch):
    monkeypatch.setattr(mesh_files, "MOST_NODES", 1000)
    with pytest.raises(GazeboError, match="its scene has more than 1000 nodes and geometries"):
        read(NODE, f'{FAN}<node id="n8"/><node id="n"><instance_node url="#n0"/>')


def test_what_references_lead_to_is_bounded(read, monkeypatch):
    read(NODE, NODE)
    monkeypatch.setattr(mesh_files, "MOST_READ", 100_000)
    read(NODE, NODE)
    with pytest.raises(GazeboError, match="its parts refer to each other so often that reading it takes too long"):
        read('<instance_node url="#n"/>', '<instance_node url="#n"/>' * 300)


# What programs write -------------------------------------------------------------------------------------------------

CORNERS = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 0), (0, 1, 0), (0, 0, 1)], dtype="<f4").reshape(2, 9)
FACETS = "".join("facet normal 0 0 0\nouter loop\n" + "vertex 0 0 0\nvertex 1 0 0\nvertex {} 1 0\n" for _ in "ab")
DOCUMENT = """<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset>{asset}</asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa">{points}</float_array><technique_common><accessor source="#pa" stride="3"/>
</technique_common></source>
<source id="t"><float_array id="ta">0 0 1 0 1 1 0 1</float_array><technique_common><accessor source="#ta" stride="2"/>
</technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>{faces}</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="one"><node><translate>5 0 0</translate><instance_geometry url="#g"/></node>
</visual_scene><visual_scene id="two"><node><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
{scene}</COLLADA>"""
VERTEX = '<input semantic="VERTEX" source="#v" offset="0"/>'
L_SHAPE = "0 0 0 2 0 0 2 1 0 1 1 0 1 2 0 0 2 0"
SQUARE = "0 0 0 1 0 0 1 1 0 0 1 0"
SECOND = '<scene><instance_visual_scene url="#two"/></scene>'


def binary_stl(more=b"", count=2, head=b"solid made by a program"):
    rows = b"".join(b"\0" * 12 + row.tobytes() + b"\0\0" for row in CORNERS)
    return head.ljust(80, b"\0") + struct.pack("<I", count) + rows + more


def area(parts):
    """Of all triangles, by their normals; at least twice as large where triangles overlap or lie outside."""
    return sum(
        0.5 * np.linalg.norm(np.cross(p[t[:, 1]] - p[t[:, 0]], p[t[:, 2]] - p[t[:, 0]]), axis=1).sum()
        for p, t in ((part.vertices, part.triangles) for part in parts)
    )


@pytest.fixture
def file(tmp_path):
    def write(name, content):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


@pytest.mark.parametrize("more", [b"", b"\0" * 10, b"comment\n", b"\0" * 50], ids=len)
def test_what_follows_the_triangles_of_a_binary_stl_is_passed_over(file, more):
    (part,) = read_mesh(file("a.stl", binary_stl(more)))
    assert part.triangles.shape == (2, 3)
    assert np.ptp(part.vertices, axis=0).tolist() == [1, 1, 1]


def test_a_binary_stl_with_too_few_triangles_is_damaged(file):
    with pytest.raises(GazeboError, match="it has 2 of 5 triangles"):
        read_mesh(file("a.stl", binary_stl(count=5)))


@pytest.mark.parametrize("end", ["endsolid a\n", "endsolid", "", "endfacet", "solid b\n"])
@pytest.mark.parametrize("start", ["solid a\n", "  solid\n", "SOLID a\n".lower()])
def test_an_stl_of_text_needs_no_end(file, start, end):
    (part,) = read_mesh(file("a.stl", start + FACETS.format(0, 1) + end))
    assert len(part.triangles) == 2


def test_solids_of_an_stl_are_parts(file):
    parts = read_mesh(file("a.stl", f"solid a\n{FACETS.format(0, 1)}endsolid a\nsolid b\n{FACETS.format(0, 1)}"))
    assert [(part.name, len(part.triangles)) for part in parts] == [("a", 2), ("b", 2)]


@pytest.mark.parametrize("order", ["1 2 3 4 5 6", "6 5 4 3 2 1", "4 5 6 1 2 3", "-6 -5 -4 -3 -2 -1"])
def test_concave_polygons_of_obj_files_are_cut(file, order):
    rows = "\n".join("v " + " ".join(L_SHAPE.split()[k : k + 3]) for k in range(0, 18, 3))
    assert area(read_mesh(file("a.obj", f"{rows}\nf {order}\n"))) == pytest.approx(3.0)


@pytest.mark.parametrize(
    "faces",
    [
        f"<polylist>{VERTEX}<vcount>6</vcount><p>0 1 2 3 4 5</p></polylist>",
        f"<polygons>{VERTEX}<p>5 4 3 2 1 0</p></polygons>",
        f"<polygons>{VERTEX}<ph><p>2 3 4 5 0 1</p></ph></polygons>",
        f"<triangles>{VERTEX}<p>0 1 2 0 2 3 0 3 5 3 4 5</p></triangles>",
        f"<trifans>{VERTEX}<p>3 4 5 0 1 2</p></trifans>",
        f"<tristrips>{VERTEX}<p>4 5 3 0</p><p>3 0 2 1</p></tristrips>",
    ],
)
def test_all_kinds_of_faces_of_collada_are_read(file, faces):
    text = DOCUMENT.format(asset="", points=L_SHAPE, faces=faces, scene="")
    assert area(read_mesh(file("a.dae", text))) == pytest.approx(3.0)


def test_holes_in_polygons_of_collada_are_open(file):
    points = "0 0 0 4 0 0 4 4 0 0 4 0 1 1 0 1 3 0 3 3 0 3 1 0"
    faces = f"<polygons>{VERTEX}<ph><p>0 1 2 3</p><h>4 5 6 7</h></ph></polygons>"
    text = DOCUMENT.format(asset="", points=points, faces=faces, scene="")
    assert area(read_mesh(file("a.dae", text))) == pytest.approx(12.0)


@pytest.mark.parametrize(("scene", "place"), [(SECOND, 0), ("", 5), (SECOND.replace("two", "none"), 5)])
def test_the_scene_that_a_document_names_is_read(file, scene, place):
    faces = f"<triangles>{VERTEX}<p>0 1 2</p></triangles>"
    (part,) = read_mesh(file("a.dae", DOCUMENT.format(asset="", points=SQUARE, faces=faces, scene=scene)))
    assert part.vertices[:, 0].min() == place


@pytest.mark.parametrize("axis", ["Y_UP", "X_UP", "Z_UP"])
def test_another_axis_is_up_only_in_the_warning(file, axis, caplog):
    faces = f"<triangles>{VERTEX}<p>0 1 2</p></triangles>"
    text = DOCUMENT.format(asset=f"<up_axis>{axis}</up_axis>", points=SQUARE, faces=faces, scene=SECOND)
    (part,) = read_mesh(file("a.dae", text))
    assert np.ptp(part.vertices, axis=0).tolist() == [1, 1, 0]
    assert (f"<up_axis>{axis}</up_axis>; its coordinates are taken as they are" in caplog.text) == (axis != "Z_UP")


def test_texture_coordinates_without_an_image_are_kept(file):
    own = '<input semantic="TEXCOORD" source="#t" offset="1"/>'
    faces = f"<polylist>{VERTEX}{own}<vcount>4</vcount><p>0 0 1 1 2 2 3 3</p></polylist>"
    (part,) = read_mesh(file("a.dae", DOCUMENT.format(asset="", points=SQUARE, faces=faces, scene=SECOND)))
    expected = [[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]]]
    assert part.texture.image is None
    assert part.texture.coordinates.tolist() == expected
    rows = "".join(f"v {x} {y} 0\nvt {x} {y}\n" for x, y in ((0, 0), (1, 0), (1, 1), (0, 1)))
    (part,) = read_mesh(file("a.obj", rows + "f 1/1 2/2 3/3 4/4\n"))
    assert part.texture.coordinates.tolist() == expected
    assert read_mesh(file("b.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"))[0].texture is None


@pytest.mark.parametrize(
    ("lines", "opacity"),
    [("d 0.25", 0.25), ("Tr 0.25", 0.75), ("d 0.25\nTr 0.25", 0.25), ("Tr 1\nd 1", 1.0), ("Tr 1.0\nd 0.5", 0.5)],
)
def test_d_comes_before_tr(file, lines, opacity):
    file("a.mtl", f"newmtl m\nKd 1 0 0\n{lines}\n")
    (part,) = read_mesh(file("a.obj", "mtllib a.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"))
    assert part.color == (1.0, 0.0, 0.0, opacity)


def test_a_material_library_is_read_once_however_often_it_is_named(file, monkeypatch):
    read_paths, read_mtl = [], mesh_files._read_mtl
    monkeypatch.setattr(mesh_files, "_read_mtl", lambda path: read_paths.append(path) or read_mtl(path))
    file("a.mtl", "newmtl m\nKd 1 0 0\n")
    read_mesh(file("a.obj", "mtllib a.mtl\n" * 9 + "usemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"))
    assert len(read_paths) == 1


def test_a_material_library_of_several_names_is_read_once(file, monkeypatch):
    read_paths, read_mtl = [], mesh_files._read_mtl
    monkeypatch.setattr(mesh_files, "_read_mtl", lambda path: read_paths.append(path) or read_mtl(path))
    folder = file("a.mtl", "newmtl m\nKd 1 0 0\n").parent.name
    names = "".join(f"mtllib {f'../{folder}/' * i}a.mtl\n" for i in range(9))
    read_mesh(file("a.obj", f"{names}usemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"))
    assert len(read_paths) == 1


def test_tables_of_an_obj_are_looked_at_once_for_all_groups(file, monkeypatch):
    looked, units = [], mesh_files.units
    monkeypatch.setattr(mesh_files, "units", lambda table: looked.append(len(table)) or units(table))
    groups = "".join(f"g g{i}\nf 1/1/1 2/1/1 3/1/1\n" for i in range(20))
    parts = read_mesh(file("a.obj", f"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 2\n{groups}"))
    assert len(parts) == 20
    assert all(part.normals[0].tolist() == [[0, 0, 1]] * 3 for part in parts)
    assert looked == [1]


def test_words_of_an_obj_are_separated_by_spaces_and_tabs(file):
    (part,) = read_mesh(file("tabs.obj", "o\tthing\n v\t0 0\t0\nv  1 0 0\n\tv 0 1 0\nf\t1\t2 3\n"))
    assert part.name == "thing"
    assert part.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    assert part.triangles.tolist() == [[0, 1, 2]]


def test_damaged_numbers_of_an_obj_are_zero_and_lines_may_be_continued(file):
    (part,) = read_mesh(file("a.obj", "v 0 0\nv 1 \\\n0 0\nv 0 one 1\nf 1 2 3\n"))
    assert part.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 0, 1]]


# Meshes that are kept ------------------------------------------------------------------------------------------------


def test_meshes_are_read_once_as_long_as_they_fit(file, monkeypatch):
    read = []
    reader = mesh_files._read
    monkeypatch.setattr(mesh_files, "_read", lambda path, when: read.append(path.stem) or reader(path, when))
    monkeypatch.setattr(mesh_files, "_kept", mesh_files._Kept())
    paths = [file(f"{k}.stl", binary_stl()) for k in range(100)]
    for path in (*paths, *paths):
        read_mesh(path)
    assert len(read) == 100
    size = mesh_files._kept.get(paths[0].resolve()).size
    monkeypatch.setattr(mesh_files, "MOST_KEPT", 10 * size)
    read_mesh(file("new.stl", binary_stl()))
    read.clear()
    for path in (paths[0], *paths[-8:]):  # the ones that were used last
        read_mesh(path)
    assert read == []
    read_mesh(paths[50])
    assert read == ["50"]


# What a hostile file may cost ----------------------------------------------------------------------------------------


def test_numbers_of_an_instanced_geometry_are_read_once(read, monkeypatch):
    texts, numbers = [], mesh_files.read_numbers
    monkeypatch.setattr(mesh_files, "read_numbers", lambda text, *kind: texts.append(text) or numbers(text, *kind))
    read(NODE, NODE)
    once = [text for text in texts if len(text) > 40]
    texts.clear()
    read('<instance_node url="#n"/>', '<instance_node url="#n"/>' * 20)
    assert [text for text in texts if len(text) > 40] == once != []


def test_an_obj_has_no_more_triangles_than_its_bytes_may_name(file, monkeypatch):
    monkeypatch.setattr(mesh_files, "MOST_SMALL", 10)
    path = file("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf" + " 1" * 1000)
    kept = []
    monkeypatch.setattr(mesh_files._Faces, "add", lambda *_: kept.append(0))
    with pytest.raises(GazeboError, match=r"a\.obj has more than \d+ triangles"):
        read_mesh(path)
    assert kept == []


@pytest.mark.parametrize("kind", ["obj", "dae"])
def test_all_groups_of_a_mesh_share_what_cutting_may_cost(file, monkeypatch, kind):
    monkeypatch.setattr(faces, "MOST_CUT", 2 * 36)
    cut, ears = [], faces._ears
    monkeypatch.setattr(faces, "_ears", lambda *given: cut.append(0) or ears(*given))
    corners = np.array(L_SHAPE.split()).reshape(-1, 3)
    group = f'<polygons count="1">{VERTEX}<p>0 1 2 3 4 5</p></polygons>'
    vertices = "".join(f"v {' '.join(row)}\n" for row in corners)
    contents = {
        "obj": vertices + "".join(f"g {k}\nf 1 2 3 4 5 6\n" for k in range(5)),
        "dae": DOCUMENT.format(asset="", points=L_SHAPE, faces=group * 5, scene=SECOND),
    }
    assert len(read_mesh(file(f"a.{kind}", contents[kind]))) == 5
    assert len(cut) == 2


@pytest.mark.parametrize("name", ["a.zip", "a.tar.gz", "a.bz2", "a.3mf", "a.zae"])
def test_archives_are_no_meshes(file, name):
    pytest.importorskip("trimesh")
    with pytest.raises(GazeboError, match="it is an archive"):
        read_mesh(file(name, b""))


def test_other_formats_are_read_from_what_was_opened(file, monkeypatch):
    trimesh = pytest.importorskip("trimesh")
    given, load = [], trimesh.load
    monkeypatch.setattr(trimesh, "load", lambda source, **more: given.append(source) or load(source, **more))
    (part,) = read_mesh(file("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"))
    assert len(part.triangles) == 1
    assert hasattr(given[0], "read")


def test_the_image_of_a_ply_is_not_looked_at(tmp_path, file, monkeypatch, caplog):
    pytest.importorskip("trimesh")
    image_module = pytest.importorskip("PIL.Image")
    image_module.new("RGB", (2, 2)).save(tmp_path / "a.png")
    monkeypatch.setattr(image_module, "open", lambda *_, **__: pytest.fail("an image is opened"))
    head = "ply\nformat ascii 1.0\ncomment TextureFile a.png\nelement vertex 3\n"
    head += "".join(f"property float {axis}\n" for axis in "xyz")
    head += "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    assert len(read_mesh(file("a.ply", head + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"))) == 1
    assert not caplog.records


def test_a_pipe_that_a_gltf_names_is_not_waited_for(tmp_path, file):
    pytest.importorskip("trimesh")
    os.mkfifo(tmp_path / "numbers")
    contents = {
        "asset": {"version": "2.0"},
        "buffers": [{"uri": "numbers", "byteLength": 36}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
    }
    writer = os.open(tmp_path / "numbers", os.O_RDWR)  # so that no reader waits in the test
    try:
        os.set_blocking(writer, False)
        os.write(writer, b"secret")
        with pytest.raises(GazeboError, match="it is a pipe, not a file"):
            read_mesh(file("a.gltf", json.dumps(contents)))
        assert os.read(writer, 10) == b"secret"
    finally:
        os.close(writer)


@pytest.mark.parametrize("read", [read_mesh, read_skin])
class TestGltf:
    """The bounds of meshes hold for skins, too, and before the instances of a scene are copied."""

    @pytest.fixture(autouse=True)
    def needed(self):
        pytest.importorskip("trimesh")

    def test_a_triangle_is_read(self, file, read):
        assert len(read(file("a.gltf", gltf()))) == 1

    def test_instances_count_before_they_are_copied(self, file, read, monkeypatch):
        path = file("a.gltf", gltf(nodes=[{"mesh": 0}] * 30, scenes=[{"nodes": list(range(30))}]))
        assert len(read(path)) == 30
        trimesh = pytest.importorskip("trimesh")
        monkeypatch.setattr(trimesh.Scene, "dump", lambda *_: pytest.fail("they are copied"))
        for bound in ("MOST_TRIANGLES", "MOST_NODES"):
            other = file("b.gltf", path.read_bytes())
            with monkeypatch.context() as less:
                less.setattr(mesh_files, bound, 20)
                with pytest.raises(GazeboError, match="it has more than 20 "):
                    read(other)

    def test_what_is_declared_counts(self, file, read):
        zeros = {"componentType": 5126, "count": 2_000_000_000, "type": "VEC3"}
        other = {"componentType": 5126, "count": -2_000_000_000, "type": "VEC3"}
        text = gltf(accessors=[zeros, other])
        whole = text.encode()
        head = b"glTF" + struct.pack("<4I", 2, 20 + len(whole), len(whole), 0x4E4F534A)
        for path in (file("a.gltf", text), file("a.glb", head + whole)):
            with pytest.raises(GazeboError, match="it declares 2000000000 vertices and indices"):
                read(path)

    def test_its_images_are_not_looked_at(self, file, tmp_path, read, monkeypatch):
        """Each material would hold one whole, of any size and in any format of pillow."""
        image_module = pytest.importorskip("PIL.Image")
        opened = []
        monkeypatch.setattr(image_module, "open", lambda *_, **__: opened.append(1))
        image_module.new("RGB", (2, 2)).save(tmp_path / "a.png")
        materials = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
        primitives = [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]
        more = {"materials": materials, "textures": [{"source": 0}], "meshes": [{"primitives": primitives}]}
        text = gltf(images=[{"uri": "a.png"}], **more)
        assert len(read(file("a.gltf", text))) == 1
        whole = text.encode() + b" " * (-len(text) % 4)
        chunks = struct.pack("<2I", len(whole), 0x4E4F534A) + whole + struct.pack("<2I", 4, 0x004E4942) + bytes(4)
        assert len(read(file("a.glb", b"glTF" + struct.pack("<2I", 2, 12 + len(chunks)) + chunks))) == 1
        assert not opened

    @pytest.mark.parametrize("children", [[[1], [0]], [[0], []], [[i + 1] for i in range(1001)]])
    def test_its_nodes_are_not_nested_too_deeply(self, file, read, children):
        nodes = [{"children": some} for some in children] + [{"mesh": 0}]
        with pytest.raises(GazeboError, match="nested more than 1000 deep, or contain themselves"):
            read(file("a.gltf", gltf(nodes=nodes)))

    @pytest.mark.parametrize("child", [-1, 2])
    def test_its_nodes_have_children_that_are_there(self, file, read, child):
        with pytest.raises(GazeboError, match="a node has a child that is not there"):
            read(file("a.gltf", gltf(nodes=[{"children": [child]}, {"mesh": 0}])))

    def test_matrices_count_for_their_numbers(self, file, read):
        wide = {"componentType": 5126, "count": 100_000_000, "type": "MAT4"}
        with pytest.raises(GazeboError, match="it declares 400000003 vertices and indices"):
            read(file("a.gltf", gltf(accessors=[json.loads(gltf())["accessors"][0], wide])))

    def test_its_files_count_together(self, file, tmp_path, read, monkeypatch):
        (tmp_path / "a.bin").write_bytes(bytes(3 << 20))
        monkeypatch.setattr(mesh_files, "LARGEST_FILE", 5 << 20)
        more = {"uri": "a.bin", "byteLength": 3 << 20}
        assert len(read(file("a.gltf", gltf([more])))) == 1
        with pytest.raises(GazeboError, match="it is larger than 2 MiB"):
            read(file("b.gltf", gltf([more, more])))

    def test_a_triangle_names_no_vertex_that_does_not_exist(self, file, read):
        wrong = {"bufferView": 0, "byteOffset": 12, "componentType": 5125, "count": 3, "type": "SCALAR"}
        with pytest.raises(GazeboError, match="a triangle names a vertex that does not exist"):
            read(file("a.gltf", gltf(accessors=[json.loads(gltf())["accessors"][0], wrong])))


def test_nodes_of_gltf_are_looked_at_some_times_each():
    """However deep they are."""
    looked = []

    class Row(list):
        def __iter__(self):
            looked.append(1)
            return super().__iter__()

    mesh_files._check_depth([Row([number]) for number in range(1, 900)] + [Row()])
    assert len(looked) < 5 * 900
