"""What compiled plugins ask of the client: pause, numbers of entities, properties of gui.ini."""

from __future__ import annotations

from libgz.base.errors import GazeboError
from libgz.classic import gui, msgs, transport
from libgz.classic.gui.named import read_ini

__all__ = ["entity_id", "find_property", "pause", "set_property"]

_set: dict[str, str] = {}


def pause(on: bool) -> None:
    """Pause the server's world, or let it run."""
    window = gui.get_main_window()
    if window is not None:  # a widget may outlive the client
        (window.Pause if on else window.Play)()


def entity_id(name: str) -> int:
    """The server's number of an entity; 0 if there is none, as in Gazebo."""
    try:
        answer = transport.request(gui.get_world(), "entity_info", name)
    except GazeboError:
        return 0
    if answer.response != "success" or not answer.type.endswith(".Model"):
        return 0
    return int(msgs.Model.FromString(answer.serialized_data).id)


def find_property(key: str) -> str | None:
    """The value of ``section.name`` that a plugin has set, or that gui.ini has; None if there is none."""
    section, _, name = key.partition(".")
    return _set.get(key, read_ini().get(section, name, fallback=None))


def set_property(key: str, value: str) -> None:
    """Set a property of this process; the file stays as it is."""
    _set[key] = value
