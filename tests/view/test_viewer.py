"""The viewer without a browser: what it sends, what it does, and what it survives."""

import base64
import contextlib
import io
import json
import math
import time
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from view_sockets import Socket, running, scene_of, showing, state_of

import libgz
from libgz.apps.world_control import WorldControl
from libgz.base.errors import GazeboError, ServerGoneError
from libgz.base.files import installed_worlds
from libgz.rendering.image import depth_text, jpeg_text
from libgz.transport.control import Control, Request
from libgz.view import driving, server as server_module
from libgz.view.local import LocalSource
from libgz.view.server import ServerControls
from libgz.view.viewer import PORT, Viewer

ROBOT = """<gz:world xmlns:gz='g' xmlns:model='m'><model:GroundPlane><id>ground</id></model:GroundPlane>
<model:Pioneer2AT><id>robot1</id><model:SickLMS200><id>laser1</id></model:SickLMS200></model:Pioneer2AT></gz:world>"""
STATIC = """<sdf version="1.6"><world name="w"><model name="box"><static>1</static><pose>7 -2 0.5 0 0 0</pose>
<link name="link"><visual name="v"><geometry><box><size>1 1 1</size></box></geometry></visual>
<sensor name="eye" type="camera"><camera><horizontal_fov>1</horizontal_fov>
<image><width>40</width><height>20</height></image></camera></sensor></link></model></world></sdf>"""


class Interfaces:
    """Controls of a world of this process: its interfaces, and requests that are kept."""

    abilities = frozenset({"interfaces", "pause", "contacts", "inventory"})

    def __init__(self, world):
        self._world, self.asked, self.error = world, [], None

    def interface(self, kind, id):
        return self._world.interface(kind, id)

    def ask(self, verb, argument="-", **content):
        self.asked.append(verb)
        if verb == "contacts":
            return [[0, 0, 0, 0, 0, 1, 0.001]]
        if verb == "inventory":
            return {"drives": [], "keys": False}
        if self.error is not None:
            raise self.error
        return None

    def reconnect(self):
        pass


class Readings:
    """Controls that answer with the image of a camera and the ranges of a laser."""

    abilities = frozenset({"readings", "problems"})

    def __init__(self, _world):
        self.image = np.zeros((20, 40, 3), np.uint8)
        self.problems = []

    def ask(self, verb, _argument="-", **content):
        if verb == "problems":
            return {"problems": self.problems[content["since"] :], "count": len(self.problems)}
        names = content["names"]
        images = {name: jpeg_text(self.image.tobytes(), 20, 40) for name in names if "eye" in name}
        return {"images": images, "ranges": {name: [1.0, float("inf"), 2.123456] for name in names if "laser" in name}}

    def interface(self, kind, id):
        raise GazeboError("there is none")

    def reconnect(self):
        pass


def until(condition, what):
    end = time.monotonic() + 60.0
    while not (value := condition()):
        assert time.monotonic() < end, what
        time.sleep(0.005)
    return value


def test_a_page_gets_scene_and_states():
    with showing(ROBOT) as (world, viewer), Socket(viewer.watch_url) as page:
        scene = scene_of(page.until("scene")["scene"])
        entities = {entity["id"]: entity for entity in scene["entities"]}
        [rays] = [sensor["data"]["file"] for sensor in entities["laser1"]["sensors"]]
        assert scene["assets"][rays].startswith("assets/")
        world.step(50)
        row = entities["robot1"]["bodies"][0]["row"]
        raw = page.until(lambda m: "state" in m and state_of(m["state"])[1][0] == 50)["state"]
        head, times, bodies, joints = state_of(raw)
        assert head[1] == scene["revision"]
        assert times[1] == world.GetSimTime()
        observed = viewer.source.state()
        assert bodies[row] == pytest.approx(observed.bodies[row], rel=1e-6, abs=1e-7)
        assert joints == pytest.approx(observed.joints, rel=1e-6, abs=1e-7)


@pytest.mark.parametrize(
    ("text", "title"),
    [(ROBOT, "my.old"), (STATIC.replace('"w"', '"default"'), "my.old"), (STATIC, "w")],
)
def test_a_page_is_titled_as_the_world_or_its_file(tmp_path, text, title):
    path = tmp_path / "my.old.world"
    path.write_text(text)
    with libgz.World.from_file(path) as world, running(LocalSource(world)) as viewer, Socket(viewer.watch_url) as page:
        hello = page.until(lambda m: m.get("hello", {}).get("title", " - libgz") != " - libgz")  # that of the scene
        assert hello["hello"]["title"] == f"{title} - libgz"


def test_a_new_model_comes_with_a_new_scene():
    with showing(ROBOT) as (world, viewer), Socket(viewer.watch_url) as page:
        page.until("scene")
        world.InsertModel("<model:SimpleSolid><id>box1</id></model:SimpleSolid>")
        world.step()
        has_box = lambda m: "scene" in m and "box1" in str(scene_of(m["scene"])["entities"])  # noqa: E731
        scene = scene_of(page.until(has_box)["scene"])  # a page that comes before the first frame gets the first twice
        assert state_of(page.until("state")["state"])[0][1] == scene["revision"]


def test_a_viewer_survives_whatever_a_frame_or_an_action_raises(monkeypatch, caplog):
    with (
        libgz.World.from_string(STATIC) as world,
        contextlib.redirect_stdout(io.StringIO()),
        Viewer(LocalSource(world), port=18960, wait=True) as viewer,
    ):
        viewer.tick()
        calls = []

        def fail(*_):
            calls.append(1)
            raise ZeroDivisionError("of a page")

        monkeypatch.setattr(viewer.channels, "show", fail)
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


def test_a_robot_is_driven_and_stops_when_its_page_is_silent_hidden_or_closed(monkeypatch):
    monkeypatch.setattr(driving, "STALE", math.inf)
    with showing(ROBOT, Interfaces) as (world, viewer):
        data = world.interface("position", "robot1").data
        command = data.cmd_vel_pos
        with Socket(viewer.url) as page:
            robots = page.until(lambda m: m.get("robots", {}).get("list"))["robots"]
            assert robots["robot"] == "robot1 (position)"
            page.send({"speeds": {"linear": 0.5, "angular": 1.0}})
            page.send({"drive": [1, -0.5, 0]})
            until(lambda: command[0] == 0.5 and data.cmd_vel_rot[2] == -0.5, "the page drives")
            page.send({"visible": False})
            until(lambda: command[0] == 0.0, "a hidden page stops the robot")
            page.send({"visible": True})
            page.send({"drive": [1, 0, 0]})
            until(lambda: command[0] == 0.5, "the page drives again")
            monkeypatch.setattr(driving, "STALE", 0.0)
            until(lambda: command[0] == 0.0, "a silent page stops the robot")
            monkeypatch.setattr(driving, "STALE", math.inf)
            page.send({"drive": [99, 0, 0]})
            until(lambda: command[0] == 0.5, "full deflection at most")
        until(lambda: command[0] == 0.0, "a closed page stops the robot")
        with Socket(viewer.url) as page:
            page.send({"robot": ""})
            page.send({"drive": [1, 0, 0]})
            page.ask("pause", "on")
            assert command[0] == 0.0  # nobody is driven


def test_a_page_that_only_watches_drives_nothing():
    with showing(ROBOT, Interfaces) as (world, viewer), Socket(viewer.watch_url) as page:
        page.until("hello")
        page.send({"drive": [1, 0, 0]})
        page.ask("pause")
        time.sleep(0.1)
        assert world.interface("position", "robot1").data.cmd_vel_pos[0] == 0.0


def test_a_server_that_does_not_say_in_time_what_it_does_is_only_watched(server, monkeypatch):
    """It may be one of --watch-only, whose first step takes long."""
    monkeypatch.setattr(server_module, "PATIENCE", 0.01)
    assert ServerControls(server.server_id).abilities == {"interfaces"}
    with contextlib.closing(Control(server.path)):
        assert ServerControls(server.server_id).abilities == frozenset()


def test_fields_of_interfaces_are_listed_and_sent():
    with showing(ROBOT, Interfaces) as (world, viewer), Socket(viewer.watch_url) as page:
        fields, _ = page.ask("fields", "robot1")
        found = {field["key"]: field for field in fields}
        assert found["position.robot1.pos[#]"]["unit"] == "m"
        assert found["laser.laser1.range_count"]["whole"]  # of what it carries
        assert found["laser.laser1.ranges[#]"]["count"] == 401  # as none was measured yet
        assert found["sonar.robot1.sonar_pos[#][1]"]["count"] == 16
        wrong = ["position.x.pos[0]", "laser.laser1.ranges[999]", "laser.laser1.head", "laser.laser1.ranges/__class__"]
        page.send({"want": "fields", "names": ["position.robot1.pos[0]", "laser.laser1.ranges[3]", *wrong]})
        world.interface("position", "robot1").command(vx=0.5)
        world.step(100)
        wanted = lambda m: m.get("series", {}).get("position.robot1.pos[0]", [0])[0] == world.GetSimTime()  # noqa: E731
        series = page.until(wanted)["series"]
        assert series["position.robot1.pos[0]"][1] > 0.5
        assert series.keys() == {"position.robot1.pos[0]", "laser.laser1.ranges[3]"}


def test_ranges_contacts_and_rings_are_sent():
    with showing(ROBOT, Interfaces) as (world, viewer), Socket(viewer.watch_url) as page:
        page.send({"want": "ranges", "names": ["laser.laser1", "sonar.robot1", "laser.none"]})
        page.send({"want": "contacts", "names": ["*"]})
        world.step(50)
        sent = page.until(lambda m: m.get("ranges"))
        assert list(sent["ranges"]) == ["laser.laser1"]
        assert max(sent["ranges"]["laser.laser1"]) > 1.0
        assert len(sent["rings"]["sonar.robot1"]["positions"]) == len(sent["rings"]["sonar.robot1"]["ranges"]) == 16
        assert page.until("contacts")["contacts"] == [[0, 0, 0, 0, 0, 1, 0.001]]


def test_images_and_ranges_of_sensors_are_sent_once():
    with showing(STATIC, Readings) as (_, viewer), Socket(viewer.watch_url) as page:
        names = ["box::link::eye"]
        page.send({"want": "images", "names": names})
        page.send({"want": "ranges", "names": ["box::link::laser"]})
        raw = page.until("image")["image"]
        assert raw[8 : 8 + raw[4]].decode() == names[0]
        assert np.asarray(Image.open(io.BytesIO(raw[8 + raw[4] :]))).shape == (20, 40, 3)
        page.until(lambda m: m.get("ranges") == {"box::link::laser": [1.0, -1.0, 2.1235]})
        viewer.controls.image = np.full((20, 40, 3), 200, np.uint8)
        raw = page.until("image")["image"]  # what is the same is not sent again
        assert np.asarray(Image.open(io.BytesIO(raw[8 + raw[4] :]))).mean() == pytest.approx(200, abs=2)


def test_messages_of_the_world_reach_pages_that_come_later_too():
    with showing(STATIC, Readings) as (_, viewer):
        viewer.controls.problems.append({"number": 0, "level": "error", "text": "<b>x</b>", "file": "a.py", "line": 3})
        with Socket(viewer.watch_url) as page:
            page.send({"want": "console", "names": ["*"]})
            assert page.until("messages")["messages"][0]["text"] == "<b>x</b>"
        with Socket(viewer.watch_url) as page:
            page.send({"want": "console", "names": ["*"]})
            assert len(page.until("messages")["messages"]) == 1


class Panel:
    """What a GUI plugin shows."""

    visible, text = True, "<i>"

    def __init__(self):
        self.images = {"camera": np.zeros((4, 6, 3), np.uint8)}
        self.plots = {"height": (np.array([0.0, 1.0]), {"z": np.array([1.0, np.nan])})}
        self.pressed = []

    def Buttons(self):
        return ["Spawn"]

    def Press(self, label):
        self.pressed.append(label)


def test_panels_of_gui_plugins_are_shown_and_their_buttons_act():
    panel = Panel()
    with showing(STATIC, Readings, overlays=lambda: {"status": panel}) as (_, viewer), Socket(viewer.url) as page:
        assert "press" in page.until("hello")["hello"]["abilities"]
        page.send({"want": "overlays", "names": ["*"]})
        [shown] = page.until("overlays")["overlays"]
        assert (shown["name"], shown["text"], shown["buttons"]) == ("status", "<i>", ["Spawn"])
        assert shown["images"]["camera"].startswith("data:image/jpeg;base64,")
        assert shown["plots"] == {"height": {"x": [0.0, 1.0], "lines": {"z": [1.0, None]}}}
        assert page.ask("press", "status", label="Spawn") == (None, None)
        assert "there is no button" in page.ask("press", "status", label="Delete")[1]
        assert panel.pressed == ["Spawn"]
        panel.visible = False
        assert page.until("overlays")["overlays"] == []


def test_parts_of_what_a_model_carries_are_listed_and_moved():
    with (
        libgz.World.from_file(installed_worlds() / "canonvcc4.world") as world,
        running(LocalSource(world), Interfaces(world)) as viewer,
        Socket(viewer.url) as page,
    ):
        page.until("scene")
        parts, _ = page.ask("parts", "cam1")
        assert [part["label"] for part in parts] == [f"cam1 {name}" for name in ("pan", "tilt", "zoom")]
        assert page.ask("steer", parts[0]["key"], value=99.0) == (None, None)
        assert world.interface("ptz", "cam1").data.cmd_pan == pytest.approx(parts[0]["high"])
        assert "there is no part" in page.ask("steer", "ptz.cam1/7", value=0)[1]


def test_a_refusal_is_one_sentence_to_the_page_that_asked():
    with showing(ROBOT, Interfaces) as (_, viewer), Socket(viewer.url) as page:
        viewer.controls.error = GazeboError("the world stands still")
        assert page.ask("pause", "on") == (None, "the world stands still")
        viewer.controls.error = ZeroDivisionError()
        assert page.ask("pause", "on") == (None, "request pause failed; the viewer's log says why")
        viewer.controls.error = None
        assert page.ask("pause", "on") == (None, None)


def test_a_server_that_ends_and_comes_back():
    class Lost(LocalSource):
        lost = False

        def state(self):
            if self.lost:
                raise ServerGoneError("it has ended")
            return super().state()

        def reconnect(self, timeout=0.0):
            if self.lost:
                raise ServerGoneError("there is none")

    with libgz.World.from_string(STATIC) as world:
        source = Lost(world)
        with running(source) as viewer, Socket(viewer.url) as page:
            page.until("scene")
            source.lost = True
            assert page.until(lambda m: m.get("status", {}).get("level") == "ended")
            source.lost = False
            page.until("scene")
            page.until(lambda m: m.get("status", {}).get("level") == "")


def test_an_image_becomes_jpeg_for_a_page():
    assert jpeg_text(None, 4, 4) == jpeg_text(b"12345", 4, 4) == ""
    grey = np.full((4, 6), 100, np.uint8)
    shown = np.asarray(Image.open(io.BytesIO(base64.b64decode(jpeg_text(grey.tobytes(), 4, 6)))))
    assert shown.shape == (4, 6, 3)
    assert shown.mean() == pytest.approx(100, abs=2)


def test_depths_become_an_image_for_a_page():
    assert depth_text(np.zeros(3, np.float32), 4, 4) == ""
    assert depth_text(np.full((2, 2), np.inf, np.float32), 2, 2)
    camera = """<sensor name='eye' type='depth'><always_on>1</always_on><update_rate>50</update_rate><camera>
    <horizontal_fov>1.2</horizontal_fov><image><width>64</width><height>48</height></image>
    <clip><near>0.1</near><far>20</far></clip></camera></sensor>"""
    box = "<visual name='v'><geometry><box><size>1 1 1</size></box></geometry></visual>"
    wall = "<visual name='v'><geometry><box><size>1 40 40</size></box></geometry></visual>"
    models = "".join(
        f"<model name='m{i}'><static>1</static><pose>{x} 0 0 0 0 0</pose><link name='l'>{part}</link></model>"
        for i, (x, part) in enumerate(((0, camera), (3, box), (9, wall)))
    )
    with libgz.World.from_string(f"<sdf version='1.6'><world name='w'>{models}</world></sdf>") as world:
        control, name = WorldControl(world), "m0::l::eye"
        request = Request("readings", "-", json.dumps({"names": [name]}).encode())
        control.obey(request)
        world.step(200)
        shown = json.loads(control.obey(request))["images"][name]
        image = np.asarray(Image.open(io.BytesIO(base64.b64decode(shown))).convert("L")).astype(int)
    assert image.shape == (48, 64)
    assert image[24, 32] > 240  # the box is near
    assert image[2, 2] < 15


def test_the_container_has_the_view_and_its_port():
    text = (Path(__file__).parents[2] / "Dockerfile").read_text()
    assert "/src[view]" in text
    assert f"EXPOSE {PORT}\n" in text
