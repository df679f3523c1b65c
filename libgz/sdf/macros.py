"""Expansion of xacro files: robot descriptions with macros, by the package of that name."""

from __future__ import annotations

import importlib
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

from lxml import etree

from libgz.base.errors import Diagnostics, GazeboError, NotFoundError, WorldFileError
from libgz.sdf.paths import find_uri
from libgz.sdf.xml import parse_document

__all__ = ["expanded"]

PREFIX = "xacro"
_lock = threading.Lock()  # the package keeps its state in variables of its modules


def expanded(
    root: etree._Element, label: str, path: Path | None, diagnostics: Diagnostics
) -> tuple[etree._Element, str]:
    """(root, label) of a document whose macros are expanded; the same ones if it has none.

    Lines are those of what xacro prints then, and the label says so.

    Args:
        root: of the document.
        label: its name in messages.
        path: its file; None for a text.
        diagnostics: takes warnings.

    Raises:
        WorldFileError: it cannot be expanded, or the package xacro is not installed.
    """
    if not any(element.prefix == PREFIX for element in root.iter(etree.Element)):
        return root, label
    if path is None:
        raise WorldFileError(f"{label}: macros of xacro are expanded in files only; `xacro` prints the result")
    label = f"{label} (expanded)"
    return parse_document(_expand(path), label, diagnostics), label


def _expand(path: Path) -> bytes:
    """The text of a file as xacro prints it.

    `$(find NAME)` finds packages as `package://NAME` does, then as ROS does. Arguments have their defaults.
    """
    try:
        xacro: Any = importlib.import_module("xacro")
        substitution: Any = importlib.import_module("xacro.substitution_args")
    except ImportError:
        raise WorldFileError(f"{path} needs the package xacro: pip install 'libgz[urdf]'") from None
    with _lock:
        by_ros = substitution._eval_find
        substitution._eval_find = _finder(path.parent, by_ros)  # it has no setting for that
        try:
            document = xacro.process_file(str(path), mappings={})
            return bytes(document.toprettyxml(indent="  ", encoding="utf-8"))
        except GazeboError as error:
            raise WorldFileError(f"{path}: {error}") from None
        except Exception as error:  # noqa: BLE001 - expressions of the file are run
            raise WorldFileError(f"{path}: xacro cannot expand it: {error}") from None
        finally:
            substitution._eval_find = by_ros


def _finder(beside: Path, by_ros: Callable[[str], str]) -> Callable[[str], str]:
    def find(package: str) -> str:
        try:
            return str(find_uri(f"package://{package}", beside))
        except NotFoundError as missing:
            try:
                return by_ros(package)
            except Exception:  # noqa: BLE001 - ROS is not here, or has no such package
                raise missing from None

    return find
