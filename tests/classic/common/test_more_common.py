"""Countdowns, images, meshes, models on the search path; SDF read into elements; messages published once."""

import numpy as np
import pytest
from PIL import Image as Pillow

from libgz.base.errors import GazeboError, ParameterError
from libgz.classic import common, msgs, sdf, transport
from libgz.classic.common import Image, MeshManager, ModelDatabase, MovingWindowFilter, Time, Timer
from libgz.classic.math import Vector3d


def test_a_timer_counts_down_and_ends(monkeypatch):
    now = [0]
    monkeypatch.setattr("time.monotonic_ns", lambda: now[0])
    timer = Timer(Time(2, 0), True)
    assert timer.GetElapsed() == Time(2, 0)
    timer.Start()
    now[0] = 500_000_000
    assert timer.GetElapsed() == Time(1.5)
    now[0] = 3_000_000_000
    assert timer.GetElapsed() == Time()
    assert not timer.GetRunning()
    upwards = Timer(Time(1, 0))
    upwards.Start()
    now[0] = 9_000_000_000
    assert upwards.GetElapsed() == Time(1, 0)
    with pytest.raises(ParameterError, match="a countdown needs the time"):
        Timer(None, True)


def test_an_image_is_read_scaled_and_written(tmp_path):
    pixels = np.zeros((2, 3, 3), dtype=np.uint8)
    pixels[1, 0] = (255, 0, 0)  # the lower left one
    Pillow.fromarray(pixels).save(tmp_path / "a.png")
    image = Image(str(tmp_path / "a.png"))
    assert (image.GetWidth(), image.GetHeight(), image.GetBPP()) == (3, 2, 24)
    assert image.GetPixel(0, 0).R() == 1.0
    assert image.GetPixel(0, 1).R() == 0.0
    assert image.MaxColor().R() == 1.0
    assert image.AvgColor().R() == pytest.approx(1.0 / 6.0)
    image.Rescale(6, 4)
    image.SavePNG(str(tmp_path / "b.png"))
    assert Image(str(tmp_path / "b.png")).GetWidth() == 6
    image.SetFromData(bytes(range(12)), 2, 2, Image.BGR_INT8)
    assert image.GetData()[:3] == bytes((2, 1, 0))
    with pytest.raises(ParameterError, match="has 5 bytes, expected 12"):
        image.SetFromData(b"12345", 2, 2, Image.RGB_INT8)
    with pytest.raises(GazeboError, match="cannot be read"):
        Image(str(tmp_path / "absent.png"))


@pytest.fixture
def meshes(monkeypatch):
    monkeypatch.setattr(MeshManager, "_instance", None)
    return MeshManager.Instance()


def test_made_meshes_have_their_volumes(meshes):
    meshes.CreateBox("box", (1, 2, 3), (1, 1))
    meshes.CreateSphere("ball", 0.5, 64, 64)
    meshes.CreateCylinder("tube", 0.5, 2.0, 1, 128)
    assert meshes.GetMesh("box").Volume() == pytest.approx(6.0)
    assert meshes.GetMesh("ball").Volume() == pytest.approx(4.0 / 3.0 * np.pi * 0.125, rel=0.01)
    assert meshes.GetMesh("tube").Volume() == pytest.approx(np.pi * 0.5, rel=0.01)
    assert meshes.GetMesh("box").Max() == Vector3d(0.5, 1.0, 1.5)
    assert meshes.GetMesh("none") is None
    assert meshes.GetMesh("unit_box").Volume() == pytest.approx(1.0)
    assert meshes.GetMesh("unit_plane").Max() == Vector3d(0.5, 0.5, 0.0)
    part = meshes.GetMesh("box").GetSubMesh(0)
    outwards = all(part.Normal(i).Dot(part.Vertex(i)) > 0 for i in range(part.GetVertexCount()))
    assert outwards


def test_a_mesh_file_is_loaded_once(meshes, tmp_path):
    path = tmp_path / "tri.obj"
    path.write_text("v 0 0 0\nv 2 0 0\nv 0 2 0\nf 1 2 3\n")
    mesh = meshes.Load(str(path))
    assert mesh is meshes.Load(str(path)) is meshes.GetMesh(str(path))
    assert (mesh.GetVertexCount(), mesh.GetIndexCount(), mesh.GetPath()) == (3, 3, str(tmp_path))
    mesh.Center()
    assert mesh.GetAABB() == (Vector3d(0, 0, 0), Vector3d(-1, -1, 0), Vector3d(1, 1, 0))
    assert (meshes.IsValidFilename("a.dae"), meshes.IsValidFilename("a.txt")) == (True, False)
    assert meshes.Load(str(tmp_path / "absent.obj")) is None


def test_the_model_database_is_the_search_path():
    database = ModelDatabase.Instance()
    assert database.GetModelFile("model://ground_plane").endswith("model.sdf")
    assert database.HasModel("model://sun")
    assert not database.HasModel("model://none_of_this_name")
    assert database.GetModels()["model://sun"] == database.GetModelName("model://sun") == "Sun"
    assert common.find_file_path("model://sun/model.config") == database.GetModelPath("model://sun")


def test_a_moving_window_has_a_mean():
    window = MovingWindowFilter(2)
    for value in (Vector3d(9, 9, 9), Vector3d(1, 0, 0), Vector3d(3, 0, 2)):
        window.Update(value)
    assert window.Get() == Vector3d(2, 0, 1)
    assert window.GetWindowFilled()


def test_elements_take_descriptions_and_documents():
    light = sdf.Element()
    assert sdf.initFile("light.sdf", light)
    assert (light.GetName(), light.Get(bool, "cast_shadows")) == ("light", False)
    assert sdf.readString("<light name='lamp' type='point'><cast_shadows>true</cast_shadows></light>", light)
    assert (light.Get(str, "name"), light.Get(bool, "cast_shadows")) == ("lamp", True)
    joint = sdf.Element()
    assert sdf.initFile("joint.sdf", joint)
    assert sdf.readString(
        "<sdf version='1.7'><joint name='j' type='prismatic'><parent>world</parent><child>l</child>"
        "<axis><limit/></axis></joint></sdf>",
        joint,
    )
    limit = joint.GetElement("axis").GetElement("limit")
    assert (limit.Get(float, "velocity"), limit.Get(float, "stiffness")) == (-1.0, 1e8)  # not 0: SDF's defaults
    whole = sdf.SDF()
    assert sdf.init(whole)
    assert sdf.readString("<sdf version='1.5'><model name='m'><link name='l'/></model></sdf>", whole)
    model = whole.Root().GetElement("model")
    assert model.GetElementTypeNames() >= {"link"}
    assert model.HasUniqueChildNames("link")
    assert not sdf.readString("<sdf version='1.5'><model></sdf>", whole)
    with pytest.raises(ParameterError, match="did you mean 'light'"):
        sdf.initFile("lihgt.sdf", sdf.Element())


def test_parameters_know_their_defaults():
    light = sdf.Element()
    sdf.initFile("light.sdf", light)
    shadows = light.GetElement("cast_shadows").GetValue()
    shadows.Set(True)
    assert (shadows.GetAsString(), shadows.GetDefaultAsString(), shadows.GetSet()) == ("true", "false", True)
    shadows.Reset()
    assert (shadows.Get(bool), shadows.GetSet(), shadows.GetTypeName()) == (False, False, "bool")
    plain = sdf.Element()
    plain.SetName("speed")
    plain.AddValue("double", "2.5")
    plain.AddAttribute("unit", "string", "m/s", False)
    assert (plain.GetValueDouble(), plain.Get(str, "unit"), plain.GetAttributeCount()) == (2.5, "m/s", 1)


def test_a_message_is_published_once_by_a_node():
    node, seen = transport.Node(), []
    node.Init("once")
    subscriber = node.Subscribe("~/hello", lambda message: seen.append(message.data))
    node.Publish("~/hello", msgs.GzString(data="hi"))
    transport.TopicManager.Instance().ProcessNodes()
    assert seen == ["hi"]
    subscriber.Unsubscribe()


@pytest.mark.parametrize(("name", "number"), [("RGB_INT8", 3), ("R8G8B8", 3), ("L8", 1), ("B8G8R8", 8), ("?", 0)])
def test_pixel_formats_of_cameras_have_numbers(name, number):
    assert common.Image.ConvertPixelFormat(name) == number
