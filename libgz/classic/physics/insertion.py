"""Insertion of models and lights into a running world."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import Future
from typing import TYPE_CHECKING

from libgz.base.errors import ParameterError
from libgz.sdf.element import Element
from libgz.sdf.paths import find_model
from libgz.sdf.reader import SdfFile
from libgz.sdf.upgrade import NEWEST, upgraded
from libgz.sdfworld.world import BUILT, SdfWorld

if TYPE_CHECKING:
    from libgz.classic.physics.world import World
    from libgz.classic.sdf import SDF

__all__ = ["described", "insert_document", "insert_file", "insert_now", "insert_text"]


def described(sdf: Element | SdfFile | SDF, name: str) -> Element:
    """The element of a name in a document, or the element itself, with the defaults of the newest version of SDF.

    Raises:
        ParameterError: there is none.
        WorldFileError: it has errors.
    """
    root = sdf if isinstance(sdf, Element) else getattr(sdf, "root", None)
    found = root if isinstance(root, Element) and root.name == name else None
    if found is None and isinstance(root, Element):
        found = next(root.find(name), None)
    if found is None:
        raise ParameterError(f"Load takes a <{name}> element, or a document with one, not {sdf!r}")
    text = f"<sdf version='{NEWEST}'><model name='_'>{upgraded(found).ToString()}</model></sdf>"
    file = SdfFile.from_string(text, found.where)
    file.diagnostics.raise_errors()
    return next(file.root.find(name))


def insert_text(world: World, text: str) -> None:
    """Add the models and lights of an SDF text."""
    _insert(world, lambda: SdfFile.from_string(text))


def insert_file(world: World, filename: str | os.PathLike[str]) -> None:
    """Add the models and lights of a file or `model://name`.

    Raises:
        ParameterError: it is not the name of a file.
    """
    if not isinstance(filename, str | os.PathLike):
        raise ParameterError(f"InsertModelFile takes a file's name or model://name, not {filename!r}")
    _insert(world, lambda: SdfFile.load(find_model(os.fspath(filename))))


def insert_document(world: World, sdf: Element | SdfFile | SDF) -> Future[None]:
    """Add the models and lights of an SDF document, or of one element of it.

    Returns:
        Whether it was done, or the error.

    Raises:
        ParameterError: it is neither.
    """
    root = sdf if isinstance(sdf, Element) else getattr(sdf, "root", None)
    if not isinstance(root, Element):
        raise ParameterError(f"InsertModelSDF takes an SDF document or an element of one, not {sdf!r}")
    whole = upgraded(root)
    text = whole.ToString() if root.name != "sdf" else "".join(part.ToString() for part in whole.children)
    return _insert(world, lambda: SdfFile.from_string(f"<sdf version='{NEWEST}'>{text}</sdf>"))


def _insert(world: World, read: Callable[[], SdfFile]) -> Future[None]:
    done: Future[None] = Future()

    def insert() -> None:
        try:
            insert_now(world, read())
        except BaseException as error:
            done.set_exception(error)
            raise
        done.set_result(None)

    world.core.after_step(insert)
    return done


def insert_now(world: World, file: SdfFile) -> None:
    """Add the models and lights of a document, with their sensors and plugins, between two steps.

    Raises:
        ParameterError: a name is taken.
        WorldFileError: it has errors, or holds no model or light.
    """
    _check_names(world, file.root)
    world.core.extension(SdfWorld).insert(file)
    world.server.finish_added()


def _check_names(world: World, root: Element) -> None:
    taken = {entity.GetId() for entity in world.core.entities} | world.server.ids.new_names
    for element in next(root.named("world"), root).children:
        name = element.Get(str, "name") if element.name in BUILT else ""
        if name in taken:
            raise ParameterError(
                f"{element.where}: A {element.name} named [{name}] already exists and allow_renaming is false. "
                f"{element.name.capitalize()} won't be inserted."
            )
        taken.update([name] if name else [])
