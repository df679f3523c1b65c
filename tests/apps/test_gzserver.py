"""The gzserver command: options, messages, exit codes, System plugins."""

import signal
import socket
import subprocess
import textwrap
import time
from pathlib import Path

import pytest
from classic_wire import PATIENCE, Connection, Publication, Subscription, close_all, new
from gzserver_process import SERVER, new_environment, run
from imageio import v3

ROOT = Path(__file__).parents[2]
HELLO = ROOT / "examples" / "plugins" / "hello_world"
EMPTY = "<sdf version='1.6'><world name='default'>{}</world></sdf>"


@pytest.fixture
def place(tmp_path):
    """The environment of the server."""
    return new_environment(tmp_path)


def connected(port):
    """A connection to the master of a server that has just been started."""
    end = time.monotonic() + PATIENCE
    while True:
        try:
            return Connection(port)
        except OSError:
            assert time.monotonic() < end
            time.sleep(0.02)


def plugin(tmp_path, name, text):
    (tmp_path / f"{name}.py").write_text("from libgz.classic import *\n" + textwrap.dedent(text))


def world(tmp_path, inside=""):
    path = tmp_path / "w.world"
    path.write_text(EMPTY.format(inside))
    return path


def test_the_tutorial_prints_its_lines(place):
    place["GAZEBO_PLUGIN_PATH"] = str(HELLO)
    done = run(place, HELLO / "hello.world", "--verbose", "--iters", 10)
    port = place["GAZEBO_MASTER_URI"].rpartition(":")[2]
    assert done.returncode == 0
    assert done.stdout.splitlines() == [
        "[Msg] Waiting for master.",
        f"[Msg] Connected to gazebo master @ http://127.0.0.1:{port}",
        "[Msg] Publicized address: 127.0.0.1",
        "Hello World!",
    ]
    assert done.stderr.startswith("Gazebo multi-robot simulator, version")


def test_without_verbose_only_errors_and_output_of_plugins_are_printed(place, tmp_path):
    plugin(tmp_path, "bad", "class P(WorldPlugin):\n    def Load(self, w, s): 1 / 0\nGZ_REGISTER_WORLD_PLUGIN(P)")
    lines = "<plugin name='bad' filename='libbad.so'/><plugin name='gone' filename='libgone.so'/>"
    done = run(place, world(tmp_path, lines), "--iters", 5)
    assert done.returncode == 0
    assert done.stdout == ""
    assert "Exception occured in the Load function of plugin with name[bad] and filename[libbad.so]." in done.stderr
    assert "ZeroDivisionError" in done.stderr
    assert "Failed to load plugin libgone.so" in done.stderr


def test_messages_go_to_the_log_file_too(place, tmp_path):
    run(place, world(tmp_path), "--iters", 1)
    port = place["GAZEBO_MASTER_URI"].rpartition(":")[2]
    text = (tmp_path / "home" / ".gazebo" / f"server-{port}" / "default.log").read_text()
    assert "Waiting for master." in text
    assert f"Loading world file [{tmp_path / 'w.world'}]" in text


@pytest.mark.parametrize(
    ("words", "code", "stream", "text"),
    [
        (["-v"], 0, "stdout", "Gazebo multi-robot simulator, version"),
        (["-h"], 0, "stdout", "gzserver -- Run the Gazebo server."),
        (["--steps", "1"], 0, "stderr", ""),
        (["--step", "1", "nowhere.world"], 255, "stderr", "Could not open file[nowhere.world]"),
        (["--itres", "5", "--iters", "1"], 0, "stderr", "unrecognized arguments: --itres 5; did you mean '--iters'"),
        (["--rso", "nowhere.world"], 255, "stderr", "Could not open file[nowhere.world]"),
        (["--iters", "1", "--gl", "glx"], 255, "stderr", "'glx' is not allowed; allowed are auto"),
        (["--seed", "many"], 255, "stderr", "Error. Invalid arguments"),
        (["nowhere.world"], 255, "stderr", "Could not open file[nowhere.world]"),
        (["emptyy.world"], 255, "stderr", "did you mean 'empty'"),
        (["/tmp"], 255, "stderr", "Could not open file[/tmp]: it is a folder"),
        (
            ["--iters", "1", "--record_resources", "--lockstep"],
            0,
            "stderr",
            "--record_resources has no effect: models and meshes are not copied",
        ),
        (["--iters", "1", "-e", "bullet"], 0, "stderr", "Unregistered physics engine [bullet], the default will be"),
        (["--iters", "1", "-o", "fast"], 0, "stderr", "Specified profile [fast] was not found"),
        (["--iters", "1", "--my-own=5"], 0, "stdout", ""),
    ],
)
def test_options_and_exit_codes(words, code, stream, text, place):
    done = run(place, *words)
    assert done.returncode == code
    assert text in getattr(done, stream)


def test_the_word_after_an_unknown_option_is_not_the_world(place, tmp_path):
    done = run(place, "--my-own", "5", world(tmp_path), "__name:=gazebo", "--iters", 1)
    assert done.returncode == 0
    assert "unrecognized arguments: --my-own 5 __name:=gazebo; there is no System plugin" in done.stderr


def test_gl_none_runs_a_world_with_cameras(place, tmp_path):
    camera = (
        "<sensor name='c' type='camera'><camera><image><width>8</width><height>8</height></image></camera></sensor>"
    )
    path = world(tmp_path, f"<model name='m'><static>1</static><link name='l'>{camera}</link></model>")
    done = run(place, "--gl", "none", "--iters", 5, path)
    assert done.returncode == 0
    assert "[Err]" not in done.stderr


def test_an_unreadable_world_is_reported(place, tmp_path):
    path = tmp_path / "broken.world"
    path.write_text("<sdf version='1.6'><world name='w'><model name='m'></world></sdf>")
    done = run(place, path)
    assert done.returncode == 255
    assert "broken.world:1" in done.stderr


def test_a_port_in_use_is_reported(place, tmp_path):
    with socket.socket() as other:
        other.bind(("127.0.0.1", int(place["GAZEBO_MASTER_URI"].rpartition(":")[2])))
        other.listen()
        done = run(place, world(tmp_path), "--iters", 1)
    assert done.returncode == 255
    assert "Unable to start server[bind: Address already in use]." in done.stderr


def test_system_plugins_come_first_and_in_order(place, tmp_path):
    plugin(
        tmp_path,
        "sys_plugin",
        """
        class P(SystemPlugin):
            def __init__(self):
                print("made", flush=True)
            def Load(self, argc, argv):
                print("Load", argc == len(argv), argv[0], "--verbose" in argv, flush=True)
                names = ("WorldCreated", "WorldUpdateBegin", "Stop")
                self.kept = [getattr(event.Events, f"Connect{name}")(self.hear(name)) for name in names]
                self.seen = set()
            def hear(self, name):
                def heard():
                    if name not in self.seen:
                        print(name, flush=True)
                    self.seen.add(name)
                return heard
            def Init(self):
                print("Init", flush=True)
        GZ_REGISTER_SYSTEM_PLUGIN(P)
        """,
    )
    done = run(place, "--verbose", "-s", "libsys_plugin.so", "-s", "libsys_none.so", world(tmp_path), "--iters", 3)
    assert [line for line in done.stdout.splitlines() if not line.startswith("[Msg] Pub")] == [
        "made", "Load True gzserver True", "[Msg] Waiting for master.",
        f"[Msg] Connected to gazebo master @ {place['GAZEBO_MASTER_URI'].replace('localhost', '127.0.0.1')}",
        "Init", "WorldCreated", "WorldUpdateBegin", "Stop",
    ]  # fmt: skip
    assert "Failed to load plugin libsys_none.so" in done.stderr


def test_interrupts_end_it_in_order(place, tmp_path):
    plugin(
        tmp_path,
        "watch",
        """
        class P(WorldPlugin):
            def Load(self, world, sdf):
                self.world = world
                self.kept = [event.Events.ConnectStop(lambda: print("stop", flush=True)),
                             event.Events.ConnectSigInt(lambda: print("sigint", flush=True))]
                print("paused", world.IsPaused(), flush=True)
        GZ_REGISTER_WORLD_PLUGIN(P)
        """,
    )
    path = world(tmp_path, "<plugin name='watch' filename='libwatch.so'/>")
    with subprocess.Popen([*SERVER, str(path), "-u"], env=place, stdout=subprocess.PIPE, text=True) as server:
        assert server.stdout.readline() == "paused True\n"
        time.sleep(0.2)
        server.send_signal(signal.SIGINT)
        assert server.stdout.read() == "stop\nsigint\n"
        assert server.wait(30) == 0


def test_a_rate_that_keeps_the_next_step_waiting_for_ever_can_be_changed(place, tmp_path):
    port = int(place["GAZEBO_MASTER_URI"].rpartition(":")[2])
    with subprocess.Popen([*SERVER, str(world(tmp_path))], env=place) as server:
        try:
            master = connected(port)
            heard = Subscription(master, "/gazebo/default/world_stats", "WorldStatistics")
            physics = Publication(master, "/gazebo/default/physics", "Physics")
            physics.publish(new("Physics", real_time_update_rate=1e-9))
            heard.socket.settimeout(1.0)
            with pytest.raises(TimeoutError):  # no more steps
                heard.until(lambda _: False)
            heard.socket.settimeout(PATIENCE)
            physics.publish(new("Physics", real_time_update_rate=1000.0))
            first = heard.next().iterations
            assert heard.until(lambda message: message.iterations > first + 10)
        finally:
            server.kill()
            close_all()


def test_a_plugin_can_stop_the_server(place, tmp_path):
    plugin(
        tmp_path,
        "end",
        """
        class P(WorldPlugin):
            def Load(self, world, sdf):
                self.world = world
                self.connection = event.Events.ConnectWorldUpdateEnd(self.OnEnd)
            def OnEnd(self):
                if self.world.Iterations() == 7:
                    print("seven", self.world.SimTime(), flush=True)
                    self.world.Stop()
        GZ_REGISTER_WORLD_PLUGIN(P)
        """,
    )
    done = run(place, world(tmp_path, "<plugin name='end' filename='libend.so'/>"))
    assert done.returncode == 0
    assert done.stdout.startswith("seven 0 7000000")


def test_legacy_worldfiles_run_too(place):
    done = run(place, ROOT / "worlds" / "pioneer2at.world", "--iters", 5)
    assert (done.returncode, done.stderr) == (0, "")


def test_a_video_of_the_whole_world_beside_classics_record(place, tmp_path):
    video, box = tmp_path / "view.mp4", "<geometry><box><size>1 1 1</size></box></geometry>"
    file = world(
        tmp_path, f"<model name='b'><static>1</static><link name='l'><visual name='v'>{box}</visual></link></model>"
    )
    done = run(place, "--record", f"view={video}", "--iters", 200, file)
    assert (done.returncode, done.stderr) == (0, "")
    frames = v3.imread(video, plugin="pyav")
    assert frames.shape == (5, 480, 640, 3)  # 0.2 s at 25 Hz
    assert frames[-1].std() > 5.0
    assert not list(tmp_path.rglob("state.log"))


EYE = """<model name='robot'><static>1</static><link name='l'>
<sensor name='eye' type='camera'><update_rate>{rate}</update_rate>
<camera><image><width>64</width><height>48</height></image><clip><near>.1</near><far>9</far></clip></camera></sensor>
</link></model>"""


@pytest.mark.parametrize(("rate", "name", "count"), [(10, "eye", 2), (0, "default::robot::l::eye", 5)])
def test_a_video_of_a_camera_sensor(place, tmp_path, rate, name, count):
    video = tmp_path / "eye.mp4"
    done = run(place, "--record", f"{name}={video}", "--iters", 230, world(tmp_path, EYE.format(rate=rate)))
    assert (done.returncode, done.stderr) == (0, "")
    assert v3.imread(video, plugin="pyav").shape == (count, 48, 64, 3)


def test_classics_record_beside_videos(place, tmp_path):
    file = world(tmp_path, EYE.format(rate=10))
    assert (
        "no camera has the id 'cam9'; there are default::robot::l::eye"
        in run(place, "--record=cam9=a.mp4", "--iters", 1, file).stderr
    )
    run(place, "--record", "--record_path", tmp_path / "log", "--iters", 1, file)
    assert list(tmp_path.rglob("state.log"))
