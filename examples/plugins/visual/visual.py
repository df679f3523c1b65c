"""A Visual plugin that makes its visual blink: the colour changes every half period.

Visual plugins are loaded where images are rendered: on servers with cameras, and in clients. They change
what is seen, and nothing else.
"""

from libgz.classic import GZ_REGISTER_VISUAL_PLUGIN, VisualPlugin
from libgz.classic.event import Events
from libgz.classic.math import Color


class Blink(VisualPlugin):
    """Elements: `<color_a>`, `<color_b>`, red green blue alpha; `<period>` [s]."""

    STATE = ()  # nothing of its own to remember

    def Load(self, visual, sdf):
        self.visual = visual
        self.colors = [
            self.LoadParam(sdf, "color_a", Color(1.0, 0.0, 0.0, 1.0)),
            self.LoadParam(sdf, "color_b", Color(0.0, 0.0, 1.0, 1.0)),
        ]
        self.period = self.LoadParam(sdf, "period", 1.0)
        # PreRender is sent before each image is rendered; changes made there are visible in it.
        self.connection = Events.ConnectPreRender(self.OnPreRender)

    def OnPreRender(self):
        now = self.visual.GetScene().SimTime().Double()
        color = self.colors[int(2.0 * now / self.period) % 2]
        self.visual.SetAmbient(color)
        self.visual.SetDiffuse(color)


GZ_REGISTER_VISUAL_PLUGIN(Blink)
