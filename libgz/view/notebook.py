"""The page in a notebook, over the channel (comm) of the kernel instead of a second port: wherever widgets work."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable
from typing import Any

import anywidget
import traitlets

from libgz.view.gate import CLIENT
from libgz.view.protocol import LARGEST_MESSAGE, held_size, read_message
from libgz.view.replay import frame_page
from libgz.view.viewer import Viewer

__all__ = ["NotebookWidget"]

MOST_VIEWS = 16  # of a widget
MOST_WAITING = 400  # messages to a view
_numbers = itertools.count(-2, -1)  # of pages: those of a port are above 0

Send = Callable[[dict[str, Any], bytes | None], None]


class _View:
    """A page of a widget, as a viewer has pages: it gets the next messages when it has shown the last ones.

    Attributes:
        number, may_control, visible, wants: as those of other pages.
    """

    def __init__(self, viewer: Viewer, may_control: bool, send: Send) -> None:
        self.number, self.may_control, self.visible = next(_numbers), may_control, True
        self.wants: dict[str, list[str]] = {}
        self._viewer, self._send = viewer, send
        self._waiting: dict[str, bytes | str] = {}
        self._assets: set[str] = set()  # that it has
        self._lock = threading.Lock()
        self._busy = False

    def post(self, key: str, message: bytes | str) -> None:
        """Send a message, when the page has time; one of the same key that has not been sent is dropped for it."""
        with self._lock:
            self._waiting.pop(key, None)
            self._waiting[key] = message
            while len(self._waiting) > MOST_WAITING:
                self._waiting.pop(next(iter(self._waiting)))
        self._flush()

    def acted(self) -> None:
        """A message has been acted on: the notebook counts none."""

    def shown(self) -> None:
        """The page has shown what it was sent."""
        with self._lock:
            self._busy = False
        self._flush()

    def _flush(self) -> None:
        with self._lock:
            if self._busy or not self._waiting:
                return
            self._busy, messages, self._waiting = True, self._waiting, {}
        for key, message in messages.items():
            if key == "scene":
                self._send_assets()
            if isinstance(message, bytes):
                self._send({}, message)
            else:
                self._send({"text": message}, None)
        self._send({"end": True}, None)

    def _send_assets(self) -> None:
        for name in sorted(self._viewer.asset_names - self._assets):
            self._assets.add(name)
            asset = self._viewer.assets.get(name)
            if asset is not None:
                self._send({"asset": name, "kind": asset.kind}, asset.body)


class NotebookWidget(anywidget.AnyWidget):  # type: ignore[misc,unused-ignore]
    """Shows a viewer's world where a notebook shows the widget, as often as it does.

    Args:
        viewer: of the world.
        width: as CSS has it.
        height: [px].
    """

    _esm = (CLIENT / "notebook.js").read_text()
    width = traitlets.Unicode("100%").tag(sync=True)
    height = traitlets.Int(600).tag(sync=True)

    def __init__(self, viewer: Viewer, width: str, height: int) -> None:
        super().__init__(width=width, height=height)
        self._viewer, self._views, self._ended = viewer, dict[str, _View](), False
        self.on_msg(self._hear)

    def end(self) -> None:
        """The viewer is closed: the pages say so."""
        self._ended = True
        for name in list(self._views):
            self.send({"view": name, "closed": True})

    def _hear(self, _widget: Any, content: Any, _buffers: Any) -> None:
        """A message of a view: it opens, closes, has shown what it got, or is one of its page."""
        name = content.get("view") if isinstance(content, dict) else None
        if not isinstance(name, str) or len(name) > 100:
            return
        view = self._views.get(name)
        if content.get("open") is True and view is None:
            if len(self._views) >= MOST_VIEWS:  # the oldest: a notebook that is loaded again closes none
                self._close(next(iter(self._views)))

            def send(message: dict[str, Any], data: bytes | None) -> None:
                self.send({"view": name, **message}, buffers=[data] if data is not None else None)

            self._views[name] = view = _View(self._viewer, self._viewer.controls is not None, send)
            send({"page": frame_page("libgz")}, None)
            if self._ended:
                send({"closed": True}, None)
            else:
                self._viewer.open(view)
        elif view is None:
            return
        elif content.get("close") is True:
            self._close(name)
        elif content.get("shown") is True:
            view.shown()
        elif isinstance(content.get("text"), str) and len(content["text"]) <= LARGEST_MESSAGE:
            message = read_message(content["text"])
            if message is not None:
                self._viewer.hear(view, message, held_size(content["text"]))

    def _close(self, name: str) -> None:
        self._viewer.leave(self._views.pop(name))
