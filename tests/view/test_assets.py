"""Assets: what a page loads beside the scene."""

import io
import json
import struct

import numpy as np
import pytest
from PIL import Image
from view_sockets import showing

import libgz
from libgz.transport.observer import arrays_of
from libgz.view.assets import Assets
from libgz.view.local import LocalSource

LEGACY = "<gz:world xmlns:gz='g' xmlns:model='m'>{}</gz:world>"
SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n"


def asset_of(world, file):
    assets = Assets(LocalSource(world))
    address = assets.of_scene(assets._source.scene).get(str(file))
    return address, assets.get(address) if address else None


def triangles_of(glb):
    """(content, positions, indices) of the first primitive of a GLB."""
    magic, version, size = struct.unpack("<4s2I", glb[:12])
    assert (magic, version, size) == (b"glTF", 2, len(glb))
    [length] = struct.unpack("<I", glb[12:16])
    content, binary = json.loads(glb[20 : 20 + length]), glb[28 + length :]
    primitive = content["meshes"][0]["primitives"][0]
    found = []
    for accessor, kind, width in ((primitive["attributes"]["POSITION"], "<f4", 3), (primitive["indices"], "<u4", 1)):
        accessor = content["accessors"][accessor]
        view = content["bufferViews"][accessor["bufferView"]]
        found.append(np.frombuffer(binary, kind, accessor["count"] * width, view["byteOffset"]).reshape(-1, width))
    return content, *found


def test_arrays_of_the_scene_are_as_they_were(tmp_path):
    (tmp_path / "a.obj").write_text(SQUARE)
    text = f"<mesh><uri>file://{tmp_path}/a.obj</uri></mesh>"
    shape = f"<collision name='c'><geometry>{text}</geometry></collision>"
    with libgz.World.from_string(
        f"<sdf version='1.6'><world name='w'><model name='m'><static>1</static><link name='l'>{shape}</link></model>"
        "</world></sdf>"
    ) as world:
        source = LocalSource(world)
        [shape] = source.scene["entities"][0]["bodies"][0]["shapes"]
        address, asset = asset_of(world, shape["data"]["file"])
        kept = source.data(shape["data"])
        found = arrays_of(asset.body, shape["data"])
        assert found.keys() == kept.keys() >= {"vertices", "triangles"}
        assert all(np.array_equal(found[name], kept[name]) for name in kept)
        assert asset_of(world, shape["data"]["file"])[0] == address  # of the content


def test_a_texture_is_an_image_that_fits(tmp_path):
    Image.new("RGB", (3000, 100), (0, 200, 0)).save(tmp_path / "wide.png")
    text = f"<model:GroundPlane><textureFile>{tmp_path}/wide.png</textureFile></model:GroundPlane>"
    with libgz.World.from_string(LEGACY.format(text)) as world:
        _, asset = asset_of(world, tmp_path / "wide.png")
        image = Image.open(io.BytesIO(asset.body))
        assert max(image.size) == 1024
        assert np.asarray(image.convert("RGB")).reshape(-1, 3).mean(axis=0) == pytest.approx((0, 200, 0), abs=3)


def test_a_skin_is_a_mesh(tmp_path, skin_file):
    text = f"<model:SimpleSolid><id>box</id><skinFile>{skin_file}</skinFile></model:SimpleSolid>"
    with libgz.World.from_string(LEGACY.format(text)) as world:
        _, asset = asset_of(world, skin_file)
        content, positions, indices = triangles_of(asset.body)
        assert asset.kind == "model/gltf-binary"
        assert len(positions) == len(indices) == 3
        assert positions.max(axis=0) == pytest.approx((1, 1, 0))
        assert content["materials"][0]["doubleSided"] is True


@pytest.fixture
def skin_file(tmp_path):
    """A triangle in a 3DS file."""

    def chunk(number, *parts):
        body = b"".join(parts)
        return struct.pack("<HI", number, 6 + len(body)) + body

    vertices = chunk(0x4110, struct.pack("<H9f", 3, 0, 0, 0, 1, 0, 0, 1, 1, 0))
    faces = chunk(0x4120, struct.pack("<H4H", 1, 0, 1, 2, 0))
    path = tmp_path / "skin.3ds"
    path.write_bytes(chunk(0x4D4D, chunk(0x3D3D, chunk(0x4000, b"a\0", chunk(0x4100, vertices, faces)))))
    return path


@pytest.mark.parametrize("content", [b"", b"no mesh", bytes(range(256))])
def test_a_file_that_cannot_be_read_is_missing(tmp_path, content, caplog):
    (tmp_path / "skin.3ds").write_bytes(content)
    text = f"<model:SimpleSolid><id>box</id><skinFile>{tmp_path}/skin.3ds</skinFile></model:SimpleSolid>"
    with libgz.World.from_string(LEGACY.format(text)) as world:
        address, asset = asset_of(world, tmp_path / "skin.3ds")
        assert asset is None
        assert not address or "not shown" in caplog.text


def test_a_file_that_cannot_be_read_is_reported_once_however_often_pages_ask_for_it(tmp_path, caplog):
    file = tmp_path / "a.png"
    file.write_bytes(b"no image")
    text = f"<model:GroundPlane><textureFile>{file}</textureFile></model:GroundPlane>"
    with libgz.World.from_string(LEGACY.format(text)) as world:
        assets = Assets(source := LocalSource(world))
        address = assets.of_scene(source.scene)[str(file)]
        assert [assets.get(address) for _ in range(5)] == [None] * 5
    assert caplog.text.count("not shown") == 1


def test_a_file_that_is_missing_hides_nothing_else(caplog):
    text = """<model:Terrain><id>hills</id><terrainFile>none.gzb</terrainFile></model:Terrain>
    <model:Pioneer2AT><id>robot1</id></model:Pioneer2AT>"""
    with showing(LEGACY.format(text)) as (world, viewer):
        viewer.do(lambda: None)
        assert LocalSource(world).scene["entities"][1]["id"] == "robot1"
        assert Assets(LocalSource(world)).of_scene(LocalSource(world).scene) is not None
        assert viewer.failures == 0


def test_a_changed_texture_has_another_address(tmp_path):
    file = tmp_path / "a.png"
    text = f"<model:GroundPlane><textureFile>{file}</textureFile></model:GroundPlane>"
    Image.new("RGB", (8, 8), (0, 200, 0)).save(file)
    with libgz.World.from_string(LEGACY.format(text)) as world:
        assets = Assets(source := LocalSource(world))
        before = assets.of_scene(source.scene)[str(file)]
        Image.new("RGB", (16, 8), (200, 0, 0)).save(file)
        after = assets.of_scene(source.scene)[str(file)]
        assert before != after
        assert assets.get(before) is None  # what no scene names is not kept
        assert Image.open(io.BytesIO(assets.get(after).body)).size == (16, 8)
