"""libgz models: list all models, or describe one."""

from __future__ import annotations

import argparse
import dataclasses
import json
import textwrap
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from libgz.apps.console import say, writing
from libgz.reference.catalogue import Entry, Part, Row, common_rows, entries, entry
from libgz.reference.pages import write_pages

__all__ = ["configure", "describe", "run"]

WIDTH = 100


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("name", nargs="?", metavar="MODEL", help="the model to describe (default: list all models)")
    parser.add_argument("--json", action="store_true", help="print JSON: an array of all models, or one model's object")
    parser.add_argument(
        "--pages", type=Path, metavar="DIR", help="write the reference pages of all built-in models to a directory"
    )


def run(options: argparse.Namespace) -> int:
    """List all models, describe one, or write the reference pages.

    Raises:
        GazeboError: there is no such model, or pages cannot be written.
    """
    if options.pages is not None:
        with writing():
            changed = write_pages(options.pages)
        say("\n".join(map(str, changed)) or f"the pages in {options.pages} are current")
    elif options.name is not None:
        model = entry(options.name)
        say(json.dumps(_as_json(model, whole=True), indent=2) if options.json else describe(model), end="")
        say(end="\n" if options.json else "")
    elif options.json:
        say(json.dumps([_as_json(model) for model in entries()], indent=2))
    else:
        found = list(entries())
        width = max(len(entry.name) for entry in found)
        for known in found:
            say(f"{known.name:{width}}  {known.summary}")
    return 0


def _as_json(model: Entry, *, whole: bool = False) -> dict[str, Any]:
    """A model for programs; with its attributes if it is wanted whole."""
    row: dict[str, Any] = {"name": model.name, "summary": model.summary, "interfaces": list(model.kind.interfaces)}
    if whole:
        row["attributes"] = [dataclasses.asdict(attribute) for attribute in (*model.rows, *common_rows())]
        row["example"] = model.example
    return row


def describe(model: Entry) -> str:
    """The description of a model, as text for a terminal."""
    bodies, joints = model.parts()
    sections = [f"{model.name}: {model.summary}"]
    if model.description:
        sections.append(model.description)
    sections.append(f"Interfaces: {', '.join(model.kind.interfaces) or 'none'}")
    sections.append("Attributes:\n" + (_attributes(model.rows) or "  none\n").rstrip())
    sections.append("Attributes of all models:\n" + _attributes(common_rows()).rstrip())
    sections.append("Bodies:\n" + _parts(bodies))
    if joints:
        sections.append("Joints:\n" + _parts(joints))
    sections.append("Example:\n" + textwrap.indent(model.example.rstrip(), "  "))
    return "\n\n".join(sections) + "\n"


def _attributes(rows: Iterable[Row]) -> str:
    """Name, unit, type and default on one line, the meaning below."""
    text = ""
    for row in rows:
        unit = f" [{row.unit}]" if row.unit else ""
        default = f", default {row.default}" if row.default else ""
        text += f"  {row.name}{unit}: {row.type}{default}\n"
        text += textwrap.fill(row.meaning, WIDTH, initial_indent="      ", subsequent_indent="      ") + "\n"
    return text


def _parts(parts: list[Part]) -> str:
    width = max(len(part.name) for part in parts)
    indent = " " * (width + 4)
    return "\n".join(
        textwrap.fill(f"{part.name:{width}}  {part.text}", WIDTH, initial_indent="  ", subsequent_indent=indent)
        for part in parts
    )
