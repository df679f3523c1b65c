"""Checking a worldfile or an SDF file: it is loaded as in the server, but no server is started and no step is made."""

from __future__ import annotations

import contextlib
import logging
import os
import sys
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from libgz.base.errors import Diagnostic, Diagnostics, GazeboError, PluginError, WorldFileError
from libgz.base.files import exists
from libgz.classic.loading import find_plugin
from libgz.classic.ros_names import absence
from libgz.front import World
from libgz.legacy.model import Model
from libgz.rendering.choice import prefer, preferred
from libgz.rendering.image import read_image
from libgz.sdf.element import Element
from libgz.sdf.reader import SdfFile
from libgz.sdf.recognition import is_sdf, is_sdf_text
from libgz.worldfile.file import WorldFile
from libgz.worldfile.search import find_worldfile, why_missing

__all__ = ["check", "check_sdf"]


class _Collector(logging.Handler):
    """Collects the warnings that are logged while a world loads."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.records: list[logging.LogRecord] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.records.append(record)


def check(
    filename: str | os.PathLike[str], arguments: Mapping[str, str] | None = None, text: bytes | None = None
) -> list[Diagnostic]:
    """All errors and warnings about a worldfile, in order of its lines.

    Loading runs `Load` of its plugins; `Init` of no model is called. An SDF file is checked by `check_sdf`.

    Args:
        filename: the worldfile, or the name of one of libgz's worlds.
        arguments: of the macros of a robot description.
        text: what is checked instead of the file's text, as if the file had it.
    """
    path = find_worldfile(filename)
    if is_sdf(path) if text is None else is_sdf_text(text):
        return check_sdf(path, arguments, text)
    file, name = WorldFile(), str(path)
    if text is None and not exists(path):
        missing = f"cannot read worldfile {name!r}: it does not exist{why_missing(filename)}"
        return [Diagnostic(name, 0, "", missing, "error")]
    try:
        if text is None:
            file.Load(path)
        else:
            file.LoadString(text, name)
            file.filename = name
    except WorldFileError as error:
        return [_from_text(name, line) for line in str(error).splitlines()]
    with _collected(file.diagnostics, name) as found, World() as world:
        try:
            world.Load(file)
        except WorldFileError:
            pass  # its lines are the file's errors
        else:
            _find_clashes(world.legacy.models)
            _find_unreadable(world.legacy.models)
    return found


@contextlib.contextmanager
def _collected(diagnostics: Diagnostics, name: str) -> Iterator[list[Diagnostic]]:
    """Fill a list, by line, with a file's diagnostics and with what is logged meanwhile."""
    handler, logger = _Collector(), logging.getLogger("libgz")
    before, propagate = logger.handlers[:], logger.propagate
    logger.handlers[:], logger.propagate = [handler], False
    found: list[Diagnostic] = []
    try:
        yield found
    finally:
        logger.handlers[:], logger.propagate = before, propagate
    known = {str(diagnostic) for diagnostic in diagnostics.found}
    for record in handler.records:
        text = record.getMessage()
        if text not in known:
            known.add(text)
            diagnostics.remark(name, text)
    every = [*diagnostics.errors, *diagnostics.warnings]
    placed = [one._replace(included=diagnostics.includes.get(one.file, 0)) for one in every]
    found += sorted(placed, key=lambda diagnostic: diagnostic.included or diagnostic.line)


def check_sdf(
    filename: str | os.PathLike[str], arguments: Mapping[str, str] | None = None, text: bytes | None = None
) -> list[Diagnostic]:
    """All errors and warnings about an SDF file: it is built with its sensors, in order of its lines.

    Plugins are searched for, not run; nothing is rendered.

    Args:
        filename: the file.
        arguments: of the macros of a robot description.
        text: what is checked instead of the file's text, as if the file had it.
    """
    name = str(filename)
    try:
        if text is None:
            file = SdfFile.load(filename, arguments=arguments)
        else:
            file = SdfFile.from_string(text, name, Path(name).parent)
    except WorldFileError as error:
        return [_from_text(name, line) for line in str(error).splitlines()]
    file.diagnostics.most_alike = sys.maxsize
    missing: dict[str, Element] = {}  # message -> its first element
    for element in list(file.root.find("plugin")):
        library = element.Get(str, "filename")
        try:
            find_plugin(library, name)
        except PluginError:
            missing.setdefault(
                absence(library) or f"there is no plugin {library!r} here; a run goes without it", element
            )
        if element.parent is not None:
            element.parent.RemoveChild(element)
    for message, element in missing.items():
        file.diagnostics.warn(element, message)
    before = preferred()
    with _collected(file.diagnostics, name) as found, World() as world:
        prefer("none")
        try:
            world.load_sdf(file)
            world.Initialize()
        except GazeboError as error:
            file.diagnostics.failure(file.root, error)
        finally:
            prefer(before)
    return found


def _from_text(name: str, line: str) -> Diagnostic:
    """The error of a file that cannot be parsed, from a line of its message."""
    rest = line.removeprefix(f"{name}:")
    number, _, message = rest.partition(":")
    if rest == line or not number.isdigit():
        return Diagnostic(name, 0, "", line, "error")
    element, separator, what = message.strip().partition(">: ")
    if separator and element.startswith("<"):
        return Diagnostic(name, int(number), element[1:], what, "error")
    return Diagnostic(name, int(number), "", message.strip(), "error")


def _find_clashes(models: list[Model]) -> None:
    """Warn of models whose interfaces have the same type and id: only the first one is served."""
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
            where = f", line {first.node.line}," if first.node is not None else ""
            model.node.warn(f"does not serve {names}: <model:{first.GetName()}>{where} does; give it another id")


def _find_unreadable(models: list[Model]) -> None:
    """Warn of textures and skins that cannot be read, once each."""
    tried: set[Path] = set()

    def attempt(read: Callable[[Path], object], path: Path | None, model: Model) -> None:
        if path is None or path in tried:
            return
        tried.add(path)
        try:
            read(path)
        except GazeboError as error:
            if model.node is not None:
                model.node.warn(str(error))

    for model in models:
        for look in (geom.appearance for body in model.bodies for geom in body.geoms):
            attempt(read_image, look.texture_file, model)
            attempt(_read_skin, look.skin_file, model)


def _read_skin(path: Path) -> None:
    from libgz.rendering.skin import read_skin  # imports OpenGL, which worlds without skins do not need

    read_skin(path)
