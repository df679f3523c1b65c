"""Visual plugins of Gazebo classic."""

import logging
import textwrap

import pytest
from classic_scenes import BEHIND, middle, model, red, see

from libgz.classic import physics, rendering


@pytest.fixture
def plugin(tmp_path):
    def write(name, text):
        head = "from libgz.classic import *\nfrom libgz.classic.event import Events\n"
        (tmp_path / f"{name}.py").write_text(head + textwrap.dedent(text))

    return write


BLINKER = """
class Blinker(VisualPlugin):
    def Load(self, visual, sdf):
        print("Load", visual.Name(), sdf.Get(str, "colour"))
        self.visual, self.frames = visual, 0
    def Init(self):
        print("Init")
        self.connection = Events.ConnectPreRender(self.OnPreRender)
    def OnPreRender(self):
        self.frames += 1
        self.visual.SetVisible(self.frames % 2 == 1)
    def Reset(self):
        print("Reset")
GZ_REGISTER_VISUAL_PLUGIN(Blinker)
"""


def with_plugin(name="blinker"):
    return red().replace(
        "</visual>", f"<plugin name='p' filename='lib{name}.so'><colour>red</colour></plugin></visual>"
    )


def test_a_visual_plugin_blinks(world_of, plugin, capsys):
    plugin("blinker", BLINKER)
    world = world_of(model(inside=with_plugin()))
    assert capsys.readouterr().out == ""  # nothing is rendered yet
    world.server.serve_visuals().add(world.core.models)
    assert capsys.readouterr().out == "Load m::link::v red\nInit\n"
    seen = [middle(see(world)) for _ in range(4)]
    assert seen == [(255, 0, 0), BEHIND] * 2
    world.Reset()
    assert capsys.readouterr().out == "Reset\n"
    shape = rendering.get_scene().GetVisual("m::link::v")
    shape.LoadPlugin("blinker.py", "second")
    assert capsys.readouterr().out == "Load m::link::v \nInit\nInit\n"
    shape.RemovePlugin("second")
    shape.RemovePlugin("p")
    shape.SetVisible(True)
    assert [middle(see(world)) for _ in range(2)] == [(255, 0, 0)] * 2


def test_visual_plugins_of_models_that_come_and_go(world_of, plugin, capsys):
    plugin("blinker", BLINKER)
    world = world_of()
    world.server.serve_visuals().add(())
    world.InsertModelString(f"<sdf version='1.6'>{model(inside=with_plugin())}</sdf>")
    world.Step(1)
    world.server.serve_visuals().add(())
    assert capsys.readouterr().out == "Load m::link::v red\nInit\n"
    assert len(list(world.server.serve_visuals().plugins())) == 1
    world.RemoveModel("m")
    world.Step(1)
    assert not list(world.server.serve_visuals().plugins())
    assert (see(world) == BEHIND).all()


@pytest.mark.parametrize("where", ["__init__", "Load", "Init", "OnPreRender"])
def test_a_visual_plugin_that_raises_is_named_and_stopped(world_of, plugin, caplog, where):
    text = BLINKER.replace("(VisualPlugin):", "(VisualPlugin):\n    def __init__(self):\n        pass")
    lines = []
    for line in text.splitlines():
        lines.append(line)
        if line.strip().startswith(f"def {where}("):
            lines.append("        raise ValueError('broken paint')")
    plugin("blinker", "\n".join(lines))
    world = world_of(model(inside=with_plugin()))
    world.server.serve_visuals().add(())
    assert middle(see(world)) == (255, 0, 0)
    assert middle(see(world)) == (255, 0, 0)
    assert "broken paint" in caplog.text
    assert "name[p] and filename[libblinker.so]" in caplog.text


def test_a_plugin_of_another_kind_is_refused_in_classic_s_words(world_of, plugin, caplog):
    plugin("wrong", "class W(WorldPlugin):\n    pass\nGZ_REGISTER_WORLD_PLUGIN(W)")
    world = world_of(model(inside=with_plugin("wrong")))
    world.server.serve_visuals().add(())
    assert (
        "Visual[m::link::v] is attempting to load a plugin, but detected an incorrect plugin type. "
        "Plugin filename[libwrong.so] name[p]" in caplog.text
    )


def test_a_server_with_a_camera_loads_them_and_draws_at_its_rate(world_of, plugin, capsys):
    plugin("blinker", BLINKER)
    sensor = (
        "<sensor name='cam' type='camera'><always_on>1</always_on><update_rate>10</update_rate><camera>"
        "<image><width>64</width><height>48</height></image></camera></sensor>"
    )
    world = world_of(model(inside=with_plugin()), model("eye", sensor, pose="0 0 0 0 0 0"))
    seen = []
    camera = world.server.sensors and rendering.get_scene().GetCamera(0)
    kept = camera.ConnectNewImageFrame(lambda: seen.append(middle(camera.pixels)))
    assert capsys.readouterr().out == "Load m::link::v red\nInit\n"
    world.Step(450)
    assert seen == [(255, 0, 0), BEHIND] * 2
    assert kept.connected


def test_a_world_without_cameras_draws_nothing(world_of, plugin, caplog, capsys):
    plugin("blinker", BLINKER)
    with caplog.at_level(logging.WARNING):
        world = world_of(model(inside=with_plugin()))
        world.Step(3)
    assert world.server.visuals is None
    assert capsys.readouterr().out == ""
    assert physics.get_world() is world
