"""What visuals look like in unusual cases: glass behind glass, no size at all, materials of many places."""

import math

import pytest
from classic_scenes import BEHIND, FLAT, material, middle, model, red, script, see, visual

from libgz.base.errors import ParameterError
from libgz.classic import rendering


def glass(name, color, x):
    pane = "<box><size>0.1 1 1</size></box>"
    return visual(name, material(FLAT.format(color)) + "<transparency>0.5</transparency>", pane, f"{x} 0 0 0 0 0")


def test_panes_of_one_link_are_seen_in_their_order_from_both_sides(world_of):
    world = world_of(model(inside=glass("red", "1 0 0", -1) + glass("blue", "0 0 1", 1)))
    half = 127.5
    assert middle(see(world)) == pytest.approx((half + 13, 25, 38 + 64), abs=2)
    assert middle(see(world, pose=(8, 0, 0, 0, 0, math.pi))) == pytest.approx((13 + 64, 25, half + 38), abs=2)


def test_glass_out_of_reach_of_a_lamp_stays_dark(world_of):
    dark = "<scene><ambient>0 0 0 1</ambient><background>0 0 0 1</background></scene>"
    lamp = """<light name='lamp' type='point'><pose>0 0 0 0 0 0</pose><diffuse>1 1 1 1</diffuse>
      <attenuation><range>{}</range><constant>1</constant><linear>0</linear><quadratic>0</quadratic></attenuation></light>"""
    near = world_of(model(inside=glass("red", "1 0 0", 0)), lamp.format(9), scene=dark)
    assert middle(see(near))[0] > 100
    far = world_of(model(inside=glass("red", "1 0 0", 0)), lamp.format(1), scene=dark)
    assert middle(see(far)) == (0, 0, 0)


def test_a_visual_comes_back_from_no_size(world_of):
    world = world_of(model(inside=red()))
    scene = rendering.scene.scene_of(world)
    for name in ("m::link::v", "m"):
        shape = scene.GetVisual(name)
        before = middle(see(world))
        shape.SetScale((0, 0, 0))
        assert tuple(shape.Scale()) == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)
        assert middle(see(world)) == (51, 102, 153)
        shape.SetScale((1, 1, 1))
        assert tuple(scene.GetVisual("m::link::v").Scale()) == pytest.approx((1.0, 1.0, 1.0))
        assert middle(see(world)) == before == (255, 0, 0)


def test_what_comes_in_the_place_of_something_looks_like_itself(world_of):
    world = world_of(model(inside=""))
    place = rendering.scene.scene_of(world).GetVisual("m::link")
    found = []
    with rendering.Camera(world, "eye", 64, 48) as camera:
        for shape, name in (("unit_box", "Red"), ("unit_sphere", "Red"), ("unit_sphere", "Blue")):
            made = rendering.Visual("made", place)
            made.AttachMesh(shape)
            made.SetMaterial(f"Gazebo/{name}")
            rendering.render_frame(world, [camera])
            found.append((middle(camera.pixels), int((camera.pixels != BEHIND).any(axis=2).sum())))
            made.Fini()
    (box, ball, blue), (large, small, same) = zip(*found, strict=True)
    assert (box, ball, blue) == ((255, 0, 0), (255, 0, 0), (0, 0, 255))
    assert small == same == pytest.approx(large * math.pi / 4.0, rel=0.4)
    assert small < 0.8 * large


def test_a_scaled_model_is_seen_in_its_new_size_and_falls_onto_the_ground(world_of):
    ground = "<include><uri>model://ground_plane</uri></include>"
    boxes = red() + "<collision name='c'><geometry><box><size>1 1 1</size></box></geometry></collision>"
    world = world_of(ground, model(inside=boxes, pose="3 0 0.5 0 0 0", static=False))
    crate = world.ModelByName("m")

    def pixels():
        return int((see(world, pose=(0, 0, 0.5, 0, 0, 0)) == (255, 0, 0)).all(axis=2).sum())

    world.Step(3000)
    assert not crate.GetLink().GetEnabled()  # it sleeps
    before = pixels()
    for _ in range(2):  # the size is half of the first one, however often that is said
        crate.SetScale((0.5, 0.5, 0.5))
    assert tuple(crate.BoundingBox().Size()) == pytest.approx((0.5, 0.5, 0.5), abs=1e-3)
    assert pixels() == pytest.approx(before * (2.5 * 0.5 / 2.75) ** 2, rel=0.1)
    world.Step(1000)
    assert crate.WorldPose().Pos().Z() == pytest.approx(0.25, abs=1e-3)
    with pytest.raises(ParameterError, match="above zero"):
        crate.SetScale((0.0, 1.0, 1.0))


def test_lines_go_with_the_model_that_they_are_drawn_on(world_of):
    world = world_of(model(inside=red()))
    scene = rendering.scene.scene_of(world)
    shape = scene.GetVisual("m::link::v")
    line = shape.CreateDynamicLine()
    for y in (-1.0, 1.0):
        line.AddPoint((-1.0, y, 0.0))
    shape.SetHighlighted(True)
    assert (see(world) != BEHIND).any()
    world.RemoveModel("m")
    world.Step(1)
    assert (see(world) == BEHIND).all()
    shape.DeleteDynamicLine(line)  # which is no error


def test_a_camera_stays_where_its_carrier_left_it(world_of):
    world = world_of(model("car", pose="0 0 0 0 0 0", static=False), model())
    scene = rendering.scene.scene_of(world)
    line = scene.WorldVisual().CreateDynamicLine()
    for _ in range(2):
        line.AddPoint((0.0, 0.0, 5.0))
    scene.GetVisual("car").AttachLineVertex(line, 0)
    with rendering.Camera(world, "eye", 16, 12) as camera:
        assert camera.AttachToVisual("car")
        assert camera.TrackVisual("m")
        rendering.render_frame(world, [camera])
        before = camera.WorldPose()
        for name in ("car", "m"):
            world.RemoveModel(name)
        world.InsertModelString(f"<sdf version='1.6'>{model('late', pose='9 9 9 0 0 0', static=False)}</sdf>")
        world.Step(1)
        rendering.render_frame(world, [camera])
        assert camera.WorldPose() == before
        assert camera.TrackedVisual() is None


def test_buffers_of_sizes_long_ago_are_let_go(world_of):
    world = world_of(model(inside=red()))
    with rendering.Camera(world, "eye", 64, 48) as camera:
        for width in (*range(64, 104), 64):
            camera.SetImageSize(width, 48)
            rendering.render_frame(world, [camera])
            assert middle(camera.pixels) == (255, 0, 0)
        assert len(camera.core._scene.thread.renderer._buffers) <= 16


# Materials -----------------------------------------------------------------------------------------------------------

OWN = "material {} {{ technique {{ pass {{ ambient 0 0 1 1\n diffuse 0 0 1 1 }} }} }}\n"


def test_a_script_s_own_name_is_not_taken_for_one_of_gazebo_s(world_of, tmp_path):
    (tmp_path / "own.material").write_text(OWN.format("Red"))
    world = world_of(model(inside=visual(looks=script("Red", "own.material"))))
    assert middle(see(world)) == (0, 0, 255)
    world = world_of(model(inside=visual(looks=script("Gazebo/Red", "own.material"))))
    assert middle(see(world)) == (255, 0, 0)
    world = world_of(model(inside=visual(looks=script("Red"))))
    assert middle(see(world)) == (255, 0, 0)


def test_grey_has_two_spellings(world_of, caplog):
    world = world_of(model(inside=visual(looks=script("Gazebo/Gray"))))
    assert middle(see(world)) == pytest.approx((76, 76, 76), abs=1)
    assert "Gray" not in caplog.text


def test_a_plugin_puts_on_a_material_of_a_script_beside_the_world(world_of, tmp_path):
    (tmp_path / "own.material").write_text(OWN.format("My/Blue") + OWN.format("My/Other"))
    world = world_of(model(inside=visual(looks=script("My/Blue", "own.material"))))
    shape = rendering.scene.scene_of(world).GetVisual("m::link::v")
    shape.SetMaterial("Gazebo/Red")
    shape.SetMaterial("My/Other")
    assert (shape.GetMaterialName(), middle(see(world))) == ("My/Other", (0, 0, 255))


# Lights --------------------------------------------------------------------------------------------------------------

DARK = "<scene><ambient>0 0 0 1</ambient><background>0 0 0 1</background></scene>"
BEAM = """<light name='lamp' type='{}'><pose>0 0 2 0 0 0</pose><diffuse>1 1 1 1</diffuse><direction>0 0 -1</direction>
  <attenuation><range>20</range><constant>{}</constant><linear>0</linear><quadratic>0</quadratic></attenuation>
  <spot><inner_angle>1.2</inner_angle><outer_angle>1.4</outer_angle><falloff>1</falloff></spot></light>"""


@pytest.mark.parametrize(
    "floor", ["<box><size>12 12 0.1</size></box>", "<plane><normal>0 0 1</normal><size>100 100</size></plane>"]
)
def test_a_spot_is_seen_on_a_large_floor(world_of, floor):
    white = visual(looks=material(FLAT.format("1 1 1")), geometry=floor)
    world = world_of(model(inside=white, pose="0 0 -0.05 0 0 0"), BEAM.format("spot", 1), scene=DARK)
    pixels = see(world, pose=(0.4, 0.4, 6, 0, math.pi / 2, 0))  # off the floor's own corners
    assert middle(pixels)[0] > 180
    assert pixels[24, 4].max() < 20


def test_lights_that_cannot_be_are_told_with_their_line(world_of, caplog):
    inside = BEAM.format("spott", 1) + BEAM.format("point", -1).replace("lamp", "other")
    world = world_of(inside, model(inside=red()))
    assert "w0.world:1: <light>: there is no light of type 'spott'" in caplog.text
    assert "<attenuation>: attenuation is (-1.0, 0.0, 0.0); its numbers must not be negative" in caplog.text
    assert middle(see(world)) == (255, 0, 0)
