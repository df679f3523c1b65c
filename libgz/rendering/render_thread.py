"""RenderThread: renders shots into arrays, in the thread of an OpenGL context."""

from __future__ import annotations

from concurrent.futures import Future

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import ClosedError
from libgz.rendering.context import Context
from libgz.rendering.renderer import Renderer
from libgz.rendering.shot import Content, Shot

__all__ = ["RenderThread"]


class RenderThread:
    """A renderer and the context in whose thread it runs."""

    def __init__(self, context: Context) -> None:
        self.context = context
        self._renderer: Renderer | None = context.run(Renderer, context.gl)
        self._rendered: Content | None = None  # by the last `start`

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
        self.context.run(self.renderer.render, shot, image, depth)

    def start(self, shot: Shot, image: NDArray[np.uint8], wait: bool) -> Future[None]:
        """Begin to render a shot. Do not touch the array before the result is there.

        Args:
            shot: what to render.
            image: out, shape (height, width, 3).
            wait: return only when the image is complete. New content always waits, because compiling it reads geoms.
        """
        rendering = self.context.submit(self.renderer.render, shot, image)
        if wait or shot.content is not self._rendered:
            rendering.result()
        self._rendered = shot.content
        return rendering

    def segment(self, shot: Shot) -> NDArray[np.int32]:
        """The number of the model at each pixel, 0 for none; shape (height, width)."""
        colors = np.zeros((shot.view.height, shot.view.width, 3), dtype=np.uint8)
        self.context.run(self.renderer.segment, shot, colors)
        return colors.astype(np.int32) @ np.array((1, 256, 65536), dtype=np.int32)

    def close(self) -> None:
        """Release the context with all meshes and buffers, and end its thread. Can be called twice."""
        self.context.close()
        self._renderer = self._rendered = None
