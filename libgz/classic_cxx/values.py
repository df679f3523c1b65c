"""What the library asks Python for: values and elements in forms that C++ reads, messages, the console, topics."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from typing import Any

from libgz.base.errors import GazeboError, NotFoundError
from libgz.classic import common, gui, msgs, transport
from libgz.classic.common import console
from libgz.classic.event import Events
from libgz.classic.math import Inertiald, MassMatrix3d, Pose3d
from libgz.classic.msgs.declare import add_compiled, message_type
from libgz.classic.msgs.message import Message
from libgz.classic.physics import TrajectoryInfo
from libgz.sdf.element import Element
from libgz.sdf.reader import SdfFile

__all__ = [
    "connect",
    "element_from",
    "element_text",
    "formatted",
    "image_bytes",
    "image_colors",
    "inertial_from",
    "inertial_numbers",
    "master",
    "matrix_numbers",
    "message_type_of",
    "namespaces",
    "quiet",
    "say",
    "signal",
    "stop_server",
    "topics",
    "topics_by_type",
    "trajectory_from",
    "type_of",
]

# sdformat 12 knows versions up to 1.9; it reads elements of a world that was upgraded to that.
VERSION = "1.9"


def matrix_numbers(matrix: Any) -> list[float]:
    """The numbers of a matrix, row by row."""
    size = 4 if type(matrix).__name__ == "Matrix4d" else 3
    return [float(matrix(row, column)) for row in range(size) for column in range(size)]


def inertial_numbers(inertial: Any) -> list[float]:
    """Mass [kg], moments and products of inertia [kg m^2], and the pose of their frame."""
    mass = inertial.MassMatrix() if hasattr(inertial, "MassMatrix") else inertial
    pose = inertial.Pose()
    names = ("IXX", "IYY", "IZZ", "IXY", "IXZ", "IYZ")
    moments = [getattr(mass, name if hasattr(mass, name) else name.capitalize())() for name in names]
    return [float(number) for number in (mass.Mass(), *moments, *pose.pos, *pose.rot)]


def inertial_from(numbers: Sequence[float]) -> Inertiald:
    """What `inertial_numbers` has made numbers of."""
    mass, ixx, iyy, izz, ixy, ixz, iyz, *pose = numbers
    return Inertiald(MassMatrix3d(mass, (ixx, iyy, izz), (ixy, ixz, iyz)), Pose3d(*pose))


# Elements ------------------------------------------------------------------------------------------------------------


def element_text(element: Element) -> tuple[str, str]:
    """The name of an element, and a document that has it alone."""
    return element.GetName(), f'<?xml version="1.0"?><sdf version="{VERSION}">{element.ToString()}</sdf>'


def element_from(text: str) -> Element:
    """The element of a text of C++'s sdformat."""
    whole = text.lstrip().startswith(("<?xml", "<sdf"))
    file = SdfFile.from_string(text if whole else f'<sdf version="{VERSION}">{text}</sdf>', parts=True)
    file.diagnostics.raise_errors()
    return file.root.GetFirstElement() or file.root


# Messages ------------------------------------------------------------------------------------------------------------


def message_type_of(name: str, files: Sequence[bytes]) -> type[Message]:
    """The type of a message by its full name; one that a plugin has compiled itself is declared.

    Args:
        name: such as ``gazebo.msgs.Vector3d``.
        files: descriptors of the file with the message, after those that it imports.
    """
    try:
        found = message_type(name)
    except NotFoundError:
        found = None
    return found if found is not None and found.DESCRIPTOR.full_name == name else add_compiled(name, files)


# Console -------------------------------------------------------------------------------------------------------------


def say(stream: str, text: str, file: str, line: int) -> None:
    """Log a line of gzmsg, gzdbg, gzwarn, gzerr or gzlog."""
    getattr(console, stream).emit(text, file, line, "")


def quiet() -> bool:
    """Whether messages of gzmsg are not shown."""
    return not logging.getLogger("libgz.classic.console").isEnabledFor(logging.INFO)


def formatted(time: common.Time, start: int, end: int) -> str:
    """A time as classic writes it."""
    return time.FormattedString(start, end)


def image_bytes(image: Any) -> bytes:
    """The pixels of an image."""
    return bytes(memoryview(image.GetData()).cast("B"))


def image_colors(image: Any) -> bytes:
    """The pixels of an image as RGB."""
    return bytes(memoryview(image.GetRGBData()).cast("B"))


def trajectory_from(number: int, kind: str, duration: float, start: float, end: float, translated: bool) -> Any:
    """A trajectory of an actor; times in [s]."""
    info = TrajectoryInfo()
    info.id, info.type, info.translated = number, kind, translated
    info.duration, info.startTime, info.endTime = duration, start, end
    return info


# Events and topics ---------------------------------------------------------------------------------------------------


def connect(event: str, callback: Callable[..., object]) -> Any:
    """Connect a callback to an event of the world whose plugin is running, or of the client: ``gui.KeyPress``."""
    space, _, name = event.rpartition(".")
    if event == "gui.KeyPress":  # Python has the whole message
        return gui.Events.ConnectKeyPress(lambda key: callback(key.text))
    return getattr(gui.Events if space else Events, f"Connect{name}")(callback)


def signal(event: str, *values: Any) -> None:
    """Signal such an event."""
    space, _, name = event.rpartition(".")
    if space:
        if name == "KeyPress":
            values = (msgs.KeyEvent(text=values[0]),)
        getattr(gui.Events, name[:1].lower() + name[1:])(*values)
        return
    if event in ("WorldUpdateBegin", "BeforePhysicsUpdate"):
        values = (common.UpdateInfo(*values),)
    getattr(Events, event[:1].lower() + event[1:])(*values)


def topics(kind: str) -> list[str]:
    """The topics that are published with a type of messages; empty: all."""
    return list(transport.getAdvertisedTopics(kind))


def topics_by_type() -> dict[str, list[str]]:
    """The topics that are published, by type."""
    found: dict[str, list[str]] = {}
    for topic in transport.getAdvertisedTopics():
        found.setdefault(transport.getTopicMsgType(topic), []).append(topic)
    return found


def type_of(topic: str) -> str:
    """The type of messages of a topic; empty: it is not published."""
    try:
        return transport.getTopicMsgType(topic)
    except GazeboError:
        return ""


def namespaces() -> list[str]:
    """The worlds that have topics."""
    return list(transport.get_topic_namespaces())


def master() -> list[str]:
    """Host and port of the master."""
    return [str(part) for part in transport.get_master_uri()]


def stop_server() -> None:
    """Let the server end, as an interrupt does."""
    for event in ("SigInt", "Stop"):
        signal(event)
