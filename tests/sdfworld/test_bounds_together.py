"""What many objects of a world may have together: files that fill the memory by many that are allowed alone."""

import math

import numpy as np
import pytest
from PIL import Image

from libgz import GazeboError, GzPose, GzQuaternFromEuler, GzVector, World
from libgz.physics import engine
from libgz.rendering import library
from libgz.rendering.camera import Camera
from libgz.rendering.scene import Scene
from libgz.sdf import reader
from libgz.sdfworld import population

WORLD = "<sdf version='1.6'><world name='w'>{}</world></sdf>"
MODEL = "<model name='m{}'><static>1</static><link name='l'>{}</link></model>"
LASER = """<sensor name='s' type='ray'><ray><scan><horizontal><samples>60</samples><min_angle>0</min_angle>
  <max_angle>1</max_angle></horizontal></scan><range><min>0.1</min><max>3</max></range></ray></sensor>"""


def written(path, text):
    path.write_text(text)
    return path


def test_includes_of_includes_end(tmp_path, monkeypatch):
    monkeypatch.setattr(reader, "MOST_INCLUDED", 1 << 20)
    monkeypatch.setenv("GAZEBO_MODEL_PATH", str(tmp_path))
    for depth in range(8):
        include = f"<include><uri>model://b{depth + 1}</uri></include>"
        folder = tmp_path / f"b{depth}"
        folder.mkdir()
        (folder / "model.config").write_text("<model><name>b</name><sdf version='1.6'>model.sdf</sdf></model>")
        (folder / "model.sdf").write_text(f"<sdf version='1.6'><model name='b'>{10 * include}</model></sdf>")
    path = written(tmp_path / "w.world", WORLD.format("<include><uri>model://b0</uri></include>"))
    with pytest.raises(GazeboError, match=r"includes have more than 1 MiB together"):
        World.from_file(path)


def test_lasers_share_their_rays(tmp_path, monkeypatch):
    monkeypatch.setattr(engine, "MOST_RAYS", 200)
    lasers = "".join(MODEL.format(i, LASER) for i in range(4))
    with pytest.raises(GazeboError, match="more rays of lasers and sonars the world would have 240; at most 200"):
        World.from_file(written(tmp_path / "w.world", WORLD.format(lasers)))


def test_terrains_and_meshes_share_their_triangles(tmp_path, monkeypatch):
    Image.fromarray(np.zeros((9, 9), dtype=np.uint8)).save(tmp_path / "h.png")
    ground = (
        "<collision name='c'><geometry><heightmap><uri>h.png</uri><size>9 9 1</size></heightmap></geometry></collision>"
    )
    turned = ground.replace("<geometry>", "<pose>0 0 0 0 0 .5</pose><geometry>")  # a mesh
    with World.from_file(written(tmp_path / "w.world", WORLD.format(MODEL.format(0, ground)))) as world:
        assert world.engine.triangles.used == 2 * 17 * 17
    path = written(tmp_path / "w.world", WORLD.format(MODEL.format(0, turned)))
    with World.from_file(path) as world:
        assert world.engine.triangles.used == 128
        world.engine.triangles.most = 200
        geom = next(geom for geom in world.engine.geoms.values() if hasattr(geom, "set_mesh"))
        with pytest.raises(GazeboError, match="at most 200 are allowed together"):
            geom.set_mesh(geom.vertices, np.repeat(geom.triangles, 2, axis=0))
        assert world.engine.triangles.used == 128
        geom.close()
        assert world.engine.triangles.used == 0


def test_cameras_share_their_pixels():
    with World() as world:
        world.Initialize()
        world.extension(Scene).pixels.most = 1000
        with Camera(world, 30, 20), pytest.raises(GazeboError, match="with 600 more pixels of cameras"):
            Camera(world, 30, 20)
        with Camera(world, 40, 20):
            pass


def test_textures_end_where_there_is_no_room(tmp_path, monkeypatch, caplog):
    monkeypatch.setattr(library, "MOST_TEXELS", 1)
    for name, color in (("red", (200, 0, 0)), ("green", (0, 200, 0))):
        Image.new("RGB", (8, 8), color).save(tmp_path / f"{name}.png")
    script = "material {0}\n{{\ntechnique\n{{\npass\n{{\ntexture_unit\n{{\ntexture {0}.png\n}}\n}}\n}}\n}}\n"
    (tmp_path / "m.material").write_text("".join(script.format(name) for name in ("red", "green")))
    look = """<visual name='v'><pose>{} 0 0 0 0 0</pose><geometry><box><size>1 1 1</size></box></geometry>
      <material><script><uri>m.material</uri><name>{}</name></script></material></visual>"""
    path = written(
        tmp_path / "w.world",
        WORLD.format(MODEL.format(0, look.format(-1, "red")) + MODEL.format(1, look.format(1, "green"))),
    )
    with World.from_file(path) as world, Camera(world, 40, 20, hfov=1.0) as camera:
        camera.SetPose(GzPose(GzVector(0, 0, 6), GzQuaternFromEuler(0, math.pi / 2, 0)))
        image = camera.Update().reshape(-1, 3).astype(int)
    redder = image[:, 0] - image[:, 1]
    textured = [redder.max() > 20, redder.min() < -20]
    assert sorted(textured) == [False, True]
    assert sum("the textures of this world have more than 1 px" in line for line in caplog.messages) == 1


def test_populations_share_their_models_and_elements(tmp_path, monkeypatch):
    crowd = """<population name='p{0}'><model name='m{0}'><static>1</static><link name='l'/></model>
      <pose>0 0 0 0 0 0</pose><box><size>9 9 9</size></box><model_count>6</model_count>
      <distribution><type>random</type></distribution></population>"""
    path = written(tmp_path / "w.world", WORLD.format("".join(map(crowd.format, range(3)))))
    for name, most, count in (("MOST_MODELS", 14, 12), ("MOST_ELEMENTS", 30, 6)):
        with monkeypatch.context() as patch:
            patch.setattr(population, name, most)
            with World.from_file(path) as world:
                assert len(world.models) == count, name
