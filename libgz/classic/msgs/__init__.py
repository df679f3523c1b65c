"""Messages: `msgs.Vector3d(x=1)`, `msgs.Pose()`, and all others of gazebo.msgs; types are created at first use.

They are Google's messages: fields are attributes (see `libgz.classic.msgs.message.Message`). The declarations are in
`libgz/classic/msgs/messages.txt`, and `declare` adds new ones.
"""

from __future__ import annotations

import typing as _typing

from libgz.base.errors import NotFoundError as _NotFoundError
from libgz.classic.api import serves_instead as _serves_instead, without as _without
from libgz.classic.msgs.convert import Convert, ConvertIgn, CreateRequest, Init, Set, Stamp
from libgz.classic.msgs.declare import PREFIX as _PREFIX, declare, known_types, message_type
from libgz.classic.msgs.message import Message
from libgz.classic.msgs.text import Parse

__all__ = [
    "Convert",
    "ConvertIgn",
    "CreateRequest",
    "Init",
    "Message",
    "Parse",
    "Set",
    "Stamp",
    "declare",
    "known_types",
    "message_type",
]


def __getattr__(name: str) -> _typing.Any:
    if name.startswith("_"):
        raise AttributeError(name)
    if name.endswith("ToSDF"):  # which needs the reader of SDF
        from libgz.classic.msgs import to_sdf as _to_sdf

        if name in _to_sdf.__all__:
            return getattr(_to_sdf, name)
    try:
        found = message_type(name)
    except _NotFoundError as error:
        if _serves_instead(__name__, name):
            return _without(__name__)(name)
        raise AttributeError(str(error)) from None
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    names = (name.removeprefix(_PREFIX) for name in known_types() if name.startswith(_PREFIX))
    return sorted({*__all__, *(name for name in names if "." not in name)})
