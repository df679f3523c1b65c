"""Logs in the browser: as a page of their own without a server, and through the viewer."""

import base64
import os
import re

import msgspec
import numpy as np
import pytest
import zstandard
from commands import run_libgz
from view_pages import browser, needs_chromium, opened, picture, reddish, served, wait_for

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
    """What a replay's page plays: (time, message) of each change, and the arrays that they name."""
    [text] = re.findall(r'__VISER_EMBED_DATA__="([^"]+)"', page_file.read_text())
    packed = zstandard.ZstdDecompressor().decompressobj().decompress(base64.b64decode(text)[8:])
    end = 8 + int.from_bytes(packed[:8], "little")
    found, arrays = msgspec.msgpack.decode(packed[8:end]), []
    for size in found["binaryBufferLengths"]:
        begin = -(-end // 8) * 8
        end = begin + size
        arrays.append(packed[begin:end])
    return found["messages"], arrays


def test_a_replay_has_the_run_in_one_file(recorded, tmp_path):
    page_file = tmp_path / "replay.html"
    done = run_libgz("play", recorded, "--html", page_file, "--frames", 10, "--show", "trails", "--show", "lasers")
    assert done.returncode == 0, done.stderr
    text = page_file.read_text()
    assert "default-src 'none'" in text
    assert "<title>default - replay</title>" in text
    messages, arrays = replayed(page_file)
    paths = {}
    for moment, message in messages:
        named = message.get("updates", {}).get("batched_positions")
        if named:
            places = np.frombuffer(arrays[named["__binary_index"]], named["dtype"]).reshape(-1, 3)
            paths.setdefault(message["name"], []).append((moment, *places[0]))
    assert paths  # each group of shapes moves with the robot
    for path in map(np.array, paths.values()):
        assert path[:, 0] == pytest.approx(np.arange(1, 41) / 10)
        assert np.ptp(path[:, 1]) == pytest.approx(0.5 * 3.9, abs=0.1)


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
    messages, _ = replayed(tmp_path / "a.html")
    images = [
        message.get("props", message.get("updates"))["_data"]
        for _, message in messages
        if "/images/cam1" in message.get("name", "") and "_data" in message.get("props", message.get("updates", {}))
    ]
    assert 2 <= len(images) <= 6  # 5 a second at most, and only what has changed


@pytest.mark.trial
@needs_chromium
def test_a_replay_plays_in_a_browser(chromium, recorded, tmp_path):
    page_file = tmp_path / "replay.html"
    assert run_libgz("play", recorded, "--html", page_file, "--frames", 10).returncode == 0
    page = chromium.new_page(viewport={"width": 640, "height": 420})
    fetched = []
    page.on("request", lambda request: fetched.append(request.url))
    page.goto(page_file.as_uri())
    places = []

    def moved():
        found = reddish(picture(page))
        places.extend([np.median(found, axis=0)] if len(found) > 15 else [])
        return places and np.ptp(np.array(places), axis=0).max() > 10.0

    wait_for(moved, "the robot moves", 600.0)
    found, wanted = page.evaluate("window.libgzChanges")
    assert found == wanted > 4
    assert all(re.match("file:|blob:|data:", url) for url in fetched)
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


def shown(page):
    """Where the slider of a log stands [s]."""
    return float(page.get_by_role("slider").last.get_attribute("aria-valuenow"))


@needs_chromium
def test_the_viewer_of_a_log_has_a_slider_for_its_time(chromium, recorded):
    server_id = free_server_id(300 + os.getpid() % 500)
    words = ("play", recorded, "-s", server_id, "--loop")
    with served(*words, program="libgz") as (_, url), libgz.Observer(server_id, timeout=20.0) as observer:
        page = opened(chromium, url)
        assert page.get_by_role("tab", name="Drive").count() == 0  # clients' commands have no effect
        page.get_by_text("Pause", exact=True).click()
        wait_for(lambda: observer.state().paused, "the pause")
        for key, moment in (("End", 4.0), ("Home", 0.0)):
            page.get_by_role("slider").last.focus()
            page.keyboard.press(key)
            wait_for(lambda moment=moment: abs(observer.state().sim_time - moment) < 0.05, f"the moment {moment}")
            wait_for(lambda moment=moment: abs(shown(page) - moment) < 0.05, f"the slider at {moment}")
        page.get_by_text("Run", exact=True).click()
        wait_for(lambda: not observer.state().paused, "the run")
        assert not page.errors
        page.close()
