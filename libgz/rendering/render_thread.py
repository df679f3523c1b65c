"""RenderThread: renders shots into arrays, in the thread of an OpenGL context."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from concurrent.futures import Future
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import ClosedError
from libgz.rendering.context import Context
from libgz.rendering.native import find_native
from libgz.rendering.renderer import Renderer
from libgz.rendering.shot import Shot

__all__ = ["RenderThread"]


class RenderThread:
    """A renderer and the context in whose thread its tape is played; several threads may use it."""

    def __init__(self, context: Context) -> None:
        self.context = context
        self._recording = threading.Lock()
        self._renderer: Renderer | None = Renderer(context, find_native())

    @property
    def renderer(self) -> Renderer:
        """The renderer.

        Raises:
            ClosedError: the context was closed.
        """
        if self._renderer is None:
            raise ClosedError(f"the {self.context.name} context was closed")
        return self._renderer

    @property
    def closed(self) -> bool:
        """Whether `close` was called."""
        return self.context.closed

    def render(self, shot: Shot, image: NDArray[np.uint8] | None, depth: NDArray[np.float32] | None = None) -> None:
        """Render a shot into arrays; see `Renderer.render`."""
        self.start(shot, image, depth).result()

    def start(
        self, shot: Shot, image: NDArray[np.uint8] | None, depth: NDArray[np.float32] | None = None
    ) -> Future[None]:
        """Begin to render a shot; see `Renderer.render`. Do not touch the arrays before the result is there.

        The world is read before this returns, and may change afterwards.
        """
        with self._recorder() as renderer:
            renderer.render(shot, image, depth)
            return renderer.gl.play()

    def segment(self, shot: Shot) -> NDArray[np.int32]:
        """The number of the model at each pixel, 0 for none; shape (height, width)."""
        colors = np.zeros((shot.view.height, shot.view.width, 3), dtype=np.uint8)
        with self._recorder() as renderer:
            renderer.segment(shot, colors)
            playing = renderer.gl.play()
        playing.result()
        return colors.astype(np.int32) @ np.array((1, 256, 65536), dtype=np.int32)

    @contextmanager
    def _recorder(self) -> Iterator[Renderer]:
        """The renderer, for one thread at a time; a new one after what ended it early, such as Ctrl-C."""
        with self._recording:
            try:
                yield self.renderer
            except BaseException:
                if not self.closed:
                    self._renderer = Renderer(self.context, find_native())
                raise

    def close(self) -> None:
        """Release the context with all meshes and buffers, and end its thread. Can be called twice."""
        self.context.close()
        self._renderer = None
