"""Rendering of Gazebo classic: images, depths, visuals, materials."""

import math

import numpy as np
import pytest
from classic_scenes import BEHIND, material, middle, model, red, script, see, visual
from PIL import Image

from libgz.base.errors import ParameterError
from libgz.classic import rendering
from libgz.classic.event import Events
from libgz.classic.math import Color, Planed, Pose3d, Vector3d
from libgz.sdf.materials import find_material

# Cameras ---------------------------------------------------------------------------------------------------------


def test_a_flat_colour_fills_its_place_and_the_background_the_rest(world_of):
    pixels = see(world_of(model(inside=red())))
    assert middle(pixels) == (255, 0, 0)
    assert tuple(pixels[0, 0]) == BEHIND
    # The front face stands 2.5 m away, 1 m wide.
    across = np.flatnonzero((pixels[24] == (255, 0, 0)).all(axis=1))
    assert len(across) == pytest.approx(64 / (2 * math.tan(1.047 / 2)) / 2.5, abs=1)


def test_frames_come_to_callbacks_and_files(world_of, tmp_path):
    world, got = world_of(model(inside=red())), []
    with rendering.Camera(world, "eye", 32, 24) as camera:
        connection = camera.ConnectNewImageFrame(lambda *values: got.append(values))
        rendering.render_frame(world, [camera])
        data, *rest = got[0]
        assert rest == [32, 24, 3, "R8G8B8"]
        assert np.array_equal(np.frombuffer(data, np.uint8).reshape(24, 32, 3), camera.pixels)
        camera.SetCaptureData(False)
        rendering.render_frame(world, [camera])
        assert len(got) == 1
        camera.SetCaptureData(True)
        camera.DisconnectNewImageFrame(connection)
        camera.EnableSaveFrame(True)
        camera.SetSaveFramePathname(str(tmp_path / "frames"))
        for _ in range(2):
            rendering.render_frame(world, [camera])
        assert len(got) == 1
        assert camera.SaveFrame(str(tmp_path / "one.png"))
        assert not camera.SaveFrame(str(tmp_path / "one.nothing"))
        assert np.array_equal(np.array(Image.open(tmp_path / "one.png")), camera.pixels)
    assert sorted(p.name for p in (tmp_path / "frames").iterdir()) == ["eye-0000.jpg", "eye-0001.jpg"]


@pytest.mark.parametrize(
    ("name", "depth", "value"),
    [
        ("R8G8B8", 3, [255, 0, 0]),
        ("B8G8R8", 3, [0, 0, 255]),
        ("L8", 1, [255]),
        ("RGB_INT16", 6, [255, 255, 0, 0, 0, 0]),
        ("BAYER_RGGB8", 1, [255]),
        ("BAYER_BGGR8", 1, [0]),
    ],
)
def test_image_formats(world_of, name, depth, value):
    world = world_of(model(inside=red()))
    with rendering.Camera(world, "eye", 32, 24, image_format=name) as camera:
        rendering.render_frame(world, [camera])
        assert camera.ImageDepth() == depth
        assert len(camera.ImageData()) == camera.ImageByteSize() == 32 * 24 * depth
        at = (12 * 32 + 16) * depth  # an even row and column
        assert list(camera.ImageData()[at : at + depth]) == value


def test_wrong_values_are_told(world_of):
    world = world_of(model())
    with pytest.raises(ParameterError, match="no image format 'R8G8B9'; did you mean 'R8G8B8'"):
        rendering.Camera(world, "eye", image_format="R8G8B9")
    with rendering.Camera(world, "eye", 8, 8) as camera:
        with pytest.raises(ParameterError, match="near < far"):
            camera.SetClipDist(2.0, 1.0)
        with pytest.raises(ParameterError, match="zero size"):
            camera.SetImageSize(0, 8)


def test_pixels_and_rays_agree(world_of):
    with rendering.Camera(world_of(model()), "eye", 320, 240, 1.0) as camera:
        camera.SetWorldPose(Pose3d(1, 2, 3, 0, 0.3, 0.7))
        ahead = camera.Project(camera.WorldPosition() + camera.Direction() * 4)
        assert tuple(ahead) == pytest.approx((160, 120), abs=1)
        for pixel in ((10, 20), (300, 200)):
            start, way = camera.CameraToViewportRay(pixel[0] + 0.5, pixel[1] + 0.5)
            assert tuple(camera.Project(start + way * 7)) == pixel
            below = camera.WorldPointOnPlane(pixel[0] + 0.5, pixel[1] + 0.5) if way.z < 0 else None
            assert below is None or tuple(camera.Project(below)) == pixel
            assert below == camera.WorldPointOnPlane(pixel[0] + 0.5, pixel[1] + 0.5, Planed((0, 0, 1), 0)) or not below
        assert tuple(camera.Project(camera.WorldPosition() - camera.Direction())) == (-1, -1)
        assert camera.Direction().Cross(camera.Up()).Equal(camera.Right(), 1e-12)
        assert float(camera.VFOV()) == pytest.approx(2 * math.atan(math.tan(0.5) * 0.75))
        assert camera.AspectRatio() == pytest.approx(4 / 3)


def test_depths_are_those_of_the_geometry(world_of):
    world, got = world_of(model()), {}
    with rendering.DepthCamera(world, "eye", 320, 240, 1.047, 0.1, 10.0) as camera:
        kept = [
            camera.ConnectNewDepthFrame(lambda *values: got.update(depth=values)),
            camera.ConnectNewRGBPointCloud(lambda *values: got.update(cloud=values)),
        ]
        rendering.render_frame(world, [camera])
        depths = got["depth"][0].reshape(240, 320)
        assert got["depth"][1:] == (320, 240, 1, "FLOAT32")
        assert depths[120, 160] == pytest.approx(2.5, abs=1e-4)
        assert np.isinf(depths[[0, -1, 120, 120], [0, -1, 0, -1]]).all()
        assert np.array_equal(camera.DepthData(), got["depth"][0])
        cloud = got["cloud"][0].reshape(240, 320, 4)
        for row, column in ((100, 140), (100, 180), (140, 140), (140, 180)):
            x, y, z, _ = cloud[row, column]
            assert z == pytest.approx(2.5, abs=1e-4)
            assert (x > 0, y > 0) == (column > 160, row > 120)
        assert x == pytest.approx(2.5 * 20.5 / (160 / math.tan(0.5235)), abs=1e-4)
        camera.SetClipDist(0.1, 2.0)
        rendering.render_frame(world, [camera])
        assert np.isinf(camera.DepthData()).all()
        del kept


def test_cameras_follow_track_and_travel(world_of):
    world = world_of(model(), model("other", pose="0 5 1 0 0 0"))
    scene = rendering.get_scene()
    with rendering.UserCamera(world, "user", 8, 8) as camera:
        camera.SetWorldPose(Pose3d(0, 0, 1, 0, 0, 0))
        assert camera.TrackVisual("other")
        camera.Update()
        assert camera.Direction().Equal(Vector3d(0, 1, 0), 1e-9)
        camera.TrackVisual("")
        camera.SetWorldPose(Pose3d(1, 0, 1, 0, 0, 0))
        assert camera.AttachToVisual(scene.GetVisual("m"))
        world.ModelByName("m").SetWorldPose(Pose3d(3, 2, 0, 0, 0, math.pi / 2))
        camera.Update()
        assert camera.WorldPose().Equal(Pose3d(3, 0, 1, 0, 0, math.pi / 2), 1e-9)
        assert not camera.AttachToVisual("nobody")

        arrived, now = [], [100.0]
        camera.mount.clock = lambda: now[0]
        assert camera.MoveToPositions([Pose3d(0, 0, 9, 0, 0, 0)], 2.0, lambda: arrived.append(1))
        assert camera.IsAnimating()
        assert not camera.MoveToPosition(Pose3d(), 1.0)
        now[0] += 1.0
        camera.Update()
        assert 1.5 < camera.WorldPosition().z < 8.5
        now[0] += 1.0
        camera.Update()
        assert camera.WorldPose().Equal(Pose3d(0, 0, 9, 0, 0, 0), 1e-9)
        assert arrived == [1]
        assert not camera.IsAnimating()


# Events ----------------------------------------------------------------------------------------------------------


def test_events_around_a_frame_come_in_order_and_once(world_of):
    world, heard = world_of(model()), []
    names = ("PreRender", "Render", "PostRender")
    kept = [getattr(Events, f"Connect{name}")(lambda name=name: heard.append(name)) for name in names]
    with rendering.Camera(world, "a", 8, 8) as a, rendering.Camera(world, "b", 8, 8) as b:
        kept.append(b.ConnectNewImageFrame(lambda data: heard.append("frame")))
        rendering.render_frame(world, [a, b])
    assert heard == ["PreRender", "Render", "frame", "PostRender"]


def test_a_callback_that_raises_is_logged_and_images_continue(world_of, caplog):
    world = world_of(model(inside=red()))

    def spoil():
        raise RuntimeError("no more paint")

    kept = Events.ConnectPreRender(spoil)
    assert middle(see(world)) == (255, 0, 0)
    assert "no more paint" in caplog.text
    assert "PreRender" in caplog.text
    assert not kept.connected


# Visuals ---------------------------------------------------------------------------------------------------------


def test_visuals_are_found_by_name_and_know_each_other(world_of):
    world = world_of(model(inside=visual("a") + visual("b")))
    scene = rendering.get_scene("default")
    assert [v.Name() for v in scene.visuals()] == ["__world_node__", "m", "m::link", "m::link::a", "m::link::b"]
    shape = scene.GetVisual("default::m::link::a")
    assert shape is scene.GetVisual("m::link").GetChild(0) is scene.GetVisual(shape.GetId())
    assert shape.GetParent().GetParent() is shape.GetRootVisual() is scene.GetVisual("m")
    assert scene.GetVisual("nobody") is None
    assert (shape.GetGeometryType(), tuple(shape.Scale())) == ("box", (1, 1, 1))
    assert shape.GetScene() is scene
    assert world.Name() == scene.Name()


def test_a_visual_is_moved_without_its_link(world_of):
    world = world_of(model(inside=red()))
    shape = rendering.get_scene().GetVisual("m::link::v")
    assert shape.WorldPose().Equal(Pose3d(3, 0, 0, 0, 0, 0), 1e-12)
    shape.SetWorldPose(Pose3d(3, 2, 0, 0, 0, 0.5))
    assert middle(see(world)) == BEHIND
    assert middle(see(world, pose=(0, 2, 0, 0, 0, 0))) == (255, 0, 0)
    assert shape.Pose().Equal(Pose3d(0, 2, 0, 0, 0, 0.5), 1e-12)
    assert world.ModelByName("m").WorldPose().Equal(Pose3d(3, 0, 0, 0, 0, 0), 1e-12)
    world.ModelByName("m").SetWorldPose(Pose3d(3, -2, 0, 0, 0, 0))
    assert middle(see(world)) == (255, 0, 0)


def test_a_model_visual_takes_along_what_is_in_it(world_of):
    inner = f"<model name='n'><pose>0 0 1 0 0 0</pose><link name='k'>{visual('w')}</link></model>"
    world_of(model().replace("</model>", f"{inner}</model>"))
    scene = rendering.get_scene()
    scene.GetVisual("m").SetWorldPose(Pose3d(0, 5, 0, 0, 0, math.pi / 2))
    assert scene.GetVisual("m::link::v").WorldPose().Equal(Pose3d(0, 5, 0, 0, 0, math.pi / 2), 1e-9)
    assert scene.GetVisual("m::n::k::w").WorldPose().Equal(Pose3d(0, 5, 1, 0, 0, math.pi / 2), 1e-9)
    assert scene.GetVisual("m::n::k").Pose().Equal(Pose3d(), 1e-9)


def test_visuals_are_hidden_and_shown(world_of):
    world = world_of(model(inside=red()))
    group, shape = (rendering.get_scene().GetVisual(name) for name in ("m", "m::link::v"))
    assert middle(see(world)) == (255, 0, 0)
    shape.SetVisible(False)
    assert middle(see(world)) == BEHIND
    assert shape is rendering.get_scene().GetVisual("m::link::v")
    shape.ToggleVisible()
    assert middle(see(world)) == (255, 0, 0)
    group.SetVisible(False)
    assert not shape.Visible()
    assert middle(see(world)) == BEHIND


def test_transparency_mixes_with_what_is_behind(world_of):
    world = world_of(model(inside=red()))
    group, shape = (rendering.get_scene().GetVisual(name) for name in ("m", "m::link::v"))
    shape.SetTransparency(0.5)
    half = [(255 + BEHIND[0]) / 2, BEHIND[1] / 2, BEHIND[2] / 2]
    assert middle(see(world)) == pytest.approx(half, abs=1.5)
    group.SetTransparency(0.5)
    assert shape.DerivedTransparency() == pytest.approx(0.75)
    quarter = [255 / 4 + BEHIND[0] * 3 / 4, BEHIND[1] * 3 / 4, BEHIND[2] * 3 / 4]
    assert middle(see(world)) == pytest.approx(quarter, abs=1.5)
    group.SetTransparency(0)
    shape.SetTransparency(0)
    assert middle(see(world)) == (255, 0, 0)


def test_transparency_of_the_file_and_of_a_colour(world_of):
    see_through = red().replace("<visual name='v'>", "<visual name='v'><transparency>0.5</transparency>")
    half = [(255 + BEHIND[0]) / 2, BEHIND[1] / 2, BEHIND[2] / 2]
    assert middle(see(world_of(model(inside=see_through)))) == pytest.approx(half, abs=1.5)
    colour = material("<ambient>1 0 0 1</ambient><diffuse>1 0 0 0.5</diffuse>")
    assert middle(see(world_of(model(inside=visual(looks=colour))))) == pytest.approx(half, abs=1.5)


def test_colours_are_set_on_one_and_on_groups(world_of):
    world = world_of(model(inside=red()))
    group, shape = (rendering.get_scene().GetVisual(name) for name in ("m", "m::link::v"))
    shape.SetAmbient(Color(0, 1, 0))
    assert middle(see(world)) == (0, 255, 0)
    group.SetAmbient(Color(0, 0, 0))
    group.SetEmissive(Color(0, 0, 1))
    assert middle(see(world)) == (0, 0, 255)
    assert (shape.GetEmissive(), shape.Ambient(), shape.Diffuse()) == (Color(0, 0, 1), Color(), Color(1, 0, 0))


def test_scale_is_the_size_of_simple_shapes(world_of):
    world = world_of(model(inside=red(geometry="<box><size>1 2 1</size></box>")))
    shape = rendering.get_scene().GetVisual("m::link::v")
    assert tuple(shape.Scale()) == (1, 2, 1)
    wide = (see(world) == (255, 0, 0)).all(axis=2).sum()
    shape.SetScale(Vector3d(1, 1, 1))
    assert (see(world) == (255, 0, 0)).all(axis=2).sum() == pytest.approx(wide / 2, rel=0.1)
    assert tuple(shape.BoundingBox().Size()) == pytest.approx((1, 1, 1))
    rendering.get_scene().GetVisual("m").SetScale(Vector3d(2, 2, 2))
    assert tuple(shape.Scale()) == pytest.approx((2, 2, 2))


def test_plugins_draw_shapes_and_lines_of_their_own(world_of):
    world = world_of(model())
    scene = rendering.get_scene()
    made = rendering.Visual("mine", scene)
    made.Load()
    made.AttachMesh("unit_sphere")
    made.SetScale(Vector3d(0.4, 0.4, 0.4))
    made.SetMaterial("Gazebo/GreenGlow")
    made.SetWorldPosition(Vector3d(1.5, 0, 0))
    assert middle(see(world)) == (0, 255, 0)
    assert scene.GetVisual("mine") is made
    made.Fini()
    assert scene.GetVisual("mine") is None
    assert middle(see(world)) == (255, 255, 255)

    line = scene.WorldVisual().CreateDynamicLine(rendering.RENDERING_LINE_LIST)
    line.AddPoint(Vector3d(1, -1, 0), Color(1, 0, 1))
    line.AddPoint(1, 1, 0, Color(1, 0, 1))
    pixels = see(world, size=(65, 49))
    assert (pixels[24] == (255, 0, 255)).all(axis=1).sum() > 60
    scene.GetVisual("m").AttachLineVertex(line, 1)
    see(world)
    assert line.Point(1).Equal(Vector3d(3, 0, 0), 1e-9)
    scene.WorldVisual().DeleteDynamicLine(line)
    assert not (see(world) == (255, 0, 255)).all(axis=2).any()


def test_a_highlighted_visual_has_a_box_around_it(world_of):
    world = world_of(model(inside=red()))
    shape = rendering.get_scene().GetVisual("m::link::v")
    assert not (see(world) == 255).all(axis=2).any()
    shape.SetHighlighted(True)
    assert (see(world) == 255).all(axis=2).sum() > 30
    shape.SetHighlighted(False)
    assert not (see(world) == 255).all(axis=2).any()


def test_a_pixel_tells_its_model(world_of):
    world = world_of(model())
    with rendering.Camera(world, "eye", 32, 24) as camera:
        rendering.render_frame(world, [camera])
        scene = camera.GetScene()
        assert scene.GetModelVisualAt(camera, (16, 12)) is scene.GetVisual("m")
        assert scene.GetModelVisualAt(camera, (0, 0)) is None
        assert scene.GetCamera("eye") is scene.GetCamera(0) is camera
    assert scene.CameraCount() == 0


def test_a_pixel_tells_its_visual(world_of):
    upper = visual("upper", geometry="<sphere><radius>0.5</radius></sphere>", pose="0 0 0.6 0 0 0")
    inside = upper + visual("lower", pose="0 0 -0.6 0 0 0") + visual("behind", pose="3 0 0 0 0 0")
    world = world_of(model(inside=inside), model("other", pose="6 3 0 0 0 0"))
    with rendering.UserCamera(world, "eye", 32, 24) as camera:
        camera.SetWorldPose(Pose3d())
        rendering.render_frame(world, [camera])
        scene = camera.GetScene()
        assert scene.VisualAt(camera, (16, 7)).Name() == "m::link::upper"
        assert scene.VisualAt(camera, (16, 16)).Name() == "m::link::lower"
        assert camera.Visual((16, 12)).Name() == "m::link::behind"
        assert scene.ModelVisualAt(camera, (16, 12)).Name() == "m"
        assert scene.VisualAt(camera, (1, 1)) is None
        scene.GetVisual("m::link::upper").SetVisible(False)
        rendering.render_frame(world, [camera])
        assert scene.VisualAt(camera, (16, 4)) is None


def test_a_plane_visual_has_its_size_though_its_collision_has_none(world_of):
    plane = "<plane><normal>0 0 1</normal><size>2 2</size></plane>"
    inside = f"<collision name='c'><geometry>{plane}</geometry></collision>" + red(geometry=plane)
    box = "<collision name='c'><geometry><box><size>1 1 1</size></box></geometry></collision>"
    world = world_of(model(inside=inside, pose="0 0 0 0 0 0"), model("b", box, "9 0 0.5 0 0 0", static=False))
    above = (0, 0, 4, 0, math.pi / 2, 0)
    pixels = see(world, pose=above)
    assert middle(pixels) == (255, 0, 0)
    assert tuple(pixels[24, 0]) == BEHIND
    world.Step(50)
    assert world.ModelByName("b").WorldPose().pos.z == pytest.approx(0.5, abs=1e-3)


# Materials -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "ambient"),
    [("Gazebo/Red", (255, 0, 0)), ("Gazebo/Grey", (76, 76, 76)), ("Gazebo/Yellow", (255, 255, 0)),
     ("Gazebo/RedBright", (222, 66, 18)), ("Gazebo/SkyBlue", (33, 112, 178)), ("Gazebo/WhiteGlow", (255, 255, 255))],
)  # fmt: skip
def test_materials_by_name(world_of, name, ambient):
    looks = script(name, "file://media/materials/scripts/gazebo.material")
    assert middle(see(world_of(model(inside=visual(looks=looks))))) == pytest.approx(ambient, abs=1)


def test_a_material_named_in_plain_text_and_one_that_is_not_known(world_of, caplog):
    plain = visual("a", material("<script>Gazebo/Green</script>"))
    world = world_of(model(inside=plain))
    assert middle(see(world)) == (0, 255, 0)
    assert "Green" not in caplog.text
    world = world_of(model(inside=visual("a", script("My/Nope"))))
    assert middle(see(world)) == pytest.approx((76, 76, 76), abs=1)
    assert caplog.text.count("there is no material 'My/Nope'") == 1
    shape = rendering.scene.scene_of(world).GetVisual("m::link::a")
    shape.SetMaterial("Gazebo/Blu")
    assert "no material 'Gazebo/Blu'" in caplog.text
    shape.SetMaterial("Gazebo/Blue")
    assert (shape.GetMaterialName(), middle(see(world))) == ("Gazebo/Blue", (0, 0, 255))


SCRIPT = """
// a material with a parent, and one with an image
material My/Base { technique { pass { ambient 0 0.5 0 1
    diffuse 0 0.5 0 1
    specular 0.1 0.2 0.3 1 20 } } }
material My/Child : My/Base
{
  technique
  {
    pass
    {
      emissive 0 0 1 /* blue
      light */
    }
  }
}
material My/Picture
{
  technique { pass { ambient 1 1 1 1
    texture_unit
    {
      texture blue.png
    } } }
}
"""


def test_materials_of_scripts(world_of, tmp_path):
    for folder in ("scripts", "textures"):
        (tmp_path / "media" / folder).mkdir(parents=True)
    (tmp_path / "media" / "scripts" / "my.material").write_text(SCRIPT)
    Image.new("RGB", (4, 4), (0, 0, 200)).save(tmp_path / "media" / "textures" / "blue.png")
    uris = f"file://{tmp_path}/media/scripts file://{tmp_path}/media/textures"
    child, picture = (world_of(model(inside=visual(looks=script(f"My/{n}", uris)))) for n in ("Child", "Picture"))
    assert middle(see(child)) == pytest.approx((0, 128, 255), abs=1)
    assert middle(see(picture)) == (0, 0, 200)
    found = find_material("My/Base", uris.split())
    assert (found.shininess, found.specular) == (20.0, (0.1, 0.2, 0.3, 1.0))
    assert find_material("My/Nothing", uris.split()) is None


@pytest.mark.parametrize("name", ["Runway", "Rocky", "BuildingFrame", "Editor", "EditorPlane", "PointCloud", "Gray"])
def test_materials_that_gazebo_names_are_known(name):
    assert find_material(f"Gazebo/{name}") is not None


def test_without_light_counting_a_colour_is_plain(world_of):
    looks = material("<lighting>false</lighting><ambient>0 0 0 1</ambient><diffuse>.2 .6 1 1</diffuse>")
    dark = "<scene><ambient>0 0 0 1</ambient></scene>"
    assert middle(see(world_of(model(inside=visual(looks=looks)), scene=dark))) == pytest.approx((51, 153, 255), abs=1)
