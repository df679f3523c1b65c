"""Rendering: meshes, materials, textures, skins, lights, sky; and images against golden ones.

To write new golden images, then check them:  LIBGZ_NEW_GOLDENS=1 .venv/bin/pytest tests/rendering/test_images.py
"""

import math
import re
import subprocess
import sys

import numpy as np
import pytest
from golden_images import assert_golden
from PIL import Image
from sample_files import model_3ds

import libgz
from libgz.base.errors import GazeboError
from libgz.base.files import installed_worlds
from libgz.base.geometry import GzColor, GzPose, GzPosePointAt, GzQuaternFromEuler, GzVector
from libgz.physics.space import Space
from libgz.rendering import mesh
from libgz.rendering.camera import Camera
from libgz.rendering.context import CONTEXTS, open_context
from libgz.rendering.geom_meshes import GEOM_MESHES, meshes_of
from libgz.rendering.skin import read_skin

HEAD = "<gz:world xmlns:gz='g' xmlns:model='m' xmlns:param='p'><param:Global><gravity>0 0 0</gravity>{}</param:Global>"
LIGHT = "<model:LightSource><xyz>-4 3 6</xyz><ambientColor>.6 .6 .6</ambientColor></model:LightSource>"


def world_of(body="", settings=""):
    return libgz.World.from_string(f"{HEAD.format(settings)}{body}</gz:world>")


def look(world, place=(0, 0, 0), at=(1, 0, 0), size=(160, 120), **options):
    """One image."""
    with Camera(world, *size, **options) as camera:
        camera.SetPose(GzPosePointAt(GzVector(*place), GzVector(*at), GzVector(0, 0, 1)))
        return camera.Update().copy()


# Golden images -------------------------------------------------------------------------------------------------

SHAPES = HEAD.format("<skyColor>.6 .7 .8</skyColor>") + LIGHT + (
    "<model:GroundPlane><color>1 1 1</color><textureFile>grid.png</textureFile><textureSize>1 1</textureSize>"
    "<height>-1</height></model:GroundPlane></gz:world>"
)  # fmt: skip


def shapes():
    """One geom of each kind, made by hand."""
    world = libgz.World.from_string(SHAPES.replace("grid.png", str(installed_worlds() / "grid.png")))
    space, turned = Space(world.engine), GzQuaternFromEuler(0.5, -0.5, 0.3)
    wave = 0.15 * np.sin(np.linspace(0, 9, 20))[:, None] * np.cos(np.linspace(0, 7, 20))
    corners = ((1, 1, 1), (-1, -1, 1), (-1, 1, -1), (1, -1, -1))
    kinds = (
        lambda body: libgz.BoxGeom(body, space, 0.7, 0.5, 0.6),
        lambda body: libgz.SphereGeom(body, space, 0.4),
        lambda body: libgz.CylinderGeom(body, space, 0.3, 0.8),
        lambda body: libgz.CapsuleGeom(body, space, 0.25, 0.5),
        lambda body: libgz.WheelGeom(body, space, 0.4, 0.12),
        lambda body: libgz.TriMeshGeom(
            body, space, 0.4 * np.array(corners), ((0, 1, 3), (0, 2, 1), (0, 3, 2), (1, 2, 3))
        ),
        lambda body: libgz.HeightfieldGeom(body, space, wave, 1.0, 1.0),
        lambda body: libgz.BoxGeom(body, space, 0.6, 0.6, 0.6),
    )
    for i, kind in enumerate(kinds):
        body = libgz.Body(world)
        geom = kind(body)
        geom.SetColor(GzColor(*((0.9, 0.3, 0.2), (0.3, 0.8, 0.3), (0.3, 0.4, 0.9))[i % 3], 0.5))
        geom.SetTransparency(i == 7)
        geom.SetShininess(40.0)
        body.SetPose(GzPose(GzVector(4.5, 1.8 - 1.2 * (i % 4), 0.9 - i // 4 * 1.2), turned))
    return world


def from_file(name):
    return lambda: libgz.World.from_file(installed_worlds() / name)


CASES = {
    "shapes": (shapes, (0, 0, 0.6), (4.5, 0, 0.2)),
    "pioneer2at": (from_file("pioneer2at.world"), (-2.0, -1.2, 1.3), (1.0, 0.3, 0.1)),
    "pioneer2dx": (from_file("pioneer2dx.world"), (-2.6, 1.4, 1.2), (-1.0, 0.0, 0.2)),
    "simplesolids": (from_file("simplesolids.world"), (-4.0, -2.0, 2.5), (1.0, 0.0, 0.3)),
    "ptz": (from_file("ptz.world"), (-2.2, 1.6, 1.6), (1.5, -0.4, 0.2)),
    "fog": (
        lambda: world_of(
            LIGHT + "<model:GroundPlane><color>.6 .5 .3</color></model:GroundPlane>"
            "<model:SimpleSolid><xyz>5 0 0</xyz><size>1 1 1</size></model:SimpleSolid>"
            "<model:SimpleSolid><xyz>9 3 0</xyz><size>1 1 2</size><color>0 0 1</color></model:SimpleSolid>",
            "<fogDensity>0.08</fogDensity>",
        ),
        (0, 0, 1.2),
        (5, 1, 0.8),
    ),
}


@pytest.mark.parametrize("context", CONTEXTS)
@pytest.mark.parametrize("case", CASES)
def test_golden_images(case, context, monkeypatch):
    monkeypatch.setenv("LIBGZ_GL", context)
    build, place, at = CASES[case]
    with build() as world:
        world.step()
        actual = look(world, place, at)
    assert_golden(actual, case, context)


SIDE_BY_SIDE = """
import os, sys
from OpenGL.platform import ctypesloader
if sys.argv[1] == "alone":
    ctypesloader.loadLibrary = lambda *words, **more: None
import libgz, numpy as np
from libgz.rendering.camera import Camera
images, cameras = [], []
for choice in ("osmesa", "egl"):
    os.environ["LIBGZ_GL"] = choice
    world = libgz.World.from_string(
        "<gz:world xmlns:gz='g' xmlns:model='m'><model:LightSource><xyz>-4 3 6</xyz></model:LightSource>"
        "<model:SimpleSolid><xyz>3 0 0</xyz></model:SimpleSolid></gz:world>")
    cameras.append(Camera(world, 160, 120))
for _ in range(2):
    images = [camera.Update().astype(int) for camera in cameras]
print([camera._scene.thread.context.name for camera in cameras], np.ptp(images[0]) > 30,
      np.abs(images[0] - images[1]).max() <= 16)
"""


@pytest.mark.parametrize("libraries", ["all", "alone"])
def test_both_kinds_of_contexts_stand_side_by_side_and_need_no_other_gl_library(libraries):
    run = subprocess.run([sys.executable, "-c", SIDE_BY_SIDE, libraries], capture_output=True, text=True)
    assert run.stdout == "['osmesa', 'egl'] True True\n", run.stderr


def test_a_name_that_opengl_lacks_is_told():
    context = open_context()
    with pytest.raises(AttributeError, match="OpenGL has no glBegun"):
        _ = context.gl.glBegun
    context.close()


# Meshes ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("shapes", "volume"),
    [
        ([mesh.box(1, 2, 3)], 6.0),
        ([mesh.sphere(1.0, 96)], 4 / 3 * math.pi),
        (mesh.cylinder(0.5, 2.0, 96), math.pi / 2),
        ([mesh.capsule(0.5, 1.0, 96)], math.pi / 4 + math.pi / 6),
        ([mesh.torus(1.0, 0.25, 96)], 2 * math.pi**2 * 0.0625),
    ],
)
def test_meshes_are_closed_and_face_outwards(shapes, volume):
    total = 0.0
    for part in shapes:
        indices = np.arange(len(part.vertices)) if part.indices is None else part.indices
        a, b, c = part.vertices[indices].astype(float).reshape(-1, 3, 3).transpose(1, 0, 2)
        total += np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0
        assert np.linalg.norm(part.normals, axis=1) == pytest.approx(1.0, abs=1e-5)
        faces = np.cross(b - a, c - a)
        assert (np.einsum("ij,ij->i", faces, part.normals[indices].reshape(-1, 3, 3).sum(axis=1)) > -1e-6).all()
    assert total == pytest.approx(volume, rel=0.01)  # the divergence theorem: positive only if all faces point outwards


def test_a_kind_of_ones_own_is_drawn_as_its_base_or_by_its_own_drawer(monkeypatch):
    class Crate(libgz.BoxGeom):
        pass

    with world_of(LIGHT) as world:
        geom = Crate(libgz.Body(world), Space(world.engine), 1, 1, 1)
        geom.body.SetPosition((3, 0, 0))
        assert look(world)[60, 80].tolist() != look(world)[0, 0].tolist()
        geom.SetRelativePosition((0, 0, 5))  # a geom that moves on its body is compiled again
        assert look(world)[60, 80].tolist() == look(world)[0, 0].tolist()
        monkeypatch.setitem(GEOM_MESHES, Crate, lambda geom, segments: [mesh.box(20, 20, 20)])
        geom.SetColor(GzColor(1, 0, 0))
        assert look(world, place=(-20, 0, 0))[60, 80].tolist() != look(world)[0, 0].tolist()


def test_a_tires_missing_inner_side_is_not_missed(monkeypatch):
    def whole(geom, segments):
        discs = [mesh.disc(0.8 * geom.radius, 0.8 * geom.tire_radius * up, segments, up) for up in (1.0, -1.0)]
        return [mesh.torus(geom.radius - geom.tire_radius, geom.tire_radius, segments), *discs]

    for tire in (0.03, 0.08, 0.14):  # the thinnest has gaps beside its discs, and so an inner side
        with world_of(LIGHT) as world:
            wheel = libgz.WheelGeom(libgz.Body(world), Space(world.engine), 0.4, tire)
            wheel.body.SetPose(GzPose(GzVector(1.5, 0, 0), GzQuaternFromEuler(0.3, 1.0, 0.2)))
            wheel.SetColor(GzColor(0.9, 0.5, 0.2))
            rendered = look(world).astype(int)
            with monkeypatch.context() as patch:
                patch.setitem(GEOM_MESHES, libgz.WheelGeom, whole)
                wheel.SetColor(GzColor(0.9, 0.5, 0.2))
                difference = np.abs(look(world) - rendered).max(axis=2)
        parts = meshes_of(wheel, 32)[0].vertices
        assert (len(parts) < len(whole(wheel, 32)[0].vertices)) == (tire > 0.05)
        assert (difference > 24).mean() < 0.015  # where edges lie a pixel beside


def test_what_has_no_normals_is_drawn_unlit(monkeypatch):
    class Dots(libgz.Geom):
        pass

    points = np.array([(3.0, y / 50.0, 0.0) for y in range(-20, 21)], dtype=np.float32)
    monkeypatch.setitem(GEOM_MESHES, Dots, lambda geom, segments: [mesh.Mesh(points, mode=0)])
    with world_of(LIGHT) as world:
        Dots(libgz.Body(world), None).SetColor(GzColor(1, 0.5, 0))
        solid = libgz.BoxGeom(libgz.Body(world), Space(world.engine), 1, 1, 1)
        solid.body.SetPosition((5, 0, -2))
        image = look(world)
        dots = (image == (255, 128, 0)).all(axis=2)
        assert 20 < dots.sum() < 100
        assert image[115, 80].tolist() not in ([255, 128, 0], image[0, 0].tolist())


def test_the_ground_may_change_its_colour():
    text = LIGHT + "<model:GroundPlane><id>g</id><height>-1</height></model:GroundPlane>"
    with world_of(text) as world, Camera(world, 160, 120) as camera:
        assert np.argmax(camera.Update()[110, 80]) == 1
        world.model("g").plane.SetColor(GzColor(0.8, 0, 0))
        assert np.argmax(camera.Update()[110, 80]) == 0


def test_geoms_that_come_and_go_and_change_are_seen_so():
    with world_of(
        LIGHT + "<model:SimpleSolid><id>s</id><xyz>3 0 -.5</xyz><size>1 1 1</size></model:SimpleSolid>"
    ) as world:
        camera = Camera(world, 160, 120)
        sky = camera.Update()[0, 0].tolist()
        assert camera.Update()[60, 80].tolist() != sky
        world.body("s").geoms[0].SetColor(GzColor(0, 0, 1))
        r, _, b = camera.Update()[60, 80].tolist()
        assert b > 2 * r
        body = libgz.Body(world)
        libgz.SphereGeom(body, Space(world.engine), 0.2).SetColor(GzColor(0, 1, 0))
        body.SetPosition((2, 0, 0))
        _, g, b = camera.Update()[60, 80].tolist()
        assert g > 2 * b
        body.close()
        _, g, b = camera.Update()[60, 80].tolist()
        assert b > 2 * g
        camera.close()


# Light, sky, transparency ----------------------------------------------------------------------------------------


def test_the_sky_has_its_colour_and_fog_fades_into_it():
    wall = "<model:SimpleSolid><xyz>{} 0 -5</xyz><size>.1 20 10</size><color>1 0 0</color></model:SimpleSolid>"
    for distance in (2.0, 5.0):
        with world_of(
            wall.format(distance + 0.05), "<skyColor>.2 .4 .8</skyColor><fogDensity>0.2</fogDensity>"
        ) as world:
            image = look(world, hfov=0.2)
            share = math.exp(-((0.2 * distance) ** 2))  # GL's EXP2
            unlit = 0.2 * 0.2 * 255  # the global ambient light on an ambient colour of a fifth
            expected = [
                share * unlit * c + (1 - share) * 255 * s for c, s in zip((1, 0, 0), (0.2, 0.4, 0.8), strict=True)
            ]
            assert image[60, 80].tolist() == pytest.approx(expected, abs=2)
    with world_of("", "<skyColor>.2 .4 .8</skyColor>") as world:
        assert look(world)[60, 80].tolist() == [51, 102, 204]


def test_light_fades_with_distance_as_its_attenuation_says():
    wall = "<model:SimpleSolid><xyz>3.05 0 -5</xyz><size>.1 20 10</size></model:SimpleSolid>"
    light = (
        "<model:LightSource><ambientColor>0 0 0</ambientColor><specularColor>0 0 0</specularColor>"
        "<diffuseColor>1 1 1</diffuseColor><attenuation>{}</attenuation></model:LightSource>"
    )
    for factors, fading in (("1 0 0", 1.0), ("1 1 0", 4.0), ("1 0 .5", 5.5)):
        with world_of(light.format(factors) + wall) as world:
            vertices_at = math.hypot(3.0, 10.0, 5.0)  # light is computed at the corners of a face
            constant, linear, square = map(float, factors.split())
            fading = constant + linear * vertices_at + square * vertices_at**2
            expected = 255 * (0.04 + min(1.0, 3.0 / vertices_at / fading))
            assert look(world, hfov=0.1)[60, 80, 0] == pytest.approx(expected, abs=2)


def test_the_ninth_light_warns(caplog):
    with world_of("<model:LightSource/>" * 9 + "<model:MonoCam/>") as world:
        world.step(12)
    assert caplog.text.count("there are 9 lights; only the first 8 are shown") == 1


def test_what_is_transparent_is_mixed_with_what_lies_behind():
    panes = "".join(
        f"<model:SimpleSolid><xyz>{x} 0 -1</xyz><size>.1 2 2</size><color>{c} 0.25</color><transparent>1</transparent>"
        "</model:SimpleSolid>"
        for x, c in ((2, "1 0 0"), (3, "0 0 1"))  # the nearer one comes first in the file, and is rendered last
    )
    with world_of(panes, "<skyColor>1 1 1</skyColor>") as world:
        behind = np.array((255, 255, 255))
        for color in ((0, 0, 1), (1, 0, 0)):
            behind = 0.75 * behind + 0.25 * 0.04 * 255 * np.array(color)
        assert look(world)[60, 80].tolist() == pytest.approx(behind.tolist(), abs=3)


def test_the_sky_dome_shows_the_hour(tmp_path):
    tones = np.zeros((16, 24, 3), dtype=np.uint8)
    tones[:8, :, 0] = np.arange(24) * 10  # zenith: red grows with the hour
    tones[8:, :, 1] = 200  # horizon: green
    Image.fromarray(tones).save(tmp_path / "tones.png")
    dome = f"<model:SkyDome><toneMap>{tmp_path}/tones.png</toneMap><timeLapse>{{}}</timeLapse></model:SkyDome>"
    for lapse, later in (("true", 12 + 6), ("false", 12)):
        with world_of(dome.format(lapse), "<dayTime>43200</dayTime><stepTime>1</stepTime>") as world:
            up = {"place": (0, 0, 1), "at": (0.1, 0, 10)}
            world.step()
            assert look(world, **up)[60, 80, 0] == pytest.approx(115, abs=8)
            assert look(world, at=(5, 0, 1))[60, 80, 1] > 150
            world.clock.sim_time = 6 * 3600.0
            world.step()
            assert look(world, **up)[60, 80, 0] == pytest.approx(later * 10 - 5, abs=8)


# Textures and skins ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["png", "ppm", "jpg"])
def test_textures_lie_upright_on_every_kind_of_image(tmp_path, kind):
    image = np.zeros((64, 64, 3), dtype=np.uint8)
    image[:32, :32] = (255, 0, 0)  # top left as it is looked at
    image[32:, 32:] = (0, 0, 255)
    Image.fromarray(image).save(tmp_path / f"t.{kind}")
    glow = "<model:LightSource><ambientColor>4 4 4</ambientColor></model:LightSource>"
    texture = f"<textureFile>{tmp_path}/t.{kind}</textureFile>"
    box = f"<model:SimpleSolid><xyz>3 0 -1</xyz><size>2 2 2</size>{texture}</model:SimpleSolid>"
    with world_of(glow + box) as world:
        image = look(world).astype(int)
        assert image[45, 65, 0] > 100 > image[45, 65, 2]
        assert image[75, 95, 2] > 100 > image[75, 95, 0]
        assert image[45, 95].max() < 60


def test_the_grounds_texture_stays_where_it_is(tmp_path):
    image = np.full((64, 64, 3), 255, dtype=np.uint8)
    image[:32] = 0  # the half of larger y
    Image.fromarray(image).save(tmp_path / "t.png")
    texture = f"<textureFile>{tmp_path}/t.png</textureFile><textureSize>3 3</textureSize>"
    ground = f"<model:GroundPlane><color>1 1 1</color>{texture}</model:GroundPlane>"
    with world_of("<model:LightSource><ambientColor>4 4 4</ambientColor></model:LightSource>" + ground) as world:
        for x, y in ((0.0, 0.75), (0.3, 2.25), (7.1, 9.75), (-11.0, -0.75), (-4.4, -2.25), (100.2, 300.75)):
            value = look(world, place=(x, y, 2), at=(x + 0.001, y, 0))[60, 80].mean()
            assert (value > 128) == (y % 3.0 < 1.5), (x, y)


def test_textures_are_made_once_and_not_as_part_of_a_list():
    texture = f"<textureFile>{installed_worlds()}/grid.png</textureFile>"
    bodies = f"<model:GroundPlane>{texture}</model:GroundPlane><model:SimpleSolid>{texture}</model:SimpleSolid>"
    with world_of(LIGHT + bodies) as world, Camera(world, 160, 120) as camera:
        gl, calls = camera._scene.thread.renderer.gl, []
        for name in ("glNewList", "glEndList", "glTexImage2D"):
            real = getattr(gl, name)
            setattr(gl, name, lambda *words, name=name, real=real: (calls.append(name), real(*words))[1])
        camera.SetPose(GzPosePointAt(GzVector(-3, 0, 2), GzVector(0, 0, 0), GzVector(0, 0, 1)))
        camera.Update()
        made = [i for i, name in enumerate(calls) if name == "glTexImage2D"]
        assert len(made) == 8 + 8  # the solid's and the ground's, each of 128, 64 ... 1 texels
        for i in made:
            assert calls[:i].count("glNewList") == calls[:i].count("glEndList")


def test_a_damaged_image_is_one_warning(tmp_path, caplog):
    path = tmp_path / "bad.png"
    path.write_bytes(b"\x89PNG\r\n\x1a\nrubbish")
    solid = f"<model:SimpleSolid><xyz>{{}} 0 0</xyz><textureFile>{path}</textureFile></model:SimpleSolid>"
    ground = f"<model:GroundPlane><textureFile>{path}</textureFile></model:GroundPlane>"
    with world_of(
        LIGHT + ground + solid.format(2) + solid.format(4) + "<model:MonoCam><xyz>0 0 1</xyz></model:MonoCam>"
    ) as world:
        world.step(12)
    assert caplog.text.count(f"image {path} cannot be read") == 1


def test_skins_replace_shapes_with_their_own_materials(tmp_path):
    path = tmp_path / "s.3ds"
    path.write_bytes(model_3ds())
    skin = f"<skinFile>{path}</skinFile><skinScale>1 2 2</skinScale><skinXyz>0 0 .2</skinXyz><skinRpy>0 0 180</skinRpy>"
    solid = f"<model:SimpleSolid><xyz>4 0 -.25</xyz>{skin}</model:SimpleSolid>"
    light = "<model:LightSource><xyz>0 0 0</xyz></model:LightSource>"
    with world_of(light + solid) as world:
        image = look(world, size=(320, 240), hfov=math.radians(60)).astype(int)
        left, right = image[110, 120], image[110, 200]  # turned by 180 degrees: red is right now
        assert right[0] > 100 > right[2]
        assert left.min() > 100
        camera = Camera(world, 320, 240)
        camera.options.displaySkins = False
        assert camera.Update()[120, 160].min() > 30  # the white box
        assert camera.Update()[110, 100].tolist() == camera.image[0, 0].tolist()  # and nothing beside it
        camera.close()


def test_a_skin_with_missing_bytes_is_read_from_the_next_object_on(tmp_path, caplog):
    path = tmp_path / "s.3ds"
    whole = model_3ds(12)
    path.write_bytes(whole)
    count = sum(len(mesh.vertices) for mesh in read_skin(path))
    for place in (200, 300, 400):  # a byte less, as a conversion of line ends leaves it
        path.write_bytes(whole[:place] + whole[place + 1 :])
        assert sum(len(mesh.vertices) for mesh in read_skin(path)) >= count * 10 // 14
    assert "faces are shown" in caplog.text


def test_a_skin_of_which_little_can_be_read_is_not_shown(tmp_path):
    path = tmp_path / "s.3ds"
    whole = model_3ds(12)
    damaged = bytearray(whole)
    for match in list(re.finditer(rb"\x10\x41", whole))[4:]:  # the vertices of most objects
        damaged[match.start() + 2 : match.start() + 6] = b"\xff" * 4
        damaged[match.start() + 6 : match.start() + 8] = b"\0\0"
    path.write_bytes(damaged)
    with pytest.raises(GazeboError, match="faces can be read"):
        read_skin(path)


@pytest.mark.parametrize("share", [0.3, 0.4, 0.6, 0.8])
def test_a_truncated_skin_is_shown_if_half_of_it_is_there(tmp_path, caplog, share):
    path = tmp_path / "s.3ds"
    whole = model_3ds(30)
    path.write_bytes(whole[: int(share * len(whole))])  # nothing says how many faces the missing objects had
    if share < 0.5:
        with pytest.raises(GazeboError, match=r"of its 6[0-9] faces can be read"):
            read_skin(path)
    else:
        assert sum(len(mesh.vertices) for mesh in read_skin(path)) >= 3 * 64 * (share - 0.05)
        assert re.search("of 6[0-9] faces are shown", caplog.text)


def test_a_damaged_skin_keeps_what_came_before(tmp_path, caplog):
    whole = model_3ds()
    path = tmp_path / "cut.3ds"
    path.write_bytes(whole[:-20])
    assert len(read_skin(path)) >= 1
    assert caplog.text.count(f"skin {path} is damaged") == 1
    for length in range(len(whole)):  # no damage does more than that
        path.write_bytes(whole[:length])
        try:
            read_skin(path)
        except libgz.base.errors.GazeboError as error:
            assert str(path) in str(error)


def test_a_skin_of_another_format(tmp_path):
    (tmp_path / "s.obj").write_text("v 0 0 0\nv 0 1 0\nv 0 1 1\nf 1 2 3\n")
    (part,) = read_skin(tmp_path / "s.obj")
    assert sorted(map(tuple, part.vertices.tolist())) == [(0, 0, 0), (0, 1, 0), (0, 1, 1)]


def test_a_skin_that_cannot_be_read_is_one_warning(tmp_path, caplog):
    (tmp_path / "s.3ds").write_bytes(b"no mesh")
    solid = f"<model:SimpleSolid><xyz>3 0 -.25</xyz><skinFile>{tmp_path}/s.3ds</skinFile></model:SimpleSolid>"
    with world_of(LIGHT + solid + "<model:MonoCam/>") as world:
        world.step(12)
        image = look(world)
        assert image[60, 80].tolist() != image[0, 0].tolist()  # the box itself
    assert caplog.text.count("s.3ds cannot be read") == 1


def test_a_model_whose_skin_cannot_be_read_is_drawn_whole(tmp_path):
    (tmp_path / "s.3ds").write_bytes(b"no mesh")
    images = []
    for skin in (f"<skinFile>{tmp_path}/s.3ds</skinFile>", ""):
        with world_of(f"{LIGHT}<model:CarChassis><xyz>5 0 -.4</xyz>{skin}</model:CarChassis>") as world:
            images.append(look(world))
    assert (images[0] == images[1]).all()
