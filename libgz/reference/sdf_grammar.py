"""A RELAX NG grammar of SDF, made from its description, for editors that check while typing."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from lxml import etree
from lxml.builder import ElementMaker  # type: ignore[import-not-found]  # lxml-stubs lack it

from libgz.sdf.description import NEWEST, UNSET, AttributeDescription, Description, describe
from libgz.sdf.reader import NEEDED, REPEATED

__all__ = ["sdf_grammar"]

RNG = "http://relaxng.org/ns/structure/1.0"
XSD = "http://www.w3.org/2001/XMLSchema-datatypes"
COUNTS = {"vector2d": (2, 2), "vector2i": (2, 2), "vector3": (2, 3), "pose": (6, 6), "color": (3, 4)}
POSE = (6, 7)  # with rotation_format='quat_xyzw'
BOOL = r"[Tt][Rr][Uu][Ee]|[Ff][Aa][Ll][Ss][Ee]|[01]"

_E = ElementMaker(namespace=RNG, nsmap={None: RNG})


def sdf_grammar(version: str = NEWEST) -> bytes:
    """The grammar of one version of SDF as an XML document.

    Raises:
        ParameterError: the version is not described.
    """
    blocks = describe(version)
    root = _E.grammar(datatypeLibrary=XSD)
    root.append(etree.Comment(f" SDF {version} as libgz reads it; made by the command libgz schema. "))
    root.append(_E.start(_element("sdf", blocks["sdf"])))
    for name, block in blocks.items():
        if name != "sdf":
            root.append(_E.define(*_content(block), name=name))
    root.append(_E.define(_anything(), name="anything"))
    root.append(_E.define(_E.zeroOrMore(_foreign()), name="foreign"))
    return etree.tostring(root, pretty_print=True, xml_declaration=True, encoding="utf-8")


def _element(name: str, about: Description) -> Any:
    if about.block:
        return _E.element(_E.ref(name=about.block), name=name)
    return _E.element(*_content(about), name=name)


def _content(about: Description) -> list[Any]:
    """Attributes, children and text of an element."""
    if about.open:
        return [_E.ref(name="anything")]
    found = [_attribute(attribute) for attribute in about.all_attributes.values()]
    found.append(_E.zeroOrMore(_E.attribute(_E.anyName(_E("except", _E.nsName(ns=""))))))
    inside = [*_children(about), _E.ref(name="foreign")]
    if not about.children:
        return [*found, _value(about.type)]
    return [*found, _E.interleave(*inside, *([_E.text()] if about.type else []))]


def _children(about: Description) -> Iterator[Any]:
    for name, child in about.children.items():
        element = _element(name, child)
        note = f" [{child.unit}]" if child.unit else f" {child.note.replace('--', '-')}" if child.note else ""
        if note:
            element.insert(0, etree.Comment(f"{note} "))
        many = child.count in ("*", "+") or (about.name, name) in REPEATED
        if (about.name, name) in NEEDED:
            yield element
        else:  # a missing one is created with its defaults
            yield _E.zeroOrMore(element) if many else _E.optional(element)


def _attribute(about: AttributeDescription) -> Any:
    attribute = _E.attribute(_value(about.type), name=about.name)
    return attribute if about.required and about.default == UNSET else _E.optional(attribute)


def _value(kind: str) -> Any:
    """The allowed text of a type of the description."""
    if kind == "bool":
        return _E.choice(_E.data(_E.param(BOOL, name="pattern"), type="token"), _E.empty())
    if kind in ("double", "int", "unsigned int"):
        return _E.choice(_number(kind), _E.empty())
    if kind not in COUNTS:
        return _E.text()
    least, most = POSE if kind == "pose" else COUNTS[kind]
    numbers = [_number("double") for _ in range(most)]
    return _E.choice(_E.list(*numbers[:least], *map(_E.optional, numbers[least:])), _E.empty())


def _number(kind: str) -> Any:
    if kind == "double":
        return _E.choice(_E.data(type="double"), _E.data(_E.param(r"[+\-]?[Ii][Nn][Ff]", name="pattern"), type="token"))
    return _E.data(_E.param(r"[+\-]?(0[xX][0-9a-fA-F]+|[0-9]+)", name="pattern"), type="token")


def _foreign() -> Any:
    """An element with a prefix, which is not of SDF."""
    return _E.element(_E.anyName(_E("except", _E.nsName(ns=""))), _E.ref(name="anything"))


def _anything() -> Any:
    inside = _E.element(_E.anyName(), _E.ref(name="anything"))
    return _E.zeroOrMore(_E.choice(_E.text(), _E.attribute(_E.anyName()), inside))
