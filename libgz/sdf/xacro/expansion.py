"""Expansion of a document with macros, into one without; each element keeps the file and line that it comes from."""

from __future__ import annotations

import keyword
import os
from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias, cast

from lxml import etree

from libgz.base.errors import Diagnostics, Place, WorldFileError, nearest
from libgz.base.trust import UntrustedError, check_trusted
from libgz.sdf.xacro.expressions import Evaluator
from libgz.sdf.xacro.files import Files, UnreadableError
from libgz.sdf.xacro.library import Library
from libgz.sdf.xacro.limits import DEEPEST_TAG, MOST_ATTRIBUTES, Budget, ExpansionError, LimitError
from libgz.sdf.xacro.macros import Macro, MacroTable, Parameter, parameters_of
from libgz.sdf.xacro.recognition import PREFIX, SUFFIX
from libgz.sdf.xacro.scopes import Scope, truth
from libgz.sdf.xacro.substitutions import Substitutions
from libgz.sdf.xacro.texts import Texts
from libgz.sdf.xml import PLACE, line_of, local_name, parse_document, place_of, set_place, tag_name

__all__ = ["expand"]

DEEPEST_INCLUDE = 100
DEEPEST_WORK = 3 * DEEPEST_TAG  # generators of `_run`: an element takes up to three
MOST_CALLS = 3  # of macros, in a message

Steps: TypeAlias = Generator["Steps | None", None, None]  # work on an element; it yields that on elements inside


def expand(
    root: etree._Element,
    label: str,
    diagnostics: Diagnostics,
    *,
    path: Path | None = None,
    folder: Path | None = None,
    arguments: Mapping[str, str] | None = None,
    environment: Mapping[str, str] | None = None,
) -> etree._Element:
    """The root of the expanded document.

    A file that ends in `.xacro` must be right. In another one, which Gazebo reads unexpanded, elements that cannot be
    expanded are left out, with a warning.

    Args:
        root: of the document.
        label: its name in messages.
        diagnostics: takes warnings.
        path: its file; None for a text.
        folder: the base of relative names in a text.
        arguments: values of `<xacro:arg>`, instead of their defaults.
        environment: the variables that `$(env NAME)` finds; by default those of this process.

    Raises:
        WorldFileError: it cannot be expanded, or files are not trusted; the message has file and line.
    """
    try:
        check_trusted("what macros (xacro) make")
    except UntrustedError as error:
        raise WorldFileError(f"{label}:{line_of(root)}: <{local_name(root)}>: {error}") from None
    strict = path is not None and path.suffix == SUFFIX
    folder = path.parent if path is not None else folder
    given = os.environ if environment is None else environment
    return _Expansion(label, folder, diagnostics, dict(arguments or {}), given, strict).run(root)


@dataclass(frozen=True)
class _Context:
    """What elements are expanded in."""

    scope: Scope
    macros: MacroTable
    calls: tuple[etree._Element, ...] = ()  # those of the macros around, the innermost last


class _Expansion:
    """One document's expansion.

    The documents that are read stay as they are; the result grows beside them. Work on elements inside is yielded to
    `_run`, so that macros that call themselves as loops do not nest calls of Python.
    """

    def __init__(
        self,
        label: str,
        folder: Path | None,
        diagnostics: Diagnostics,
        arguments: dict[str, str],
        environment: Mapping[str, str],
        strict: bool,
    ) -> None:
        self.label, self.diagnostics, self.strict = label, diagnostics, strict
        self.budget = Budget()
        self.files = Files(folder, self.budget)
        self.folders = [self.files.folder]  # of the files that are being included, for names relative to them
        self.arguments = arguments
        self.evaluator = Evaluator(self.budget)
        self.substitutions = Substitutions(self.files, self.evaluator, arguments, environment, lambda: self.folders[-1])
        self.texts = Texts(self.evaluator, self.substitutions.text)
        self.library = Library(self)
        self.documents: dict[Path, etree._Element] = {}
        self.at: etree._Element | None = None  # what is being expanded
        self.calls: tuple[etree._Element, ...] = ()  # the macros around it

    def run(self, root: etree._Element) -> etree._Element:
        """The root of the result."""
        _mark(root, self.label)
        context = _Context(Scope(self.library.names, self.texts.value), MacroTable())
        holder = etree.Element("expanded")
        self._enter(root, context)
        try:
            _run(self._copy(root, holder, context))
        except (ExpansionError, RecursionError, MemoryError) as error:
            text = str(error) if isinstance(error, ExpansionError) else "it is nested too deeply"
            place = self._place()
            raise WorldFileError(f"{place.file}:{place.line}: <{place.name}>: {text}{self._called()}") from None
        made = holder[0]
        holder.remove(made)
        return made

    # Messages --------------------------------------------------------------------------------------------------------

    def _enter(self, source: etree._Element, context: _Context) -> None:
        self.at, self.calls = source, context.calls

    def _place(self) -> Place:
        if self.at is None:
            return Place(self.label, 0, "")
        return place_of(self.at, self.label)._replace(name=tag_name(self.at))

    def _called(self) -> str:
        """The macros around an element, for the end of a message."""
        places = [(tag_name(call), place_of(call, self.label)) for call in reversed(self.calls[-MOST_CALLS:])]
        shown = [f"<{tag}> at {place.file}:{place.line}" for tag, place in places]
        if len(self.calls) > MOST_CALLS:
            shown.append("others")
        return f"; in {', in '.join(shown)}" if shown else ""

    def warn(self, message: str) -> None:
        """Warn at the element that is being expanded."""
        self.diagnostics.warn(self._place(), f"{message}{self._called()}")

    # Elements --------------------------------------------------------------------------------------------------------

    def _content(self, source: etree._Element, into: etree._Element, context: _Context) -> Steps:
        """Expand all that is in an element."""
        self._add_text(source.text, source, into, context)
        for child in source:
            if isinstance(child.tag, str):
                self._enter(child, context)
                yield self._element(child, tag_name(child), into, context)
            self._add_text(child.tail, source, into, context)

    def _element(self, source: etree._Element, tag: str, into: etree._Element, context: _Context) -> Steps | None:
        if not tag.startswith(PREFIX):
            return self._copy(source, into, context)
        self.budget.spend(1)
        name = tag.removeprefix(PREFIX)
        return _SPECIAL.get(name, _Expansion._call)(self, source, name, into, context)

    def _copy(self, source: etree._Element, into: etree._Element, context: _Context, name: str | None = None) -> Steps:
        """Add an element with its attributes and content expanded, maybe with another name."""
        made = self._add(source, into, tag_name(source) if name is None else name)
        for key, value in _attributes(source).items():
            if key == PLACE:
                self._set(made, key, value)
            elif not self._as_written(source, key).startswith(PREFIX):
                self._set(made, key, self._text(value, context) if "$" in value else value)
        yield self._content(source, made, context)

    def _add(self, source: etree._Element, into: etree._Element, name: str) -> etree._Element:
        self.budget.add_element(sum(1 for _ in into.iterancestors()))
        prefix, colon, local = name.rpartition(":")
        spaces: dict[Any, str] = {}  # lxml-stubs know no default namespace
        if colon or "}" in source.tag:
            known = self._spaces(source)
            space = known.get(prefix or None, f"urn:{prefix}" if prefix else None)
            if space is not None:
                spaces[prefix or None] = space
                name = f"{{{space}}}{local}"
        for key in _attributes(source):
            if key.startswith("{") and key != PLACE:
                spaces.update(
                    {known: space for known, space in self._spaces(source).items() if key.startswith(f"{{{space}}}")}
                )
        try:
            return etree.SubElement(into, name, nsmap=spaces or None)
        except ValueError:
            raise ExpansionError(f"{name[:80]!r} is not the name of an element") from None

    def _spaces(self, element: etree._Element) -> dict[Any, str]:
        """Its namespaces by prefix."""
        spaces = cast("dict[Any, str]", element.nsmap)
        self.budget.spend(len(spaces))
        return spaces

    def _as_written(self, element: etree._Element, key: str) -> str:
        """The name of an attribute with its prefix."""
        if not key.startswith("{"):
            return key
        space, _, name = key[1:].rpartition("}")
        prefixes = [str(prefix) for prefix, known in self._spaces(element).items() if known == space]
        return f"{'xacro' if 'xacro' in prefixes else prefixes[0]}:{name}" if prefixes else name

    def _set(self, element: etree._Element, name: str, value: str) -> None:
        self.budget.length(len(value))
        if len(element.attrib) >= MOST_ATTRIBUTES:
            raise LimitError(f"an element has more than {MOST_ATTRIBUTES} attributes")
        try:
            element.set(name, value)
        except ValueError as error:
            raise ExpansionError(f"attribute {name[:80]!r}: {error}") from None

    def _add_text(self, text: str | None, source: etree._Element, into: etree._Element, context: _Context) -> None:
        if not text:
            return
        if "$" in text:
            self._enter(source, context)
            text = self._text(text, context)
        last = next(into.iterchildren(reversed=True), None)  # len() counts them all
        text = ((into.text if last is None else last.tail) or "") + text
        self.budget.length(len(text))
        try:
            if last is None:
                into.text = text
            else:
                last.tail = text
        except ValueError as error:
            raise ExpansionError(f"the text of the element: {error}") from None

    def _text(self, text: str, context: _Context) -> str:
        try:
            return self.texts.text(text, context.scope)
        except LimitError:
            raise
        except ExpansionError as error:
            if self.strict:
                raise
            self.warn(f"{error}; the text stays as it is")
            return text

    # Attributes of xacro's elements ----------------------------------------------------------------------------------

    def _given(self, source: etree._Element, needed: tuple[str, ...], others: tuple[str, ...] = ()) -> list[Any]:
        """The texts of attributes, None for others that are not there; unknown ones are a warning."""
        for name in needed:
            if source.get(name) is None:
                raise ExpansionError(f"attribute {name!r} is missing and must be given")
        for name in _attributes(source):
            if name not in (*needed, *others, PLACE):
                self.warn(f"attribute {name!r} has no effect{nearest(name, (*needed, *others))}")
        return [source.get(name) for name in (*needed, *others)]

    # xacro's elements ------------------------------------------------------------------------------------------------

    def _arg(self, source: etree._Element, _: str, into: etree._Element, context: _Context) -> None:
        name, default = self._given(source, ("name", "default"))
        if name not in self.arguments:
            self.arguments[name] = self.texts.text(default, context.scope)

    def _property(self, source: etree._Element, _: str, into: etree._Element, context: _Context) -> None:
        others = ("value", "default", "remove", "scope", "lazy_eval")
        name, value, default, remove, where, lazy = self._given(source, ("name",), others)
        scope = context.scope
        name = self.texts.text(name, scope)
        if not name.isidentifier() or keyword.iskeyword(name) or name.startswith("__"):
            raise ExpansionError(f"{name[:80]!r} is not the name of a property: it must be an identifier of Python")
        removed = truth(self.texts.value(remove or "false", scope), remove or "")
        if (value is not None) + (default is not None) + removed > 1:
            raise ExpansionError(f"property {name!r} has more than one of value, default and remove")
        if removed:
            scope.remove(name)
            return
        if default is not None and name in scope:
            return
        block = value is None and default is None
        is_lazy = truth(self.texts.value(lazy or "true", scope), lazy or "") and where not in ("global", "parent")
        target = scope.top() if where == "global" else scope.caller() if where == "parent" else scope
        if target is None:
            self.warn(f"property {name!r} has no parent scope here")
            target = scope
        if scope.is_builtin(name):
            self.warn(f"property {name!r} hides what expressions have of that name")
        if block:
            target.set(f"**{name}", source)
            return
        given = value if value is not None else default
        target.set(name, given if is_lazy else self.texts.value(given, scope), lazy=is_lazy)

    def _macro(self, source: etree._Element, _: str, into: etree._Element, context: _Context) -> None:
        name, parameters = self._given(source, ("name",), ("params",))
        name = name.removeprefix(PREFIX)
        if name == "call" or "." in name:
            raise ExpansionError(f"a macro cannot have the name {name[:80]!r}")
        context.macros.macros[name] = Macro(name, source, parameters_of(parameters or "", self.budget))

    def _condition(self, source: etree._Element, name: str, into: etree._Element, context: _Context) -> Steps | None:
        (condition,) = self._given(source, ("value",))
        value = truth(self.texts.value(condition, context.scope), condition)
        return self._content(source, into, context) if value is (name == "if") else None

    def _insert_block(self, source: etree._Element, _: str, into: etree._Element, context: _Context) -> Steps:
        (name,) = self._given(source, ("name",))
        for stars in ("**", "*"):
            if f"{stars}{name}" in context.scope:
                block = context.scope[f"{stars}{name}"]
                return self._content(block, into, context) if stars == "**" else self._copy(block, into, context)
        raise ExpansionError(f"there is no block {name[:80]!r}")

    def _attribute(self, source: etree._Element, _: str, into: etree._Element, context: _Context) -> None:
        name, value = (self.texts.text(text, context.scope) for text in self._given(source, ("name", "value")))
        self._set(into, name, value)

    def _renamed(self, source: etree._Element, _: str, into: etree._Element, context: _Context) -> Steps | None:
        """An element whose name is the attribute `xacro:name`."""
        given = [text for key, text in _attributes(source).items() if self._as_written(source, key) == f"{PREFIX}name"]
        if not given:
            raise ExpansionError(f"attribute '{PREFIX}name' is missing and must be given")
        name = self.texts.text(given[0], context.scope)
        if name.startswith(PREFIX):
            return self._element(source, name, into, context)
        return self._copy(source, into, context, name)

    def _include(self, source: etree._Element, _: str, into: etree._Element, context: _Context) -> Steps:
        name, space, optional = self._given(source, ("filename",), ("ns", "optional"))
        name = self.texts.text(name, context.scope)
        if space:
            space = self.texts.text(space, context.scope)
            scope, macros = context.scope.inner(is_namespace=True), MacroTable()
            context.scope.set(space, scope)
            context.macros.namespaces[space] = macros
            inner = _Context(scope, macros, context.calls)
        else:
            inner = context
        if len(self.folders) > DEEPEST_INCLUDE:
            raise LimitError(f"files include each other more than {DEEPEST_INCLUDE} deep")
        is_optional = truth(optional, optional) if optional else False
        try:
            paths = self.files.matching(self.files.path(name, self.folders[-1]))
        except UnreadableError as error:
            self._missing(error, is_optional)
            return
        if not paths:
            self.warn(f"no file is named {name[:200]!r}")
        for path in paths:
            try:
                root = self._document(path)
            except UnreadableError as error:
                self._missing(error, is_optional)
                continue
            self.folders.append(path.parent)
            yield self._content(root, into, inner)
            self.folders.pop()
            self._enter(source, context)

    def _missing(self, error: UnreadableError, is_optional: bool) -> None:
        if self.strict and not is_optional:
            raise error
        if not is_optional:
            self.warn(f"{error}; it is not included")

    def _document(self, path: Path) -> etree._Element:
        """The root of an included file."""
        if path not in self.documents:
            data = self.files.read(path)
            try:
                root = parse_document(data, str(path), self.diagnostics)
            except WorldFileError as error:
                raise ExpansionError(f"{error}") from None
            _mark(root, str(path))
            self.documents[path] = root
        return self.documents[path]

    # Macros ----------------------------------------------------------------------------------------------------------

    def _named_call(self, source: etree._Element, _: str, into: etree._Element, context: _Context) -> Steps:
        """`<xacro:call macro="...">`."""
        name = source.get("macro")
        if not name:
            raise ExpansionError("attribute 'macro' is missing and must be given")
        return self._call(source, self.texts.text(name, context.scope), into, context, ("macro",))

    def _call(
        self,
        source: etree._Element,
        name: str,
        into: etree._Element,
        context: _Context,
        used: tuple[str, ...] = (),
    ) -> Steps:
        try:
            macro, table, around = context.macros.find(name, context.scope)
        except KeyError:
            known = nearest(name, context.macros.names())
            if self.strict:
                raise ExpansionError(f"there is no macro {name[:80]!r}{known}") from None
            self.warn(f"there is no macro {name[:80]!r}; the element is left out{known}")
            return
        missing = {parameter.name: parameter for parameter in macro.parameters}
        inner = around.inner()
        for key, text in _attributes(source).items():
            if key == PLACE or key in used or key.startswith("{"):
                continue
            if key not in missing:
                raise ExpansionError(f"the macro {name!r} has no parameter {key!r}{nearest(key, missing)}")
            del missing[key]
            inner.set(key, self.texts.value(text, context.scope))
        blocks = etree.Element("blocks")
        if len(source):
            yield self._content(source, blocks, context)
            self._enter(source, context)
        given = iter(list(blocks.iterchildren(etree.Element)))
        for parameter in [one for one in missing.values() if one.is_block]:
            block = next(given, None)
            if block is None:
                raise ExpansionError(f"the macro {name!r} needs an element for its parameter {parameter.name!r}")
            inner.set(parameter.name, block)
            del missing[parameter.name]
        unused = next(given, None)
        if unused is not None:
            raise ExpansionError(f"the macro {name!r} has no parameter for the element <{tag_name(unused)}>")
        for parameter in [one for one in missing.values() if one.is_optional]:
            inner.set(parameter.name, self._default(parameter, context.scope))
            del missing[parameter.name]
        if missing:
            raise ExpansionError(f"the macro {name!r} needs the parameters {', '.join(missing)}")
        calls = (*context.calls, source)
        yield self._content(macro.body, into, _Context(inner, MacroTable(table), calls))

    def _default(self, parameter: Parameter, scope: Scope) -> Any:
        if parameter.forwards and parameter.name in scope:
            return scope[parameter.name]
        if parameter.default is None:
            raise ExpansionError(f"there is no property {parameter.name!r} for the parameter of that name")
        return self.texts.value(parameter.default, scope)


_SPECIAL: dict[str, Callable[..., Steps | None]] = {
    "arg": _Expansion._arg,
    "attribute": _Expansion._attribute,
    "call": _Expansion._named_call,
    "element": _Expansion._renamed,
    "if": _Expansion._condition,
    "include": _Expansion._include,
    "insert_block": _Expansion._insert_block,
    "macro": _Expansion._macro,
    "property": _Expansion._property,
    "unless": _Expansion._condition,
}


def _run(first: Steps) -> None:
    """Do work, and first what it yields."""
    stack = [first]
    while stack:
        try:
            further = next(stack[-1])
        except StopIteration:
            stack.pop()
            continue
        if further is not None:
            stack.append(further)
        if len(stack) > DEEPEST_WORK:
            raise LimitError(f"macros and elements are nested more than {DEEPEST_TAG} deep; is there a loop?")


def _mark(root: etree._Element, file: str) -> None:
    """Write the file and line of each element into it, for what is made of it."""
    for element in root.iter(etree.Element):
        set_place(element, line_of(element), file)


def _attributes(element: etree._Element) -> Mapping[str, str]:
    if len(element.attrib) > MOST_ATTRIBUTES:  # their list takes the square of that
        raise LimitError(f"an element has more than {MOST_ATTRIBUTES} attributes")
    return cast("Mapping[str, str]", element.attrib)
