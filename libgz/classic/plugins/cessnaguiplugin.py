"""CessnaGUIPlugin: flies the aeroplane of CessnaPlugin by keys and buttons of the client."""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING, Any

from libgz.classic import gui, msgs, transport
from libgz.classic.plugin import GZ_REGISTER_GUI_PLUGIN, GUIPlugin

if TYPE_CHECKING:
    from libgz.sdf.element import Element

MODEL = "cessna_c172"
THRUST = 0.1  # share of the maximum that a key press adds
ANGLE = math.radians(1.0)  # that a key press adds [rad]
MOST = math.radians(30.0)  # of a surface [rad]

# Key: surfaces or the propeller, each with the direction in which the key moves it.
KEYS: dict[str, dict[str, float]] = {
    "w": {"propeller_speed": 1.0},
    "s": {"propeller_speed": -1.0},
    "g": {"left_flap": 1.0, "right_flap": 1.0},
    "b": {"left_flap": -1.0, "right_flap": -1.0},
    "d": {"left_aileron": 1.0, "right_aileron": -1.0},
    "a": {"left_aileron": -1.0, "right_aileron": 1.0},
    "i": {"elevators": 1.0},
    "k": {"elevators": -1.0},
    "l": {"rudder": 1.0},
    "j": {"rudder": -1.0},
}
PRESETS: dict[str, dict[str, float]] = {
    "Take-off": {"propeller_speed": 0.8, "elevators": ANGLE, "left_flap": ANGLE, "right_flap": ANGLE},
    "Cruise": {"propeller_speed": 0.6},
    "Landing": {"propeller_speed": 0.3, "elevators": ANGLE, "left_flap": 10.0 * ANGLE, "right_flap": 10.0 * ANGLE},
}


class CessnaGUIPlugin(GUIPlugin):
    """Sends commands on ~/cessna_c172/control to the plugin CessnaPlugin of a model of this name.

    Keys: w and s change the thrust, a and d roll, i and k move the elevators, j and l the rudder, g and b the flaps.
    The buttons Take-off, Cruise and Landing set all of them.
    """

    STATE = ("commands",)

    def Load(self, sdf: Element) -> None:
        """Add the buttons, and subscribe to keys and the state."""
        self.commands: dict[str, float] = {}
        for name in PRESETS:
            self.gui.AddButton(name, functools.partial(self.preset, name))
        self.node = transport.Node()
        self.node.Init(gui.get_world())
        self.publisher = self.node.Advertise(msgs.Cessna, f"~/{MODEL}/control")
        self.subscriber = self.node.Subscribe(f"~/{MODEL}/state", self.OnState, kind="Cessna")
        self.connection = gui.Events.ConnectKeyPress(self.OnKeyPress)

    def OnState(self, message: Any) -> None:
        """Show the state."""
        self.gui.SetText(f"thrust {100.0 * message.propeller_speed:.0f} %")

    def OnKeyPress(self, event: Any) -> None:
        """Change what a key changes."""
        moved = KEYS.get(event.text.lower(), {})
        for name, direction in moved.items():
            step, most = (THRUST, 1.0) if name == "propeller_speed" else (ANGLE, MOST)
            least = 0.0 if name == "propeller_speed" else -most
            self.commands[name] = min(max(self.commands.get(name, 0.0) + direction * step, least), most)
        if moved:
            self._send()

    def preset(self, name: str) -> None:
        """Set all commands to those of a preset."""
        names = {part for moved in KEYS.values() for part in moved}
        self.commands = dict.fromkeys(names, 0.0) | PRESETS[name]
        self._send()

    def _send(self) -> None:
        self.publisher.Publish(msgs.Cessna(**{f"cmd_{name}": value for name, value in self.commands.items()}))


GZ_REGISTER_GUI_PLUGIN(CessnaGUIPlugin)
