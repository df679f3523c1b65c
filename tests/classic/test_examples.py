"""The examples of plugins, run as they stand: each must do what it says."""

import contextlib
import logging
import math
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from master_uri import free_master_uri
from topics import send

import libgz
from libgz.classic import msgs, physics, transport
from libgz.classic.math import Pose3d, Rand
from libgz.classic.ros_names import STAND_INS, WITHOUT_EFFECT
from libgz.reference.classic_api import classic_api
from libgz.reference.classic_pages import classic_pages

EXAMPLES = Path(__file__).parents[2] / "examples" / "plugins"


@pytest.fixture(autouse=True)
def own_places(monkeypatch, tmp_path, caplog):
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    for variable in ("GAZEBO_PLUGIN_PATH", "GAZEBO_MODEL_PATH"):
        monkeypatch.delenv(variable, raising=False)
    caplog.set_level(logging.INFO)
    yield
    # Whatever goes wrong in a plugin is logged, and must not pass for success.
    assert not [record.getMessage() for record in caplog.records if record.levelno >= logging.ERROR]


@contextlib.contextmanager
def example(name, world=None):
    with libgz.World.from_file(EXAMPLES / name / (world or f"{name}.world")) as core:
        yield core, physics.get_world(core.name)


def test_every_example_is_listed_in_the_readme():
    readme = (EXAMPLES / "README.md").read_text()
    folders = {path.name for path in EXAMPLES.iterdir() if path.is_dir() and path.name != "__pycache__"}
    assert folders == {name for name in folders if f"[{name}]({name}/" in readme}


def test_hello_world_says_hello(capsys):
    with example("hello_world", "hello.world"):
        assert capsys.readouterr().out == "Hello World!\n"


def test_world_edit_lets_the_ball_fall_as_on_the_moon(caplog):
    with example("world_edit") as (core, world):
        assert "max_step_size: 0.001 -> 0.002" in caplog.text
        assert world.Physics().GetMaxStepSize() == 0.002
        assert world.Physics().GetRealTimeUpdateRate() == pytest.approx(500.0)
        assert core.engine.iterations == 80
        ball = world.ModelByName("ball")
        core.run(1.0)
        assert ball.WorldPose().Pos().Z() == pytest.approx(1.1 - 1.62 / 2.0, abs=2e-3)


def test_model_push_pushes_both_boxes():
    with example("model_push") as (core, world):
        pusher, near, far = (world.ModelByName(name) for name in ("pusher", "near", "far"))
        core.run(3.0)
        x = pusher.WorldPose().Pos().X()
        assert x == pytest.approx(0.5 * 3.0, abs=0.1)
        # In touch: half a side of the one and half a side of the other apart.
        assert near.WorldPose().Pos().X() == pytest.approx(x + 0.25 + 0.15, abs=0.02)
        assert far.WorldPose().Pos().X() == pytest.approx(x + 0.25 + 0.15 + 0.3, abs=0.02)


def test_model_move_passes_its_waypoints_and_arrives(caplog):
    with example("model_move") as (core, world):
        cart = world.ModelByName("cart")
        for seconds, place in ((2.0, (2.0, 0.0)), (1.0, (2.5, 0.5)), (2.0, (2.5, 2.5))):
            core.run(seconds)
            assert tuple(cart.WorldPose().Pos())[:2] == pytest.approx(place, abs=0.01)
        assert cart.WorldPose().Yaw() == pytest.approx(1.5708, abs=1e-3)
        core.run(0.1)
        assert caplog.text.count("cart has arrived at 2.5 2.5 0.2") == 1


def test_animated_box_goes_round_and_round():
    with example("animated_box") as (core, world):
        box = world.ModelByName("box")
        for corner in ((2.0, 0.0), (2.0, 2.0), (0.0, 2.0), (0.0, 0.0), (2.0, 0.0)):
            core.run(2.0)
            assert tuple(box.WorldPose().Pos())[:2] == pytest.approx(corner, abs=0.01)


def test_factory_inserts_models_by_file_text_document_and_message():
    with example("factory") as (core, world):
        core.step(2)
        names = {model.GetName() for model in world.Models()}
        assert {"ground_plane", "pioneer2dx", "sphere", "another_sphere"} <= names
        assert tuple(world.ModelByName("another_sphere").WorldPose().Pos())[:2] == (2.5, 0.0)
        assert tuple(world.ModelByName("third_sphere").WorldPose().Pos())[:2] == (-2.0, 0.0)
        assert world.ModelByName("pioneer2dx").GetJointCount() == 3
        core.run(1.5)
        assert world.ModelByName("sphere").WorldPose().Pos().Z() == pytest.approx(0.5, abs=0.01)


def test_events_insert_and_delete_at_their_times(caplog):
    with example("events") as (core, world):
        core.step(10)
        assert world.ModelByName("flag") is None
        for _ in range(20):
            core.run(0.1)
            if world.ModelByName("ball") is None:
                break
        assert world.ModelByName("gate").GetJoint("hinge").Position(0) > 0.3
        assert {"flag", "prize"} <= {model.GetName() for model in world.Models()}
        assert world.ModelByName("ball") is None
        notes = [record.getMessage() for record in caplog.records if record.name == "libgz.classic.console"]
        words = [line.split("s: ")[-1] for line in notes]
        assert words.index("insert flag") < words.index("insert prize") < words.index("delete ball")
        assert "there is prize now" in words
        assert "ball is gone" in words


def test_joint_pid_holds_the_arm():
    with example("joint_pid") as (core, world):
        arm = world.ModelByName("arm")
        core.run(5.0)
        assert arm.GetJoint("shoulder").Position(0) == pytest.approx(1.0, abs=0.1)
        assert arm.GetJoint("elbow").Position(0) == pytest.approx(-0.5, abs=0.1)


def test_joint_pid_turns_the_head_at_the_speed_of_the_topic():
    with example("joint_pid") as (core, world):
        neck = world.ModelByName("turret").GetJoint("neck")
        core.run(2.0)
        assert neck.GetVelocity(0) == pytest.approx(0.2, abs=0.05)
        kept = send("~/turret/vel_cmd", msgs.Vector3d(x=3.0))
        core.run(2.0)
        assert neck.GetVelocity(0) == pytest.approx(3.0, abs=0.05)
        del kept


def test_random_velocity_takes_new_directions_and_repeats_them_after_a_reset():
    def directions():
        Rand.Seed(7)
        with example("random_velocity") as (core, world):
            rover, found = world.ModelByName("rover"), []
            for _ in range(4):
                core.run(0.5)
                velocity = rover.WorldLinearVel()
                assert math.hypot(velocity.X(), velocity.Y()) == pytest.approx(0.5, abs=0.02)
                found.append(math.atan2(velocity.Y(), velocity.X()))
                core.run(0.5)
            return found

    first = directions()
    assert len({round(angle, 2) for angle in first}) == 4
    assert first == directions()


def test_set_velocity_has_three_ways():
    with example("set_velocity") as (core, world):
        joints = {name: world.ModelByName(name).GetJoint("hinge") for name in ("instantly", "motor", "pid")}
        core.step(20)
        assert joints["instantly"].GetVelocity(0) == pytest.approx(2.0 * math.exp(-0.02), abs=0.01)
        assert joints["motor"].GetVelocity(0) == pytest.approx(2.0, abs=1e-6)
        assert 0.0 < joints["pid"].GetVelocity(0) < 1.9
        core.run(1.98)
        # Damping 0.1 N m s/rad on 0.1 kg m^2: a time constant of 1 s.
        assert joints["instantly"].GetVelocity(0) == pytest.approx(2.0 * math.exp(-2.0), abs=0.01)
        assert joints["motor"].GetVelocity(0) == pytest.approx(2.0, abs=1e-3)
        assert joints["pid"].GetVelocity(0) == pytest.approx(2.0, abs=0.1)


def test_diff_drive_goes_around_a_square():
    with example("diff_drive") as (core, world):
        robot = world.ModelByName("pioneer2dx")
        corner = math.pi / 2.0 / 0.5
        for place in ((1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0)):
            core.run(1.0 / 0.25)
            assert tuple(robot.WorldPose().Pos())[:2] == pytest.approx(place, abs=0.4)  # wheels slip in turns
            core.run(corner)


def test_pioneer2dx_drives_four_metres_in_twenty_seconds():
    text = (EXAMPLES / "diff_drive" / "diff_drive.world").read_text()
    square = text.partition('<plugin name="square"')[2].partition("</plugin>")[0]
    with libgz.World.from_string(text.replace(f'<plugin name="square"{square}</plugin>', "")) as core:
        robot = physics.get_world().ModelByName("pioneer2dx")
        message = msgs.Pose()
        msgs.Set(message, Pose3d(0.2, 0.0, 0.0, 0.0, 0.0, 0.0))
        kept = send("~/pioneer2dx/vel_cmd", message)
        core.run(20.0)
        x, y, z = robot.WorldPose().Pos()
        assert x == pytest.approx(4.0, abs=0.1)
        assert y == pytest.approx(0.0, abs=0.5)
        assert z == pytest.approx(0.0, abs=0.01)
        del kept


def test_custom_message_is_answered_with_heights():
    with example("custom_message") as (core, _):
        survey, answers = msgs.message_type("survey.msgs.Survey"), []
        node = transport.Node()
        node.Init("default")
        kept = node.Subscribe("~/survey/heights", answers.append)
        publisher = node.Advertise(survey, "~/survey")
        question = survey(count=5)
        msgs.Set(question.begin, (-2.0, 0.0, 0.0))
        msgs.Set(question.end, (2.0, 0.0, 0.0))
        publisher.Publish(question)
        core.step(3)
        (answer,) = answers
        assert list(answer.height) == pytest.approx([0.0, 1.0, 0.0, 0.8, 0.0], abs=1e-6)
        assert [name.partition("::")[0] for name in answer.entity] == [
            "ground_plane", "box", "ground_plane", "ball", "ground_plane",
        ]  # fmt: skip
        assert answer.question == question
        del kept, publisher


def server_of(core):
    return core.companions[0]


def test_contact_reports_the_begin_and_end_of_contacts(caplog):
    with example("contact") as (core, _):
        core.run(2.0)
        notes = [record.getMessage() for record in caplog.records if record.name == "libgz.classic.console"]
        first, last = notes[0], notes[-1]
        assert {*first.split(" touches ")} == {"ball::link::skin", "bumper::link::plate"}
        assert last == first.replace(" touches ", " has left ")


def test_camera_finds_the_red_ball(tmp_path):
    text = (EXAMPLES / "camera" / "camera.world").read_text()
    saving = text.replace(
        'filename="libcamera.so"/>', f'filename="libcamera.so"><save_folder>{tmp_path}</save_folder></plugin>'
    )
    (tmp_path / "camera.world").write_text(saving)
    (tmp_path / "camera.py").write_text((EXAMPLES / "camera" / "camera.py").read_text())
    with libgz.World.from_file(tmp_path / "camera.world") as core:
        (loaded,) = server_of(core).sensors.plugins()
        finder, ball = loaded.plugin, physics.get_world().ModelByName("ball")
        for _ in range(3):
            core.run(0.5)
            x, y, _ = ball.WorldPose().Pos()
            # Up to 0.1 s old: the ball does 0.8 m/s, 3 m away.
            assert finder.bearing == pytest.approx(math.atan2(y, x), abs=0.045)
        assert finder.frames == pytest.approx(15, abs=1)
    assert len([*tmp_path.glob("*.jpg"), *tmp_path.glob("*.png")]) == finder.frames


def test_visual_blinks():
    from libgz.classic.sensors import SensorManager

    with example("visual") as (core, _):
        eye, colors = SensorManager.Instance().GetSensor("eye"), []
        core.run(0.05)
        for _ in range(8):
            core.run(0.1)
            middle = np.frombuffer(eye.ImageData(), np.uint8).reshape(60, 80, 3)[30, 40].astype(int)
            red, green, blue = middle
            assert green < 10
            colors.append("red" if red > blue + 50 else "blue" if blue > red + 50 else "neither")
    assert colors.count("red") == pytest.approx(4, abs=1)
    assert colors.count("blue") == pytest.approx(4, abs=1)
    assert "neither" not in colors


def test_system_gui_watches_the_server(tmp_path):
    folder = EXAMPLES / "system_gui"
    command = [sys.executable, "-m", "libgz.apps.gzserver", "-s", "libsystem_gui.so", "--iters", "100", "--verbose"]
    environment = {
        "PATH": "/usr/bin:/bin", "HOME": str(tmp_path), "GAZEBO_MASTER_URI": "http://127.0.0.1:0",
        "GAZEBO_PLUGIN_PATH": str(folder),
    }  # fmt: skip
    run = subprocess.run(
        [*command, str(folder / "system_gui.world")], capture_output=True, text=True, timeout=60, env=environment
    )
    assert run.returncode == 0, run.stderr
    lines = [line.removeprefix("[Msg] ") for line in run.stdout.splitlines()]
    notes = [
        "world default is there", "default has reached 0.050 s", "default has reached 0.100 s", "100 updates in all",
    ]  # fmt: skip
    places = [lines.index(line) for line in notes]
    assert places == sorted(places)


# The guide -----------------------------------------------------------------------------------------------------------

GUIDE = (EXAMPLES.parent.parent / "docs" / "plugins.md").read_text()


# System plugins are named by the command line alone.
WITHOUT_EXAMPLE = {"ModelPropShop", "RestWebPlugin"}

# Stand-ins that the guide means without their names.
OTHERS_OF_THEIR_KIND = {
    "gazebo_ros_thermal_camera", "gazebo_ros_thermal_depth_camera", "gazebo_ros_triggered_multicamera",
    "roboticsgroup_gazebo_disable_link_plugin", "roboticsgroup_upatras_gazebo_disable_link_plugin",
}  # fmt: skip


def code_of_guide(word):
    """The block of Python code in the guide that holds a word."""
    (block,) = [part.split("```")[0] for part in GUIDE.split("```python\n")[1:] if word in part.split("```")[0]]
    return block


def test_the_guides_first_plugins_run(tmp_path, capsys):
    (tmp_path / "hello_world.py").write_text(code_of_guide("WorldPluginTutorial"))
    (tmp_path / "hover.py").write_text(code_of_guide("class Hover"))
    hello = GUIDE.split("```xml\n")[1].split("```")[0]
    model = """
    <model name='drone'><pose>0 0 1 0 0 0</pose><link name='base'><inertial><mass>3</mass></inertial></link>
      <plugin name='hover' filename='libhover.so'><height>2.5</height></plugin></model></world>"""
    (tmp_path / "hello.world").write_text(hello.replace("</world>", model))
    with libgz.World.from_file(tmp_path / "hello.world") as core:
        core.run(5.0)
        assert capsys.readouterr().out == "Hello World!\n"
        assert physics.get_world().ModelByName("drone").WorldPose().Pos().Z() == pytest.approx(2.5, abs=0.01)


def test_the_guide_lists_all_ready_plugins_and_its_links_exist():
    from libgz.classic.loading import READY

    files = {path.stem.removeprefix("lib") for path in READY.glob("[a-z]*.py")} - {"hooks"}
    notes = {word.lower() for word in re.findall(r"`lib(\w+)\.so`", GUIDE)}
    assert files == notes - {"hello_world"} - STAND_INS.keys() - WITHOUT_EFFECT.keys()
    named = {stem for stem in STAND_INS if stem in notes or f"`...{stem.removeprefix('gazebo_ros')}.so`" in GUIDE}
    assert STAND_INS.keys() - named <= OTHERS_OF_THEIR_KIND
    for target in re.findall(r"\]\(([^)#]+)\)", GUIDE):
        assert (EXAMPLES.parent.parent / "docs" / target).exists(), target
    headings = {
        re.sub(r"[^\w -]", "", line).strip().lower().replace(" ", "-") for line in re.findall("^##+ (.*)$", GUIDE, re.M)
    }
    assert set(re.findall(r"\]\(#([^)]+)\)", GUIDE)) <= headings


def test_the_examples_page_names_every_world():
    text = (EXAMPLES / "README.md").read_text()
    files = [path.relative_to(EXAMPLES).as_posix() for path in EXAMPLES.rglob("*") if path.suffix in (".world", ".py")]
    assert len(files) > 40
    missing = [name for name in files if f"({name})" not in text and name.split("/")[1] not in text]
    assert not missing
    ready = {Path(name).stem for name in files if name.startswith("ready/")}
    assert {name for name in ready if f"[{name}](ready/{name}.world)" not in text} == set()


def test_each_ready_plugin_of_the_guide_has_an_example():
    worlds = "".join(path.read_text() for path in EXAMPLES.rglob("*.world")).lower()
    names = set(re.findall(r"`lib(\w+)\.so`", GUIDE.split("## Ready plugins")[1].split("## Porting")[0]))
    without = {name for name in names if f"lib{name.lower()}.so" not in worlds}
    assert without - STAND_INS.keys() - WITHOUT_EFFECT.keys() == WITHOUT_EXAMPLE


def test_each_class_of_the_table_has_a_page_in_its_modules_index():
    pages = classic_pages()
    holders = {
        row.holder for row in classic_api() if row.state in ("present", "differs", "old") and "(" not in row.holder
    }
    for holder in holders:
        module, _, name = holder.rpartition(".")
        assert module in ("event", "common") or f"[{name}](" in pages[f"{module}/README.md"], holder
    assert {"gui/MainWindow.md", "physics/Link.md", "plugin/ModelPlugin.md", "msgs/README.md"} <= pages.keys()
    link = pages["physics/Link.md"]
    assert "| `AddForce` |" in link
    assert "`GetWorldLinearVel`" in link
    assert "From [Entity](../physics/Entity.md): " in link
    assert "not in libgz" in link


# The client ----------------------------------------------------------------------------------------------------------

PRESS = """
import time
from libgz.classic.gui.client import Client
from libgz.classic.transport import connect
with connect(timeout=60.0), Client((80, 60)) as client:
    place, end = client.window.places["overlay"], time.monotonic() + 60.0
    place.Press("Spawn sphere")
    while time.monotonic() < end and not (client.window.scene.GetVisual("sphere_0") and place.text):
        client.frame()
        time.sleep(0.01)
    print(place.position, place.text.endswith(" s"), client.window.scene.GetVisual("sphere_0"))
"""


@pytest.fixture
def system_gui_server(tmp_path, monkeypatch):
    """A server with the world of system_gui, on a port of its own."""
    monkeypatch.setenv("GAZEBO_MASTER_URI", free_master_uri())
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", str(EXAMPLES / "system_gui"))
    command = [sys.executable, "-m", "libgz.apps.gzserver", str(EXAMPLES / "system_gui" / "system_gui.world")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as server:
        yield server
        server.send_signal(signal.SIGINT)
        assert server.communicate(timeout=60)[1] == ""


def test_overlay_shows_the_time_and_spawns_a_sphere(system_gui_server):
    run = subprocess.run([sys.executable, "-c", PRESS], capture_output=True, text=True, timeout=120)
    assert run.stdout.startswith("(10, 10) True <Visual 'sphere_0'"), run.stderr


def test_client_frames_saves_five_frames(system_gui_server, tmp_path):
    folder = tmp_path / "pictures"
    command = [sys.executable, "-m", "libgz.apps.gzclient", "-g", "libclient_frames.so", f"--frames-to={folder}"]
    with subprocess.Popen(
        [*command, "--size", "80x60"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as client:
        end = time.monotonic() + 60.0
        while time.monotonic() < end and client.poll() is None and len([*folder.glob("*")]) < 5:
            time.sleep(0.05)
        time.sleep(0.3)  # for more, if they were to come
        client.send_signal(signal.SIGINT)
        error = client.communicate(timeout=60)[1]
    assert len([*folder.glob("*.jpg")]) == 5, error
