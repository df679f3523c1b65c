"""The 3D view alone, in headless Chromium, over scenes and states of real worlds."""

import http.server
import io
import json
import shutil
import threading
from pathlib import Path

import numpy as np
import pytest
from bone_files import two_bones
from PIL import Image

import libgz
import libgz.view
from libgz.base.geometry import GzPose, GzQuatern, GzVector
from libgz.sdf.reader import SdfFile
from libgz.sdfworld.world import SdfWorld
from libgz.view.assets import Assets
from libgz.view.local import LocalSource

ROOT = Path(__file__).parents[2]
CLIENT = Path(libgz.view.__file__).parent / "client"
PAGE = Path(__file__).parent / "stage"
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
FLAGS = ["--headless=new", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"]
WIDTH, HEIGHT = 480, 360
PATIENCE = 120_000  # [ms] software rendering on a loaded machine
TYPES = {".js": "text/javascript", ".html": "text/html", ".css": "text/css"}

pytestmark = [
    pytest.mark.skipif(CHROMIUM is None, reason="Debian's chromium is not installed"),
    pytest.mark.filterwarnings("ignore"),
]


class Served:
    """A world, as the page asks for it."""

    def __init__(self, path):
        self.world = libgz.World.from_file(path, server_id=None)
        self.source = LocalSource(self.world)
        self.assets = Assets(self.source)

    def answer(self, name):
        if name == "scene.json":
            self.source.state()
            scene = self.source.scene
            return json.dumps({**scene, "assets": self.assets.of_scene(scene)}).encode(), "application/json"
        if name == "state.json":
            state = self.source.state()
            content = {"steps": state.steps, "simTime": state.sim_time, "paused": False}
            return json.dumps(content | {"bodies": state.bodies.ravel().tolist()}).encode(), "application/json"
        found = self.assets.get(name)
        return (found.body, found.kind) if found is not None else None


class Handler(http.server.BaseHTTPRequestHandler):
    served = None

    def do_GET(self):
        name = self.path.split("?")[0].lstrip("/")
        path = CLIENT / name.removeprefix("client/") if name.startswith("client/") else PAGE / name
        if path.is_file():
            found = path.read_bytes(), TYPES[path.suffix]
        else:
            found = Handler.served.answer(name) if Handler.served is not None else None
        body, kind = found or (b"", "text/plain")
        self.send_response(200 if found else 404)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_):
        pass


@pytest.fixture(scope="module")
def page():
    from playwright.sync_api import sync_playwright

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server, sync_playwright() as playwright:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        chromium = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        try:
            page = chromium.new_page(viewport={"width": WIDTH, "height": HEIGHT})
            page.set_default_timeout(PATIENCE)
            page.errors = []
            page.on("pageerror", lambda error: page.errors.append(str(error)))
            page.on(
                "console", lambda line: page.errors.append(line.text) if line.type in ("error", "warning") else None
            )
            page.goto(f"http://127.0.0.1:{server.server_port}/page.html?quality=fast")
            page.wait_for_function("window.libgz")
            yield page
            assert [line for line in page.errors if "GPU stall" not in line] == []
        finally:
            chromium.close()
            server.shutdown()
            thread.join()


@pytest.fixture
def shown(page, tmp_path, monkeypatch):
    """A function that shows a world: a file's text, or its name in worlds/. It returns the world."""
    monkeypatch.setenv("TMP", str(tmp_path))
    monkeypatch.setenv("LIBGZ_GL", "none")
    worlds = []

    def show(text, steps=20):
        path = ROOT / "worlds" / text
        if "<" in text:
            path = tmp_path / "test.world"
            path.write_text(text)
        Handler.served = Served(path)
        worlds.append(Handler.served.world)
        worlds[-1].step(steps)
        page.evaluate("show()")
        return worlds[-1]

    yield show
    page.evaluate(
        "libgz.store.select(null); libgz.store.setHandles({mode: 'none'}); libgz.store.setFollow(null);"
        "for (const name of libgz.store.switches) libgz.store.setSwitch(name, false);"
        "for (const name of ['grid', 'shadows', 'skins']) libgz.store.setSwitch(name, true)"
    )
    Handler.served = None
    for world in worlds:
        world.close()


def image(page):
    """The view, shape (height, width, 3)."""
    page.evaluate("frames(3)")
    return np.asarray(Image.open(io.BytesIO(page.screenshot(timeout=PATIENCE))).convert("RGB")).astype(int)


def red(page):
    """Pixels of a Pioneer's red body: their rows and columns."""
    shown = image(page)
    return np.argwhere((shown[..., 0] > 60) & (shown[..., 0] > 2.2 * shown[..., 1:].max(axis=2)))


def entity(page, name):
    return page.evaluate(f"libgz.store.ids.get({name!r})")


def switch(page, name, on=True, number=None):
    page.evaluate(f"libgz.store.setSwitch({name!r}, {json.dumps(on)}, {json.dumps(number) if number else 'undefined'})")


def sdf(models, scene=""):
    return f"<sdf version='1.6'><world name='w'>{scene}{models}</world></sdf>"


def box(name="box", pose="0 0 0.5 0 0 0", material="", size="1 1 1", static=0):
    geometry = f"<geometry><box><size>{size}</size></box></geometry>"
    visual = f"<visual name='v'>{geometry}<material>{material}</material></visual>"
    link = f"<link name='l'><collision name='c'>{geometry}</collision>{visual}</link>"
    return f"<model name='{name}'><static>{static}</static><pose>{pose}</pose>{link}</model>"


def move(world, name, x, y, z):
    world.model(name).SetPose(GzPose(GzVector(x, y, z), GzQuatern(1.0, 0.0, 0.0, 0.0)))


def center(page):
    """Where the picture of the red body is: row and column [px]."""
    pixels = red(page)
    assert len(pixels) > 20
    return np.median(pixels, axis=0)


def near(page):
    """Distance of the camera from what it looks at [m]."""
    return page.evaluate("libgz.stage.cameras.distance")


def eye(page):
    return np.array(page.evaluate("libgz.stage.cameras.camera.position.toArray()"))


def resize(page, width):
    """Give the window a width, and wait until the camera has it."""
    page.set_viewport_size({"width": width, "height": HEIGHT})
    missing = f"Math.abs(libgz.stage.cameras.camera.aspect - {width / HEIGHT}) > 0.01"
    page.evaluate(f"(async () => {{ do await frames(1); while ({missing}); }})()")


def glided(page):
    """Wait until a change of view has ended."""
    page.evaluate("(async () => { do await frames(2); while (libgz.stage.cameras._glide); })()")


def colored(page, color, apart=40):
    """How many pixels have nearly a colour."""
    return int((np.abs(image(page) - np.array(color)).max(axis=2) < apart).sum())


def test_the_robot_fills_the_frame_and_moves(shown, page):
    world = shown("pioneer2at.world")
    pixels = red(page)
    assert len(pixels) > 0.02 * WIDTH * HEIGHT
    assert np.abs(np.median(pixels, axis=0) - (HEIGHT / 2, WIDTH / 2)).max() < 0.25 * WIDTH
    former = center(page)
    move(world, "robot1", 0.0, 0.4, 0.2)
    page.evaluate("state()")
    assert np.abs(center(page) - former).max() > 20


def test_a_click_selects_and_locked_models_are_passed_over(shown, page):
    shown("pioneer2at.world")
    robot = entity(page, "robot1")
    row, column = center(page)
    page.mouse.click(column, row)
    assert page.evaluate("libgz.store.selection") == {"entity": robot}
    assert colored(page, (0x4C, 0x8D, 0xFF)) > 50  # its outline
    switch(page, "locked", True, robot)
    page.mouse.click(column, row)
    assert page.evaluate("libgz.store.selection?.entity ?? null") != robot
    switch(page, "locked", False, robot)
    page.mouse.move(column + 1, row)
    page.wait_for_function(f"libgz.store.hover === {robot}")
    page.mouse.move(5, HEIGHT - 5)
    page.wait_for_function("libgz.store.hover === null")
    page.mouse.click(5, HEIGHT - 5)  # the ground
    assert page.evaluate("libgz.store.selection") is None


def test_views_and_focus_move_the_camera(shown, page):
    shown("pioneer2at.world")
    start = near(page)
    page.evaluate("libgz.store.view('fit')")
    glided(page)
    assert near(page) > 1.5 * start  # all that moves, not the robot alone
    page.evaluate("libgz.store.view({focus: libgz.store.ids.get('robot1')})")
    glided(page)
    assert near(page) < start
    for view, axis, sign in (("front", 0, 1), ("back", 0, -1), ("left", 1, 1), ("right", 1, -1), ("top", 2, 1)):
        page.evaluate(f"libgz.store.view({view!r})")
        glided(page)
        outward = eye(page) - page.evaluate("libgz.stage.cameras.controls.target.toArray()")
        assert outward[axis] * sign > 0.9 * np.linalg.norm(outward)
    page.evaluate("libgz.store.select({entity: libgz.store.ids.get('robot1')}); libgz.store.view('right')")
    glided(page)
    row, column = center(page)
    page.mouse.dblclick(column, row)
    glided(page)
    assert np.abs(center(page) - (HEIGHT / 2, WIDTH / 2)).max() < 0.2 * WIDTH


def test_what_falls_for_ever_is_not_framed(shown, page):
    world = shown(sdf(box("kept") + box("lost")))
    move(world, "lost", 0.0, 0.0, -3000.0)
    page.evaluate("state()")
    page.evaluate("libgz.store.view('fit')")
    glided(page)
    assert page.evaluate("libgz.stage.cameras.controls.target.z") == pytest.approx(0.4, abs=0.3)
    assert near(page) < 4.0


def test_the_camera_follows_and_walks(shown, page):
    world = shown("pioneer2at.world")
    former, start = center(page), eye(page)
    page.evaluate("libgz.store.setFollow(libgz.store.ids.get('robot1')); frames(2)")
    move(world, "robot1", -3.0, 0.0, 0.2)
    page.evaluate("state()")
    assert np.abs(center(page) - former).max() < 12
    assert np.linalg.norm(eye(page) - start) > 2.5
    page.evaluate("libgz.store.setFollow(null)")
    start = eye(page)
    page.evaluate("libgz.store.view({walk: [1, 0, 0]}); frames(4)")
    page.evaluate("libgz.store.view({walk: [0, 0, 0]}); frames(2)")
    walked = eye(page) - start
    assert np.linalg.norm(walked[:2]) > 0.02
    assert abs(walked[2]) < 1e-6


@pytest.mark.parametrize(
    ("world", "height"), [("pioneer2at.world", 0.0), ("terrain.world", None), ("heightmap.world", None)]
)
def test_the_camera_stays_above_the_ground(shown, page, world, height):
    shown(world)
    page.evaluate("libgz.stage.cameras.camera.position.set(1.5, 0.5, -30)")
    page.evaluate("frames(2)")
    x, y, z = eye(page)
    ground = page.evaluate(f"libgz.stage.cameras.groundAt({x}, {y})")
    assert height is None or ground == pytest.approx(height)
    assert z == pytest.approx(ground + 0.08)


def test_what_is_put_into_an_empty_world_fills_the_frame(shown, page):
    ground = "<include><uri>model://ground_plane</uri></include>"
    world = shown(sdf(ground))
    world.extension(SdfWorld).insert(SdfFile.from_string(f"<sdf version='1.6'>{box(pose='5 5 0.5 0 0 0')}</sdf>"))
    world.step()
    page.evaluate("added()")
    target = page.evaluate("libgz.stage.cameras.controls.target.toArray()")
    assert target == pytest.approx([5.0, 5.0, 0.3], abs=0.3)
    assert near(page) < 5.0


def test_the_camera_begins_by_a_state_of_its_own_world(shown, page):
    for x, y in ((9.0, 0.0), (0.0, 9.0)):
        shown(sdf(box(pose=f"{x} {y} 0.5 0 0 0")))
        target = page.evaluate("libgz.stage.cameras.controls.target.toArray()")
        assert target[:2] == pytest.approx([x, y], abs=0.3)


def test_the_camera_begins_where_the_world_says(shown, page):
    camera = "<gui><camera name='c'><pose>4 1 3 0 0.5 3.14</pose></camera></gui>"
    shown(sdf(camera + "<include><uri>model://ground_plane</uri></include>" + box()))
    assert eye(page) == pytest.approx([4.0, 1.0, 3.0], abs=1e-3)


@pytest.mark.parametrize(("wall", "back"), [("", 1.0), (box("wall", "5 1 3 0 0 0", size="0.1 9 9", static=1), 0.0)])
def test_a_narrow_window_shows_as_much_as_the_worlds_view(shown, page, wall, back):
    camera = "<gui><camera name='c'><pose>4 1 3 0 0.5 3.14159265</pose></camera></gui>"
    resize(page, HEIGHT // 2)
    try:
        shown(sdf(camera + box(pose="-2 1 0.5 0 0 0") + wall))
        found = eye(page)
    finally:
        resize(page, WIDTH)
    away = found - [4.0, 1.0, 3.0]
    if not back:
        assert away == pytest.approx([0.0, 0.0, 0.0], abs=1e-3)  # the camera stays before the wall
        return
    assert away[2] / away[0] == pytest.approx(np.tan(0.5), rel=1e-3)
    assert np.linalg.norm(away) / near(page) == pytest.approx(1.0 - (1 / 2) / (4 / 3), rel=0.01)


def test_switches_change_what_is_seen(shown, page):
    shown("pioneer2at.world")
    robot, laser = entity(page, "robot1"), entity(page, "laser1")
    body = len(red(page))
    switch(page, "hidden", True, robot)
    assert len(red(page)) < 0.02 * body
    switch(page, "hidden", False, robot)
    switch(page, "transparent", True, robot)
    opacities = f"libgz.stage.bodies.of.get({robot}).map(({{batch}}) => batch.material.opacity)"
    assert set(page.evaluate(opacities)) == {0.45}
    assert len(red(page)) < 0.8 * body
    switch(page, "transparent", False, robot)
    assert set(page.evaluate(opacities)) == {1}
    switch(page, "wireframe", True, robot)
    assert len(red(page)) < 0.6 * body
    switch(page, "wireframe", False, robot)
    switch(page, "collisions", True, robot)
    assert len(red(page)) < 0.1 * body
    switch(page, "collisions", False, robot)
    before = image(page)
    switch(page, "grid", False)
    assert (np.abs(image(page) - before).max(axis=2) > 12).sum() > 300
    switch(page, "grid")
    for name in ("lasers", "axes", "masses", "frames", "names", "boxes"):
        former = image(page)
        for number in (robot, laser):
            switch(page, name, True, number)
        assert (np.abs(image(page) - former).max(axis=2) > 25).sum() > 60, name
        for number in (robot, laser):
            switch(page, name, False, number)
        assert (np.abs(image(page) - former).max(axis=2) > 25).sum() < 30, name


@pytest.mark.parametrize("world", ["terrain.world", "heightmap.world"])
def test_hills_have_a_grid(shown, page, world):
    shown(world)
    with_grid = image(page)
    switch(page, "grid", False)
    changed = np.abs(image(page) - with_grid).max(axis=2) > 8
    assert changed[HEIGHT // 2 :].mean() > 0.02  # below the horizon
    switch(page, "grid")


def test_lasers_end_where_they_measure(shown, page):
    shown("pioneer2at.world")
    switch(page, "lasers")
    assert page.evaluate("[...libgz.store.wants.get('ranges').get('stage')]") == ["laser.laser1"]
    reach = "Math.max(...ask.ends('lasers'))"
    assert page.evaluate(reach) > 4.0
    page.evaluate("libgz.store.learn({ranges: {'laser.laser1': Array(181).fill(0.5)}, rings: {}}); frames(2)")
    assert page.evaluate(reach) < 1.0


def test_sonars_contacts_and_trails_are_shown(shown, page):
    world = shown("pioneer2sonars.world")
    served = page.evaluate("ask.sonar()")
    switch(page, "sonars")
    ring = {"positions": [[0.2, 0, 0.1]], "directions": [0.0], "ranges": [1.5]}
    former = image(page)
    page.evaluate(f"libgz.store.learn({json.dumps({'ranges': {}, 'rings': {f'sonar.{served}': ring}})})")
    assert (np.abs(image(page) - former).max(axis=2) > 15).sum() > 200
    switch(page, "sonars", False)
    for name in ("contacts", "forces"):
        switch(page, name)
        former = image(page)
        page.evaluate("libgz.store.learn({contacts: [[0, 0, 0, 0, 0, 1, 0.001, 0, 0, 90, 1, 2]]})")
        assert (np.abs(image(page) - former).max(axis=2) > 25).sum() > 20
        page.evaluate("libgz.store.learn({contacts: []})")
        switch(page, name, False)
    switch(page, "trails")
    robot = next(
        entity for entity in world.entities if any(one.type == "position" for one in world.interfaces_of(entity))
    )
    for x in (0.3, 0.6):
        move(world, robot.GetId(), x, 0.0, 0.3)
        page.evaluate("state()")
    assert page.evaluate("libgz.stage.marks.lines.trails.count") > 0


def test_inertia_is_a_box_of_even_density(shown, page):
    inertia = "<inertial><mass>12</mass><inertia><ixx>5</ixx><iyy>10</iyy><izz>13</izz></inertia></inertial>"
    shown(sdf(box().replace("<link name='l'>", f"<link name='l'>{inertia}")))
    switch(page, "inertia")
    page.evaluate("frames(1)")
    corners = np.array(page.evaluate("ask.ends('inertia')")).reshape(-1, 3)
    assert np.ptp(corners, axis=0) == pytest.approx([3.0, 2.0, 1.0], rel=1e-4)  # 12 kg with these sides [m]


def test_handles_hold_what_they_move(shown, page):
    shown(sdf("<include><uri>model://ground_plane</uri></include>" + box(pose="0 0 0.5 0 0 0.7")))
    number = entity(page, "box")
    page.evaluate(f"libgz.store.select({{entity: {number}}}); libgz.store.setHandles({{mode: 'translate'}}); frames(2)")
    grip = "libgz.stage.handles.controls"
    assert page.evaluate(f"{grip}.object !== undefined")
    at = page.evaluate("ask.arrow()")
    page.evaluate("asked.length = 0")
    page.mouse.move(*at)
    page.mouse.down()
    for i in range(1, 8):
        page.mouse.move(at[0] + 9 * i, at[1])
        page.wait_for_timeout(30)
    page.mouse.up()
    page.wait_for_function("asked.some(([verb, argument]) => verb === 'hold' && argument === 'off')")
    asked = page.evaluate("asked")
    poses = [content["pose"] for verb, argument, content in asked if argument == "on"]
    assert {verb for verb, _, _ in asked} == {"hold"}
    assert asked[-1][1:] == ["off", {"name": "box"}]
    assert abs(poses[-1][0] - poses[0][0]) > 0.1
    assert poses[-1][1:3] == pytest.approx(poses[0][1:3], abs=1e-6)
    assert page.evaluate("libgz.store.selection") == {"entity": number}  # a drag is no click
    page.evaluate(f"libgz.store.setSwitch('locked', true, {number}); libgz.store.setHandles({{mode: 'rotate'}})")
    assert page.evaluate(f"{grip}.object === undefined")


def test_places_are_on_the_ground(shown, page):
    shown("pioneer2at.world")
    x, y, z = page.evaluate("libgz.stage.place()")
    assert z == pytest.approx(0.0, abs=1e-6)
    low, high = page.evaluate("ask.bounds('robot1')")
    assert not (low[0] < x < high[0] and low[1] < y < high[1])
    assert page.evaluate(f"libgz.stage.place({WIDTH / 2}, {HEIGHT - 4})")[2] == pytest.approx(0.0, abs=1e-6)


def test_materials_are_shown(shown, page):
    plain = "<diffuse>0.1 0.1 0.1 1</diffuse>"
    lit = f"{plain}<emissive>0 1 0 1</emissive>"
    clear = "<diffuse>1 0 0 0.3</diffuse>"
    models = (
        box("glow", "0 -1.5 0.5 0 0 0", lit)
        + box("plain", "0 0 0.5 0 0 0", plain)
        + box("clear", "0 1.5 0.5 0 0 0", clear)
    )
    shown(sdf(models))
    assert colored(page, (0, 255, 0), 90) > 300
    kinds = page.evaluate("ask.looks()")
    assert sorted(kinds) == [["clear", 0.3, False], ["glow", 1, True], ["plain", 1, True]]


def test_shapes_of_one_form_are_instances_of_one_mesh(shown, page):
    shown(sdf("".join(box(f"b{i}", f"{i} 0 0.5 0 0 0", f"<diffuse>{i / 40} 0 0 1</diffuse>") for i in range(40))))
    assert page.evaluate("libgz.stage.bodies.batches.map(({instances}) => instances.length)") == [40]


def test_sky_fog_and_theme(shown, page):
    background = "<scene><background>0.2 0.4 0.9 1</background></scene>"
    shown(sdf(box(), background))
    page.evaluate(
        "libgz.stage.cameras.camera.position.set(-6, 0, 0.6); libgz.stage.cameras.controls.target.set(0, 0, 1.4)"
    )
    day = image(page)[: HEIGHT // 10].mean(axis=(0, 1))
    assert day[2] > day[0] + 30
    page.evaluate("libgz.store.setTheme('dark')")
    dark = image(page)[: HEIGHT // 10].mean(axis=(0, 1))
    page.evaluate("libgz.store.setTheme('light')")
    assert dark.mean() < 0.6 * day.mean()
    fog = "<scene><fog><type>linear</type><color>1 0 0 1</color><start>1</start><end>4</end></fog></scene>"
    shown(sdf(box(), fog))
    page.evaluate("libgz.stage.cameras.camera.position.set(-9, 0, 1)")
    assert colored(page, (255, 0, 0), 70) > 0.3 * WIDTH * HEIGHT


def test_a_surface_that_another_casts_a_shadow_on_is_darker(shown, page):
    models = "<include><uri>model://sun</uri></include><include><uri>model://ground_plane</uri></include>"
    shown(sdf(models + box(pose="0 0 1.5 0 0 0", size="2 2 0.1", static=1)))
    page.evaluate("libgz.stage.quality.index = 2; libgz.stage._applyLevel(); libgz.store.view('top')")
    glided(page)
    lit = image(page)
    switch(page, "shadows", False)
    darker = lit.sum(axis=2) < image(page).sum(axis=2) - 40
    page.evaluate("libgz.stage.quality.index = 6; libgz.stage._applyLevel()")
    assert darker.sum() > 100


def test_a_world_whose_only_light_is_out_is_darker_than_one_without_lights(shown, page):
    material = "<diffuse>0.8 0.8 0.8 1</diffuse>"
    shown(sdf(box(material=material)))
    without = image(page)[HEIGHT // 2, WIDTH // 2].sum()
    light = "<light type='directional' name='s'><diffuse>0 0 0 1</diffuse><direction>0.4 0.3 -1</direction></light>"
    shown(sdf(light + box(material=material)))
    assert image(page)[HEIGHT // 2, WIDTH // 2].sum() < 0.8 * without


def test_skins_of_actors_are_bent(shown, page, tmp_path):
    (tmp_path / "arm.dae").write_text(two_bones())
    file = "<filename>arm.dae</filename>"
    world = shown(sdf(f"<actor name='a'><skin>{file}</skin><animation name='turn'>{file}</animation></actor>"))
    places = "ask.skin([0, 8])"
    fixed, turned = np.array(page.evaluate(places))
    world.step(1000)
    page.evaluate("state()")
    later = np.array(page.evaluate(places))
    assert later[0] == pytest.approx(fixed, abs=0.02)
    assert np.linalg.norm(later[1] - turned) > 0.3


def test_a_screenshot_is_sharper_than_the_page(shown, page):
    shown("pioneer2at.world")
    size = page.evaluate("ask.screenshot()")
    assert size == [2 * WIDTH, 2 * HEIGHT]


def test_nothing_is_rendered_while_nothing_changes(shown, page):
    shown("pioneer2at.world")
    page.wait_for_function("libgz.stage._refined")
    before = page.evaluate("libgz.stage.renderer.info.render.frame")
    page.evaluate("libgz.store.setState({...libgz.store.state})")
    page.wait_for_timeout(300)
    assert page.evaluate("libgz.stage.renderer.info.render.frame") == before


def test_slow_frames_lower_the_quality(page):
    assert page.evaluate("ask.level(true, 8) < ask.level(true, 120)")
    assert page.evaluate("[ask.level(false, 8), ask.level(true, 1000)]") == [0, 6]


def test_old_robots_have_fine_skins_that_can_be_switched_off(page, shown):
    shown("pioneer2at.world")
    forms = """libgz.stage.bodies.instances.filter((one) => libgz.store.entities.get(one.entity)?.id === "robot1")
        .map((one) => one.batch.geometry.getAttribute("position").count)"""
    crate = "libgz.stage.bodies.of.get(libgz.store.ids.get('crate')).length"
    fine, around = page.evaluate(forms), page.evaluate("ask.bounds('robot1')")
    assert page.evaluate(crate) == 1
    page.evaluate("libgz.store.setSwitch('skins', false)")
    plain = page.evaluate(forms)
    assert len(fine) == len(plain) + 4  # rims
    assert sum(fine) > sum(plain)
    assert np.allclose(around, page.evaluate("ask.bounds('robot1')"), atol=0.005)
    page.evaluate("libgz.store.setSwitch('skins', true)")
    assert page.evaluate(forms) == fine


def test_still_images_are_dark_where_surfaces_meet(page, shown):
    shown("pioneer2at.world")
    page.evaluate("libgz.store.view({ focus: libgz.store.ids.get('robot1') })")
    glided(page)
    look = """(still) => {
        const { stage } = libgz, gl = stage.renderer.getContext();
        stage._render(still);
        const width = gl.drawingBufferWidth, height = gl.drawingBufferHeight;
        const found = new Uint8Array(4 * width * height);
        gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, found);
        return [height, width, Array.from(found)];
    }"""
    found = [page.evaluate(look, still) for still in (False, True)]
    moving, still = (np.reshape(pixels, (height, width, 4)).astype(int) for height, width, pixels in found)
    darker = (moving - still)[..., :3].mean(axis=2)
    assert darker.min() > -3.0  # nothing becomes brighter
    share = np.mean(darker > 5.0)
    assert 0.005 < share < 0.3  # some places, not the open ground
