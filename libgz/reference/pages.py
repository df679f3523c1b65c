"""Reference pages in Markdown: one per model and an index, made from the catalogue."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from libgz.base.files import write_whole
from libgz.legacy.factory import ModelFactory
from libgz.models import MODELS
from libgz.reference.catalogue import Entry, Part, Row, common_rows, entries
from libgz.reference.markdown import NOTE

__all__ = ["INDEX", "pages", "write_changed", "write_pages"]

INDEX = "README.md"


def pages() -> dict[str, str]:
    """File name -> text of all pages of the built-in models."""
    found = [entry for entry in entries(ModelFactory()) if entry.name in MODELS]
    return {INDEX: _index(found), **{f"{entry.name}.md": page(entry) for entry in found}}


def write_pages(directory: Path) -> list[Path]:
    """Write all pages; the files that changed.

    Raises:
        OSError: a file cannot be written.
    """
    return write_changed(directory, pages())


def write_changed(directory: Path, texts: dict[str, str]) -> list[Path]:
    """Write texts by file name, unless a file has its text already; the files that changed.

    Raises:
        OSError: a file cannot be written.
    """
    directory.mkdir(parents=True, exist_ok=True)
    changed = []
    for name, text in texts.items():
        path = directory / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            write_whole(path, text.encode())
            changed.append(path)
    return changed


def page(entry: Entry) -> str:
    """The page of one model."""
    bodies, joints = entry.parts()
    parts = [NOTE, f"# {entry.name}\n", f"{entry.summary}\n"]
    if entry.description:
        parts.append(f"{entry.description}\n")
    parts += [_interfaces(entry), "## Attributes\n", _attributes(entry.rows)]
    parts += [f"It also has the [attributes of all models]({INDEX}#attributes-of-all-models).\n"]
    parts += ["## Bodies\n", _table(("body", "mass and shapes"), bodies)]
    if joints:
        parts += ["## Joints\n", _table(("joint", "kind and bodies"), joints)]
    parts += ["## Example\n", f"```xml\n{entry.example}```\n"]
    return "\n".join(parts)


def _index(found: list[Entry]) -> str:
    models = "\n".join(f"| [{e.name}]({e.name}.md) | {_cell(e.summary)} |" for e in found)
    parts = [NOTE, "# The models in full\n", "The models for `<model:...>` elements of a worldfile.\n"]
    parts += [f"| model | description |\n|---|---|\n{models}\n", "## Attributes of all models\n"]
    parts += [_attributes(common_rows())]
    return "\n".join(parts)


def _interfaces(entry: Entry) -> str:
    if not entry.kind.interfaces:
        return "It serves no interface.\n"
    return f"Interfaces: {', '.join(f'`{name}`' for name in entry.kind.interfaces)}, under the model's id.\n"


def _attributes(rows: Iterable[Row]) -> str:
    lines = [
        f"| `{r.name}` | {r.type} | {_cell(r.default) or '-'} | {_cell(r.unit)} | {_cell(r.meaning)} |" for r in rows
    ]
    if not lines:
        return "It has none of its own.\n"
    return "\n".join(["| attribute | type | default | unit | meaning |", "|---|---|---|---|---|", *lines, ""])


def _table(head: tuple[str, str], parts: Iterable[Part]) -> str:
    lines = [f"| {_cell(part.name)} | {_cell(part.text)} |" for part in parts]
    return "\n".join([f"| {head[0]} | {head[1]} |", "|---|---|", *lines, ""])


def _cell(text: str) -> str:
    return text.replace("|", "\\|")
