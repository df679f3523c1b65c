"""Conversion of SDF documents of older versions, as XML: comments and layout stay.

The table conversions.tsv lists what moved: the version that moved it, the elements it stood in (the end of their path),
and the ways from these to the old and to the new place. `@` marks attributes; without a new place, an attribute became
an element of its name.
"""

from __future__ import annotations

import csv
import functools
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from lxml import etree

from libgz.base.errors import Diagnostic, Diagnostics, Remark, WorldFileError
from libgz.sdf.description import LATER, NEWEST, OLDEST
from libgz.sdf.xacro.recognition import has_macros
from libgz.sdf.xml import (
    PLACE,
    ROBOT,
    ROOTS,
    child_of,
    copy_place,
    document_text,
    line_of,
    local_name,
    parse_document,
)

__all__ = ["convert", "upgrade_document"]

VERSIONS = (OLDEST, "1.1", "1.2", "1.3", "1.4", "1.5", NEWEST)
SENSORS = ("camera", "ray", "contact")  # types with an element of their name
TABLE = Path(__file__).with_name("conversions.tsv")
KINDS = {"rate": "angular_velocity", "accel": "linear_acceleration"}  # of the noise of an <imu>


@dataclass(frozen=True)
class _Move:
    """A row of the table."""

    where: tuple[str, ...]
    source: str
    target: str


@functools.cache
def _moves(version: str) -> dict[str, list[_Move]]:
    """Name of an element -> what a version moved in it."""
    found: dict[str, list[_Move]] = {}
    with TABLE.open(encoding="utf-8", newline="") as table:
        for row in csv.DictReader(table, delimiter="\t"):
            if row["version"] == version:
                where = tuple(row["where"].split("/"))
                for source in row["from"].split(" "):
                    move = _Move(where, source, row["to"] or source.removeprefix("@"))
                    found.setdefault(where[-1], []).append(move)
    return found


def convert(root: etree._Element, version: str, target: str, label: str = "<string>") -> list[Remark]:
    """Convert a document in place.

    Args:
        root: its root element; `<gazebo>` becomes `<sdf>`.
        version: of the document, from 1.0 on.
        target: the version to convert to, up to 1.6.
        label: the document's name in the list of changes.

    Returns:
        What was changed, by line.
    """
    work = _Conversion(label)
    for step in VERSIONS:
        if version < step <= target:
            work.take(root, step)
    if local_name(root) == "gazebo":
        work.note(root, "became <sdf>")
        root.tag = "sdf"
    if version != target:
        work.note(root, f"version {version} became {target}")
        root.set("version", target)
    return sorted(work.changes, key=lambda change: change.line)


def upgrade_document(
    data: bytes, label: str = "<string>", path: Path | None = None, arguments: Mapping[str, str] | None = None
) -> tuple[bytes, Sequence[Remark | Diagnostic]]:
    """A document in SDF 1.6, and what was changed; one of a later version stays as it is.

    Args:
        data: the document, SDF or a robot description.
        label: its name in messages.
        path: its file, for what its macros name.
        arguments: of its macros.

    Raises:
        WorldFileError: it cannot be read, is neither, has errors, or its version is not known.
    """
    root = parse_document(data, label, Diagnostics())
    if local_name(root) == ROBOT:
        from libgz.sdf.urdf import sdf_of  # other documents do without them
        from libgz.sdf.xacro.expansion import expand

        diagnostics = Diagnostics()
        robot = expand(root, label, diagnostics, path=path, arguments=arguments) if has_macros(root, path) else root
        sdf = sdf_of(robot, label, diagnostics)
        diagnostics.raise_errors()
        return document_text(sdf), [
            Remark(label, line_of(robot), ROBOT, f"became <sdf version='{NEWEST}'>"),
            *diagnostics.warnings,
        ]
    version = root.get("version", OLDEST if local_name(root) == "gazebo" else "")
    if local_name(root) not in ROOTS or not version:
        raise WorldFileError(f"{label}:{line_of(root)}: <{local_name(root)}>: the root must be <sdf version='...'>")
    if version not in VERSIONS:
        if version in LATER or re.fullmatch(r"1\.\d\d", version):  # those after the last one are read as that
            return data, []
        known = f"{OLDEST} to {LATER[-1]} are known"
        raise WorldFileError(f"{label}:{line_of(root)}: <{local_name(root)}>: version is {version!r}; {known}")
    changes = convert(root, version, NEWEST, label)
    if not changes:
        return data, []
    encoding = root.getroottree().docinfo.encoding or "UTF-8"
    nodes = [*reversed(list(root.itersiblings(preceding=True))), root, *root.itersiblings()]
    lines = [f"<?xml version='1.0' encoding='{encoding}'?>"]
    lines += [etree.tostring(node, encoding="unicode", with_tail=False) for node in nodes]
    return "\n".join([*lines, ""]).encode(encoding, "xmlcharrefreplace"), changes


class _Conversion:
    def __init__(self, label: str) -> None:
        self.label = label
        self.changes: list[Remark] = []

    def note(self, xml: etree._Element, message: str) -> None:
        self.changes.append(Remark(self.label, line_of(xml), local_name(xml), message))

    def take(self, root: etree._Element, version: str) -> None:
        """One step, to the next version."""
        moves = _moves(version)
        for xml, path in list(_walk(root, ())):
            for move in moves.get(path[-1], ()):
                if path[-len(move.where) :] == move.where:
                    self._move(xml, move)
            if version == "1.2" and path[-1] == "sensor" and "type" not in xml.attrib:
                self._name_type(xml)
            if version == "1.5" and path[-1] in ("axis", "axis2") and child_of(xml, "use_parent_model_frame") is None:
                _add(xml, "use_parent_model_frame").text = "true"
                self.note(xml, "<use_parent_model_frame> true was added: up to 1.4, axes are in the model's frame")
            if version == "1.6" and path[-1] == "imu":
                self._spread_noise(xml)

    def _move(self, xml: etree._Element, move: _Move) -> None:
        way, _, attribute = move.source.partition("@")
        source: etree._Element | None = xml
        for step in filter(None, way.split("/")):
            source = child_of(source, step) if source is not None else None
        if source is None or (attribute and attribute not in source.attrib):
            return
        *steps, name = move.target.split("/")
        holder = xml
        for step in steps:
            known = holder.getparent() if step == ".." else child_of(holder, step)
            holder = known if known is not None else _add(holder, step, source)
        old = f"attribute {attribute!r}" + (f" of <{way}>" if way else "") if attribute else f"<{way}>"
        present = child_of(holder, name)
        if present is not None and (present is not source or not attribute):
            self.note(source, f"{old} was dropped, for there is a <{name}>")
        else:
            self.note(source, f"{old} became <{'/'.join(step for step in (*steps, name) if step != '..')}>")
            target = source if present is source else _add(holder, name, source)
            if attribute:
                target.text = source.get(attribute)
            else:
                target.text = source.text
                target.extend(list(source))
                target.attrib.update(source.attrib)
        if attribute:
            del source.attrib[attribute]
        if source is not xml and source is not present and (not attribute or _is_empty(source)):
            _remove(source)

    def _name_type(self, sensor: etree._Element) -> None:
        """Set the type of a sensor that has none, by its content."""
        kind = next((name for name in SENSORS if child_of(sensor, name) is not None), None)
        if kind is not None:
            sensor.set("type", kind)
            self.note(sensor, f"type {kind!r} was added, for there is a <{kind}>")

    def _spread_noise(self, imu: etree._Element) -> None:
        """Replace one noise for all axes by one for each."""
        noise = child_of(imu, "noise")
        if noise is None:
            return
        kind = child_of(noise, "type")
        for old, new in KINDS.items():
            values = child_of(noise, old)
            if values is None:
                continue
            holder = child_of(imu, new)
            holder = _add(imu, new) if holder is None else holder
            for axis in "xyz":
                target = _add(_add(holder, axis), "noise")
                target.set("type", ((kind.text if kind is not None else "") or "gaussian").strip())
                for value in values:
                    if isinstance(value.tag, str):
                        _add(target, local_name(value)).text = value.text
        _remove(noise)
        self.note(noise, "was split into <angular_velocity> and <linear_acceleration>, for each axis")


def _walk(xml: etree._Element, above: tuple[str, ...]) -> Iterator[tuple[etree._Element, tuple[str, ...]]]:
    """Elements with their paths, parents first; not those in plugins."""
    path = (*above, local_name(xml))
    yield xml, path
    for child in xml:
        if isinstance(child.tag, str) and local_name(child) != "plugin":
            yield from _walk(child, path)


def _is_empty(xml: etree._Element) -> bool:
    return not len(xml) and not set(xml.attrib) - {PLACE} and not (xml.text or "").strip()


def _add(xml: etree._Element, name: str, source: etree._Element | None = None) -> etree._Element:
    """Add a child on a line of its own; for messages, it has the line of its source."""
    indent = _indent(xml)
    if len(xml):
        xml[-1].tail = f"{(xml[-1].tail or '').rstrip()}\n{indent}  "
    else:
        xml.text = f"{(xml.text or '').rstrip()}\n{indent}  "
    child = etree.SubElement(xml, name)
    child.tail = f"\n{indent}"
    copy_place(child, xml if source is None else source)
    return child


def _indent(xml: etree._Element) -> str:
    """The blanks before an element."""
    before = xml.getprevious()
    above = xml.getparent()
    text = before.tail if before is not None else above.text if above is not None else ""
    return (text or "").rpartition("\n")[2] if not (text or "").strip() else ""


def _remove(xml: etree._Element) -> None:
    """Remove an element with the blanks after it."""
    above, before = xml.getparent(), xml.getprevious()
    if above is None:
        return
    if xml.getnext() is None and before is not None:
        before.tail = xml.tail
    elif xml.getnext() is None:
        above.text = None if not (above.text or "").strip() else above.text
    xml.tail = None
    above.remove(xml)
