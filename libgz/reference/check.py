"""Checking a worldfile: it is loaded as the server would, but nothing is started, stepped or left behind."""

from __future__ import annotations

import logging
import os
from collections.abc import Iterator

from libgz.errors import Diagnostic, GazeboError, WorldFileError
from libgz.front import World
from libgz.legacy.model import Model
from libgz.worldfile.file import WorldFile

__all__ = ["check"]


class _Gathered(logging.Handler):
    """Keeps the warnings that are logged while a world loads."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.records: list[logging.LogRecord] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.records.append(record)


def check(filename: str | os.PathLike[str]) -> list[Diagnostic]:
    """All that is wrong or unused in a worldfile, in order of its lines.

    Its plugins are run as far as `Load`, as loading needs it; `Init` of no model is called.

    Args:
        filename: the worldfile.
    """
    file, name = WorldFile(), os.fspath(filename)
    try:
        file.Load(filename)
    except WorldFileError as error:
        return [_from_text(name, line) for line in str(error).splitlines()]
    handler, logger = _Gathered(), logging.getLogger("libgz")
    before, propagate = logger.handlers[:], logger.propagate
    logger.handlers[:], logger.propagate = [handler], False
    world = World()
    try:
        world.Load(file)
    except WorldFileError:
        pass  # its lines are the file's errors
    else:
        _find_clashes(world.models)
        _find_unreadable(world.models)
    finally:
        world.close()
        logger.handlers[:], logger.propagate = before, propagate
    told = {str(error) for error in file.diagnostics.found}
    others = (Diagnostic(name, 0, "", text, "warning") for text in _messages(handler) if text not in told)
    return sorted([*file.diagnostics.found, *others], key=lambda error: error.line)


def _messages(handler: _Gathered) -> Iterator[str]:
    """What was logged; once each."""
    yield from dict.fromkeys(record.getMessage() for record in handler.records)


def _from_text(name: str, line: str) -> Diagnostic:
    """The error of a file that cannot be parsed at all, from its message."""
    rest = line.removeprefix(f"{name}:")
    number, _, message = rest.partition(":")
    if rest == line or not number.isdigit():
        return Diagnostic(name, 0, "", line, "error")
    element, separator, what = message.strip().partition(">: ")
    if separator and element.startswith("<"):
        return Diagnostic(name, int(number), element[1:], what, "error")
    return Diagnostic(name, int(number), "", message.strip(), "error")


def _find_clashes(models: list[Model]) -> None:
    """Warn of models that want to serve one interface under one id: only the first is served."""
    served: dict[tuple[str, str], Model] = {}
    for model in models:
        lost = []
        for interface in model.interfaces:
            first = served.setdefault((interface, model.GetId()), model)
            if first is not model:
                lost.append((interface, first))
        if lost and model.node is not None:
            names = " and ".join(f"{interface}.{model.GetId()}" for interface, _ in lost)
            first = lost[0][1]
            where = f", line {first.node.line}" if first.node is not None else ""
            model.node.warn(f"does not serve {names}, for <model:{first.GetName()}>{where}, does; give it another id")


def _find_unreadable(models: list[Model]) -> None:
    """Warn of pictures and skins that cameras could not draw; each is told once."""
    from libgz.rendering.image import read_image  # here, for they bring OpenGL's constants along
    from libgz.rendering.skin import read_skin

    tried = set()
    for model in models:
        looks = [geom.appearance for body in model.bodies for geom in body.geoms]
        for look in looks:
            for path, read in ((look.texture_file, read_image), (look.skin_file, read_skin)):
                if path is None or path in tried:
                    continue
                tried.add(path)
                try:
                    read(path)
                except GazeboError as error:
                    if model.node is not None:
                        model.node.warn(str(error))
