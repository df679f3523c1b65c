"""The slider of a log's time: what a user wants stays, whatever the log says meanwhile."""

import asyncio
import time
from types import SimpleNamespace

import pytest

from libgz.view import log_slider
from libgz.view.log_slider import LogSlider


class Slider:
    """A slider of a page, whose user can move it."""

    def __init__(self, **_):
        self.min, self.max, self.value = 0.0, 1.0, 0.0
        self.sent = []

    def on_update(self, changed):
        self.changed = changed

    def __setattr__(self, name, value):
        if name == "value" and value != getattr(self, "value", None) and hasattr(self, "sent"):
            self.sent.append(value)  # as viser does
        object.__setattr__(self, name, value)

    def move(self, value, client=0):
        object.__setattr__(self, "value", value)
        asyncio.run(self.changed(SimpleNamespace(client_id=client, target=self)))


@pytest.fixture
def parts(monkeypatch):
    """A slider with its handle, what waits to be done, and what was sought."""
    monkeypatch.setattr(log_slider, "HOLD", 0.0)
    handle, waiting, sought = Slider(), [], []
    loop = SimpleNamespace(call_soon_threadsafe=lambda function, *arguments: function(*arguments))
    page = SimpleNamespace(gui=SimpleNamespace(add_slider=lambda *_, **__: handle), get_event_loop=lambda: loop)
    return SimpleNamespace(
        slider=LogSlider(page, waiting.append, sought.append), handle=handle, waiting=waiting, sought=sought
    )


def status(now):
    return {"begin": 0.0, "end": 4.0, "time": now}


def test_the_slider_shows_where_the_log_is(parts):
    parts.slider.show(status(1.234), parts.slider.moves)
    assert (parts.handle.min, parts.handle.max, parts.handle.value) == (0.0, 4.0, 1.23)
    parts.slider.show(status(9.0), parts.slider.moves)
    assert parts.handle.value == 4.0
    assert not parts.waiting  # the program's own changes are no user's


def test_a_status_from_before_a_move_does_not_undo_it(parts):
    parts.slider.show(status(0.0), parts.slider.moves)
    asked = parts.slider.moves
    parts.handle.move(4.0)
    parts.slider.show(status(0.0), asked)
    assert parts.handle.value == 4.0
    parts.slider.show(status(0.0), parts.slider.moves)  # asked for before the move was passed on
    assert parts.handle.value == 4.0
    parts.waiting.pop()()
    assert parts.sought == [4.0]
    parts.slider.show(status(3.5), parts.slider.moves)
    assert parts.handle.value == 3.5


def test_the_slider_is_the_users_for_a_while(parts, monkeypatch):
    now = time.monotonic()
    monkeypatch.setattr(log_slider, "HOLD", 2.0)
    monkeypatch.setattr(log_slider.time, "monotonic", lambda: now)
    parts.handle.move(2.0)
    parts.waiting.pop()()
    parts.slider.show(status(1.0), parts.slider.moves)
    assert parts.handle.value == 2.0
    now += 2.1
    parts.slider.show(status(1.0), parts.slider.moves)
    assert parts.handle.value == 1.0


def test_the_page_is_put_right_after_a_move(parts):
    parts.slider.show(status(1.0), parts.slider.moves)  # on its way to the page while the user moves the slider
    for moment in (4.0, 0.0, 2.0):
        parts.handle.move(moment)
        parts.waiting.pop()()
        parts.handle.sent.clear()
        parts.slider.show(status(moment), parts.slider.moves)
        assert parts.handle.sent[-1] == moment
        parts.handle.sent.clear()
        parts.slider.show(status(moment), parts.slider.moves)
        assert not parts.handle.sent
