"""Which GUI plugins a client has: those of gui.ini, of the command line, and of the world."""

from __future__ import annotations

import configparser
import logging
import os
from collections.abc import Iterator, Sequence
from pathlib import Path

from libgz.sdf.element import Element

__all__ = ["gui_of", "ini_plugins", "named_plugins", "read_ini"]

log = logging.getLogger("libgz.classic")


def read_ini() -> configparser.ConfigParser:
    """The file that GAZEBO_GUI_INI_FILE names, or ~/.gazebo/gui.ini; empty if it cannot be read, which is logged."""
    path = Path(os.environ.get("GAZEBO_GUI_INI_FILE") or "~/.gazebo/gui.ini").expanduser()
    parser = configparser.ConfigParser(interpolation=None, strict=False)
    try:
        parser.read(path, encoding="utf-8")
    except (configparser.Error, UnicodeDecodeError) as error:
        log.warning("%s cannot be read: %s", path, error)
        return configparser.ConfigParser()
    return parser


def ini_plugins() -> list[str]:
    """The plugins that gui.ini names: ``[overlay_plugins] filenames=a.so:b.so``."""
    names = read_ini().get("overlay_plugins", "filenames", fallback="")
    return [name.strip() for name in names.split(":") if name.strip()]


def gui_of(world: Element | None) -> Element | None:
    """The `<gui>` of a world, if it has one."""
    return next(world.named("gui"), None) if world is not None else None


def named_plugins(filenames: Sequence[str], world: Element | None) -> Iterator[tuple[str, str, Element]]:
    """(filename, name, element) of all GUI plugins, in the order in which they are loaded.

    Args:
        filenames: those of the command line.
        world: the element of the world.
    """
    for filename in (*ini_plugins(), *filenames):
        yield filename, filename, Element("plugin")
    gui = gui_of(world)
    for element in gui.named("plugin") if gui is not None else ():
        yield element.Get(str, "filename"), element.Get(str, "name"), element
