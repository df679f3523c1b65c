"""Element: a piece of an SDF document, with the getters that plugins use."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import Any, TypeVar, overload

from libgz.base.errors import NotFoundError, ParameterError, Place, nearest
from libgz.base.files import xml_attribute, xml_text
from libgz.sdf.description import UNSET, Description
from libgz.sdf.value import format_value, parse

__all__ = ["Element", "Param"]

T = TypeVar("T")


class Param:
    """A value of an element or attribute: its text, and whether the file contains it."""

    def __init__(self, name: str, kind: str, text: str, *, given: bool) -> None:
        self.name = name
        self.kind = kind
        self.text = self.default = text
        self.given = given

    def Get(self, kind: type[T]) -> T:
        """The value as a `kind`; see `libgz.sdf.value.parse`."""
        return parse(kind, self.text)

    def GetAsString(self) -> str:
        """The text, without blanks at its ends."""
        return self.text

    def Set(self, value: Any) -> None:
        """Replace the value."""
        self.text, self.given = format_value(value).strip(), True

    def SetFromString(self, text: str) -> bool:
        """Replace the text; blanks at its ends are dropped."""
        self.text, self.given = text.strip(), True
        return True

    def GetKey(self) -> str:
        """The name of the element or attribute."""
        return self.name

    def GetTypeName(self) -> str:
        """The type in the description of SDF: double, string, vector3 and so on."""
        return self.kind or "string"

    def GetSet(self) -> bool:
        """Whether the file, or a call, gives it."""
        return self.given

    def GetDefaultAsString(self) -> str:
        """The default of the description of SDF."""
        return self.default

    def GetDefault(self, kind: type[T]) -> T:
        """The default of the description of SDF as a `kind`."""
        return parse(kind, self.default)

    def Reset(self) -> None:
        """Take the default again."""
        self.text, self.given = self.default, False

    def Clone(self) -> Param:
        """A copy."""
        copy = Param(self.name, self.kind, self.text, given=self.given)
        copy.default = self.default
        return copy


class Element:
    """One element of an SDF document.

    Args:
        name: the tag.
        description: its possible attributes and children; None for an element unknown to SDF, such as those of plugins.
        file, line: where it was read, for messages.

    Attributes:
        include: where the `<include>` is that it took the place of; None if the document itself has it.
        placed: whether its pose was that of a frame in it, its placement frame.
        comments: in front of it; not read from files, where they are kept without this.
        implied: whether it was only created to be read: with its defaults, which no document gave.
    """

    include: Place | None = None
    placed: bool = False
    comments: tuple[str, ...] = ()
    implied: bool = False

    def __init__(
        self, name: str = "", description: Description | None = None, *, file: str = "", line: int = 0
    ) -> None:
        self.name = name
        self.description = description
        self.file, self.line = file, line
        self.parent: Element | None = None
        self.children: list[Element] = []
        self.attributes: dict[str, Param] = {}
        if description is not None:
            self._take_defaults(description)
        else:
            self.value = Param(name, "", "", given=False)

    def _take_defaults(self, about: Description) -> None:
        self.value = Param(self.name, about.type, about.default, given=False)
        for key, attribute in about.all_attributes.items():
            self.attributes[key] = Param(key, attribute.type, attribute.default, given=False)

    def __repr__(self) -> str:
        return f"<Element {self.name} at {self.where}>"

    @property
    def where(self) -> str:
        """``file:line``."""
        return f"{self.file or '<string>'}:{self.line}"

    def GetName(self) -> str:
        """The tag."""
        return self.name

    def SetName(self, name: str) -> None:
        """Set the tag."""
        self.name = self.value.name = name

    def GetParent(self) -> Element | Any:
        """The element around this one."""
        return self.parent

    def SetParent(self, parent: Element | None) -> None:
        """Set the element around this one, whose children do not change."""
        self.parent = parent

    def RemoveFromParent(self) -> None:
        """Remove it from the element around it."""
        if self.parent is not None:
            self.parent.RemoveChild(self)

    def FilePath(self) -> str:
        """The file it was read from."""
        return self.file

    def SetFilePath(self, path: str) -> None:
        """Set the file that messages name, and that relative paths start from."""
        self.file = path

    def GetDescription(self) -> str:
        """The names of the children that SDF knows here; empty for an unknown element."""
        return ", ".join(self.description.children) if self.description is not None else ""

    def HasElementDescription(self, name: str) -> bool:
        """Whether SDF knows a child of this name here."""
        return self.description is not None and name in self.description.children

    def GetElementDescriptionCount(self) -> int:
        """The number of children that SDF knows here."""
        return len(self.description.children) if self.description is not None else 0

    def describe(self, description: Description) -> None:
        """Take a description: tag, defaults of attributes, and required children."""
        self.name, self.description = description.name, description
        self._take_defaults(description)
        self.add_required()

    # Children ----------------------------------------------------------------------------------------------------

    def named(self, name: str) -> Iterator[Element]:
        """All children of one name, in order."""
        return (child for child in self.children if child.name == name)

    def find(self, name: str) -> Iterator[Element]:
        """All elements of one name in this one, at any depth, in the order of the file."""
        waiting = self.children[::-1]
        while waiting:
            element = waiting.pop()
            if element.name == name:
                yield element
            waiting += element.children[::-1]

    def _first(self, name: str) -> Element | None:
        """The first child of a name."""
        for child in self.children:
            if child.name == name:
                return child
        return None

    def HasElement(self, name: str) -> bool:
        """Whether there is a child of this name."""
        return self._first(name) is not None

    def GetElement(self, name: str) -> Element | Any:
        """The first child of this name. If SDF knows it here, a missing one is created with its defaults; else None."""
        found = self.find_or_imply(name)
        if found is not None:
            found.implied = False
        return found

    def find_or_imply(self, name: str) -> Element | None:
        """The same, for reading only: `prune` removes what was created unless a value of it is set later."""
        found = self._first(name)
        if found is None and self.description is not None and name in self.description.children:
            found = self.AddElement(name)
            found.implied = True
        return found

    def prune(self) -> None:
        """Remove all in it that was only created to be read, with its defaults."""
        self.children = [child for child in self.children if not child.implied or child._is_given()]
        for child in self.children:
            child.prune()

    def _is_given(self) -> bool:
        values = (self.value, *self.attributes.values())
        return any(value.given for value in values) or any(child._is_given() for child in self.children)

    def child(self, name: str) -> Element:
        """The same, for reading only, of a child that must exist.

        Raises:
            NotFoundError: there is none, and SDF knows none of this name here.
        """
        found = self.find_or_imply(name)
        if found is None:
            names = [child.name for child in self.children]
            raise NotFoundError(f"{self.where}: <{self.name}> has no <{name}>{nearest(name, names)}")
        return found

    def GetElementTypeNames(self) -> set[str]:
        """The names of its children."""
        return {child.name for child in self.children}

    def CountNamedElements(self, name: str = "") -> dict[str, int]:
        """How often each value of the attribute `name` occurs among the children of a name, or among all of them."""
        found = (c.Get(str, "name") for c in self.children if c.HasAttribute("name") and name in ("", c.name))
        return dict(Counter(found))

    def HasUniqueChildNames(self, name: str = "") -> bool:
        """Whether the attributes `name` of the children of a name, or of all of them, differ."""
        return all(count == 1 for count in self.CountNamedElements(name).values())

    def GetFirstElement(self) -> Element | Any:
        """The first child."""
        return self.children[0] if self.children else None

    def GetNextElement(self, name: str = "") -> Element | Any:
        """The next element beside this one, of a name if one is given."""
        beside = self.parent.children if self.parent is not None else []
        index = next((i for i, element in enumerate(beside) if element is self), len(beside))
        return next((e for e in beside[index + 1 :] if not name or e.name == name), None)

    def AddElement(self, name: str) -> Element:
        """Add a child at the end; one that SDF knows here gets its required children with their defaults."""
        description = self.description.children.get(name) if self.description is not None else None
        element = self.InsertElement(Element(name, description, file=self.file, line=self.line))
        element.add_required()
        return element

    def add_required(self) -> None:
        """Create the required children that are missing."""
        for name, about in self.description.children.items() if self.description is not None else ():
            if about.required and not self.HasElement(name):
                self.AddElement(name)

    def InsertElement(self, element: Element) -> Element:
        """Add an element as the last child."""
        element.parent = self
        self.children.append(element)
        return element

    def RemoveChild(self, element: Element) -> None:
        """Remove a child."""
        self.children = [child for child in self.children if child is not element]
        element.parent = None

    def ClearElements(self) -> None:
        """Remove all children."""
        for child in list(self.children):
            self.RemoveChild(child)

    # Values ------------------------------------------------------------------------------------------------------

    def HasAttribute(self, key: str) -> bool:
        """Whether the file contains this attribute."""
        return key in self.attributes and self.attributes[key].given

    def GetAttribute(self, key: str) -> Param | Any:
        """An attribute; None if SDF knows none of this name here."""
        return self.attributes.get(key)

    def GetAttributeCount(self) -> int:
        """The number of attributes, those that the file does not give included."""
        return len(self.attributes)

    def GetAttributeSet(self, key: str) -> bool:
        """Whether the file, or a call, gives an attribute."""
        return self.HasAttribute(key)

    def AddAttribute(self, key: str, type: str, defaultvalue: str, required: bool, description: str = "") -> None:
        """Add an attribute with a default."""
        self.attributes[key] = Param(key, type, str(defaultvalue), given=bool(required))

    def AddValue(self, type: str, defaultValue: str, required: bool = False, description: str = "") -> None:
        """Give it a value with a default."""
        self.value = Param(self.name, type, str(defaultValue), given=False)

    def GetValue(self) -> Param:
        """This element's own value."""
        return self.value

    @overload
    def Get(self, kind: type[T], key: str = "") -> T: ...

    @overload
    def Get(self, kind: type[T], key: str, default: T) -> tuple[T, bool]: ...

    def Get(self, kind: type[T], key: str = "", default: T | None = None) -> T | tuple[T, bool]:
        """A value: of the attribute `key`, else of the child `key`, else the default of the description.

        Without a key, this element's own. A value found nowhere is empty: an empty string, 0, False, the zero pose.
        With a third argument, the pair (value, whether it was found), with that default if it was not.

        Raises:
            ParameterError: the text is no such value; the message has file and line.
        """
        element, text, found = self._look_up(key)
        if default is not None and not found:
            return default, False
        try:
            value = parse(kind, text)
        except ParameterError as error:
            raise ParameterError(f"{element.where}: <{element.name}>: {error}") from None
        return (value, True) if default is not None else value

    def _look_up(self, key: str) -> tuple[Element, str, bool]:
        """(element, text, whether it was found)."""
        if not key:
            return self, self.value.text, True
        attribute = self.attributes.get(key)
        if attribute is not None:
            return self, attribute.text, attribute.given
        child = self._first(key)
        if child is not None:
            return child, child.value.text, True
        known = self.description.children.get(key) if self.description is not None else None
        return self, known.default if known is not None else "", False

    def Set(self, value: Any) -> bool:
        """Replace this element's own value."""
        self.value.Set(value)
        return True

    def set_attribute(self, key: str, value: Any) -> None:
        """Set an attribute, which need not exist yet."""
        self.attributes.setdefault(key, Param(key, "string", "", given=True)).Set(value)

    # Copies and text ---------------------------------------------------------------------------------------------

    def Clone(self) -> Element:
        """A copy of this element and all in it, without a parent."""
        copy = Element(self.name, self.description, file=self.file, line=self.line)
        copy.implied = self.implied
        copy.value = self.value.Clone()
        copy.attributes = {k: p.Clone() for k, p in self.attributes.items()}
        for child in self.children:
            copy.InsertElement(child.Clone())
        return copy

    def Copy(self, other: Element) -> None:
        """Become a copy of another element, in its own place."""
        copy = other.Clone()
        self.name, self.description, self.value = copy.name, copy.description, copy.value
        self.attributes = copy.attributes
        self.ClearElements()
        for child in list(copy.children):
            self.InsertElement(child)

    # Of SDF 1.3 and before: `sdf->GetElement("x")->GetValueDouble()` ----------------------------------------------

    def GetValueString(self, key: str = "") -> str:
        """The value as a text; also of an attribute or child."""
        return self.Get(str, key)

    def GetValueDouble(self, key: str = "") -> float:
        """The value as a number; also of an attribute or child."""
        return self.Get(float, key)

    GetValueFloat = GetValueDouble

    def GetValueInt(self, key: str = "") -> int:
        """The value as a whole number; also of an attribute or child."""
        return self.Get(int, key)

    GetValueUInt = GetValueInt

    def GetValueBool(self, key: str = "") -> bool:
        """Whether the value is true; also of an attribute or child."""
        return self.Get(bool, key)

    def ToString(self, prefix: str = "") -> str:
        """The element as XML, each line after `prefix`.

        Of the attributes that the file does not give, those are written that SDF requires, with their defaults.
        """
        words = [f' {k}="{xml_attribute(p.GetAsString())}"' for k, p in self.attributes.items() if self._is_written(p)]
        before = "".join(f"{prefix}<!--{comment}-->\n" for comment in self.comments)
        start = f"{before}{prefix}<{self.name}{''.join(words)}"
        text = xml_text(self.value.GetAsString())
        if self.children:
            inside = "".join(child.ToString(prefix + "  ") for child in self.children)
            return f"{start}>{text}\n{inside}{prefix}</{self.name}>\n"
        return f"{start}>{text}</{self.name}>\n" if text else f"{start}/>\n"

    def _is_written(self, attribute: Param) -> bool:
        about = self.description.all_attributes.get(attribute.name) if self.description is not None else None
        return attribute.given or (about is not None and about.required and attribute.text not in ("", UNSET))

    def PrintValues(self, prefix: str = "") -> str:
        """The same; the old name."""
        return self.ToString(prefix)
