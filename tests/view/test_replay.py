"""Logs in the browser: as a page of their own without a server, and through the viewer."""

import base64
import html
import json
import os
import re

import numpy as np
import pytest
from commands import run_libgz
from view_pages import browser, button, needs_chromium, opened, served, status, wait_for
from view_sockets import scene_of, state_of

import libgz
from libgz.base.files import installed_worlds
from libgz.recording.capture import Capture
from libgz.transport.server import free_server_id

pytestmark = pytest.mark.filterwarnings("ignore")


EYE = """<?xml version="1.0"?><gz:world xmlns:gz="http://playerstage.sourceforge.net/gazebo/xmlschema/#gz"
 xmlns:model="http://playerstage.sourceforge.net/gazebo/xmlschema/#model">
<model:GroundPlane><id>ground</id></model:GroundPlane>
<model:SimpleSolid><id>box</id><xyz>3 0 0.5</xyz></model:SimpleSolid>
<model:Pioneer2AT><id>robot1</id><model:SonyVID30><id>cam1</id><xyz>0.15 0 0.2</xyz><imageSize>32 24</imageSize>
</model:SonyVID30></model:Pioneer2AT></gz:world>"""


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("log") / "run.mcap"
    world = libgz.World.from_file(installed_worlds() / "pioneer2at.world")
    with world, Capture(world, path) as log:
        world.interface("position", "robot1").command(vx=0.5)
        for _ in range(200):
            world.step()
            log.take()
    return path


@pytest.fixture(scope="module")
def chromium():
    with browser() as found:
        yield found


def replayed(page_file):
    """What a replay's page has in itself."""
    [text] = re.findall(r'<script type="application/json" id="recording">(.*?)</script>', page_file.read_text())
    return json.loads(text)


def test_a_replay_has_the_run_in_one_file(recorded, tmp_path):
    page_file = tmp_path / "replay.html"
    done = run_libgz("play", recorded, "--html", page_file, "--frames", 10, "--show", "trails", "--show", "lasers")
    assert done.returncode == 0, done.stderr
    text = page_file.read_text()
    assert "default-src 'none'" in text
    assert "unsafe" not in re.search(r'<meta http-equiv="Content-Security-Policy" content="([^"]*)"', text)[1]
    assert "<title>default - replay</title>" in text
    found = replayed(page_file)
    assert found["switches"] == ["trails", "lasers"]
    scene = scene_of(base64.b64decode(found["moments"][0][1]["scene"]))
    assert set(scene["assets"].values()) == set(found["assets"])
    [robot] = [entity for entity in scene["entities"] if entity["id"] == "robot1"]
    row = robot["bodies"][0]["row"]
    path = [[time, *state_of(base64.b64decode(sent["state"]))[2][row, :3]] for time, sent in found["moments"]]
    path = np.array(path)
    assert path[:, 0] == pytest.approx(np.arange(41) / 10)
    assert np.ptp(path[:, 1]) == pytest.approx(0.5 * 3.9, abs=0.1)
    ranges = [json.loads(sent["ranges"])["ranges"]["laser.laser1"] for _, sent in found["moments"] if "ranges" in sent]
    assert len(ranges) > 20
    assert ranges[0] != ranges[-1]


def test_every_module_of_a_replay_is_in_it(recorded, tmp_path):
    page_file = tmp_path / "replay.html"
    assert run_libgz("play", recorded, "--html", page_file, "--to", 0.1).returncode == 0
    imports = json.loads(re.search(r'<script type="importmap">(.*?)</script>', page_file.read_text())[1])["imports"]
    assert "libgz/app.js" in imports
    for name, address in imports.items():
        text = base64.b64decode(address.partition("base64,")[2]).decode()
        for wanted in re.findall(r"""(?m)^(?:import\s*|(?:import|export|\}).*?\bfrom\s*)["']([^"'\n]+)["']""", text):
            assert wanted in imports, f"{name} imports {wanted}"


def test_a_replay_shows_the_images_of_cameras(tmp_path):
    world = libgz.World.from_string(EYE)
    with world, Capture(world, tmp_path / "run.mcap") as log:
        for step in range(60):
            if step == 20:
                world.SetModelPose(world.model("box"), libgz.GzPose(libgz.GzVector(1.0, 0.0, 0.5)))
            world.step()
            log.take()
    done = run_libgz("play", tmp_path / "run.mcap", "--html", tmp_path / "a.html", "--frames", 10, "--show", "frusta")
    assert done.returncode == 0, done.stderr
    images = [sent["image cam1"] for _, sent in replayed(tmp_path / "a.html")["moments"] if "image cam1" in sent]
    assert 2 <= len(images) <= 6  # 5 a second at most, and only what has changed


def test_names_of_a_world_are_no_markup_in_a_replay(tmp_path):
    name = "</script><script>alert(1)</script>"
    world = libgz.World.from_string(f"<sdf version='1.6'><world name='{html.escape(name)}'/></sdf>")
    with world, Capture(world, tmp_path / "run.mcap") as log:
        world.step()
        log.take()
    done = run_libgz("play", tmp_path / "run.mcap", "--html", tmp_path / "a.html")
    assert done.returncode == 0, done.stderr
    text = (tmp_path / "a.html").read_text()
    assert "<script>alert" not in text
    assert replayed(tmp_path / "a.html")["title"].startswith(name)


@needs_chromium
def test_a_replay_plays_in_a_browser(chromium, recorded, tmp_path):
    page_file = tmp_path / "replay.html"
    assert run_libgz("play", recorded, "--html", page_file, "--frames", 10).returncode == 0
    page = opened(chromium, page_file.as_uri())
    wait_for(lambda: (status(page)[0] or 0.0) > 1.0, "the run")
    assert not page.errors
    assert all(re.match("file:|blob:|data:", url) for url in page.fetched)
    page.evaluate("libgz.store.ask('seek', '3')")
    page.evaluate("libgz.store.ask('pause', 'on')")
    row = "libgz.store.bodies.get(libgz.store.entities.get(libgz.store.ids.get('robot1')).body).row"
    assert page.evaluate(f"libgz.store.bodyPose({row})[0]") > 1.0
    page.close()


@pytest.mark.trial
def test_only_what_was_asked_for_is_in_a_replay(recorded, tmp_path):
    sizes = []
    for words in (["--from", 1, "--to", 1.1], ["--frames", 40]):
        page_file = tmp_path / "replay.html"
        done = run_libgz("play", recorded, "--html", page_file, *words)
        assert done.returncode == 0, done.stderr
        sizes.append(page_file.stat().st_size)
    assert sizes[0] < sizes[1]
    done = run_libgz("play", recorded, "--html", tmp_path / "nothing" / "replay.html")
    assert done.returncode == 1
    assert "replay.html' cannot be written: No such file or directory" in done.stderr


@needs_chromium
def test_the_viewer_of_a_log_has_a_slider_for_its_time(chromium, recorded):
    server_id = free_server_id(300 + os.getpid() % 500)
    words = ("play", recorded, "-s", server_id, "--loop")
    with served(*words, program="libgz") as (_, url), libgz.Observer(server_id, timeout=20.0) as observer:
        page = opened(chromium, url)
        assert page.evaluate("libgz.store.robots.length") == 0  # clients' commands have no effect
        button(page, "Pause").click()
        wait_for(lambda: observer.state().paused, "the pause")
        slider = page.get_by_role("group", name="Time line").get_by_role("slider")
        for key, moment in (("End", 4.0), ("Home", 0.0)):
            slider.focus()
            page.keyboard.press(key)
            wait_for(lambda moment=moment: abs(observer.state().sim_time - moment) < 0.05, f"the moment {moment}")
            wait_for(lambda moment=moment: abs(float(slider.input_value()) - moment) < 0.05, f"the slider at {moment}")
        button(page, "Run").click()
        wait_for(lambda: not observer.state().paused, "the run")
        assert not page.errors
        page.close()
