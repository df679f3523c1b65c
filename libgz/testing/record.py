"""Record: what a failed test leaves behind: images of its worlds, and what was logged."""

from __future__ import annotations

import logging
import re
from collections.abc import Iterable
from pathlib import Path

from libgz.base.errors import GazeboError
from libgz.base.geometry import GzQuaternToEuler
from libgz.base.visible import visible
from libgz.front import World
from libgz.recording.images import FreeView, ImageSource, cameras_of
from libgz.rendering.framing import overview
from libgz.rendering.image import write_image

__all__ = ["Record"]

_UNSAFE = re.compile(r"[^\w.,=+-]+")
LONGEST = 120  # characters of a file name


class Record:
    """Collects what libgz logs from its construction on, until `close`."""

    def __init__(self) -> None:
        self._lines: list[str] = []
        self._logger = logging.getLogger("libgz")
        self._level = self._logger.level
        self._handler = _Lines(self._lines)
        self._logger.addHandler(self._handler)
        self._logger.setLevel(logging.DEBUG)

    def close(self) -> None:
        """Stop collecting."""
        self._logger.removeHandler(self._handler)
        self._logger.setLevel(self._level)

    def save(self, folder: Path, test: str, failure: str, worlds: Iterable[World]) -> Path:
        """Save an image of each camera of each world, an overview of each world, and the log; the test's own folder.

        Args:
            folder: of all tests.
            test: the name of the test.
            failure: why it failed, for the log.
            worlds: those that it had started and not ended.

        Raises:
            OSError: a file cannot be written.
        """
        place = folder / _UNSAFE.sub("-", test).strip("-")[-LONGEST:]
        place.mkdir(parents=True, exist_ok=True)
        for old in place.iterdir():  # of an earlier run
            if old.suffix in (".png", ".txt"):
                old.unlink()
        text = [f"test: {test}", *self._lines]  # before rendering, which is logged, too
        for number, world in enumerate(worlds):
            text += ["", *_describe(world)]
            text += _save_images(world, place, f"world{number}" if number else "world")
        (place / "log.txt").write_text("\n".join([*text, "", failure, ""]), encoding="utf-8")
        return place


class _Lines(logging.Handler):
    """Keeps messages as lines of text."""

    def __init__(self, lines: list[str]) -> None:
        super().__init__(logging.DEBUG)
        self._lines = lines
        self.setFormatter(logging.Formatter("%(levelname)-8s%(name)s: %(message)s"))

    def emit(self, record: logging.LogRecord) -> None:
        self._lines.append(visible(self.format(record)))


def _describe(world: World) -> list[str]:
    """The state of a world, a line for each model."""
    served = f"world {world.name!r}, server id {world.server_id}, sim time {world.GetSimTime():.3f} s"
    lines = [served, "  models: x y z [m] roll pitch yaw [rad]"]
    for model in world.models:
        try:
            pose = model.GetPose()
            numbers = " ".join(f"{value:.4f}" for value in (*pose.pos, *GzQuaternToEuler(pose.rot)))
            lines.append(f"  {model.GetId() or model.GetName()}: {numbers}")
        except GazeboError as error:
            lines.append(f"  {model.GetId() or model.GetName()}: {error}")
    return lines + [f"  {problem}" for problem in (*world.errors, *world.warnings)]


def _save_images(world: World, place: Path, prefix: str) -> list[str]:
    """Save the images of a world; what could not be saved, as lines for the log."""
    lost = []
    try:
        sources: dict[str, ImageSource] = {**cameras_of(world), "overview": FreeView(world, overview(world))}
    except GazeboError as error:
        return [f"  no images: {error}"]
    for name, source in sources.items():
        try:
            image = source.image()
            if image.size:
                write_image(place / f"{prefix}-{_UNSAFE.sub('-', name)[-LONGEST:]}.png", image)
            else:
                lost.append(f"  no image of {name}: rendering is disabled, or the camera has rendered none yet")
        except GazeboError as error:
            lost.append(f"  no image of {name}: {error}")
    return lost
