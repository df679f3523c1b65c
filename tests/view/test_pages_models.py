"""What users do with models in the page: insert, move, delete, save, rewind; joints, lights, looks and plots."""

import os
from pathlib import Path

import numpy as np
import pytest
from view_pages import browser, button, needs_chromium, opened, picture, reddish, row, served, until, wait_for

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


def ids(observer):
    return {entity.id for entity in observer.entities}


def test_models_come_move_and_go_and_the_world_is_saved_and_rewound(chromium, tmp_path):
    file, server_id = tmp_path / "a.world", new_id()
    file.write_bytes((installed_worlds() / "pioneer2at.world").read_bytes())
    with served("-s", server_id, "-d", 0, file) as (_, url), libgz.Observer(server_id, timeout=20.0) as observer:
        page = opened(chromium, url)
        line = page.get_by_role("group", name="Time line")
        line.get_by_role("button", name="Record 60 s").click()
        button(page, "Insert").click()
        page.get_by_label("Search models").fill("shrimp")
        page.get_by_role("option", name="Shrimp", exact=True).click()
        wait_for(lambda: "shrimp1" in ids(observer), "the insertion")
        begin = observer.state().sim_time
        wait_for(lambda: observer.state().sim_time > begin + 1.0, "a second")
        assert observer.pose("shrimp1").rot.u == pytest.approx(1.0, abs=0.01)  # it stands on free ground
        until(page, "libgz.store.entities.get(libgz.store.selection?.entity)?.id === 'shrimp1'")
        before = file.read_text()
        button(page, "Save the world").click()
        button(page, "Save").click()  # it asks first
        wait_for(lambda: "<id>shrimp1</id>" in file.read_text(), "the file")
        assert "<xyz>-8 6 20</xyz>" in file.read_text()  # the sun has not moved
        assert Path(f"{file}.bak").read_text() == before

        row(page, "shrimp1").click()
        if not page.locator("#inspector").is_visible():
            page.keyboard.press("]")
        before = observer.pose("shrimp1").pos
        field = page.locator("#inspector").get_by_label("x", exact=True)
        field.fill(f"{before.x + 1.0:.3f}")
        field.press("Enter")
        wait_for(lambda: observer.pose("shrimp1").pos.x > before.x + 0.9, "the field moves it")
        page.keyboard.press("f")
        page.keyboard.press("t")
        before = observer.pose("shrimp1").pos
        until(page, "libgz.workplace.stage.handles.controls.object")
        drag_handle(page)
        wait_for(lambda: np.linalg.norm(np.array([*observer.pose("shrimp1").pos]) - before) > 0.2, "the model moves")

        row(page, "shrimp1").click()
        page.keyboard.press("Delete")
        dialog = page.get_by_role("dialog").get_by_role("button", name="Delete")
        if dialog.count():  # without undo, it asks
            dialog.click()
        wait_for(lambda: "shrimp1" not in ids(observer), "the deletion")
        button(page, "Pause").click()
        wait_for(lambda: observer.state().paused, "the pause")
        page.get_by_role("slider", name="Time line").focus()
        for _ in range(4):
            page.keyboard.press("ArrowLeft")  # 0.5 s each
        now = observer.state().sim_time
        button(page, "Rewind to there").click()
        wait_for(lambda: observer.state().sim_time < now - 1.0, "the moment before")
        assert not page.errors
        page.close()


def drag_handle(page):
    """Drag the handles' arrow along x, once the camera is at rest."""
    until(page, "!libgz.workplace.stage.cameras._glide && libgz.workplace.stage._refined")
    (x0, y0), (x, y) = page.evaluate(ARROW)
    page.mouse.move(x, y)
    page.mouse.down()
    along = 10.0 / np.hypot(x - x0, y - y0)
    for i in range(1, 9):
        page.mouse.move(x + along * i * (x - x0), y + along * i * (y - y0))
        page.wait_for_timeout(60)
    page.mouse.up()


ARROW = """() => {
  const { handles, cameras } = libgz.workplace.stage;
  const box = document.querySelector('#stage canvas').getBoundingClientRect();
  const pixel = (point) => {
    point.project(cameras.camera);
    return [box.left + ((point.x + 1) / 2) * box.width, box.top + ((1 - point.y) / 2) * box.height];
  };
  const meshes = [];
  handles.controls.getHelper().traverse((one) => one.name === 'X' && one.isMesh && one.visible && meshes.push(one));
  const [{ geometry, matrixWorld }] = meshes;
  geometry.computeBoundingBox();
  const middle = geometry.boundingBox.getCenter(handles.grip.position.clone());
  return [pixel(handles.grip.position.clone()), pixel(middle.applyMatrix4(matrixWorld))];
}"""  # where the handles and that arrow are in the window [px]; the arrow is on the side that the camera is on


def test_sliders_move_joints_and_lights_and_images_of_sensors_are_shown(chromium, tmp_path):
    file, server_id = tmp_path / "arm.world", new_id()
    file.write_text(ARM)
    with served("-s", server_id, "-d", 0, file) as (_, url), libgz.Observer(server_id, timeout=20.0) as observer:
        page = opened(chromium, url, (1280, 800))
        panel = page.locator("#inspector")
        row(page, "arm").click()
        shoulder = panel.get_by_role("slider", name="shoulder")
        place = observer.joints[0].row
        for key, angle in (("End", 1.0), ("Home", -1.0)):
            shoulder.press(key)
            wait_for(lambda angle=angle: abs(observer.state().joints[place, 0] - angle) < 0.05, f"the joint at {angle}")
        panel.get_by_role("button", name="shoulder").click()
        until(page, 'Math.abs(libgz.workplace.sampler.read(\'["joint","arm","shoulder",0,"position"]\') + 1) < 0.05')
        button(page, "Release the joints").click()

        row(page, "sun").click()
        bright = picture(page).mean()
        panel.get_by_role("slider", name="Brightness").fill("0.1")
        wait_for(lambda: picture(page).mean() < 0.95 * bright, "the darkness")

        button(page, "Show").click()
        page.get_by_role("menuitemcheckbox", name="arm::upper::cam").click()
        page.get_by_role("img", name="Image of arm::upper::cam").wait_for()
        assert not page.errors
        page.close()


def test_wireframe_and_collision_shapes(chromium):
    server_id = new_id()
    with served("-s", server_id, "-d", 0, "worlds/pioneer2at.world") as (_, url):
        page = opened(chromium, url)

        def switch(name):
            button(page, "Show").click()
            page.get_by_role("menuitemcheckbox", name=name).click()
            page.keyboard.press("Escape")

        wait_for(lambda: len(reddish(picture(page))) > 100, "the robot")
        full = len(reddish(picture(page)))
        switch("Wireframe")
        wait_for(lambda: len(reddish(picture(page))) < 0.7 * full, "the wireframe")
        switch("Wireframe")
        wait_for(lambda: len(reddish(picture(page))) > 0.9 * full, "the robot as it was")
        switch("Collision shapes")
        wait_for(lambda: orange(picture(page)) > 500, "the collision shapes")
        page.close()


def test_fields_of_interfaces_are_plotted_and_warnings_listed(chromium, tmp_path):
    file, server_id = tmp_path / "a.world", new_id()
    text = (installed_worlds() / "pioneer2at.world").read_text()
    file.write_text(text.replace("<id>crate</id>", "<id>crate</id><colour>1</colour>"))
    with served("-s", server_id, "-d", 0, file) as (_, url):
        page = opened(chromium, url, (1280, 800))
        page.get_by_role("tab", name="Console").click()
        message = page.locator(".message.warning")
        message.first.wait_for()
        assert "<colour>" in message.first.inner_text()
        assert f"{file}:" in message.first.inner_text()
        row(page, "robot1").click()
        page.locator("#inspector").get_by_text("position.robot1", exact=True).click()
        button(page, "Plot pos[0]").first.click()
        page.keyboard.down("w")
        until(page, "(workplace => workplace.plots.plots[0].curves[0].values.at(-1) > 0.1)(libgz.workplace)")
        page.keyboard.up("w")
        assert not page.errors
        page.close()


CLOCK = """from libgz.classic import plugin
class Clock(plugin.WorldPlugin):
    turns = 0
    def Load(self, world, sdf):
        self.turns = 12.5
plugin.GZ_REGISTER_WORLD_PLUGIN(Clock)
"""
DROP = """([name, text]) => {
    const data = new DataTransfer();
    data.items.add(new File([text], name));
    const what = { dataTransfer: data, bubbles: true, cancelable: true, clientX: 640, clientY: 300 };
    document.querySelector("#view-area").dispatchEvent(new DragEvent("drop", what));
}"""
CORNERS = "v 0 0 0\nv 0.4 0 0\nv 0 0.4 0\nv 0 0 0.4\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"  # of a tetrahedron [m]


def test_the_catalogue_shows_models_and_takes_meshes_and_numbers_of_plugins_are_plotted(
    chromium, tmp_path, monkeypatch
):
    monkeypatch.setenv("HOME", str(tmp_path))
    (tmp_path / "clock.py").write_text(CLOCK)
    file, server_id = tmp_path / "arm.world", new_id()
    file.write_text(ARM.replace("</world>", f"<plugin name='clock' filename='{tmp_path}/libclock.so'/></world>"))
    with served("-s", server_id, "-d", 0, file) as (_, url), libgz.Observer(server_id, timeout=20.0) as observer:
        page = opened(chromium, url, (1280, 800))
        page.evaluate(DROP, ["My part.obj", CORNERS])
        wait_for(lambda: "mesh_my_part" in ids(observer), "the mesh is inserted")
        until(page, "libgz.store.entities.get(libgz.store.selection?.entity)?.id === 'mesh_my_part'")
        button(page, "Undo").click()
        wait_for(lambda: "mesh_my_part" not in ids(observer), "it is gone")
        button(page, "Insert").click()
        page.get_by_label("Search models").fill("mesh my")
        card = page.get_by_role("option", name="mesh_my_part")
        card.locator(".card-portrait.shown").wait_for()  # with its image
        assert card.locator("img").evaluate("(image) => image.naturalWidth") == 256
        assert page.get_by_role("option").count() == 1
        card.click()
        wait_for(lambda: "mesh_my_part" in ids(observer), "the model of the catalogue is inserted")
        until(page, "libgz.store.entities.get(libgz.store.selection?.entity)?.id === 'mesh_my_part'")

        page.evaluate("libgz.store.select(null)")
        page.get_by_role("tab", name="Plots").click()
        page.locator("[data-section='plugin clock'] > summary").click()
        page.locator("[data-section='plugin clock'] [data-series]").drag_to(page.locator(".plots-panel"))
        until(page, "libgz.workplace.plots.plots[0]?.curves[0].values.at(-1) === 12.5")
        page.locator("[data-section='topic /gazebo/default/world_stats'] > summary").click()
        button(page, "Plot /gazebo/default/world_stats iterations").click()
        until(page, "libgz.workplace.plots.plots[0].curves[1]?.values.at(-1) > 0")
        assert not page.errors
        page.close()


def orange(image):
    """How many pixels are as collision shapes are shown."""
    red, green, blue = (image[..., i] for i in range(3))
    return np.count_nonzero((red > 150) & (green > 80) & (green < 160) & (blue < 90))
