"""What users do with models in the page: handles, insertion, deletion, saving, rewinding, joints, lights, looks."""

import os
from pathlib import Path

import numpy as np
import pytest
from view_pages import PANEL, browser, needs_chromium, opened, picture, reddish, served, wait_for

import libgz
from libgz.base.files import installed_worlds
from libgz.transport.server import free_server_id

pytestmark = [needs_chromium, pytest.mark.trial, pytest.mark.filterwarnings("ignore")]

ARM = """<sdf version="1.6"><world name="default"><include><uri>model://ground_plane</uri></include><include>
<uri>model://sun</uri></include><model name="arm"><link name="base"><pose>0 0 .1 0 0 0</pose><inertial>
<mass>20</mass></inertial><collision name="c"><geometry><box><size>.6 .6 .2</size></box></geometry>
</collision><visual name="v"><geometry><box><size>.6 .6 .2</size></box></geometry></visual></link>
<link name="upper"><pose>0 0 .7 0 0 0</pose><inertial><mass>2</mass><inertia><ixx>.1</ixx><iyy>.1</iyy>
<izz>.1</izz></inertia></inertial><visual name="v"><geometry><box><size>.1 .1 1</size></box></geometry>
</visual><sensor name="cam" type="camera"><pose>0 0 .5 0 0 0</pose><update_rate>10</update_rate><camera>
<horizontal_fov>1.2</horizontal_fov><image><width>160</width><height>120</height></image><clip>
<near>.02</near><far>20</far></clip></camera></sensor></link><joint name="shoulder" type="revolute">
<parent>base</parent><child>upper</child><pose>0 0 -.5 0 0 0</pose><axis><xyz>0 1 0</xyz><limit>
<lower>-1</lower><upper>1</upper></limit></axis></joint></model></world></sdf>"""


@pytest.fixture(scope="module")
def chromium():
    with browser() as found:
        yield found


def new_id():
    return free_server_id(300 + os.getpid() % 500)


def tab(page, name):
    page.get_by_role("tab", name=name).click()


def choose(page, label, option):
    page.get_by_label(label, exact=True).click()
    page.get_by_role("option", name=option, exact=True).click()


def test_models_come_move_and_go_and_the_world_is_saved_and_rewound(chromium, tmp_path):
    file, server_id = tmp_path / "a.world", new_id()
    file.write_bytes((installed_worlds() / "pioneer2at.world").read_bytes())
    with served("-s", server_id, "-d", 0, file) as (_, url), libgz.Observer(server_id, timeout=20.0) as observer:
        page = opened(chromium, url)
        tab(page, "World")
        page.get_by_label("Record 60 s").click()
        choose(page, "Insert", "Shrimp")
        page.get_by_role("button", name="Insert", exact=True).click()
        wait_for(lambda: "shrimp1" in {entity.id for entity in observer.entities}, "the insertion")
        begin = observer.state().sim_time
        wait_for(lambda: observer.state().sim_time > begin + 1.0, "a second")
        assert observer.pose("shrimp1").rot.u == pytest.approx(1.0, abs=0.01)  # it stands on free ground
        before = file.read_text()
        page.get_by_role("button", name="Save the world").click()
        page.get_by_role("button", name="Save", exact=True).click()  # it asks first
        wait_for(lambda: "<id>shrimp1</id>" in file.read_text(), "the file")
        assert "<xyz>-8 6 20</xyz>" in file.read_text()  # the sun has not moved
        assert Path(f"{file}.bak").read_text() == before

        tab(page, "Model")
        choose(page, "Model", "shrimp1")
        page.get_by_label("Handles").click()
        before = observer.pose("shrimp1").pos
        wait_for(lambda: drag_handle(page), "the handles")
        wait_for(lambda: np.linalg.norm(np.array([*observer.pose("shrimp1").pos]) - before) > 0.2, "the model moves")

        page.get_by_role("button", name="Delete", exact=True).click()
        wait_for(lambda: "shrimp1" not in {entity.id for entity in observer.entities}, "the deletion")
        page.get_by_text("Pause", exact=True).click()
        wait_for(lambda: observer.state().paused, "the pause")
        tab(page, "World")
        page.get_by_role("slider").last.focus()
        for _ in range(4):
            page.keyboard.press("ArrowLeft")  # 0.5 s each
        page.wait_for_timeout(500)
        now = observer.state().sim_time
        page.get_by_role("button", name="Rewind to there").click()
        wait_for(lambda: observer.state().sim_time < now - 1.0, "the moment before")
        assert not page.errors
        page.close()


def drag_handle(page):
    """Drag a blue arrow of the handles, if there is one."""
    image = picture(page)[:, :-PANEL]
    found = np.argwhere((image[..., 2] > 220) & (image[..., 0] < 90) & (image[..., 1] > 110))
    if len(found) < 60:
        return False
    row, column = found[np.argmin(found[:, 0])]  # the tip of the vertical one
    page.mouse.move(float(column), float(row) + 4.0)
    page.mouse.down()
    for i in range(1, 9):
        page.mouse.move(float(column), float(row) + 4.0 - 10.0 * i)
        page.wait_for_timeout(60)
    page.mouse.up()
    return True


def test_sliders_move_joints_and_lights_and_images_of_sensors_are_shown(chromium, tmp_path):
    file, server_id = tmp_path / "arm.world", new_id()
    file.write_text(ARM)
    with served("-s", server_id, "-d", 0, file) as (_, url), libgz.Observer(server_id, timeout=20.0) as observer:
        page = opened(chromium, url)
        tab(page, "Model")
        choose(page, "Model", "arm")
        page.get_by_text("shoulder [rad]").wait_for()
        row = observer.joints[0].row
        for key, angle in (("End", 1.0), ("Home", -1.0)):
            page.get_by_role("slider").nth(1).focus()
            page.keyboard.press(key)
            wait_for(lambda angle=angle: abs(observer.state().joints[row, 0] - angle) < 0.05, f"the joint at {angle}")
        page.get_by_role("button", name="Release the joints").click()

        choose(page, "Model", "sun")
        page.get_by_text("Brightness").wait_for()
        light = picture(page)[300:, :-PANEL].mean()
        page.get_by_role("slider").nth(1).focus()
        page.keyboard.press("Home")
        wait_for(lambda: picture(page)[300:, :-PANEL].mean() < 0.8 * light, "the darkness")

        tab(page, "Show")
        page.get_by_label("Camera images").click()
        page.get_by_text("arm::upper::cam").wait_for()
        page.close()


def test_wireframe_and_collision_shapes(chromium):
    server_id = new_id()
    with served("-s", server_id, "-d", 0, "worlds/pioneer2at.world") as (_, url):
        page = opened(chromium, url)
        wait_for(lambda: len(reddish(picture(page))) > 100, "the robot")
        full = len(reddish(picture(page)))
        tab(page, "Show")
        page.get_by_label("Wireframe").click()
        wait_for(lambda: len(reddish(picture(page))) < 0.7 * full, "the wireframe")
        page.get_by_label("Wireframe").click()
        page.get_by_label("Collision shapes").click()
        wait_for(lambda: len(reddish(picture(page))) > 0.7 * full, "the collision shapes")
        page.close()
