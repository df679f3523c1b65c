"""What `world.view()` opens: a page with a world of this process, embedded where a notebook shows it."""

from __future__ import annotations

import atexit
import contextlib
import html
import json
import logging
import threading
import time
import weakref
from typing import Any

from libgz.apps.world_control import WorldControl, steps_of
from libgz.base.closing import Closing
from libgz.base.errors import GazeboError, LibraryError
from libgz.base.extras import install
from libgz.front import World
from libgz.simulation.pacing import Pacer
from libgz.transport.control import Request

__all__ = ["WorldView", "view"]

log = logging.getLogger("libgz.view")

NOT_HERE = {"keep", "rewind"}  # requests that are left out: a notebook has the methods of the world
IDLE = 0.05  # [s]
LAST = 1.0  # [s] that a page shows the end of its world


class _Controls:
    """Does what a page's users want with a world of this process; Run steps it in real time, in a thread."""

    def __init__(self, world: World) -> None:
        self._world, self._requests = world, WorldControl(world)
        self._steps = 0  # that are still to do
        self._runs = False
        self._pacer = Pacer(1.0)
        threading.Thread(target=self._loop, name="world", daemon=True).start()

    @property
    def abilities(self) -> frozenset[str]:
        """The requests that work."""
        return frozenset(self.ask("abilities")) - NOT_HERE

    def ask(self, verb: str, argument: str = "-", **content: Any) -> Any:
        """Do something between two steps.

        Raises:
            GazeboError: it was refused.
        """
        if verb == "pause":
            self._pacer = Pacer(self._pacer.speed)
            self._runs, self._steps = argument == "off", 0
            if self._runs:
                self._world.paused = False
            return None
        if verb == "step":
            with self._world.lock:
                self._steps += steps_of(argument)
                self._world.paused = False
            return None
        with self._world.lock:
            answer = self._requests.obey(Request(verb, argument, json.dumps(content).encode() if content else b""))
            if verb == "speed":
                self._pacer = Pacer(self._requests.speed or 0.0)
        return json.loads(answer) if answer else None

    def interface(self, kind: str, id: str) -> Any:
        """An interface of the world.

        Raises:
            NotFoundError: there is none.
        """
        return self._world.interface(kind, id)

    def reconnect(self) -> None:
        """Nothing to do: the world does not come back."""

    def _passed(self) -> float:
        """The time that steps have simulated, paused ones included [s]."""
        return self._world.GetSimTime() + self._world.GetPauseTime()

    def _loop(self) -> None:
        world, after = self._world, self._passed()
        while world.running:
            if not self._runs and not self._steps:
                time.sleep(IDLE)
                continue
            if self._passed() != after:  # cells, a reset or an undo have moved it, and nothing is to catch up
                self._pacer = Pacer(self._pacer.speed)
            try:
                world.Step()
                with world.lock:
                    self._requests.stepped()
                    self._steps = max(self._steps - 1, 0)
            except GazeboError as error:
                if world.running:
                    log.error("the world does not run on: %s", error)
                self._runs, self._steps = False, 0
                continue
            after = self._passed()
            while self._runs and self._passed() == after and not self._pacer.sleep(after):
                pass


class WorldView(Closing):
    """The live view of a world, until it or the world is closed. As the result of a cell it is an embedded page.

    Args:
        world: in this process.
        width: of the embedded page, as CSS has it.
        height: of it [px].
        host: address to bind.
        port: first one that is tried.
        watch_only: nobody can control the world from the page.
        skins: of the robots of worldfiles, "fine" or "plain".

    Attributes:
        viewer: shows the page.
        url: the address of the page, with the token that lets it control the world.

    Raises:
        LibraryError: the extra `view` is not installed.
        ClosedError: the world is closed.
        GazeboError: no port is free.
    """

    def __init__(
        self,
        world: World,
        width: str = "100%",
        height: int = 600,
        *,
        host: str = "127.0.0.1",
        port: int = 8080,
        watch_only: bool = False,
        skins: str = "fine",
    ) -> None:
        try:
            from libgz.view.local import LocalSource
            from libgz.view.viewer import Viewer
        except ImportError as error:
            raise LibraryError(f"the viewer needs the extra `view`: {install('view')} ({error})") from None
        self.world, self._size = world, (width, height)
        self._widget: Any = None
        source = LocalSource(world)
        self.viewer = Viewer(source, None if watch_only else _Controls(world), host=host, port=port, skins=skins)
        self.viewer.frame()
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._run, name="viewer", daemon=True)
        self._thread.start()
        atexit.register(self.close)

    def _run(self) -> None:
        with self.viewer:
            self.viewer.run(lambda: self._closed.is_set() or not self.world.running)
            with contextlib.suppress(GazeboError):
                self.viewer.frame()
            self._closed.wait(LAST)
        if self._widget is not None:
            self._widget.end()

    @property
    def url(self) -> str:
        """The address of the page, with the token that lets it control the world."""
        return self.viewer.url

    def __repr__(self) -> str:
        return f"<WorldView {self.url if self._thread.is_alive() else 'closed'}>"

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, Any]:
        """As a widget, where the extra `notebook` is installed and the notebook shows widgets; else as a frame."""
        shown: dict[str, Any] = {"text/plain": repr(self), "text/html": self._repr_html_()}
        try:
            from libgz.view.notebook import NotebookWidget
        except ImportError:
            return shown
        if self._widget is None:
            width, height = self._size
            self._widget = NotebookWidget(self.viewer, str(width), int(height))
        bundle = self._widget._repr_mimebundle_()
        widget = bundle[0] if isinstance(bundle, tuple) else bundle or {}
        return {**widget, **shown}

    def _repr_html_(self) -> str:
        width, height = self._size
        return (
            f'<iframe src="{html.escape(self.url)}" width="{html.escape(str(width))}" height="{int(height)}" '
            'style="border:0" allow="fullscreen"></iframe>'
        )

    def close(self) -> None:
        """End the page. Can be called twice."""
        self._closed.set()
        atexit.unregister(self.close)
        if threading.current_thread() is not self._thread:
            self._thread.join(10.0)


_views: weakref.WeakKeyDictionary[World, WorldView] = weakref.WeakKeyDictionary()


def view(world: World, **options: Any) -> WorldView:
    """The view of a world: the open one, if it has one already; the options are those of `WorldView`."""
    known = _views.get(world)
    if known is None or not known._thread.is_alive() or options:
        _views[world] = known = WorldView(world, **options)
    return known
