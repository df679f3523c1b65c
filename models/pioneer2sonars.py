"""Pioneer2Sonars: the sonar ring of a Pioneer 2 as a separate model, as in Gazebo 0.3 to 0.5."""

from __future__ import annotations

from typing import ClassVar

from libgz.legacy.model import Model
from libgz.models.parts import add_body
from libgz.models.sonars import PIONEER2AT_RING, PIONEER2DX_RING, SonarRing
from libgz.simulation.plan import Plan
from libgz.simulation.rate import UpdateRate
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

UPDATE_RATE = 10.0  # [Hz]


class Pioneer2Sonars(Model):
    """Sixteen sonars on the robot it is nested in, with the layout of that robot; without a shape.

    The robot keeps its own sonar interface. On all models but a Pioneer2AT the layout is that of a Pioneer2DX.
    """

    STATE: ClassVar[tuple[str, ...]] = ("rate", "sonars")

    interfaces = ("sonar",)
    example = """
        <model:Pioneer2DX>
          <id>robot1</id>
          <xyz>0 0 0.24</xyz>
          <model:Pioneer2Sonars>
            <id>sonars1</id>
          </model:Pioneer2Sonars>
        </model:Pioneer2DX>
    """

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        body = add_body(self, dummy=True)
        on_at = self.parent is not None and self.parent.GetName() == "Pioneer2AT"
        self.rate = UpdateRate(UPDATE_RATE)
        self.sonars = SonarRing(self, self.parentBody or body, PIONEER2AT_RING if on_at else PIONEER2DX_RING)

    def Init(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        self.sonars.Init()

    def Fini(self) -> None:  # noqa: D102
        self.sonars.Fini()

    def plan_update(self, plan: Plan) -> None:  # noqa: D102
        with plan.due(self.rate):
            self.sonars.plan_update(plan)
