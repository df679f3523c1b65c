"""The page around the view, in headless Chromium, over a world that moves by itself (workplace/world.js)."""

import http.server
import shutil
import threading
import time
from pathlib import Path

import pytest

import libgz.view

CLIENT = Path(libgz.view.__file__).parent / "client"
PAGE = Path(__file__).parent / "workplace"
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
PATIENCE = 120_000  # [ms]
SIZES = {"wide": (1280, 800), "narrow": (800, 600), "phone": (390, 844)}
# As the viewer's, but for the page's own import map.
POLICY = "default-src 'none'; script-src 'self' 'unsafe-inline'; style-src 'self'; img-src 'self' data: blob:"
TIMES = "\N{MULTIPLICATION SIGN}"

pytestmark = [
    pytest.mark.skipif(CHROMIUM is None, reason="Debian's chromium is not installed"),
    pytest.mark.filterwarnings("ignore"),
]


class Handler(http.server.SimpleHTTPRequestHandler):
    def translate_path(self, path):
        name = path.split("?")[0].lstrip("/")
        return str(CLIENT / name.removeprefix("client/") if name.startswith("client/") else PAGE / name)

    def end_headers(self):
        self.send_header("Content-Security-Policy", POLICY)
        super().end_headers()

    def log_message(self, *_):
        pass


@pytest.fixture(scope="module")
def address():
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield f"http://127.0.0.1:{server.server_port}/page.html"
        server.shutdown()
        thread.join()


@pytest.fixture(scope="module")
def chromium():
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--headless=new", "--no-sandbox"])
        try:
            yield browser
        finally:
            browser.close()


@pytest.fixture
def opened(chromium, address):
    """A function that opens the page; at the end no page may have had an error."""
    pages = []

    def opened(query="", size="wide", **context):
        width, height = SIZES[size]
        found = chromium.new_context(viewport={"width": width, "height": height}, **context)
        page = found.new_page()
        page.errors = []
        page.on("pageerror", lambda error: page.errors.append(str(error)))
        page.on("console", lambda line: page.errors.append(line.text) if line.type == "error" else None)
        page.set_default_timeout(PATIENCE)
        page.goto(f"{address}?{query}")
        painted(page)
        pages.append(page)
        return page

    yield opened
    for page in pages:
        assert page.errors == []
        assert page.evaluate("window.errors") == []
        page.context.close()


def asked(page, verb, wait=True):
    """What was asked for by a verb: [[argument, content], ...]; forgotten then. Keys may take a moment to arrive."""
    end = time.monotonic() + PATIENCE / 1000.0
    while wait and not page.evaluate("verb => asked.some(one => one[0] === verb)", verb):
        assert time.monotonic() < end, f"{verb} was not asked for"
        page.wait_for_timeout(20)
    return page.evaluate(
        "verb => { const found = asked.filter(one => one[0] === verb).map(one => one.slice(1));"
        " window.asked = asked.filter(one => one[0] !== verb); return found; }",
        verb,
    )


def button(page, name, exact=True):
    return page.get_by_role("button", name=name, exact=exact)


def until(page, condition, argument=None):
    """Wait for a condition, which the page's policy does not let Playwright do itself."""
    end = time.monotonic() + PATIENCE / 1000.0
    test = condition if "=>" in condition.split("(")[0] else f"Boolean({condition})"
    while not page.evaluate(test, argument):
        assert time.monotonic() < end, f"did not happen: {condition}"
        page.wait_for_timeout(20)


def press_until(page, key, test):
    """Press a key, again if need be: browsers may lose one while they are busy, and close dialogs a little later."""
    end = time.monotonic() + PATIENCE / 1000.0
    while True:
        page.keyboard.press(key)
        for _ in range(50):
            if test():
                return
            page.wait_for_timeout(20)
        assert time.monotonic() < end, f"{key} has no effect"


def painted(page):
    """Wait for the page, and for its first image: browsers drop keys and clicks before it."""
    until(page, "window.workplace && performance.getEntriesByName('first-contentful-paint').length")


def row(page, name):
    return page.get_by_role("treeitem", name=name)


# Time ----------------------------------------------------------------------------------------------------------------


def test_the_toolbar_runs_and_steps_the_world(opened):
    page = opened()
    until(page, "parseFloat(document.querySelector('#sim-time').textContent) > 0.1")
    assert page.inner_text("#real-time-factor") == f"1.00{TIMES}"
    assert page.inner_text("#run-state") == "running"
    button(page, "Pause").click()
    assert asked(page, "pause") == [["on", {}]]
    button(page, "Run").wait_for()  # its name says what it does
    assert page.inner_text("#run-state") == "paused"
    before = page.inner_text("#sim-time")
    button(page, "Step").click()
    assert asked(page, "step") == [["1", {}]]
    until(page, "before => document.querySelector('#sim-time').textContent !== before", before)
    button(page, "Reset").click()
    assert asked(page, "reset") == [["-", {}]]
    button(page, "Speed").click()
    page.get_by_role("menuitemradio", name=f"0.5{TIMES}").click()
    assert asked(page, "speed") == [["0.5", {}]]
    button(page, "Speed").click()
    page.get_by_role("menu").get_by_role("slider", name="Speed").fill("1")
    assert asked(page, "speed") == [["10", {}]]
    page.keyboard.press("Escape")
    page.get_by_role("menu").wait_for(state="detached")
    button(page, "Run").click()
    assert asked(page, "pause") == [["off", {}]]


def test_keys_do_what_the_buttons_do(opened):
    page = opened("paused")
    page.keyboard.press("Space")
    assert asked(page, "pause") == [["off", {}]]
    page.keyboard.press("Space")
    page.evaluate("world.chooseRobot('')")  # else the arrow keys drive
    for key, step in (("ArrowRight", "1"), ("ArrowUp", "10")):
        page.keyboard.press(key)
        assert asked(page, "step") == [[step, {}]]
    page.keyboard.press("ArrowLeft")
    assert asked(page, "rewind") == [["1", {}]]
    page.keyboard.press("Control+r")
    assert asked(page, "reset") == [["-", {}]]
    page.evaluate("world.select({entity: 3})")
    for key, mode in (("t", "translate"), ("r", "rotate"), ("r", "none")):
        page.keyboard.press(key)
        until(page, "mode => world.handles.mode === mode", mode)
    page.keyboard.press("l")
    page.keyboard.press("n")
    until(page, "world.handles.space === 'local' && world.handles.snap")
    page.evaluate("world.views = []")
    for key in ("f", "Shift+F", "1", "2", "3", "4", "5", "6"):
        page.keyboard.press(key)
    until(page, "world.views.length === 8")
    assert page.evaluate("world.views") == [{"focus": 3}, "fit", "front", "back", "left", "right", "top", "iso"]
    page.keyboard.press("v")
    until(page, "world.follow === 3")
    page.keyboard.press("Escape")
    until(page, "world.selection === null")
    for key, panel in (("[", "Tree"), ("]", "Inspector")):
        shown = page.get_by_role("complementary", name=panel)
        assert shown.is_visible()
        page.keyboard.press(key)
        shown.wait_for(state="hidden")
        page.keyboard.press(key)
        shown.wait_for()
    # No key does anything while a user types.
    asked(page, "pause")
    page.get_by_label("Search the tree").fill("t")
    page.keyboard.press("Space")
    assert asked(page, "pause", wait=False) == []


def test_keys_act_on_the_world_after_a_button_was_clicked(opened):
    page = opened()
    button(page, "Insert").click()
    page.get_by_role("dialog", name="Insert a model").get_by_label("Search models").wait_for()
    press_until(page, "Escape", lambda: not page.locator("dialog").count())
    page.keyboard.press("Space")
    assert len(asked(page, "pause")) == 1
    button(page, "Reset").click()
    page.keyboard.press("Space")
    assert len(asked(page, "pause")) == 1
    assert len(asked(page, "reset")) == 1
    button(page, "Insert").focus()
    page.keyboard.press("Shift+Tab")
    page.keyboard.press("Tab")
    page.keyboard.press("Space")  # of those who use keys alone
    page.get_by_role("dialog", name="Insert a model").wait_for()


def test_undo_and_redo_by_keys_and_buttons_where_the_server_can(opened):
    page = opened("verbs=undo redo delete")
    page.keyboard.press("Control+z")
    page.keyboard.press("Control+Shift+Z")
    button(page, "Undo").click()
    button(page, "Redo").click()
    until(page, "asked.length === 4")
    assert [len(asked(page, verb)) for verb in ("undo", "redo")] == [2, 2]
    page.evaluate("world.select({entity: 6})")
    page.keyboard.press("Delete")  # without a question, as it can be undone
    assert asked(page, "delete") == [["-", {"name": "arm"}]]
    page = opened("verbs=pause")
    assert button(page, "Undo").count() == 0
    page.keyboard.press("Control+z")
    assert asked(page, "undo", wait=False) == []


def test_models_are_duplicated_and_aligned(opened):
    page = opened("verbs=duplicate align move")
    page.evaluate("world.select({entity: 6})")
    page.keyboard.press("Control+d")
    until(page, "world.selection?.entity === 7")  # the copy
    assert asked(page, "duplicate") == [["-", {"name": "arm"}]]
    button(page, "More for rover").click()
    page.get_by_role("menuitem", name="Align with another model").click()
    dialog = page.get_by_role("dialog", name="Align rover")
    for label, value in (("With", "robot1"), ("Along", "y"), ("At", "high")):
        dialog.get_by_label(label, exact=True).select_option(value)
    button(page, "Align").click()
    assert asked(page, "align") == [["y", {"names": ["robot1", "rover"], "to": "high"}]]


def test_help_shows_the_keys(opened):
    page = opened()
    for key in ("?", "h"):
        dialog = page.get_by_role("dialog", name="Keys")
        press_until(page, key, dialog.count)
        for text in (
            "Pause",
            "Step",
            "Move by handles",
            "Turn by handles",
            "Delete",
            "Drive up and down",
            "Oblique view",
        ):
            dialog.get_by_text(text, exact=True).wait_for()
        press_until(page, "Escape", lambda: not page.locator("dialog").count())
    button(page, "Keys").click()
    button(page, "Close").click()
    page.get_by_role("dialog").wait_for(state="detached")


def test_the_time_line_records_and_rewinds(opened):
    page = opened()
    line = page.get_by_role("slider", name="Time line")
    assert line.is_disabled()
    page.get_by_role("group", name="Time line").get_by_role("button", name="Record 60 s").click()
    assert asked(page, "keep") == [["60", {}]]
    line.focus()
    for _ in range(4):
        page.keyboard.press("ArrowLeft")
    button(page, "Rewind to there").click()
    assert asked(page, "rewind") == [["2", {}]]
    page.get_by_role("toolbar", name="Tools").get_by_role("button", name="Record 60 s").click()
    assert asked(page, "keep") == [["0", {}]]
    assert line.is_disabled()


def test_a_log_has_a_slider_that_seeks(opened):
    page = opened("verbs=pause step speed seek status")
    page.evaluate("world.log = {begin: 0, end: 20, time: 0}; world.emit('status')")
    line = page.get_by_role("slider", name="Time line")
    line.fill("12.5")
    until(page, "asked.some(one => one[0] === 'seek' && one[1] === '12.500')")
    assert page.get_by_role("group", name="Time line").get_by_role("button").filter(visible=True).count() == 0
    until(page, "world.state.simTime > 1 && Number(document.querySelector('.timeline input').value) < 5")  # it follows


# Tree and inspector --------------------------------------------------------------------------------------------------


def test_the_tree_selects_hides_locks_and_finds(opened):
    page = opened()
    tree = page.get_by_role("tree")
    row(page, "robot1").click()
    assert page.evaluate("world.selection") == {"entity": 3}
    row(page, "arm").dblclick()
    assert page.evaluate("world.views.at(-1)") == {"focus": 6}
    row(page, "robot1").hover()
    assert page.evaluate("world.hover") == 3
    for name, switch in (("Hide robot1", "hidden"), ("Lock robot1", "locked")):
        button(page, name).click()
        assert page.evaluate("name => world.isOn(name, 3)", switch)
    button(page, "Show robot1").click()
    assert not page.evaluate("world.isOn('hidden', 3)")
    assert row(page, "laser1").get_attribute("aria-level") == "3"

    tree.focus()
    page.keyboard.press("Home")
    for _ in range(3):
        page.keyboard.press("ArrowDown")
    page.keyboard.press("Enter")
    until(page, "world.entities.get(world.selection.entity).id === 'robot1'")
    assert row(page, "robot1").get_attribute("aria-selected") == "true"
    page.keyboard.press("ArrowLeft")
    row(page, "laser1").wait_for(state="detached")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowRight")
    active = "id => document.querySelector('[role=tree]').getAttribute('aria-activedescendant') === id"
    until(page, active, row(page, "laser1").get_attribute("id"))

    search = page.get_by_label("Search the tree")
    search.fill("should")
    row(page, "shoulder").click()
    assert page.evaluate("world.selection") == {"entity": 6, "part": {"kind": "joint", "name": "shoulder"}}
    assert row(page, "robot1").count() == 0
    search.fill("nothing like it")
    page.get_by_text("Nothing is called").wait_for()
    search.fill("")
    page.evaluate("world.select({entity: 7})")  # as a click in the view
    assert row(page, "rover").get_attribute("aria-selected") == "true"

    row(page, "arm").click(button="right")
    menu = page.get_by_role("menu")
    menu.get_by_role("menuitemcheckbox", name="Joint axes").click()
    menu.get_by_role("menuitemcheckbox", name="Trails").click()  # it stays open
    assert page.evaluate("[world.isOn('axes', 6), world.isOn('trails', 6), world.isOn('axes')]") == [True, True, False]
    page.keyboard.press("Escape")


def test_a_model_with_the_name_of_the_root_folds_alone(opened):
    page = opened()
    page.evaluate("world.entities.get(6).id = 'world'; world.emit('scene')")
    row(page, "world").click()
    assert page.evaluate("world.selection") == {"entity": 6}
    for key, folded in (("ArrowRight", "true"), ("ArrowLeft", "false")):
        page.keyboard.press(key)
        assert row(page, "world").get_attribute("aria-expanded") == folded
    assert row(page, "arena").get_attribute("aria-expanded") == "true"


def test_a_tree_of_many_models_has_few_rows_in_the_page(opened):
    page = opened("models=500")
    tree = page.get_by_role("tree")
    assert page.get_by_role("treeitem").count() < 60
    tree.focus()
    page.keyboard.press("End")
    row(page, "box_499").click()
    assert page.evaluate("world.entities.get(world.selection.entity).id") == "box_499"


def test_names_of_a_world_are_texts(opened):
    page = opened()
    name = "<img src=x onerror=window.evil=1>"
    row(page, name).click()
    assert page.get_by_role("heading", name=name).is_visible()
    page.evaluate(
        "world.messages.push({number: 1, level: 'error', text: '<b>bold</b>', file: '<i>'});"
        " world.overlays = [{name: '<b>', text: '<script>evil</script>', buttons: ['<u>'], images: {}, plots: {}}];"
        " world.emit('messages'); world.emit('overlays')"
    )
    page.get_by_role("tab", name="Console").click()
    page.get_by_text("<b>bold</b>").wait_for()
    page.get_by_text("<script>evil</script>").wait_for()
    assert not page.evaluate("window.evil")
    assert page.locator("#view-area b, .messages i, .tree img").count() == 0


def test_the_inspector_shows_and_sets_a_model(opened):
    page = opened()
    page.evaluate("world.select({entity: 3})")
    panel = page.locator("#inspector")
    assert "Pioneer2AT" in panel.inner_text()
    panel.get_by_text("28.05 kg").wait_for()
    panel.get_by_text("position.robot1", exact=True).wait_for()
    panel.get_by_text("libdrive.so").wait_for()
    assert page.evaluate("world.wants.fields") == []
    panel.get_by_text("position.robot1", exact=True).click()
    panel.get_by_text("stall").wait_for()  # a field of an interface
    chosen = [*(f"pos[{place}]" for place in range(3)), "stall", "ranges[200]/far"]
    assert page.evaluate("world.wants.fields") == [f"position.robot1.{name}" for name in chosen]
    panel.get_by_label("Place in ranges/far").fill("7")
    panel.get_by_label("Place in ranges/far").press("Enter")
    until(page, "world.wants.fields.includes('position.robot1.ranges[7]/far')")
    button(page, "Plot ranges[7]/far").wait_for()
    panel.get_by_text("levels").click()
    until(page, "world.wants.fields.includes('position.robot1.levels[9]')")
    panel.get_by_text("levels").first.click()
    until(page, "!world.wants.fields.includes('position.robot1.levels[9]')")
    for name in ("vx", "wz"):
        assert panel.get_by_text(name, exact=True).is_visible()
    button(page, "Pause").click()
    field = panel.get_by_label("x", exact=True)
    field.fill("1.5")
    field.press("Enter")
    move = asked(page, "move")[0][1]
    assert move["name"] == "robot1"
    assert move["pose"][0] == 1.5
    yaw = panel.get_by_label("yaw", exact=True)
    yaw.fill("90")
    yaw.press("Tab")
    assert asked(page, "move")[0][1]["pose"][3:] == pytest.approx([0.5**0.5, 0, 0, 0.5**0.5])
    field.fill("many")
    field.press("Tab")
    assert field.get_attribute("aria-invalid") == "true"
    assert asked(page, "move", wait=False) == []

    panel.get_by_role("slider", name="ptz1 pan").fill("0.5")
    button(page, "gripper1: close").click()
    until(page, "asked.filter(one => one[0] === 'steer').length === 2")
    assert asked(page, "steer") == [["ptz1/pan", {"value": 0.5}], ["gripper1/2", {"value": 1}]]
    panel.get_by_role("button", name="laser1", exact=True).click()
    assert page.evaluate("world.selection") == {"entity": 4}
    page.evaluate("world.select({entity: 3})")
    button(page, "Fit what is selected").click()
    assert page.evaluate("world.views.at(-1)") == {"focus": 3}
    panel.get_by_role("button", name="Follow what is selected").click()
    assert page.evaluate("world.follow") == 3
    button(page, "More for robot1").click()
    page.get_by_role("menuitemcheckbox", name="Hidden").click()
    assert page.evaluate("world.isOn('hidden', 3)")
    page.keyboard.press("Escape")
    panel.get_by_text("Velocity").click()
    until(page, "localStorage['libgz.inspector.folded']?.includes('Velocity')")
    page.evaluate("world.select({entity: 7})")
    assert not panel.get_by_text("vx", exact=True).is_visible()  # a folded section stays so


@pytest.mark.parametrize("query", ["paused", "paused&watch"])
@pytest.mark.parametrize("part", ["", ", part: {kind: 'body', name: 'link'}"], ids=["model", "link"])
def test_angles_of_poses_are_in_degrees_whether_they_can_be_edited_or_not(opened, query, part):
    page = opened(query)
    page.evaluate("world.state.simTime = 1.5 * Math.PI; world.move()")
    page.evaluate(f"world.select({{entity: 7{part}}})")
    shown = "(name) => { const row = document.querySelector(`[data-series$='\"${name}\"]']`);"
    shown += " return (row.querySelector('input')?.value ?? row.querySelector('output').textContent)"
    shown += " + row.querySelector('.unit').textContent; }"
    assert page.evaluate(shown, "yaw") == "90.0deg"
    assert page.evaluate(shown, "wz").endswith("rad/s")


def test_links_joints_sensors_and_lights(opened):
    page = opened()
    panel = page.locator("#inspector")
    page.evaluate("world.select({entity: 6})")
    panel.get_by_role("slider", name="shoulder").fill("0.75")
    until(page, "asked.some(one => one[0] === 'joint')")
    assert asked(page, "joint") == [["-", {"name": "arm", "joint": "shoulder", "axis": 0, "position": 0.75}]]
    button(page, "Release the joints").click()
    assert asked(page, "release") == [["-", {"name": "arm"}]]
    panel.get_by_role("button", name="shoulder").click()
    for text in ("revolute joint of arm", "arm/base", "arm/upper", "-1 to 1 rad"):
        assert panel.get_by_text(text).is_visible()
    button(page, "To the model").click()
    panel.get_by_role("button", name="upper", exact=True).click()
    assert panel.get_by_text(f"cylinder · 0.4 {TIMES} 0.3 {TIMES} 0.2 m").is_visible()
    button(page, "To the model").click()
    panel.get_by_role("button", name="cam camera", exact=True).click()
    assert panel.get_by_text("10 Hz").is_visible()
    page.evaluate("world.select({entity: 2})")
    panel.get_by_role("slider", name="Brightness").fill("0.5")
    until(page, "asked.some(one => one[0] === 'light')")
    assert asked(page, "light")[0][1]["color"] == pytest.approx([0.5, 0.5, 0.5 * 0.8 / 0.9])
    panel.get_by_label("Colour").fill("#ff0000")
    until(page, "asked.some(one => one[0] === 'light')")
    assert asked(page, "light")[0][1] == {"name": "sun", "color": [0.5, 0, 0]}


def test_attributes_are_edited_within_their_types_and_limits(opened):
    page = opened("verbs=attributes edit embed")
    page.evaluate("world.select({entity: 6})")
    panel = page.locator("#inspector")
    mass = panel.get_by_label("mass")
    mass.fill("3.5")
    mass.press("Tab")
    assert asked(page, "edit") == [["-", {"name": "arm", "key": "mass", "value": 3.5}]]
    for wrong in ("-1", "much", ""):
        mass.fill(wrong)
        mass.press("Tab")
        assert mass.get_attribute("aria-invalid") == "true"
    assert asked(page, "edit", wait=False) == []
    panel.get_by_label("size 2").fill("2.5")
    panel.get_by_label("size 2").press("Tab")
    panel.get_by_label("static").check()
    panel.get_by_label("kind").select_option("a")
    panel.get_by_label("colour").fill("#000000")
    panel.get_by_label("name", exact=True).fill("claw")
    panel.get_by_label("name", exact=True).press("Tab")
    until(page, "asked.filter(one => one[0] === 'edit').length === 5")
    values = [one[1]["value"] for one in asked(page, "edit")]
    assert values == [[1, 2.5, 3], True, "a", [0, 0, 0, 1], "claw"]
    plugin = panel.get_by_label("gravity")
    assert plugin.is_disabled()
    assert "set by the world" in plugin.locator("..").get_attribute("title")
    page.evaluate("world.select({entity: 7})")
    panel.get_by_text("/models/rover/model.sdf", exact=True).wait_for()
    panel.get_by_text("libgz edit /models/rover/model.sdf").wait_for()
    button(page, "Copy into this world").click()
    panel.get_by_text("/models/rover/model.sdf", exact=True).wait_for(state="detached")
    assert asked(page, "embed") == [["-", {"name": "rover"}]]
    page.evaluate("world.select({entity: 6, part: {kind: 'joint', name: 'shoulder'}})")
    until(page, "asked.some(one => one[0] === 'attributes' && one[2].part === 'shoulder' && one[2].kind === 'joint')")


# Plots and console ---------------------------------------------------------------------------------------------------


BUILT_AGAIN = """async () => {
    const { Store } = await import('libgz/store.js');
    const store = new Store();
    const scene = (...names) => store.setScene({
        assets: {}, others: [],
        entities: names.map(([number, id]) => ({ number, id, bodies: [] })),
    });
    const hidden = (number) => store.isOn('hidden', number);
    const shown = () => [store.selection, store.follow, hidden(9), hidden(2), store.isOn('grid')];
    scene([1, 'ground'], [2, 'box']);
    store.select({ entity: 2, part: { kind: 'body', name: 'link' } });
    store.setFollow(2);
    store.setSwitch('hidden', true, 2);
    scene([1, 'ground'], [9, 'box']);
    const edited = shown();
    scene([1, 'ground'], [2, 'box']);
    const undone = shown();
    scene([1, 'ground']);
    return [edited, undone, shown()];
}"""


def test_what_is_built_again_stays_selected_followed_and_hidden(opened):
    edited, undone, deleted = opened().evaluate(BUILT_AGAIN)
    part = {"kind": "body", "name": "link"}
    assert edited == [{"entity": 9, "part": part}, 9, True, False, True]
    assert undone == [{"entity": 2, "part": part}, 2, False, True, True]
    assert deleted == [None, None, False, False, True]


def test_the_inspector_stays_where_it_is_while_a_model_is_edited(opened):
    attributes = [{"key": f"a{i}", "label": f"a{i}", "type": "number", "value": i} for i in range(40)]
    page = opened("verbs=edit+attributes&paused")
    page.evaluate(
        "list => { const { store } = workplace, { ask } = store;"
        " store.ask = async (verb, ...rest) => (verb === 'attributes' ? list : ask.call(store, verb, ...rest)); }",
        attributes,
    )
    row(page, "arm").click()
    field = page.locator("[data-key=a30] input")
    field.focus()
    top = page.evaluate("document.querySelector('#inspector').scrollTop")
    assert top > 100
    page.evaluate("workplace.inspector.build()")
    until(page, "document.activeElement.closest('[data-key=a30]')")
    assert page.evaluate("document.querySelector('#inspector').scrollTop") == top
    row(page, "rover").click()
    until(page, "document.querySelector('[data-key=a30]') && !document.querySelector('#inspector').scrollTop")


def test_an_empty_world_says_how_to_begin(opened):
    page = opened("paused")
    hint = page.locator(".empty-hint")
    assert not hint.is_visible()
    page.evaluate("() => { const { store } = workplace; store.entities = new Map(); store.emit('scene'); }")
    assert "is empty" in hint.inner_text()
    hint.get_by_role("button").click()
    page.get_by_label("Search models").wait_for()


def test_ids_of_interfaces_have_any_letters(opened):
    page = opened()
    page.evaluate("world.entities.get(3).interfaces.push({type: 'gps', id: 'a#b'}); world.select({entity: 3})")
    page.locator("#inspector").get_by_text("gps.a#b", exact=True).click()
    until(page, "world.wants.fields.includes('gps.a#b.fix[1]')")


def test_values_are_dragged_into_plots(opened):
    page = opened(accept_downloads=True)
    page.evaluate("world.select({entity: 3})")
    page.get_by_role("tab", name="Plots").click()
    page.get_by_text("Drag a value from the inspector").wait_for()
    page.locator('[data-series=\'["entity","robot1","vx"]\']').drag_to(page.locator(".plots-panel"))
    plot = page.get_by_role("region", name="Plot", exact=True)
    assert plot.count() == 1
    page.locator("#inspector").get_by_text("yaw", exact=True).drag_to(plot)  # beside a field whose text can be marked
    button(page, "Remove robot1 yaw").click()
    button(page, "Plot robot1 vy").click()
    page.locator("#inspector").get_by_text("position.robot1", exact=True).click()
    button(page, "Plot pos[0]").click()
    assert plot.locator("li").all_inner_texts()[0].split()[:2] == ["robot1", "vx"]
    assert plot.locator("li").count() == 3
    assert plot.get_by_text("m/s").count() == 2
    until(page, "workplace.plots.plots[0].times.length > 20")
    assert plot.locator("canvas").count() == 1
    assert page.evaluate("new Set(workplace.plots.plots[0].curves.map(curve => curve.values.at(-1))).size") == 3
    button(page, "Pause the plot").click()
    count = page.evaluate("workplace.plots.plots[0].times.length")
    with page.expect_download() as download:
        button(page, "Export as CSV").click()
    lines = Path(download.value.path()).read_text().splitlines()
    assert lines[0] == '"sim time [s]","robot1 vx [m/s]","robot1 vy [m/s]","pos[0] [m]"'
    assert len(lines) == count + 1
    assert page.evaluate("workplace.plots.plots[0].times.length") == count
    button(page, "Continue the plot").click()
    button(page, "Time shown").click()
    page.get_by_role("menuitemradio", name="60 s").click()
    until(page, "workplace.plots.plots[0].times.length > 3")
    button(page, "Clear the plot").click()
    button(page, "Remove robot1 vy").click()
    assert plot.locator("li").count() == 2
    page.reload()
    plot.locator("li").nth(1).wait_for()  # plots are remembered
    button(page, "Close the plot").click()
    assert plot.count() == 0


def test_a_plot_goes_back_with_the_world_and_is_bounded(opened):
    page = opened("paused")
    page.evaluate("workplace.plots.add({key: '[\"entity\",\"robot1\",\"x\"]', label: 'x', unit: 'm'})")
    sizes = page.evaluate(
        """() => {
          const [plot] = workplace.plots.plots;
          for (let i = 1; i <= 30000; i++) { world.state.simTime = i / 100; plot.sample(i / 100); }
          const most = plot.times.length;
          world.state.simTime = 250;
          plot.sample(250);
          return [most, plot.times.length === plot.curves[0].values.length, plot.times.at(-1)];
        }"""
    )
    assert sizes[0] <= 20000
    page.evaluate("workplace.layout.openDock('plots'); workplace.plots.plots[0].curves[0].values.fill(3e-9)")
    page.evaluate("workplace.plots.plots[0].draw()")
    until(
        page, "(y => y && Math.abs(y.min + y.max) < 1e-6 && y.max > 0.09)(workplace.plots.plots[0].chart?.scales.y)"
    )  # noise is no curve
    assert sizes[1]
    assert sizes[2] == 250  # its value is there, so that no state that comes later adds one


def test_the_console_lists_counts_and_filters(opened):
    page = opened()
    page.evaluate(
        """() => {
          const levels = ['error', 'warning', 'warning', 'info'];
          const place = {file: '/a/b.world', line: 7, time: 1};
          levels.forEach((level, number) => world.messages.push({number, level, text: `message ${number}`, ...place}));
          world.emit('messages');
        }"""
    )
    tab = page.get_by_role("tab", name="Console")
    until(page, "document.querySelector('#tab-console .badge').textContent === '3'")
    tab.click()
    rows = page.locator(".message")
    assert rows.count() == 4
    assert "/a/b.world:7" in rows.first.inner_text()
    until(page, "document.querySelector('#tab-console .badge').hidden")  # all have been seen
    button(page, "Warnings").click()
    assert rows.count() == 2
    page.get_by_label("Filter messages").fill("message 3")
    assert rows.count() == 1
    button(page, "Clear the console").click()
    assert rows.count() == 0


# View, windows, dialogs ----------------------------------------------------------------------------------------------


def test_marks_views_and_handles(opened):
    page = opened()
    for name, switch in (
        ("Laser rays", "lasers"),
        ("Contacts", "contacts"),
        ("Inertia", "inertia"),
        ("Wireframe", "wireframe"),
    ):
        button(page, "Show").click()
        page.get_by_role("menuitemcheckbox", name=name, exact=True).click()
        assert page.evaluate("name => world.isOn(name)", switch)
        page.keyboard.press("Escape")
    for name, view in (("View from above", "top"), ("Oblique view", "iso"), ("Fit all", "fit")):
        button(page, "Views").click()
        page.get_by_role("menuitem", name=name).click()
        assert page.evaluate("world.views.at(-1)") == view
    tools = page.get_by_role("toolbar", name="View")
    tools.get_by_role("button", name="Move by handles").click()
    assert page.evaluate("world.handles.mode") == "translate"
    tools.get_by_role("button", name="Turn by handles").click()
    assert page.evaluate("world.handles.mode") == "rotate"
    tools.get_by_role("button", name="Handles along the world").click()
    tools.get_by_role("button", name="Snap").click()
    assert page.evaluate("[world.handles.space, world.handles.snap]") == ["local", True]
    tools.get_by_role("button", name="Fit all").click()
    assert page.evaluate("world.views.at(-1)") == "fit"
    with page.expect_download() as download:
        button(page, "Screenshot").click()
    assert download.value.suggested_filename.startswith("arena-")


def test_images_are_windows(opened):
    page = opened()
    button(page, "Show").click()
    page.get_by_role("menuitemcheckbox", name="camera1").click()
    page.keyboard.press("Escape")
    assert page.evaluate("world.wants.images") == ["camera1"]
    window = page.get_by_role("region", name="camera1")
    page.evaluate(
        """() => { const canvas = document.createElement('canvas'); canvas.width = canvas.height = 8;
                   world.images.set('camera1', canvas.toDataURL()); world.emit('images'); }"""
    )
    window.get_by_role("img", name="Image of camera1").wait_for()
    before = window.bounding_box()
    page.mouse.move(before["x"] + 100, before["y"] + 12)
    page.mouse.down()
    page.mouse.move(before["x"] + 180, before["y"] + 72)
    page.mouse.up()
    after = window.bounding_box()
    assert (after["x"] - before["x"], after["y"] - before["y"]) == (80, 60)
    button(page, "Fold camera1").click()
    assert not window.get_by_role("img").is_visible()
    page.evaluate("world.select({entity: 6, part: {kind: 'sensor', name: 'cam'}})")
    button(page, "Image of arm::upper::cam").click()
    assert page.evaluate("world.wants.images") == ["camera1", "arm::upper::cam"]
    button(page, "Close camera1").click()
    assert page.evaluate("world.wants.images") == ["arm::upper::cam"]


def test_a_model_is_inserted_deleted_and_the_world_saved(opened):
    page = opened()
    button(page, "Insert").click()
    dialog = page.get_by_role("dialog", name="Insert a model")
    dialog.get_by_role("option", name="Pioneer 2AT").wait_for()
    assert dialog.get_by_role("option").count() == 5
    dialog.get_by_label("Search models").fill("tab")
    assert dialog.get_by_role("option").count() == 1
    page.keyboard.press("Enter")
    until(page, "asked.some(one => one[0] === 'insert')")
    assert asked(page, "insert") == [["-", {"model": "model://table", "pose": [1, 2, 0, 1, 0, 0, 0]}]]
    until(page, "world.selection?.entity === 7")  # what the server said that it inserted

    page.keyboard.press("Delete")
    page.get_by_role("dialog", name="Delete rover?").get_by_role("button", name="Cancel").click()
    page.locator("dialog").wait_for(state="detached")  # keys are its own until then
    assert asked(page, "delete", wait=False) == []
    page.keyboard.press("Delete")
    page.get_by_role("dialog").get_by_role("button", name="Delete").click()
    page.locator("dialog").wait_for(state="detached")
    assert asked(page, "delete") == [["-", {"name": "rover"}]]
    page.evaluate("world.select({entity: 1})")
    page.keyboard.press("Delete")
    page.get_by_role("dialog").get_by_role("button", name="Delete").click()
    page.get_by_text("ground cannot be deleted").wait_for()  # what the server refuses is shown

    page.evaluate("world.abilities.add('diff')")
    button(page, "Save the world").click()
    page.get_by_text("+<xyz>1 0 0.2</xyz>").wait_for()
    button(page, "Save").click()
    page.get_by_text("Saved: /tmp/a.world").wait_for()
    assert asked(page, "write") == [["-", {}]]


def test_files_are_dropped_on_the_view(opened):
    page = opened()
    drop = """([name, text]) => {
      const data = new DataTransfer();
      data.items.add(new File([text], name));
      const what = {dataTransfer: data, bubbles: true, cancelable: true, clientX: 500, clientY: 300};
      document.querySelector('#view-area').dispatchEvent(new DragEvent('drop', what));
    }"""
    page.evaluate(drop, ["a.sdf", "<sdf/>"])
    until(page, "asked.some(one => one[0] === 'insert')")
    [[_, content]] = asked(page, "insert")
    assert (content["model"], content["text"]) == ("a.sdf", "<sdf/>")  # errors name the file
    page.evaluate(drop, ["a.exe", "x"])
    page.get_by_text("a.exe cannot be inserted; allowed are sdf").wait_for()
    assert asked(page, "insert", wait=False) == []
    page.evaluate("world.abilities.add('mesh')")
    page.evaluate(drop, ["a.stl", "solid"])
    until(page, "asked.some(one => one[0] === 'mesh')")
    assert asked(page, "mesh")[0][1]["data"] == "c29saWQ="


def test_panels_of_plugins_and_their_buttons(opened):
    page = opened()
    page.evaluate(
        """() => { world.overlays = [{name: 'clock', text: '3.2 s', buttons: ['Spawn sphere'],
          images: {front: document.createElement('canvas').toDataURL()},
          plots: {height: {x: [0, 1, 2], lines: {z: [1, 2, 1]}}}}]; world.emit('overlays'); }"""
    )
    window = page.get_by_role("region", name="clock")
    window.get_by_text("3.2 s").wait_for()
    assert window.locator("canvas").count() == 1
    assert window.get_by_role("img", name="front").count() == 1
    button(page, "Spawn sphere").click()
    assert asked(page, "press") == [["clock", {"label": "Spawn sphere"}]]
    page.evaluate("world.overlays = []; world.emit('overlays')")
    assert window.count() == 0


# Driving -------------------------------------------------------------------------------------------------------------


def test_robots_are_driven_by_keys_and_by_the_stick(opened):
    page = opened()
    page.keyboard.down("w")
    page.keyboard.down("a")
    until(page, "world.drives.some(way => way.join() === '1,1,0')")
    page.keyboard.up("w")
    page.keyboard.up("a")
    until(page, "world.drives.at(-1).join() === '0,0,0'")
    page.keyboard.down("ArrowDown")
    until(page, "world.drives.at(-1).join() === '-1,0,0'")
    page.keyboard.up("ArrowDown")
    page.keyboard.down("PageUp")
    until(page, "world.drives.at(-1).join() === '0,0,1'")
    page.evaluate("window.dispatchEvent(new Event('blur'))")  # a window without the focus gets no key up
    until(page, "world.drives.at(-1).join() === '0,0,0'")
    stick = page.get_by_role("application")
    box = stick.bounding_box()
    page.mouse.move(box["x"] + 52, box["y"] + 52)
    page.mouse.down()
    page.mouse.move(box["x"] + 52, box["y"] - 40)
    until(page, "world.drives.at(-1)[0] === 1")
    count = page.evaluate("world.drives.length")
    until(page, "count => world.drives.length > count", count)  # sent again, as servers stop silent pages
    page.mouse.up()
    until(page, "world.drives.at(-1).join() === '0,0,0'")
    stick.focus()
    page.keyboard.down("ArrowUp")
    until(page, "world.drives.at(-1).join() === '1,0,0'")
    page.keyboard.up("ArrowUp")
    page.get_by_role("slider", name="Speed", exact=True).fill("1")
    page.get_by_role("slider", name="Turn", exact=True).fill("2")
    assert page.evaluate("world.speeds") == {"linear": 1, "angular": 2}
    page.get_by_label("Robot", exact=True).select_option("rover (vel_cmd)")
    assert page.evaluate("world.robot") == "rover (vel_cmd)"
    page.get_by_label("Robot", exact=True).select_option("free camera")
    page.keyboard.down("w")
    until(page, "JSON.stringify(world.views.at(-1)) === JSON.stringify({walk: [1, 0, 0]})")
    page.keyboard.up("w")
    until(page, "JSON.stringify(world.views.at(-1)) === JSON.stringify({walk: [0, 0, 0]})")
    button(page, "Close the drive panel").click()
    assert not page.get_by_role("application").is_visible()
    button(page, "Show").click()
    page.get_by_role("menuitemcheckbox", name="Drive panel").click()
    assert page.get_by_role("application").is_visible()


def test_a_gamepad_drives(opened):
    page = opened()
    page.evaluate(
        "navigator.getGamepads = () => [{connected: true, axes: [0, -1, 0, 0], buttons: []}, null]",
    )
    until(page, "world.drives.at(-1)?.join() === '1,0,0'")
    page.evaluate("navigator.getGamepads = () => []")
    until(page, "world.drives.at(-1).join() === '0,0,0'")


# The page ------------------------------------------------------------------------------------------------------------


def test_without_control_a_page_says_so_and_offers_what_works(opened):
    page = opened("watch")
    page.get_by_text("This page only watches").wait_for()
    for name in ("Pause", "Step", "Reset", "Insert", "Save the world"):
        assert button(page, name).count() == 0
    page.evaluate("world.select({entity: 3})")
    assert page.locator("#inspector").get_by_label("x", exact=True).count() == 0
    page.keyboard.press("Space")
    page.keyboard.press("Delete")
    page.keyboard.press("w")
    assert page.evaluate("asked.filter(one => !['describe', 'fields'].includes(one[0]))") == []
    assert page.evaluate("world.drives") == []
    button(page, "Plot robot1 vx").click()
    assert page.get_by_role("region", name="Plot", exact=True).count() == 1
    page.evaluate("world.controllers = {here: false, other: true, canAsk: true}")
    button(page, "Watching").click()
    button(page, "Ask for control").click()
    assert asked(page, "control") == [["ask", {}]]
    page.evaluate("world.control = true; world.asked = 'page 2'; world.emit('hello')")
    page.get_by_text("page 2 asks for control. Answer").wait_for()
    button(page, "page 2 asks for control").click()
    button(page, "Hand over").click()
    assert asked(page, "control") == [["give", {}]]


def test_loading_and_lost_connections_are_shown(opened):
    page = opened("loading")
    assert page.get_by_role("progressbar").inner_text() == "Loading arena …"
    assert 0 < int(page.get_by_role("progressbar").get_attribute("aria-valuenow")) < 100
    page.evaluate("workplace.stage.ready = true; world.emit('progress')")
    assert page.get_by_role("progressbar").count() == 0
    assert not page.locator("#banner").is_visible()
    page.evaluate(
        "world.connected = false; world.status = {text: 'The connection is lost.', level: 'lost'}; world.emit('status')"
    )
    assert "connection is lost" in page.inner_text("#banner")
    assert button(page, "Pause").is_disabled()
    page.evaluate(
        "world.connected = true; world.status = {text: 'The server has ended.', level: 'ended'}; world.emit('status')"
    )
    assert page.inner_text("#banner") == "The server has ended."
    page.evaluate("world.dispatchEvent(new CustomEvent('problem', {detail: {text: 'one', level: 'warning'}}))")
    page.get_by_text("one", exact=True).wait_for()
    button(page, "Dismiss").click()
    assert page.get_by_text("one", exact=True).count() == 0


def test_panels_fold_are_resized_and_are_remembered(opened):
    page = opened()
    tree = page.get_by_role("complementary", name="Tree")
    width = tree.bounding_box()["width"]
    edge = page.get_by_role("separator", name="Width of the tree")
    edge.focus()
    for _ in range(3):
        page.keyboard.press("ArrowRight")
    assert tree.bounding_box()["width"] == width + 48
    box = edge.bounding_box()
    page.mouse.move(box["x"], box["y"] + 200)
    page.mouse.down()
    page.mouse.move(box["x"] + 30, box["y"] + 200)
    page.mouse.up()
    page.get_by_role("complementary", name="Inspector").get_by_role("button", name="Fold the inspector").click()
    page.get_by_role("tab", name="Console").click()
    button(page, "Light theme").click() if button(page, "Light theme").count() else button(page, "Dark theme").click()
    theme = page.evaluate("document.documentElement.dataset.theme")
    page.reload()
    painted(page)
    assert tree.bounding_box()["width"] == pytest.approx(width + 78, abs=1)
    assert not page.get_by_role("complementary", name="Inspector").is_visible()
    assert page.get_by_role("log").is_visible()
    assert page.evaluate("[document.documentElement.dataset.theme, world.theme]") == [theme, theme]
    page.get_by_role("tab", name="Console").click()
    assert not page.get_by_role("log").is_visible()


def test_a_page_without_storage_works(opened):
    page = opened()
    page.context.add_init_script(
        "Object.defineProperty(window, 'localStorage', {get() { throw new Error('forbidden'); }})"
    )
    page.reload()
    painted(page)
    page.get_by_role("tab", name="Console").click()
    assert page.get_by_role("log").is_visible()


@pytest.mark.parametrize("scheme", ["dark", "light"])
def test_the_theme_is_the_systems_at_first(opened, scheme):
    page = opened(color_scheme=scheme)
    assert page.evaluate("[document.documentElement.dataset.theme, world.theme]") == [scheme, scheme]


def test_a_phone_has_sheets_and_a_stick(opened):
    page = opened(size="phone", has_touch=True)
    assert not page.get_by_role("tree").is_visible()
    nav = page.get_by_role("navigation", name="Panels")
    whole = page.locator("#stage").bounding_box()
    nav.get_by_role("button", name="World").tap()  # browsers act on taps a little later
    row(page, "robot1").wait_for()
    seen, sheet = (page.locator(name).bounding_box() for name in ("#stage", "aside.left"))
    assert 0.3 * whole["height"] < seen["height"]
    assert sheet["y"] <= seen["y"] + seen["height"] < sheet["y"] + 50  # the view is above the sheet
    row(page, "robot1").tap()
    until(page, "JSON.stringify(world.selection) === JSON.stringify({entity: 3})")
    nav.get_by_role("button", name="Inspector").tap()
    page.get_by_role("tree").wait_for(state="hidden")
    page.locator("#inspector").get_by_text("Velocity").wait_for()
    button(page, "Plot robot1 vx").tap()
    page.get_by_role("region", name="Plot", exact=True).wait_for()
    nav.get_by_role("button", name="Plots").tap()
    page.get_by_role("region", name="Plot", exact=True).wait_for(state="hidden")
    stick = page.get_by_role("application")
    stick.wait_for()
    box = stick.bounding_box()
    page.mouse.move(box["x"] + 64, box["y"] + 64)
    page.mouse.down()
    page.mouse.move(box["x"], box["y"] + 64)
    until(page, "world.drives.at(-1)?.[1] === 1")
    page.mouse.up()
    button(page, "More").tap()
    page.get_by_role("menuitem", name="Insert").tap()
    page.get_by_role("dialog", name="Insert a model").wait_for()


@pytest.mark.parametrize("size", SIZES)
def test_nothing_is_outside_of_the_window(opened, size):
    page = opened(size=size)
    page.evaluate("world.select({entity: 3}); workplace.layout.openDock('plots')")
    found = page.evaluate(
        """() => [...document.querySelectorAll('button, input, select, [role=tab]')]
          .filter(one => one.offsetParent !== null && !one.closest('.panel-body'))
          .map(one => [one.getAttribute('aria-label') ?? one.textContent, one.getBoundingClientRect()])
          .filter(([, {left, top, right, bottom}]) =>
            left < 0 || top < 0 || right > innerWidth + 1 || bottom > innerHeight + 1)
          .map(([name]) => name)"""
    )
    assert found == []
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")


def test_every_control_has_a_name(opened):
    page = opened()
    page.evaluate(
        """() => { world.select({entity: 3}); workplace.plots.add({key: '["sim","rate"]', label: 'rate', unit: 'Hz'});
                   workplace.layout.openDock('plots'); workplace.images.toggle('camera1', 'camera1'); }"""
    )
    page.locator("#inspector").get_by_text("28.05 kg").wait_for()
    nameless = page.evaluate(
        """() => [...document.querySelectorAll('button, input, select, [role=application], [role=separator]')]
          .filter(one => !(one.getAttribute('aria-label') || one.textContent.trim() || one.labels?.length))
          .map(one => one.outerHTML)"""
    )
    assert nameless == []


def test_texts_can_be_read(opened):
    """Contrast of texts is at least 4.5 in both themes, as WCAG AA wants."""
    for scheme in ("dark", "light"):
        page = opened(color_scheme=scheme)
        colors = page.evaluate(
            """() => { const style = getComputedStyle(document.documentElement);
              return Object.fromEntries(['text', 'text-soft', 'accent', 'error', 'surface', 'raised'].map(
                name => [name, style.getPropertyValue(`--${name}`).trim()])); }"""
        )
        for text in ("text", "text-soft", "error"):
            for ground in ("surface", "raised"):
                assert contrast(colors[text], colors[ground]) >= 4.5, (scheme, text, ground)
        assert contrast(colors["accent"], colors["surface"]) >= 4.5, scheme


def contrast(a, b):
    light = sorted((luminance(a), luminance(b)))
    return (light[1] + 0.05) / (light[0] + 0.05)


def luminance(color):
    parts = [int(color[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
