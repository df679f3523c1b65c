"""BlinkVisualPlugin: fades a visual between two colours."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.base.errors import ParameterError
from libgz.classic.common import Color, Time
from libgz.classic.event import Events
from libgz.classic.plugin import GZ_REGISTER_VISUAL_PLUGIN, VisualPlugin

if TYPE_CHECKING:
    from libgz.classic.rendering import Visual
    from libgz.sdf.element import Element


class BlinkVisualPlugin(VisualPlugin):
    """Fades its visual from one colour to another and back; the colours' alpha is its opacity.

    Elements:
        color_a: the colour at the begin of a period (1 0 0 1).
        color_b: the colour in the middle of it (0 0 0 1).
        period: [s] (1).
        use_wall_time: whether it follows real time instead of sim time (false).
    """

    STATE = ()  # it follows from the time

    def Load(self, visual: Visual, sdf: Element) -> None:
        """Read the elements.

        Raises:
            ParameterError: the period is not positive.
        """
        self.visual = visual
        self.first = sdf.Get(Color, "color_a", Color(1.0, 0.0, 0.0, 1.0))[0]
        self.second = sdf.Get(Color, "color_b", Color(0.0, 0.0, 0.0, 1.0))[0]
        self.period = sdf.Get(float, "period", 1.0)[0]
        if not self.period > 0.0:
            raise ParameterError(f"{sdf.where}: <period> is {self.period:g}; it must be positive")
        self.wall = sdf.Get(bool, "use_wall_time", False)[0]
        self.connection = Events.ConnectPreRender(self.OnPreRender)

    def OnPreRender(self) -> None:
        """Set the colour of this moment."""
        now = (Time.GetWallTime() if self.wall else self.visual.GetScene().SimTime()).Double()
        share = 1.0 - abs(2.0 * (now / self.period % 1.0) - 1.0)  # 0 at the begin, 1 in the middle of a period
        color = Color(*(a + share * (b - a) for a, b in zip(self.first, self.second, strict=True)))
        self.visual.SetAmbient(color)
        self.visual.SetDiffuse(color)
        self.visual.SetTransparency(1.0 - color.A())


GZ_REGISTER_VISUAL_PLUGIN(BlinkVisualPlugin)
