"""The page "C++ API": each signature of the table."""

from __future__ import annotations

from collections.abc import Iterator

from libgz.classic_cxx.table import Row, rows

__all__ = ["api_page"]

SPACES = ("", "common", "event", "gui", "msgs", "physics", "rendering", "sensors", "transport", "util")


def api_page() -> str:
    """The page as Markdown."""
    lines = [
        "# C++ API of Gazebo classic",
        "",
        "What [compiled plugins](classic_cxx.md) may use: the names and signatures of Gazebo 11. A method does what "
        "[the Python API](classic.md) says of its name. Each has its header; any of them includes all.",
    ]
    for space in SPACES:
        scope = f"gazebo::{space}" if space else "gazebo"
        own = [row for row in rows() if row.scope == scope]
        classes = [row for row in own if row.kind == "class"]
        if not own:
            continue
        lines += ["", f"## {scope}", ""]
        functions = [row for row in own if row.kind == "function" and row.type]
        if functions:
            lines += ["```cpp", *map(_signature, functions), "```"]
        for row in classes:
            lines += list(_class(row))
    return "\n".join(lines) + "\n"


def _class(row: Row) -> Iterator[str]:
    bases = f" : {row.type}" if row.type else ""
    yield from ("", f"### {row.name}", "", f"`{row.name}{bases}`, `<{row.header}>`", "")
    own = [one for one in rows() if one.scope == row.full_name]
    text = [f"enum {one.name} {{ {one.parameters} }};" for one in own if one.kind == "enum"]
    text += [_signature(one) for one in own if one.kind == "method"]
    if text:
        yield from ("```cpp", *text, "```")


def _signature(row: Row) -> str:
    before = "static " if "static" in row.flags else ""
    result = "" if "ctor" in row.flags else f"{row.type} "
    return f"{before}{result}{row.name}({row.parameters}){' const' if 'const' in row.flags else ''};"
