"""KeyboardGUIPlugin: sends the keys that are pressed in the client."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.classic import gui, msgs, transport
from libgz.classic.plugin import GZ_REGISTER_GUI_PLUGIN, GUIPlugin

if TYPE_CHECKING:
    from libgz.sdf.element import Element


class KeyboardGUIPlugin(GUIPlugin):
    """Publishes each key press of the client on ~/keyboard/keypress: a msgs.Any with the key's number as `int_value`.

    The number is that of the character, `ord("w")`, or the event's own for keys without one, such as arrows. Key
    presses are events of the client: ``gui.Events.keyPress(msgs.KeyEvent(text="w"))``.
    """

    def Load(self, sdf: Element) -> None:
        """Connect to key presses of the client."""
        self.node = transport.Node()
        self.node.Init(gui.get_world())
        self.publisher = self.node.Advertise(msgs.Any, "~/keyboard/keypress")
        self.connection = gui.Events.ConnectKeyPress(self.OnKeyPress)

    def OnKeyPress(self, event: Any) -> None:
        """A key was pressed."""
        number = ord(event.text[0]) if event.text else event.key
        self.publisher.Publish(msgs.Any(type="INT32", int_value=number))


GZ_REGISTER_GUI_PLUGIN(KeyboardGUIPlugin)
