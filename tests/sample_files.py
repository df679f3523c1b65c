"""Valid files of each kind of asset, small, for tests that damage them."""

from __future__ import annotations

import base64
import io
import json
import struct
from pathlib import Path

import numpy as np
from PIL import Image

from libgz.base.files import installed_worlds

__all__ = ["SETTINGS", "TEXTURE_FORMATS", "chunk", "gltf", "model_3ds", "sample", "with_library", "with_texture"]

TEXTURE_FORMATS = ("PNG", "JPEG", "PPM", "BMP", "TGA", "GIF", "DDS", "TIFF", "JPEG2000", "WEBP", "PCX", "ICO", "SGI")


# Files that say how to run or show what others contain.
SETTINGS = {
    "player": (
        """driver
(
  name "gz_position"
  provides ["6665:position:0"]
  gz_id "robot1" # the robot
)
driver ( name "gz_stereo" gz_id "s" provides ["right::camera:0" "left_disparity::camera:1"] save 1 )
""",
        """define robot driver ( name "gz_position" gz_id "a" )
robot ( provides ["position:3"] gz_id "b" )
sonar:1 ( driver "gz_sonars" port 6670 gz_id "b" )
window ( size [700 740] scale 0.028 )
""",
        """driver ( name "gazebo" provides ["simulation:0"] plugin "libgazeboplugin" server_id "default" )
driver ( name "gazebo" provides ["localhost:6667:ptz:0"] gz_id "head" alwayson true )
driver ( name "vfh" provides ["position:1"] requires ["position:0" "laser:0"] cell_size 0.1 )
""",
    ),
    "parameters": (
        """/**:
  ros__parameters:
    use_sim_time: true
    gains: [1.0, 2, -3e4]
    names: ['a', b]
/robot/*:
  controller_manager:
    ros__parameters:
      update_rate: 100
      a.b: {c: 0x10, d: 1_000}
base: &base {p: 10.0}
arm:
  ros__parameters:
    joint: *base
    text: |
      lines
      of it
""",
    ),
    "study": (
        '''world = """<gz:w xmlns:gz='g' xmlns:model='m'><model:SimpleSolid>
<id>crate</id><xyz>0 0 1</xyz></model:SimpleSolid></gz:w>"""
duration = 1.0
seeds = 2
repeats = 2
solver = "quick"
[parameters]
"crate/mass" = [1.0, 8]
"crate/xyz[0]" = { uniform = [0.5, 0.8] }
"crate/surfaceFriction" = { normal = [1, 0.1] }
[measures]
distance = "crate/pos[0]"
highest = { of = "crate/linear_vel", reduce = "max" }
[limits]
time = 60
memory = 2000
''',
    ),
    "material": (
        """// a script
material Plain
{
  technique
  {
    pass
    {
      ambient 0.5 0.5 0.5 1
      diffuse 1 0 0
      specular 1 1 1 1 12.5
      emissive 0 0 0
      scene_blend alpha_blend
      lighting off
      texture_unit
      {
        texture none.png
        scale 0.5 0.5
        rotate 90
        scroll 0.1 0.2
        alpha_op_ex source1 src_manual src_current 0.5
      }
    }
  }
}
/* and */ material Own : Plain
{
}
""",
    ),
    "config": (
        """<?xml version="1.0"?>
<model>
  <name>Door</name>
  <version>1.0</version>
  <sdf version="1.4">model.sdf</sdf>
  <sdf version="1.6">model.sdf</sdf>
  <author><name>A</name><email>a@example.org</email></author>
  <description>A door &amp; its frame.</description>
</model>
""",
    ),
    "manifest": (
        """<?xml version="1.0"?>
<package format="3">
  <name>robot_pack</name>
  <version>0.0.1</version>
  <depend condition="$ROS_VERSION == 1">gazebo_ros</depend>
  <export>
    <gazebo_ros gazebo_model_path="${prefix}/models" plugin_path="${prefix}/lib"/>
  </export>
</package>
""",
    ),
}


def chunk(kind, *parts):
    data = b"".join(parts)
    return struct.pack("<HI", kind, 6 + len(data)) + data


def model_3ds(more: int = 0) -> bytes:
    """Two squares facing -x, one red, one without a material."""

    def square(name, y, *more):
        points = np.array([(0, y - 0.4, -0.4), (0, y - 0.4, 0.4), (0, y + 0.4, 0.4), (0, y + 0.4, -0.4)], "<f4")
        faces = np.array([(0, 1, 2, 0), (0, 2, 3, 0)], "<u2")
        vertices = chunk(0x4110, struct.pack("<H", 4), points.tobytes())
        triangles = chunk(0x4120, struct.pack("<H", 2), faces.tobytes(), *more)
        return chunk(0x4000, name + b"\0", chunk(0x4100, vertices, triangles))

    red = chunk(0xAFFF, chunk(0xA000, b"red\0"), chunk(0xA020, chunk(0x0011, bytes((255, 0, 0)))))
    group = chunk(0x4130, b"red\0", struct.pack("<HHH", 2, 0, 1))
    return chunk(
        0x4D4D,
        chunk(
            0x3D3D,
            red,
            square(b"left", 0.5, group),
            square(b"right", -0.5),
            *(square(b"more%d" % i, i) for i in range(more)),
        ),
    )


def _image(kind: str) -> bytes:
    rows, columns = np.mgrid[0:12, 0:17]
    pixels = np.stack([rows * 20, columns * 14, (rows * columns) % 256], axis=2).astype(np.uint8)
    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, kind)
    return stream.getvalue()


CORNERS = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], dtype="<f4")
TRIANGLES = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))


def _stl() -> bytes:
    rows = b"".join(struct.pack("<3f", 0, 0, 0) + CORNERS[list(t)].tobytes() + b"\0\0" for t in TRIANGLES)
    return b"sample".ljust(80) + struct.pack("<I", len(TRIANGLES)) + rows


def _stl_text() -> bytes:
    lines = ["solid sample"]
    for triangle in TRIANGLES:
        corners = ["vertex {:g} {:g} {:g}".format(*CORNERS[i]) for i in triangle]
        lines += ["facet normal 0 0 0", "outer loop", *corners, "endloop", "endfacet"]
    return "\n".join([*lines, "endsolid sample"]).encode()


def _obj() -> bytes:
    vertices = ["v {:g} {:g} {:g}".format(*corner) for corner in CORNERS]
    faces = ["f {} {} {}".format(*(i + 1 for i in triangle)) for triangle in TRIANGLES]
    lines = ["mtllib sample.mtl", "o sample", *vertices, "vn 0 0 1", "vt 0 0", "usemtl red", *faces]
    return "\n".join([*lines, "g more", "f 1//1 2/1/1 3 4", "f -1 -2 -3"]).encode()


def _mtl() -> bytes:
    return b"""# a library
newmtl red
Ns 96.0
Ka 0 0 0
Kd 1.0 0.5 0.25
d 1.0
illum 2
newmtl shown
Kd 0.8 0.8 0.8
map_Kd -s 1 1 1 -clamp off image.png
newmtl plain
Kd 0.5
"""


def with_library(library: Path) -> Path:
    """Write a mesh, beside a material library, whose faces name the library's materials, and their image."""
    image = library.parent / "image.png"
    if not image.exists():
        image.write_bytes(_image("PNG"))
    _write_dae(library, image)
    return _write_obj(library, library)


def with_texture(image: Path) -> Path:
    """Write two meshes that show an image beside it, the first of them with a material library."""
    library = image.with_suffix(".mtl")
    library.write_bytes(_mtl().replace(b"image.png", image.name.encode()))
    _write_dae(image, image)
    return _write_obj(image, library)


def _write_obj(beside: Path, library: Path) -> Path:
    rows = ["v 0 0 0", "v 1 0 0", "v 1 1 0", "v 0 1 0", "vt 0 0", "vt 1 0", "vt 1 1", "vt 0 1"]
    for material in ("red", "shown", "plain"):
        rows += [f"usemtl {material}", "f 1/1 2/2 3/3 4/4"]
    path = beside.with_suffix(".obj")
    path.write_text("\n".join([f"mtllib {library.name}", *rows]))
    return path


def _write_dae(beside: Path, image: Path) -> None:
    beside.with_suffix(".dae").write_bytes(_dae_image().replace(b"none.png", image.name.encode()))


def _dae() -> bytes:
    numbers = " ".join(f"{v:g}" for v in CORNERS.ravel())
    corners = " ".join(f"{i} 0" for triangle in TRIANGLES for i in triangle)
    return f"""<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
 <asset><unit name="meter" meter="0.5"/><up_axis>Z_UP</up_axis></asset>
 <library_effects><effect id="e"><profile_COMMON><technique sid="t"><phong>
  <diffuse><color>1 0 0 1</color></diffuse></phong></technique></profile_COMMON></effect></library_effects>
 <library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>
 <library_geometries><geometry id="g" name="g"><mesh>
  <source id="p"><float_array id="pa" count="12">{numbers}</float_array><technique_common>
   <accessor source="#pa" count="4" stride="3"/></technique_common></source>
  <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
  <triangles count="4" material="s"><input semantic="VERTEX" source="#v" offset="0"/>
   <input semantic="NORMAL" source="#p" offset="1"/><p>{corners}</p></triangles>
  <polylist count="1" material="s"><input semantic="VERTEX" source="#v" offset="0"/>
   <vcount>4</vcount><p>0 1 2 3</p></polylist>
  <polygons count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></polygons>
 </mesh></geometry></library_geometries>
 <library_nodes><node id="n"><translate>0 0 1</translate><instance_geometry url="#g"/></node></library_nodes>
 <library_visual_scenes><visual_scene id="scene"><node id="top" name="top">
  <matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix><rotate>0 0 1 90</rotate><scale>1 2 3</scale>
  <instance_geometry url="#g"><bind_material><technique_common><instance_material symbol="s" target="#m"/>
   </technique_common></bind_material></instance_geometry>
  <node><instance_node url="#n"/></node></node></visual_scene></library_visual_scenes>
 <scene><instance_visual_scene url="#scene"/></scene>
</COLLADA>""".encode()


def _dae_image() -> bytes:
    """The same with an image, and texture coordinates for the first triangles."""
    image = """<newparam sid="f"><surface type="2D"><init_from>i</init_from></surface></newparam>
  <newparam sid="d"><sampler2D><source>f</source></sampler2D></newparam><technique"""
    bound = (
        """target="#m"><bind_vertex_input semantic="u" input_semantic="TEXCOORD" input_set="0"/></instance_material>"""
    )
    changes = {
        "<library_effects>": '<library_images><image id="i"><init_from>none.png</init_from></image></library_images>'
        "<library_effects>",
        "<technique": image,
        "<color>1 0 0 1</color>": '<texture texture="d" texcoord="u"/>',
        'semantic="NORMAL" source="#p"': 'semantic="TEXCOORD" set="0" source="#p"',
        'target="#m"/>': bound,
    }
    text = _dae().decode()
    for old, new in changes.items():
        text = text.replace(old, new, 1)
    return text.encode()


def _bvh() -> bytes:
    return b"""HIERARCHY
ROOT shoulder
{ OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT elbow
  { OFFSET 0 0 50
    CHANNELS 3 Zrotation Xrotation Yrotation
    End Site { OFFSET 0 0 50 } } }
MOTION
Frames: 3
Frame Time: 0.5
0 40 0 0 0 0 0 0 0
0 40 50 0 0 0 0 0 45
0 40 100 0 0 0 0 0 90
"""


def _gzb() -> bytes:
    numbers = [500, 0, 0, 0, 0, 0, 0, 4, 4, 6]
    for x, y in ((0, 0), (1, 0), (0, 1), (1, 1)):
        numbers += [1000 * x, 1000 * y, 700, 700, 700, 1000, 0, 0, 1000, 1000 * x, 1000 * y, 100 * x * y]
    numbers += [0, 1, 2, 3, 0, 1, 2, 1, 3, 2]
    return np.array(numbers, dtype=">i4").tobytes()


def _road() -> bytes:
    lines = (installed_worlds() / "road.txt").read_text().splitlines()
    return "\n".join([line for line in lines if line.startswith("waypoint")][:3] + lines[:20]).encode()


def sample(kind: str, number: int = 0) -> bytes:
    """A valid file of a kind of `readers.ASSETS`.

    STL alternates between its two forms, COLLADA between a colour and an image; textures have one format after another.
    """
    if kind == "texture":
        return _image(TEXTURE_FORMATS[number % len(TEXTURE_FORMATS)])
    makers = {
        "3ds": model_3ds,
        "gzb": _gzb,
        "road": _road,
        "stl": (_stl, _stl_text)[number % 2],
        "obj": _obj,
        "dae": (_dae, _dae_image)[number % 2],
        "bvh": _bvh,
        "mtl": _mtl,
    }
    return makers[kind]() if kind in makers else _image(kind.upper())


def worlds(folder: Path, root: bytes) -> list[Path]:
    """The worlds of a folder and of its folders whose text contains a root's tag."""
    return sorted(path for path in folder.rglob("*.world") if root in path.read_bytes())


def gltf(more=(), **changes):
    """A triangle, one node; changes of its parts, and its buffers."""
    numbers = struct.pack("<9f3I", 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 2)
    address = "data:application/octet-stream;base64," + base64.b64encode(numbers).decode()
    contents = {
        "asset": {"version": "2.0"},
        "buffers": [{"uri": address, "byteLength": 48}, *more],
        "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 12}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5125, "count": 3, "type": "SCALAR"},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
    }
    return json.dumps({**contents, **changes})
