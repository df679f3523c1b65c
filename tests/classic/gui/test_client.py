"""gzclient: a real client beside a real server, each a process of its own, on a port of its own."""

import os
import signal
import subprocess
import sys
import textwrap
from types import SimpleNamespace

import numpy as np
import pytest
from master_uri import free_master_uri
from PIL import Image

import libgz
from libgz.apps import gzclient
from libgz.apps.classic_command import read_command_line
from libgz.apps.libgz import main
from libgz.base.errors import NotFoundError
from libgz.classic import gui, msgs
from libgz.classic.gui.named import ini_plugins
from libgz.classic.gui.scene_link import only_looks
from libgz.classic.gui.window import GUI, MainWindow
from libgz.sdf.reader import SdfFile

PATIENCE = 60.0  # [s]: a machine under load
WORLD = """
<sdf version="1.6"><world name="default">
  <scene><ambient>1 1 1 1</ambient><background>0 0 1 1</background><grid>false</grid></scene>
  <gui>
    <camera name="user_camera"><pose>0 0 0.5 0 0 0</pose></camera>
    <plugin name="teller" filename="libteller.so"><word>hello</word></plugin>
  </gui>
  <model name="box"><static>true</static><pose>3 0 0.5 0 0 0</pose>
    <link name="link">
      <visual name="v"><geometry><box><size>1 1 1</size></box></geometry>
        <material><ambient>1 0 0 1</ambient><diffuse>1 0 0 1</diffuse></material>
        <plugin name="painter" filename="libpainter.so"/>
      </visual>
    </link>
    <plugin name="inside" filename="libmover.so"/>
  </model>
  <plugin name="mover" filename="libmover.so"/>
</world></sdf>
"""
PLUGINS = {
    "mover": """
    class P(WorldPlugin):
        def Load(self, world, sdf):
            self.world = world
            self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)
        def OnUpdate(self, info):
            self.world.ModelByName("box").SetWorldPose(Pose3d(3, 0, 0.5 + info.simTime.Double(), 0, 0, 0))
            if self.world.Iterations() == 300:
                self.world.InsertModelString("<sdf version='1.6'><model name='late'><link name='l'/></model></sdf>")
    GZ_REGISTER_WORLD_PLUGIN(P)
    """,
    "still": """
    class P(WorldPlugin):
        def Load(self, world, sdf):
            pass
    GZ_REGISTER_WORLD_PLUGIN(P)
    """,
    "painter": """
    class P(VisualPlugin):
        def Load(self, visual, sdf):
            print("painter Load", visual.Name())
        def Init(self):
            print("painter Init")
    GZ_REGISTER_VISUAL_PLUGIN(P)
    """,
    "system": """
    class P(SystemPlugin):
        def __init__(self):
            print("system made")
        def Load(self, argc, argv):
            print("system Load", argv[0])
        def Init(self):
            print("system Init")
    GZ_REGISTER_SYSTEM_PLUGIN(P)
    """,
    "first": """
    class P(GUIPlugin):
        def Load(self, sdf):
            print("first Load", self.GetHandle())
    GZ_REGISTER_GUI_PLUGIN(P)
    """,
    "broken": """
    class P(GUIPlugin):
        def Load(self, sdf):
            raise ValueError("no such button")
    GZ_REGISTER_GUI_PLUGIN(P)
    """,
    "teller": """
    class P(GUIPlugin):
        def Load(self, sdf):
            print("teller Load", sdf.Get(str, "word"), self.gui.name, gui.get_world())
            self.camera = gui.get_active_camera()
            self.heights = []
            self.kept = [
                gui.Events.ConnectMainWindowReady(lambda: print("teller ready")),
                Events.ConnectPreRender(self.OnPreRender),
            ]
        def OnPreRender(self):
            scene = rendering.get_scene()
            self.heights.append(scene.GetVisual("box").WorldPose().Pos().Z())
            if scene.GetVisual("late") is not None and len(self.heights) > 3:
                rises = self.heights[-1] > self.heights[0] and self.heights == sorted(self.heights)
                print("teller saw", rises, abs(self.heights[-1] - 0.5 - scene.SimTime().Double()) < 0.01)
                gui.get_main_window().close()
    GZ_REGISTER_GUI_PLUGIN(P)
    """,
}
HEAD = """
from libgz.classic import *
from libgz.classic import gui, rendering
from libgz.classic.event import Events
from libgz.classic.math import Pose3d
"""


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A folder with world and plugins, and a port of its own."""
    for name, text in PLUGINS.items():
        (tmp_path / f"{name}.py").write_text(HEAD + textwrap.dedent(text))
    (tmp_path / "moving.world").write_text(WORLD)
    (tmp_path / "still.world").write_text(WORLD.replace("libmover", "libstill").replace("<word>hello</word>", ""))
    monkeypatch.setenv("GAZEBO_MASTER_URI", free_master_uri())
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", str(tmp_path))
    monkeypatch.delenv("GAZEBO_GUI_INI_FILE", raising=False)
    return tmp_path


@pytest.fixture
def server(place):
    """Starts gzserver with one of the worlds."""
    started = []

    def start(world, *options):
        started.append(command("gzserver", place / world, *options))
        return started[-1]

    yield start
    for process in started:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
        process.communicate(timeout=PATIENCE)


def command(name, *words):
    line = [sys.executable, "-m", f"libgz.apps.{name}", *map(str, words)]
    env = {**os.environ, "PYTHONUNBUFFERED": "1"}
    return subprocess.Popen(line, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=env)


def client(*words):
    process = command("gzclient", *words)
    out, err = process.communicate(timeout=PATIENCE)
    return process.returncode, out.splitlines(), err


def test_plugins_come_in_classic_s_order_and_see_the_server_s_world(server, place):
    server("moving.world")
    (place / "home" / ".gazebo").mkdir(parents=True)
    (place / "home" / ".gazebo" / "gui.ini").write_text("[overlay_plugins]\nfilenames=libfirst.so:libnothere.so\n")
    code, out, err = client("--no-view", "-g", "libsystem.so", "--gui-client-plugin", "libbroken.so", "--rate", "200")
    assert (code, out) == (0, [
        "system made", "system Load gzclient", "system Init", "first Load libfirst.so",
        "teller Load hello teller default", "painter Load box::link::v", "painter Init", "teller ready",
        "teller saw True True",
    ])  # fmt: skip
    assert "g/gui-plugin is really loading a SystemPlugin" in err
    assert "Unable to create gui overlay plugin with filename[libnothere.so]" in err
    assert "no such button" in err
    assert "name[libbroken.so] and filename[libbroken.so]" in err


def test_a_picture_shows_what_the_user_s_camera_sees(server, place):
    server("still.world", "-u")
    code, out, _ = client("--picture", place / "a.png", "--size", "80x60")
    assert (code, out[-1]) == (0, f"{place / 'a.png'}: 80 x 60 px, of 'default'")
    pixels = np.array(Image.open(place / "a.png"))
    assert pixels.shape == (60, 80, 3)
    red, *others = map(int, pixels[30, 40])  # lit, as in all images for people
    assert red > 200
    assert others == [0, 0]
    assert tuple(pixels[0, 0]) == (0, 0, 255)
    code, _, _ = client("--picture", place / "b.png", "--size", "80x60", "--pose", "0 0 0.5 0 0 3.14159")
    assert code == 0
    assert tuple(np.array(Image.open(place / "b.png"))[30, 40]) == (0, 0, 255)


def edit(folder, name, old, new):
    path = folder / f"{name}.py"
    path.write_text(path.read_text().replace(old, new))


def test_plugins_are_reloaded_and_a_client_ends_with_its_server(server, place, capsys, monkeypatch):
    """`libgz plugin reload` reaches the server and its clients."""
    monkeypatch.setenv("TMP", str(place))
    running = server("still.world")
    process = command("gzclient", "--verbose", "--no-view")
    while "teller ready" not in (line := process.stdout.readline()):
        assert line, process.communicate()
    edit(place, "teller", "teller Load", "teller edited")
    edit(place, "painter", "painter Load", "painter edited")
    edit(place, "still", "pass", "world.ModelByName('box').SetWorldPose(Pose3d(1, 2, 3, 0, 0, 0))")
    assert main(["plugin", "reload", "teller"]) == 0
    assert main(["plugin", "reload", "libpainter.so"]) == 0
    assert main(["plugin", "reload", "mover"]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "reloaded GUI plugin teller", "reloaded Visual plugin box::link::v::painter", "reloaded World plugin mover",
    ]  # fmt: skip
    assert process.stdout.readline() == "teller edited  teller default\n"
    assert process.stdout.readline() == "painter edited box::link::v\n"
    edit(place, "still", "SetWorldPose(", "SetNoPose(")
    assert main(["plugin", "reload", "mover"]) == 1
    error = capsys.readouterr().err
    assert "still.py" in error
    assert "AttributeError" in error
    assert main(["plugin", "reload", "moved"]) == 1
    assert "did you mean 'mover'" in capsys.readouterr().err
    assert main(["plugin", "reload", "mover", "-s", "999"]) == 1
    assert "no server with id 999" in capsys.readouterr().err
    running.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 255
    assert "The server has ended" in err


def test_interrupts_end_a_client_well(server):
    server("still.world")
    for number in (signal.SIGINT, signal.SIGTERM):
        process = command("gzclient")
        while "teller ready" not in (line := process.stdout.readline()):
            assert line, process.communicate()
        process.send_signal(number)
        process.communicate(timeout=PATIENCE)
        assert process.returncode == 0


def test_a_second_interrupt_ends_a_client_whose_plugin_hangs(server, place):
    hangs = "self.kept = Events.ConnectPreRender(self.OnPreRender)\n    def OnPreRender(self):\n        print('hangs')"
    text = PLUGINS["first"].replace('print("first Load", self.GetHandle())', hangs.replace("\n", "\n    "))
    text = text.replace("print('hangs')", "print('hangs')\n            while True: pass")
    (place / "first.py").write_text(HEAD + textwrap.dedent(text))
    server("still.world")
    process = command("gzclient", "--gui-client-plugin", "libfirst.so")
    while "hangs" not in (line := process.stdout.readline()):
        assert line, process.communicate()
    process.send_signal(signal.SIGINT)
    while "a second signal ends the process" not in (line := process.stderr.readline()):
        assert line, process.communicate()
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=PATIENCE)
    assert process.returncode == 128 + signal.SIGTERM


def test_without_a_server_it_says_so_and_ends(place):
    code, _, err = client("--timeout", "0.3")
    assert code == 255
    assert "[Err]" in err
    assert "Failed to connect to master in 0.3 seconds." in err


@pytest.mark.parametrize("words", [["--size", "0x3"], ["--size", "wide"], ["--pose", "1 2 3"], ["--rate", "0"]])
def test_wrong_options(words, capsys):
    with pytest.raises(SystemExit) as ended:
        gzclient.main(words)
    assert ended.value.code == 255
    assert "Error. Invalid arguments" in capsys.readouterr().err


def test_words_that_roslaunch_gives_all_nodes_are_no_options(capsys):
    words = ["__name:=gazebo_gui", "__log:=/tmp/x.log", "--size", "64x48"]
    _, options = read_command_line(gzclient.make_parser(), words, plugins=("gui_plugin",))
    assert (options.rest, options.size) == ([], (64, 48))
    assert "unrecognized" not in capsys.readouterr().err


def test_help_and_version(capsys):
    for words, found in (["-h"], "--gui-client-plugin"), (["-v"], "Gazebo multi-robot simulator, version"):
        with pytest.raises(SystemExit) as ended:
            gzclient.main(words)
        assert not ended.value.code
        assert found in capsys.readouterr().out


def test_the_ini_file(tmp_path, monkeypatch, caplog):
    path = tmp_path / "my.ini"
    monkeypatch.setenv("GAZEBO_GUI_INI_FILE", str(path))
    assert ini_plugins() == []
    path.write_text("[geometry]\nx=0\n[overlay_plugins]\nfilenames = liba.so: libb.so:\n")
    assert ini_plugins() == ["liba.so", "libb.so"]
    path.write_text("what is this")
    assert ini_plugins() == []
    assert "my.ini cannot be read" in caplog.text


def test_a_copy_of_a_world_keeps_looks_only():
    root = SdfFile.from_string(WORLD.replace("</link>", "<sensor name='s' type='imu'/></link>")).root
    only_looks(root)
    assert [plugin.Get(str, "name") for plugin in root.find("plugin")] == ["teller", "painter"]
    assert not list(root.find("sensor"))


def test_a_place_has_text_and_buttons():
    pressed = []
    place = GUI("mine")
    place.Move(10, 20)
    place.Resize(120, 40)
    place.SetText("Ready")
    place.AddButton("Go", lambda: pressed.append(1))
    place.Press("Go")
    assert (place.position, place.size, place.text, place.Buttons(), pressed) == (
        (10, 20), (120, 40), "Ready", ["Go"], [1],
    )  # fmt: skip
    with pytest.raises(NotFoundError, match="no button 'Stop'"):
        place.Press("Stop")


def test_the_window_waits_for_the_server_and_controls_it():
    done = []
    controls = SimpleNamespace(WaitForConnection=lambda seconds: done.append(seconds > 0), Publish=done.append)
    window = MainWindow(SimpleNamespace(), SimpleNamespace(), controls)
    window.Pause()
    window.Play()
    assert done == [True, msgs.WorldControl(pause=True), True, msgs.WorldControl(pause=False)]


def test_there_is_no_window_outside_a_client():
    assert gui.get_main_window() is gui.get_active_camera() is None
    assert gui.get_world() == ""
    heard = []
    connection = gui.Events.ConnectKeyPress(heard.append)
    gui.Events.keyPress("a")
    gui.Events.DisconnectKeyPress(connection)
    gui.Events.keyPress("b")
    assert heard == ["a"]
    with pytest.raises(AttributeError, match="did you mean 'ConnectKeyPress'"):
        _ = gui.Events.ConnectKeyPres
    assert libgz.World is not None
