"""The elements of one version of SDF, as text in the form of `gz sdf --describe`, or as a page."""

from __future__ import annotations

import html
import re
from collections.abc import Iterator

from libgz.sdf.description import UNSET, Description, describe

__all__ = ["sdf_page", "sdf_text"]

NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")
STYLE = "body{font-family:sans-serif;margin:2em}details{margin-left:1.5em}code{background:#eee}"


def sdf_text(version: str) -> str:
    """Elements and attributes, nested, with their types and defaults, and how often they may occur.

    Raises:
        ParameterError: the version is not described.
    """
    return "\n".join(_lines(describe(version)["sdf"], "", ())) + "\n"


def _lines(element: Description, indent: str, above: tuple[str, ...]) -> Iterator[str]:
    if element.block in above:  # a model in a model has what that one has
        yield f"{indent}<element ref ='{element.name}' required ='{element.count}'/>"
        return
    kind = f" type ='{element.type}' default ='{_shown(element.type, element.default)}'" if element.type else ""
    yield f"{indent}<element name ='{element.name}' required ='{element.count}'{kind}>"
    for attribute in element.all_attributes.values():
        default, required = _shown(attribute.type, attribute.default), int(attribute.required)
        yield (
            f"{indent}  <attribute name ='{attribute.name}' type ='{attribute.type}' default ='{default}' "
            f"required ='{required}'>"
        )
        yield f"{indent}  </attribute>"
    if element.open:
        yield f"{indent}  <element copy_data ='true' required ='*'/>"
    for child in element.children.values():
        yield from _lines(child, f"{indent}  ", (*above, element.block or element.path))
    yield f"{indent}</element>"


def _shown(kind: str, default: str) -> str:
    """A default as Gazebo prints it: numbers without needless digits, true as 1."""
    if kind == "bool":
        default = {"true": "1", "false": "0"}.get(default, default)
    elif kind != "string":
        default = " ".join(f"{float(word):g}" if NUMBER.fullmatch(word) else word for word in default.split())
    return html.escape(default, quote=True)


def sdf_page(version: str) -> str:
    """The same as a page of HTML that needs no other file: elements fold, attributes follow an `@`.

    Raises:
        ParameterError: the version is not described.
    """
    title = f"SDF {version}"
    body = "\n".join(_blocks(describe(version)["sdf"], ()))
    return (
        f"<!DOCTYPE html>\n<html lang='en'>\n<head><meta charset='utf-8'><title>{title}</title>"
        f"<style>{STYLE}</style></head>\n<body><h1>{title}</h1>\n{body}\n</body>\n</html>\n"
    )


def _blocks(element: Description, above: tuple[str, ...]) -> Iterator[str]:
    if element.block in above:
        yield f"<div><code>&lt;{element.name}&gt;</code> as above</div>"
        return
    counts = {"1": "once", "0": "at most once", "+": "at least once", "*": "any number"}
    yield (
        f"<details{' open' if not above else ''}><summary><code>&lt;{element.name}&gt;</code> "
        f"{_typed(element.type, element.default)}{counts.get(element.count, element.count)}</summary>"
    )
    for attribute in element.all_attributes.values():
        must = "required" if attribute.required else "optional"
        yield f"<div><code>@{attribute.name}</code> {_typed(attribute.type, attribute.default)}{must}</div>"
    for child in element.children.values():
        yield from _blocks(child, (*above, element.block or element.path))
    yield "</details>"


def _typed(kind: str, default: str) -> str:
    given = f", default <code>{_shown(kind, default)}</code>" if default not in ("", UNSET) else ""
    return f"{kind}{given}, " if kind else ""
