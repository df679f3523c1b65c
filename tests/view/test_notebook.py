"""The page in a notebook, over the kernel's channel: what the widget sends, and the page with such a kernel."""

import base64
import json
import queue
import time
from pathlib import Path

import pytest
from view_pages import PATIENCE, browser, is_error, needs_chromium, wait_for
from view_sockets import scene_of, state_of

import libgz
from libgz.apps.notebook import WorldView

pytest.importorskip("anywidget")
SCRIPT = (Path(libgz.__file__).parent / "view" / "client" / "notebook.js").read_text()


@pytest.fixture
def view():
    with libgz.World.from_file("worlds/pioneer2at.world") as world, WorldView(world, port=18970) as shown:
        shown._repr_mimebundle_()
        yield shown


class Kernel:
    """What is sent to a notebook's page, as the kernel's channel would."""

    def __init__(self, view, monkeypatch):
        self.sent = queue.Queue()
        self.widget = view._widget
        monkeypatch.setattr(self.widget, "send", lambda content, buffers=None: self.sent.put((content, buffers or [])))

    def hear(self, **content):
        self.widget._hear(self.widget, content, [])

    def until(self, accept):
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            content, buffers = self.sent.get(timeout=PATIENCE)
            if content.get("end"):
                self.hear(view=content["view"], shown=True)
            if accept(content, buffers):
                return content, buffers
        raise AssertionError("it was not sent")

    def answer(self, view, number, verb, argument="-", **content):
        ask = {"ask": verb, "number": number, "argument": argument, "content": content}
        self.hear(view=view, text=json.dumps(ask))
        wanted = f'"answer": {number}'
        return json.loads(self.until(lambda message, _: wanted in message.get("text", ""))[0]["text"])


def test_a_notebook_shows_a_widget_and_a_frame_where_there_is_none(view):
    bundle = view._repr_mimebundle_()
    assert "application/vnd.jupyter.widget-view+json" in bundle
    assert "<iframe" in bundle["text/html"]
    assert view._repr_mimebundle_() == bundle


def test_a_notebook_that_is_loaded_again_and_again_shows_the_world(view, monkeypatch):
    kernel = Kernel(view, monkeypatch)
    for number in range(20):
        kernel.hear(view=str(number), open=True)
    page, _ = kernel.until(lambda message, _: message["view"] == "19" and "page" in message)
    assert 'id="port"' in page["page"]
    wait_for(lambda: view.viewer.pages == 16, "the oldest are closed")


def test_scene_states_and_answers_come_over_the_channel(view, monkeypatch):
    kernel = Kernel(view, monkeypatch)
    kernel.hear(view="a", open=True)
    page, _ = kernel.until(lambda message, _: "page" in message)
    assert 'id="port"' in page["page"]
    _, [scene] = kernel.until(lambda _, buffers: buffers and buffers[0][0] == 3)
    assert "robot1" in {entity["id"] for entity in scene_of(scene)["entities"]}
    _, [state] = kernel.until(lambda _, buffers: buffers and buffers[0][0] == 1)
    begin = state_of(state)[1][1]
    assert kernel.answer("a", 1, "step", "5")["value"] is None
    kernel.until(lambda _, buffers: buffers and buffers[0][0] == 1 and state_of(buffers[0])[1][1] > begin)
    assert "no request" in kernel.answer("a", 2, "publish", "x")["error"]
    for argument in ("-1", "1e3", "1000000000", "9" * 60):
        assert "allowed are 1 to 100000" in kernel.answer("a", 3, "step", argument)["error"]
    assert kernel.answer("a", 4, "step", "100000")["value"] is None  # and the page lives on meanwhile
    assert kernel.answer("a", 5, "pause", "on")["value"] is None
    for content in ({}, {"view": 7}, {"view": "a", "text": "{"}, {"view": "a", "text": 3}, {"view": "b", "text": "{}"}):
        kernel.hear(**content)
    kernel.hear(view="a", close=True)
    kernel.hear(view="a", shown=True)
    wait_for(lambda: view.viewer.pages == 0, "the page is closed")


def test_a_page_that_shows_nothing_is_sent_no_more(view, monkeypatch):
    kernel = Kernel(view, monkeypatch)
    kernel.hear(view="a", open=True)
    while "end" not in kernel.sent.get(timeout=PATIENCE)[0]:
        pass
    for _ in range(20):
        view.world.step()
        view.viewer.do(lambda: None)
    time.sleep(0.3)
    assert kernel.sent.empty()  # until the page says that it has shown the first ones
    kernel.hear(view="a", shown=True)
    kernel.until(lambda _, buffers: buffers and buffers[0][0] == 1)


HOST = """async (script) => {
    const module = await import(URL.createObjectURL(new Blob([script], { type: "text/javascript" })));
    const heard = [];
    window.sent = [];
    window.send = (content) => window.sent.push(content);
    const model = {
        get: (name) => ({ width: "100%", height: 500 })[name],
        send: (content) => window.send(content),
        on: (_, hear) => heard.push(hear),
        off: (_, hear) => heard.splice(heard.indexOf(hear), 1),
    };
    window.hear = (content, data) => {
        const bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
        for (const one of heard) one(content, data.map((text) => new DataView(bytes(text).buffer)));
    };
    module.default.render({ model, el: document.body });
}"""


@needs_chromium
def test_the_page_in_a_frame_shows_and_steps_the_world(view, monkeypatch):
    kernel = Kernel(view, monkeypatch)
    with browser() as chromium:
        page = chromium.new_page(viewport={"width": 900, "height": 560})
        errors = []
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.on("console", lambda line: errors.append(line.text) if is_error(line) else None)
        page.set_default_timeout(1000.0 * PATIENCE)
        page.goto("about:blank")
        page.evaluate(HOST, SCRIPT)

        def passes(condition):
            """Pass messages on in both directions; whether the page in the frame fulfils a condition."""
            for content in page.evaluate("window.sent.splice(0)"):
                kernel.hear(**content)
            while not kernel.sent.empty():
                content, buffers = kernel.sent.get()
                page.evaluate("([c, d]) => hear(c, d)", [content, [base64.b64encode(one).decode() for one in buffers]])
            frame = page.frames[-1]
            return len(page.frames) > 1 and frame.evaluate(f"Boolean({condition})")

        wait_for(lambda: passes("window.libgz?.workplace.stage.ready"), "the world is shown")
        frame = page.frames[-1]
        before = view.world.GetSimTime()
        frame.get_by_role("button", name="Step", exact=True).click()
        wait_for(lambda: passes(f"libgz.store.state.simTime > {before}"), "a step is made and shown")
        assert frame.evaluate("libgz.store.control")

        view.close()
        wait_for(lambda: passes("!libgz.store.connected"), "the view is closed")
        assert "This view is closed" in frame.inner_text("#banner")
        page.evaluate("() => { window.send = () => { throw new Error('the kernel has ended'); }; }")
        page.evaluate("window.dispatchEvent(new Event('pagehide'))")
        assert errors == []


def test_what_cells_step_does_not_stop_a_running_world(view):
    world, controls = view.world, view.viewer.controls
    controls.ask("pause", "off")
    wait_for(lambda: world.GetSimTime() > 0.1, "the world runs")
    world.run(2.0 * PATIENCE)
    ahead = world.GetSimTime()
    wait_for(lambda: world.GetSimTime() > ahead + 0.1, "the world runs on")
    controls.ask("pause", "on")


def test_a_page_that_comes_after_the_end_says_so(view, monkeypatch):
    kernel = Kernel(view, monkeypatch)
    view.close()
    kernel.hear(view="a", open=True)
    kernel.until(lambda message, _: message.get("closed"))
    kernel.hear(view="a", close=True)
