"""The viewer without a browser."""

import base64
import contextlib
import io

import numpy as np
import pytest
import trimesh
from PIL import Image

import libgz
from libgz.base.files import installed_worlds
from libgz.rendering.image import jpeg_text
from libgz.view.local import LocalSource
from libgz.view.shapes import Shapes
from libgz.view.viewer import Viewer

STATIC = """<sdf version="1.6"><world name="w"><include><uri>model://ground_plane</uri></include>
<model name="box"><static>1</static><pose>7 -2 0.5 0 0 0</pose><link name="link"><visual name="v"><geometry><box>
<size>1 1 1</size></box></geometry></visual><sensor name="eye" type="camera"><camera><horizontal_fov>1</horizontal_fov>
<image><width>40</width><height>20</height></image></camera></sensor></link></model></world></sdf>"""


class Readings:
    """Controls that answer with the image of a camera."""

    abilities = frozenset({"readings"})
    image = np.zeros((20, 40, 3), np.uint8)

    def ask(self, _verb, _argument="-", **content):
        return {"images": {name: jpeg_text(self.image.tobytes(), 20, 40) for name in content["names"]}, "ranges": {}}

    def reconnect(self):
        pass


class Interfaces:
    """Controls of interfaces only."""

    abilities = frozenset({"interfaces"})

    def __init__(self, world):
        self.interface = world.interface


@pytest.fixture
def viewer():
    with (
        libgz.World.from_string(STATIC) as world,
        contextlib.redirect_stdout(io.StringIO()),
        Viewer(LocalSource(world), Readings(), port=18960, wait=True) as viewer,
    ):
        yield viewer


def test_a_viewer_survives_whatever_a_frame_or_an_action_raises(viewer, monkeypatch, caplog):
    viewer.tick()
    calls = []

    def fail(*_):
        calls.append(1)
        raise ZeroDivisionError("of a page")

    monkeypatch.setattr(viewer.view, "move", fail)
    viewer.do(fail)
    for _ in range(6):
        viewer._due, viewer._state = 0.0, None  # a frame is due, and has something new
        viewer.tick()
    assert viewer.failures == len(calls) >= 6
    told = [record for record in caplog.records if "the viewer continues after an error" in record.getMessage()]
    assert 1 <= len(told) <= 4  # of 1, 2, 4, 8 ...
    monkeypatch.undo()
    viewer._due = viewer._shown = 0.0
    before = viewer.failures
    viewer.tick()
    assert viewer.failures == before


@contextlib.contextmanager
def showing(text):
    """A world and a viewer that only shows it."""
    with (
        libgz.World.from_string(text) as world,
        contextlib.redirect_stdout(io.StringIO()),
        Viewer(LocalSource(world), port=18960, wait=True) as viewer,
    ):
        yield world, viewer


def test_the_first_view_shows_the_models_not_the_ground(viewer):
    viewer.frame(0.0)
    camera = viewer.page.initial_camera
    assert camera.look_at == pytest.approx((7.0, -2.0, 0.5))
    assert np.linalg.norm(np.subtract(camera.position, camera.look_at)) < 5.0


def test_the_first_view_of_nothing_but_ground_is_near():
    ground = "<gz:world xmlns:gz='g' xmlns:model='m'><model:GroundPlane/></gz:world>"
    with showing(ground) as (_, viewer):
        viewer.frame(0.0)
        assert np.linalg.norm(viewer.page.initial_camera.position) < 10.0


def test_the_first_view_of_what_is_far_away_shows_it():
    box = "<model:SimpleSolid><id>box{0}</id><xyz>{0} 0 10</xyz></model:SimpleSolid>"
    with showing(f"<gz:world xmlns:gz='g' xmlns:model='m'>{box.format(70)}{box.format(90)}</gz:world>") as (_, viewer):
        viewer.frame(0.0)
        assert viewer.page.initial_camera.look_at == pytest.approx((80.0, 0.0, 10.0), abs=1.0)


def test_a_mesh_whose_file_is_missing_hides_nothing_else():
    text = """<gz:world xmlns:gz='g' xmlns:model='m'><model:Terrain><id>hills</id><terrainFile>none.gzb</terrainFile>
    </model:Terrain><model:Pioneer2AT><id>robot1</id></model:Pioneer2AT></gz:world>"""
    with showing(text) as (_, viewer):
        viewer.frame(0.0)
        state = viewer.source.state()
        assert viewer.view.bounds(viewer.view.ids["robot1"], state) is not None
        assert viewer.view.bounds(viewer.view.ids["hills"], state) is None


def test_the_ground_of_a_height_map_has_its_textures(tmp_path):
    Image.new("L", (5, 5), 9).save(tmp_path / "h.png")
    Image.new("RGB", (8, 8), (0, 200, 0)).save(tmp_path / "grass.png")
    texture = f"<texture><diffuse>file://{tmp_path}/grass.png</diffuse><normal>-</normal><size>1</size></texture>"
    shape = f"<heightmap><uri>file://{tmp_path}/h.png</uri><size>8 8 2</size>{texture}</heightmap>"
    visual = f"<visual name='v'><geometry>{shape}</geometry></visual>"
    ground = f"<model name='m'><static>1</static><link name='l'>{visual}</link></model>"
    with libgz.World.from_string(f"<sdf version='1.6'><world name='w'>{ground}</world></sdf>") as world:
        source = LocalSource(world)
        [shape] = source.scene["entities"][0]["bodies"][0]["shapes"]
        [[form]] = [[one.form for one in Shapes(source).instances(shape)]]
        loaded = trimesh.load(io.BytesIO(form.glb), file_type="glb")
        [part] = loaded.geometry.values()
        found = np.asarray(part.visual.material.baseColorTexture.convert("RGB"))
        assert found.reshape(-1, 3).mean(axis=0) == pytest.approx((0, 200, 0), abs=3)
        assert np.ptp(part.visual.uv, axis=0) == pytest.approx((1, 1))


def test_trails_are_above_the_ground_and_begin_anew_after_a_reset():
    text = """<gz:world xmlns:gz='g' xmlns:model='m'><model:GroundPlane/><model:Pioneer2AT><id>robot1</id>
    </model:Pioneer2AT></gz:world>"""
    with showing(text) as (world, viewer):
        viewer.frame(0.0)
        viewer.set_mark("trails", True)
        world.interface("position", "robot1").command(vx=0.5)
        for step in range(8):
            world.step(25)
            viewer.frame(1.0 + step)
        points = viewer.marks._handles["trails"].points
        assert np.ptp(points[..., 0]) > 1.0
        assert points[..., 2].min() > 0.02
        world.Reset()
        viewer.frame(20.0)
        assert "trails" not in viewer.marks._handles or not len(viewer.marks._handles["trails"].points)


def test_frusta_show_the_last_image_of_a_camera(viewer):
    viewer.set_mark("frusta", True)
    viewer.frame(0.0)
    [(screen, shown)] = viewer.marks._screens.values()
    assert shown.shape == (20, 40, 3)
    assert screen.position == pytest.approx((7.5, -2.0, 0.5))
    assert screen.render_width == pytest.approx(2 * screen.render_height) == pytest.approx(np.tan(0.5))
    viewer.frame(1.0)
    assert next(iter(viewer.marks._screens.values()))[1] is shown  # the same image is not sent again
    Readings.image = np.full((20, 40, 3), 200, np.uint8)
    viewer.frame(2.0)
    assert next(iter(viewer.marks._screens.values()))[1].mean() == pytest.approx(200, abs=2)
    viewer.set_mark("frusta", False)
    assert not viewer.marks._screens


def test_a_selected_model_has_the_sliders_of_what_it_carries():
    with (
        libgz.World.from_file(installed_worlds() / "canonvcc4.world") as world,
        contextlib.redirect_stdout(io.StringIO()),
        Viewer(LocalSource(world), Interfaces(world), port=18960) as viewer,
    ):
        viewer.frame(0.0)
        viewer.select("cam1")
        shown = viewer.panel._parts["model"]
        assert [one.label for one in shown] == [f"cam1 {name} [rad]" for name in ("pan", "tilt", "zoom")]


def test_an_image_becomes_jpeg_for_a_page():
    assert jpeg_text(None, 4, 4) == jpeg_text(b"12345", 4, 4) == ""
    grey = np.full((4, 6), 100, np.uint8)
    shown = np.asarray(Image.open(io.BytesIO(base64.b64decode(jpeg_text(grey.tobytes(), 4, 6)))))
    assert shown.shape == (4, 6, 3)
    assert shown.mean() == pytest.approx(100, abs=2)
