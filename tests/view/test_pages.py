"""The live viewer as users have it: a server, the viewer's process, and a page in a browser."""

import contextlib
import os
import re
import subprocess
import sys

import numpy as np
import pytest
from gzserver_process import SERVER, new_environment
from view_pages import (
    PATIENCE,
    ROOT,
    address_of,
    browser,
    button,
    needs_chromium,
    opened,
    picture,
    reddish,
    row,
    served,
    status,
    wait_for,
)

import libgz
from libgz.transport.server import free_server_id

pytestmark = [needs_chromium, pytest.mark.filterwarnings("ignore")]

WORLD = "worlds/pioneer2at.world"


@pytest.fixture(scope="module")
def chromium():
    with browser() as found:
        yield found


def test_a_page_shows_the_robot_and_controls_it(chromium):
    server_id = free_server_id(300 + os.getpid() % 500)
    with served("-s", server_id, "-d", 0, WORLD) as (_, url), libgz.Observer(server_id, timeout=20.0) as observer:
        page = opened(chromium, url)
        assert "token=" in url
        assert url.startswith("http://127.0.0.1:")
        wait_for(lambda: len(reddish(picture(page))) > 15, "the robot's red body in the page")

        start = np.array([*observer.pose("robot1").pos])
        page.keyboard.down("w")
        wait_for(lambda: np.linalg.norm(np.array([*observer.pose("robot1").pos]) - start) > 0.2, "W drives the robot")
        page.keyboard.up("w")
        with libgz.Client(server_id, client_id=-1) as client:
            robot = client.position("robot1")
            wait_for(lambda: robot.data.cmd_vel_pos[0] == 0.0, "the robot stops")

        button(page, "Pause").click()
        wait_for(lambda: observer.state().paused, "the pause")
        wait_for(lambda: "paused" in status(page)[1], "the page shows the pause")
        paused = observer.state().sim_time
        wait_for(lambda: abs(status(page)[0] - paused) < 0.01, "the page shows the time of the pause")
        page.wait_for_timeout(300)
        assert observer.state().sim_time == paused
        button(page, "Step").click()
        wait_for(lambda: observer.state().sim_time > paused and observer.state().paused, "a step")
        assert observer.state().sim_time == pytest.approx(paused + 0.02)

        wait_for(lambda: click_robot(page), "a click selects the robot")
        assert "position.robot1" in page.inner_text("#inspector")
        assert "laser1" in page.inner_text("#inspector")

        button(page, "Reset").click()
        button(page, "Run").click()
        wait_for(lambda: not observer.state().paused, "the run")
        wait_for(lambda: np.linalg.norm(np.array([*observer.pose("robot1").pos]) - start) < 0.05, "the reset")
        assert not page.errors
        port = url.split("/")[2]
        assert all(url.split("/")[2] == port for url in page.fetched if url.startswith(("http", "ws")))
        page.close()


def click_robot(page):
    found = reddish(picture(page))
    if not len(found):
        return False
    down, right = np.median(found, axis=0)
    box = page.locator("#stage canvas").first.bounding_box()
    page.mouse.click(box["x"] + float(right), box["y"] + float(down))
    page.wait_for_timeout(500)
    return row(page, "robot1").get_attribute("aria-selected") == "true"


def test_without_the_token_a_page_only_watches(chromium):
    server_id = free_server_id(300 + os.getpid() % 500)
    with served("-s", server_id, "-d", 0, WORLD) as (_, url), libgz.Observer(server_id, timeout=20.0) as observer:
        page = opened(chromium, url.split("?")[0])
        wait_for(lambda: (status(page)[0] or 0.0) > 0.0, "the time in the page")
        start = observer.pose("robot1").pos
        page.get_by_text("This page only watches").wait_for()
        assert button(page, "Pause").count() == 0
        page.keyboard.press("Space")
        page.keyboard.down("w")
        page.wait_for_timeout(1500)
        assert not observer.state().paused
        assert observer.pose("robot1").pos.x == pytest.approx(start.x, abs=0.01)
        page.close()


def test_one_page_controls_and_hands_over(chromium):
    server_id = free_server_id(300 + os.getpid() % 500)
    with served("-s", server_id, "-d", 0, WORLD) as (_, url):
        first = opened(chromium, url)
        button(first, "Pause").wait_for()
        second = opened(chromium, url)
        button(second, "Watching").click()
        button(second, "Ask for control").click()
        asks = first.get_by_role("button", name="asks for control")
        asks.click()
        button(first, "Hand over").click()
        button(second, "Pause").wait_for()
        wait_for(lambda: not button(first, "Pause").count(), "the first page only watches")
        second.close()
        button(first, "Pause").wait_for()
        assert not first.errors
        first.close()


def test_the_viewer_and_the_server_come_and_go(chromium):
    server_id = free_server_id(300 + os.getpid() % 500)
    with served("-s", server_id, "-d", 0, WORLD, viewer=False) as (server, _):
        with viewing(server_id) as (_, url):
            opened(chromium, url).close()
        assert server.poll() is None
        with viewing(server_id) as (_, url):
            page = opened(chromium, url)
            wait_for(lambda: status(page)[0], "the time after the viewer came back")
            server.kill()
            server.wait(10.0)
            wait_for(lambda: "has ended" in status(page)[1], "the page says that the server ended")
            with served("-s", server_id, "-f", "-d", 0, WORLD, viewer=False):
                wait_for(lambda: "has ended" not in status(page)[1], "the page reconnects")
                wait_for(lambda: status(page)[0] is not None, "the time in the page")
                page.close()


def test_gzclient_shows_the_panels_of_gui_plugins_and_their_buttons_act(chromium, tmp_path):
    folder = ROOT / "examples" / "plugins" / "system_gui"
    environment = new_environment(tmp_path) | {"GAZEBO_PLUGIN_PATH": str(folder), "LIBGZ_GL": "none"}
    client_words = [sys.executable, "-m", "libgz.apps.gzclient", "--view-port", "18480"]
    with (
        running([*SERVER, str(folder / "system_gui.world")], environment),
        running(client_words, environment) as client,
    ):
        page = opened(chromium, address_of(client))
        button(page, "Spawn sphere").click()
        wait_for(lambda: (status(page)[0] or 0.0) > 0.1, "the time")
        text = page.locator(".overlay-text").filter(has_text=re.compile(r"[0-9.]+ s"))
        wait_for(lambda: text.count(), "the plugin's text")
        row(page, "sphere_0").wait_for()
        page.close()


@contextlib.contextmanager
def running(words, environment):
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment) as found:
        try:
            yield found
        finally:
            found.terminate()
            found.wait(PATIENCE)


@contextlib.contextmanager
def viewing(server_id):
    """A viewer in a process of its own: (process, address)."""
    words = [sys.executable, "-m", "libgz", "view", "-s", str(server_id), "--view-port", "18280"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=ROOT) as viewer:
        try:
            yield viewer, address_of(viewer)
        finally:
            viewer.terminate()
            viewer.wait(PATIENCE)
