"""Worlds: starts the worlds of a test, each under a server id of its own, and ends them."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Unpack

from libgz.base.files import is_file
from libgz.front import World, WorldOptions
from libgz.transport.server import on_free_server_id

__all__ = ["Worlds"]


class Worlds:
    """The worlds of one test; the fixture `libgz_world` is one of these.

    Args:
        folder: where worldfiles are looked for first, such as that of the test's file.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._started: list[World] = []

    @property
    def started(self) -> list[World]:
        """The worlds that were started and not ended yet, in order."""
        return list(self._started)

    def __call__(self, world: str | os.PathLike[str], **options: Unpack[WorldOptions]) -> World:
        """Start a world: ready to step, serving its interfaces, and strict.

        The world is at `world.server_id`, which no other server on this machine has, so that tests can run in parallel.

        Args:
            world: a worldfile beside the test's file, what `World.from_file` takes, or the text of a world, which
                begins with ``<``.
            **options: those of World; `server_id=None` keeps the interfaces in this process, `strict=False` lets the
                world run on after errors and warnings.

        Raises:
            WorldFileError: there is no such worldfile, or it has errors; the message lists them all.
            StrictError: there was a warning about the world, or an error of a model or plugin.
            PluginError: a model's Init failed.
        """
        chosen: WorldOptions = {"strict": True, **options}
        if "server_id" in chosen:
            return self._start(world, chosen)
        return on_free_server_id(lambda server_id: self._start(world, {**chosen, "server_id": server_id}))

    def _start(self, world: str | os.PathLike[str], options: WorldOptions) -> World:
        if isinstance(world, str) and world.lstrip().startswith("<"):
            started = World.from_string(world, **options)
        else:
            beside = self._folder / world
            named = beside.with_name(f"{beside.name}.world")
            found = next((path for path in (beside, named) if is_file(path)), world)
            started = World.from_file(found, **options)
        self._started.append(started)
        return started

    def close(self) -> None:
        """End all worlds.

        Raises:
            StrictError: a strict world had an error or warning that was not raised yet, such as one of its end.
        """
        ended, self._started = self._started, []
        for world in reversed(ended):
            world.close()
        for world in ended:
            world.problems.check(again=False)
