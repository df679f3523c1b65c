"""TimerGUIPlugin: a stopwatch in the client."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.classic import gui, transport
from libgz.classic.common import Time, Timer
from libgz.classic.common.console import gzwarn
from libgz.classic.event import Events
from libgz.classic.math import Vector2i
from libgz.classic.plugin import GZ_REGISTER_GUI_PLUGIN, GUIPlugin

if TYPE_CHECKING:
    from libgz.sdf.element import Element


class TimerGUIPlugin(GUIPlugin):
    """Shows the real time that it has run as HH:MM:SS.mm, or of a countdown the time that remains.

    A GzString on its topic controls it: start, stop, reset.

    Elements:
        topic: (~/timer_control).
        pos: of its upper left corner [px] (0 0); negative: of its right or lower edge from that of the window.
        size: width and height [px] (200 80).
        start_stop_button, reset_button: whether it has them (false).
        countdown_time: a time [s] and [ns] from which it counts down.
    """

    def Load(self, sdf: Element) -> None:
        """Add the buttons, and subscribe.

        Raises:
            ParameterError: the countdown is not positive.
        """
        countdown = sdf.Get(Time, "countdown_time") if sdf.HasElement("countdown_time") else None
        self.timer = Timer(countdown, True) if countdown is not None else Timer()
        size = sdf.Get(Vector2i, "size", Vector2i(200, 80))[0]
        self.gui.Resize(size.X(), size.Y())
        self._move(sdf.Get(Vector2i, "pos"), size)
        if sdf.Get(bool, "start_stop_button", False)[0]:
            self.gui.AddButton("Start/Stop", self.OnStartStopButton)
        if sdf.Get(bool, "reset_button", False)[0]:
            self.gui.AddButton("Reset", self.timer.Reset)
        self.node = transport.Node()
        self.node.Init(gui.get_world())
        self.subscriber = self.node.Subscribe(
            sdf.Get(str, "topic", "~/timer_control")[0], self.OnTimerCtrl, kind="GzString"
        )
        self.OnPreRender()
        self.connection = Events.ConnectPreRender(self.OnPreRender)

    def _move(self, place: Vector2i, size: Vector2i) -> None:
        window = gui.get_main_window()
        x, y = place.X(), place.Y()
        self.gui.Move(
            x if x >= 0 else max(0, window.width() + x - size.X()),
            y if y >= 0 else max(0, window.height() + y - size.Y()),
        )

    def OnTimerCtrl(self, message: Any) -> None:
        """A command."""
        actions = {"start": self.timer.Start, "stop": self.timer.Stop, "reset": self.timer.Reset}
        action = actions.get(message.data)
        if action is None:
            gzwarn(f"Unable to process command[{message.data}]; there are {', '.join(actions)}")
        else:
            action()

    def OnStartStopButton(self) -> None:
        """Start it, or stop it if it runs."""
        if self.timer.GetRunning():
            self.timer.Stop()
        else:
            self.timer.Start()

    def OnPreRender(self) -> None:
        """Show the time."""
        hundredths = round(self.timer.GetElapsed().Double() * 100.0)
        minutes, hundredths = divmod(hundredths, 6000)
        self.gui.SetText(f"{minutes // 60:02}:{minutes % 60:02}:{hundredths // 100:02}.{hundredths % 100:02}")


GZ_REGISTER_GUI_PLUGIN(TimerGUIPlugin)
