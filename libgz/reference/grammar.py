"""A RELAX NG grammar of worldfiles, made from the models' declarations, for editors that check while typing.

It covers the spelling of 0.5 to 0.7. Models of plugins are recognised by their `<plugin>` and may contain anything.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from lxml import etree
from lxml.builder import ElementMaker  # type: ignore[import-not-found]  # lxml-stubs lack it

from libgz.legacy.model import CommonAttributes
from libgz.legacy.settings import GlobalAttributes
from libgz.reference.catalogue import NAMESPACE, entries
from libgz.worldfile.attributes import Attribute, Limits, attributes_of

__all__ = ["grammar"]

RNG = "http://relaxng.org/ns/structure/1.0"
XSD = "http://www.w3.org/2001/XMLSchema-datatypes"
TEXTS = frozenset({"text", "file"})
SIZES = {"3 numbers": (1, 3), "3 angles": (1, 3), "colour": (3, 4)}  # how many numbers

_E = ElementMaker(namespace=RNG, nsmap={None: RNG})


def grammar() -> bytes:
    """The grammar as an XML document."""
    models = list(entries())
    root = _E.grammar(datatypeLibrary=XSD)
    root.append(
        etree.Comment(" Worldfiles of Gazebo 0.5 to 0.7 as libgz reads them; made by the command libgz schema. ")
    )
    root.append(_E.start(_E.ref(name="world")))
    root.append(_E.define(_world(), name="world"))
    root.append(_E.define(_E.choice(*(_E.ref(name=e.name) for e in models), _E.ref(name="plugin")), name="model"))
    root.append(_E.define(_E.interleave(*_optional(attributes_of(CommonAttributes))), name="common"))
    for entry in models:
        root.append(_E.define(_model(entry.name, entry.kind.attributes), name=entry.name))
    root.append(_E.define(_plugin([entry.name for entry in models]), name="plugin"))
    root.append(_E.define(_anything(), name="anything"))
    return etree.tostring(root, pretty_print=True, xml_declaration=True, encoding="utf-8")


def _world() -> Any:
    # Files of those years use either address for the prefix `param`.
    names = _E.choice(*(_E.name("Global", ns=f"{NAMESPACE}{end}") for end in ("param", "params")))
    settings = _E.element(names, _E.interleave(*_optional(attributes_of(GlobalAttributes))))
    content = _E.interleave(_E.zeroOrMore(settings), _E.zeroOrMore(_E.ref(name="model")))
    version = _E.optional(_E.attribute(name="version"))
    return _E.element(_E.name("world", ns=f"{NAMESPACE}gz"), version, content)


def _model(name: str, declaration: type[Any]) -> Any:
    # A model may override a common attribute, with another meaning or default.
    own = attributes_of(declaration)
    common = attributes_of(CommonAttributes)
    shared = [_E.ref(name="common")]
    if own.keys() & common.keys():
        shared = _optional({key: attribute for key, attribute in common.items() if key not in own})
    content = _E.interleave(*shared, *_optional(own), _E.zeroOrMore(_E.ref(name="model")))
    return _E.element(_E.name(name, ns=f"{NAMESPACE}model"), content)


def _optional(attributes: Any) -> list[Any]:
    """An optional element for each attribute, with its meaning."""
    found = []
    for name, attribute in attributes.items():
        unit = f" [{attribute.unit}]" if attribute.unit else ""
        tags = [name, "enabled"] if name == "enable" else [name]
        names = _E.choice(*map(_E.name, tags)) if len(tags) > 1 else _E.name(name)
        help_ = etree.Comment(f" {attribute.help.replace('--', '-')}{unit} ")
        element = _E.element(names, _value(attribute))
        element.insert(0, help_)
        found.append(_E.optional(element))
    return found


def _value(attribute: Attribute) -> Any:
    """The allowed content of an attribute's element."""
    kind = attribute.type
    if kind in TEXTS:
        return _E.text()
    if attribute.words:
        return _E.choice(*map(_E.value, attribute.words))
    if kind == "bool":
        return _E.data(_E.param(r"[Tt][Rr][Uu][Ee]|[Ff][Aa][Ll][Ss][Ee]|[+\-]?[0-9]+", name="pattern"), type="token")
    if kind == "whole number":
        return _number("integer", attribute.limits)
    if kind in ("number", "angle"):
        return _number("double", attribute.limits)
    least, most = SIZES.get(kind) or (1, int(kind.removesuffix(" numbers").split()[-1]))
    numbers = [_number("double", attribute.limits) for _ in range(most)]
    # Flat, because libxml2 miscounts nested optional parts.
    return _E.list(*numbers[:least], *map(_E.optional, numbers[least:]))


def _number(type: str, limits: Limits) -> Any:
    params = [
        _E.param(f"{value:g}", name=name)
        for name, value in (
            ("minExclusive", limits.above),
            ("minInclusive", limits.least),
            ("maxInclusive", limits.most),
        )
        if value is not None
    ]
    number = _E.data(*params, type=type)
    if type == "integer" or limits.most is not None:
        return number
    return _E.choice(number, _E.value("inf", type="token"))  # XML Schema's own spelling is INF


def _plugin(known: Iterable[str]) -> Any:
    """A model of a plugin: it names the plugin and may contain anything."""
    space = f"{NAMESPACE}model"
    names = _E.nsName(_E("except", *(_E.name(name, ns=space) for name in known)), ns=space)
    not_plugin = _E.element(_E.anyName(_E("except", _E.name("plugin"), _E.nsName(ns=space))), _E.ref(name="anything"))
    content = _E.interleave(
        _E.element(_E.name("plugin"), _E.text()), _E.zeroOrMore(not_plugin), _E.zeroOrMore(_E.ref(name="model"))
    )
    return _E.element(names, content)


def _anything() -> Any:
    inside = _E.element(_E.anyName(), _E.ref(name="anything"))
    attribute = _E.attribute(_E.anyName())
    return _E.zeroOrMore(_E.choice(_E.text(), attribute, inside))
