"""Message types: those of Gazebo classic, made when they are first used, and those that programs declare.

They are Google's dynamic messages, with what `libgz.classic.msgs.message` adds. `messages.txt` has the declarations of
classic's. They are in a pool of their own, beside the messages that a program has from other sources.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from google.protobuf import descriptor_pool, message_factory
from google.protobuf.descriptor import Descriptor
from google.protobuf.descriptor_pb2 import DescriptorProto, FieldDescriptorProto, FileDescriptorProto

from libgz.base.encoding import register
from libgz.base.errors import NotFoundError, ParameterError, nearest
from libgz.classic.msgs.message import Message, extend

__all__ = ["PREFIX", "add_compiled", "declarations", "declare", "known_types", "message_type", "restored"]

PREFIX = "gazebo.msgs."
_FIELD = re.compile(
    r"(?P<kind>[\w.]+)\s+(?P<name>[A-Za-z_]\w*)\s*(?P<label>!|\[\])?\s*(?P<number>\d+)?\s*(?:=\s*(?P<default>\S+))?"
)
_KINDS = {
    name: FieldDescriptorProto.Type.Value(f"TYPE_{name.upper()}")
    for name in ("double", "float", "bool", "int32", "int64", "uint32", "uint64", "sint32", "string", "bytes")
}
_LABELS = {
    None: FieldDescriptorProto.LABEL_OPTIONAL,
    "!": FieldDescriptorProto.LABEL_REQUIRED,
    "[]": FieldDescriptorProto.LABEL_REPEATED,
}

_pool = descriptor_pool.DescriptorPool()
_types: dict[str, type[Message]] = {}  # by names without PREFIX
_added: set[str] = set()  # classic's messages in the pool
_compiled: set[str] = set()  # files in the pool that C++ code has compiled


@functools.cache
def declarations() -> dict[str, str]:
    """Name to declaration of classic's messages and enumerations."""
    text = Path(__file__).with_name("messages.txt").read_text(encoding="utf-8")
    lines = (line.partition(": ") for line in text.splitlines() if not line.startswith("#"))
    return {name: declaration for name, _, declaration in lines}


@functools.cache
def _families() -> dict[str, list[str]]:
    """Name of a message or enumeration -> itself, and those inside it."""
    families: dict[str, list[str]] = {}
    for name in declarations():
        families.setdefault(name.partition(".")[0], []).append(name)
    return families


def _is_enum(name: str) -> bool:
    return declarations().get(name, "").startswith("enum ")


def known_types() -> list[str]:
    """Return the full names of all message types."""
    classic = (PREFIX + name for name in declarations() if not _is_enum(name))
    return sorted({*classic, *(kind.GetTypeName() for kind in _types.values())})


def message_type(name: str) -> type[Message]:
    """Return the type with a name such as `gazebo.msgs.Vector3d`, `Vector3d`, or one that was declared.

    Raises:
        NotFoundError: there is none.
    """
    short = name.removeprefix(PREFIX)
    found = _types.get(short)
    if found is None:
        if short not in declarations() or _is_enum(short):
            known = [name.removeprefix(PREFIX) for name in known_types()]
            raise NotFoundError(
                f"there is no message type {name!r}{nearest(short, known)}; msgs.declare makes new ones"
            )
        _add_classic(short.partition(".")[0])
        found = _types[short]
    return found


def declare(name: str, fields: str, **enums: str) -> type[Message]:
    """Declare a message type.

    Both ends of a topic must declare it alike: a field's number on the wire is its position in `fields`, unless it is
    given.

    Args:
        name: Such as `my_robot.msgs.WheelSpeeds`.
        fields: Such as ``"double left, double right, Vector3d points[], int32 mode = 1"``: kind, name, `[]` for a
            repeated field or `!` for a required one, a number, a default. Kinds are double, float, bool, int32, int64,
            uint32, uint64, sint32, string, bytes, and the names of messages.
        enums: Enumerations by the names that `fields` use, such as ``Mode="IDLE DRIVING"``; values count from 1.

    Raises:
        ParameterError: the name is used by another declaration, or a field is invalid.
    """
    if not re.fullmatch(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*", name):
        raise ParameterError(f"a message type cannot be called {name!r}; it takes letters, digits, _ and dots")
    before = _types.get(name)
    if before is not None and before.__doc__ == _describe(name, fields):
        return before
    if name.removeprefix(PREFIX) in declarations():
        raise ParameterError(f"there is already a message type {name!r}")
    package, _, short = name.rpartition(".")
    file = FileDescriptorProto(name=f"{name}.proto", package=package, syntax="proto2")
    message = file.message_type.add(name=short)
    for key, words in enums.items():
        values = message.enum_type.add(name=key).value
        for number, word in enumerate(words.split(), 1):
            values.add(name=word, number=number)
    local = {key: f".{name}.{key}" for key in enums}
    _add_fields(file, message, name, fields, local)
    if before is not None:
        if before.__doc__ == name and _encoding(before.DESCRIPTOR) == _encoding(message):  # compiled from C++
            return before
        raise ParameterError(f"there is already a message type {name!r}")
    _add_file(file, {f"{name}": _describe(name, fields)})
    return _types[name]


def add_compiled(name: str, files: Sequence[bytes]) -> type[Message]:
    """Declare a message type that C++ code has compiled, and return it.

    Args:
        name: its full name.
        files: descriptors of its file and of those that it imports, each after what it imports itself. Classic's
            messages in them are libgz's own, and those that Python code has declared are that code's.

    Raises:
        ParameterError: a name is used by another declaration.
        NotFoundError: no file has it.
    """
    imports: dict[str, None] = {}  # files of the pool
    for data in files:
        file = FileDescriptorProto.FromString(data)
        kinds: list[Any] = [*file.message_type, *file.enum_type]
        new: list[Any] = []
        for one in kinds:
            if not file.package and one.name in declarations():
                raise ParameterError(f"message {one.name} of C++ has no package, and Gazebo has a {one.name}: name one")
            known = _file_of(f"{file.package}.{one.name}".lstrip("."))
            if known is None:
                new.append(one)
            else:
                imports[known] = None
        if not new:
            continue
        # Files of two programs may have one name, and one file may import others publicly.
        made = FileDescriptorProto(name=f"{len(_compiled)}/{file.name}", package=file.package)
        made.syntax = file.syntax or "proto2"
        made.dependency.extend(imports)
        made.options.CopyFrom(file.options)
        made.extension.extend(file.extension)
        made.message_type.extend(one for one in new if isinstance(one, DescriptorProto))
        made.enum_type.extend(one for one in new if not isinstance(one, DescriptorProto))
        _add_file(made, {})
        _compiled.add(made.name)
        imports[made.name] = None
    return message_type(name)


def restored(name: str, data: bytes) -> Message:
    """Return the message of a type and its encoding: what pickled messages are made of."""
    return message_type(name).FromString(data)


Message._restored = staticmethod(restored)
register(Message, lambda message: message.__reduce__()[1], restored)


def _file_of(name: str) -> str | None:
    """The pool's file with a message or an enumeration; None if no file has it."""
    if name.startswith(PREFIX) and (short := name.removeprefix(PREFIX)) in declarations():
        _add_classic(short)
    try:
        return str(_pool.FindFileContainingSymbol(name).name)
    except KeyError:
        return None


def _encoding(message: Descriptor | DescriptorProto) -> set[tuple[str, int, int, int, str]]:
    """What two declarations of a message must have in common."""
    if isinstance(message, Descriptor):
        found = DescriptorProto()
        message.CopyToProto(found)
        message = found
    return {(one.name, one.number, one.label, one.type, one.type_name) for one in message.field}


def _describe(name: str, fields: str) -> str:
    return f"{name}: {' '.join(fields.split())}"


# Descriptors ----------------------------------------------------------------------------------------------------------


def _add_classic(name: str) -> None:
    """Make one of classic's types, with those inside it and those that it contains."""
    if name in _added:
        return
    _added.add(name)
    file = FileDescriptorProto(name=f"{PREFIX}{name}.proto", package=PREFIX.rstrip("."), syntax="proto2")
    protos: dict[str, DescriptorProto] = {}
    texts: dict[str, str] = {}
    own = _families()[name]
    for key in sorted(own, key=lambda key: key.count(".")):
        outer, _, short = key.rpartition(".")
        if not _is_enum(key):
            protos[key] = protos[outer].nested_type.add(name=short) if outer else file.message_type.add(name=short)
    for key in own:
        declaration = declarations()[key]
        if _is_enum(key):
            outer, _, short = key.rpartition(".")
            values = protos[outer].enum_type.add(name=short).value
            for word in declaration.removeprefix("enum ").split(", "):
                value, number = word.split()
                values.add(name=value, number=int(number))
        else:
            _add_fields(file, protos[key], PREFIX + key, declaration, {})
            texts[PREFIX + key] = _describe(PREFIX + key, declaration)
    _add_file(file, texts)


def _add_file(file: FileDescriptorProto, texts: dict[str, str]) -> None:
    """Add a file to the pool, and register the classes of its messages."""
    try:
        _pool.Add(file)
        found = _pool.FindFileByName(file.name)
    except (TypeError, KeyError) as error:
        kinds: list[Any] = [*file.message_type, *file.enum_type]
        raise ParameterError(f"message {file.package}.{kinds[0].name}: {error}") from None
    for descriptor in found.message_types_by_name.values():
        _register(descriptor, texts)


def _register(descriptor: Descriptor, texts: dict[str, str]) -> None:
    full = descriptor.full_name
    made: Any = message_factory.GetMessageClass(descriptor)
    short = full.removeprefix(PREFIX)
    made.__module__, made.__qualname__, made.__doc__ = "libgz.classic.msgs", short, texts.get(full, full)
    extend(made)
    _types[short] = made
    for nested in descriptor.nested_types:
        _register(nested, texts)


def _add_fields(
    file: FileDescriptorProto, message: DescriptorProto, owner: str, fields: str, local: dict[str, str]
) -> None:
    """Add the fields of a declaration to a message's descriptor, and the files of their types as dependencies."""
    names: set[str] = set()
    for position, words in enumerate(fields.split(","), 1):
        match = _FIELD.fullmatch(words.strip())
        if match is None:
            raise ParameterError(f"message {owner}: field {words.strip()!r} is not like 'double x' or 'double x[]'")
        name, number = match["name"], int(match["number"] or position)
        if name in names:
            raise ParameterError(f"message {owner}: there are two fields {name!r}")
        names.add(name)
        field = message.field.add(name=name, number=number, label=_LABELS[match["label"]])
        kind = match["kind"]
        if kind in _KINDS:
            field.type = _KINDS[kind]
        elif kind in local:
            field.type, field.type_name = FieldDescriptorProto.TYPE_ENUM, local[kind]
        elif _is_enum(kind):
            field.type, field.type_name = FieldDescriptorProto.TYPE_ENUM, f".{PREFIX}{kind}"
            _depend(file, kind.partition(".")[0])
        else:
            field.type = FieldDescriptorProto.TYPE_MESSAGE
            field.type_name = "." + _message_name(file, owner, kind, local)
        if match["default"] is not None:
            if field.type == FieldDescriptorProto.TYPE_MESSAGE or match["label"] == "[]":
                raise ParameterError(f"message {owner}: field {name!r} cannot have a default")
            field.default_value = _default(owner, field, match["default"])


def _message_name(file: FileDescriptorProto, owner: str, kind: str, local: dict[str, str]) -> str:
    """Return the full name of a message that a field contains; its file becomes a dependency."""
    if owner in (kind, PREFIX + kind):
        return owner
    if kind in declarations():
        _depend(file, kind.partition(".")[0])
        return PREFIX + kind
    try:
        descriptor: Any = message_type(kind).DESCRIPTOR
    except NotFoundError:
        known = [*_KINDS, *local, *(name.removeprefix(PREFIX) for name in known_types())]
        raise ParameterError(f"message {owner}: there is no type {kind!r}{nearest(kind, known)}") from None
    if descriptor.file.name not in file.dependency:
        file.dependency.append(descriptor.file.name)
    return str(descriptor.full_name)


def _depend(file: FileDescriptorProto, name: str) -> None:
    """Make one of classic's messages a dependency of a file."""
    needed = f"{PREFIX}{name}.proto"
    if needed != file.name and needed not in file.dependency:
        _add_classic(name)
        file.dependency.append(needed)


def _default(owner: str, field: FieldDescriptorProto, word: str) -> str:
    """Return a default in the form of descriptors.

    Raises:
        ParameterError: it does not fit the field.
    """
    word = word.strip('"')
    try:
        if field.type in (FieldDescriptorProto.TYPE_DOUBLE, FieldDescriptorProto.TYPE_FLOAT):
            float(word)
        elif field.type == FieldDescriptorProto.TYPE_BOOL:
            if word not in ("true", "false"):
                raise ValueError("it must be true or false")
        elif field.type not in (
            FieldDescriptorProto.TYPE_STRING, FieldDescriptorProto.TYPE_BYTES, FieldDescriptorProto.TYPE_ENUM
        ):  # fmt: skip
            int(word)
    except ValueError as error:
        raise ParameterError(f"{owner}.{field.name} cannot be {word}: {error}") from None
    return word
