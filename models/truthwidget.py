"""TruthWidget: publishes the true pose of its robot, and moves it on request."""

from __future__ import annotations

import math

from libgz.base.geometry import GzCoordPoseSub, GzPose, GzQuatern, GzQuaternNormal, GzVector
from libgz.base.law import law
from libgz.interfaces.truth import Truth, TruthData
from libgz.legacy.model import Model
from libgz.models.parts import add_body
from libgz.models.serving import serve
from libgz.simulation.entity import Entity
from libgz.simulation.exchange import Exchange
from libgz.simulation.plan import Plan, handler
from libgz.transport.guard import Guard
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

FARTHEST = 1e6  # [m]; largest coordinate that a client can request


class TruthWidget(Model):
    """The true global pose of the model it is nested in, or its own at the top level; without a shape.

    A client that writes `cmd_pos` and `cmd_rot` and then sets `cmd_new` moves that model there, at rest. It publishes
    and obeys in every step, also while the world is paused.
    """

    active_while_paused = True
    behaviour = "moving its robot on request"
    interfaces = ("truth",)
    example = """
        <model:Pioneer2DX>
          <id>robot1</id>
          <xyz>0 0 0.24</xyz>
          <model:TruthWidget>
            <id>truth1</id>
          </model:TruthWidget>
        </model:Pioneer2DX>
    """

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        add_body(self, dummy=True)
        self.truth = Truth()

    def Init(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        self.guard = Guard(f"truth.{self.GetId()}")
        serve(self, self.truth)
        self._publish()

    def Fini(self) -> None:  # noqa: D102
        self.truth.destroy()

    def plan_update(self, plan: Plan) -> None:  # noqa: D102
        plan.exchange(self.truth, self._write, unless=self._expect, otherwise=self._exchange)

    @law
    def _write(self, _data: TruthData) -> None:
        """Write the pose."""
        self.truth.publish(self.world.GetSimTime(), self._subject.GetPose())

    def _expect(self, exchange: Exchange) -> None:
        """The condition that there is no request."""
        exchange.switch("cmd_new", self.guard.switch_record("cmd_new"))

    @handler
    def _exchange(self) -> None:
        """Publish, and do what a client requests."""
        if not self.truth.lock():
            return
        new = self.truth.data.cmd_new
        wanted = self.truth.take_move()
        self._write(self.truth.data)
        self.truth.unlock()
        if wanted is not None and self.truth.intact() and self.guard.switch("cmd_new", new, False):
            self._move(wanted)
            self._publish()

    @property
    @law
    def _subject(self) -> Entity:
        return self.parent or self

    def _publish(self) -> None:
        if self.truth.lock():
            self._write(self.truth.data)
            self.truth.unlock()

    def _move(self, wanted: GzPose) -> None:
        """Move the model to a global pose, if that is valid."""
        numbers = (*wanted.pos, *wanted.rot)
        length = math.sqrt(sum(q * q for q in wanted.rot)) if all(map(math.isfinite, numbers)) else 0.0
        if not 1e-6 < length < 1e6 or max(map(abs, wanted.pos)) > FARTHEST:
            self.guard.warn("cmd_pos, cmd_rot", "are {}, not a valid pose", "are ignored", numbers)
            return
        pose = GzPose(GzVector(*wanted.pos), GzQuaternNormal(GzQuatern(*wanted.rot)))
        subject = self._subject
        if subject.parentBody is not None:
            pose = GzCoordPoseSub(pose, subject.parentBody.GetPose())
        self.world.SetModelPose(subject, pose)
