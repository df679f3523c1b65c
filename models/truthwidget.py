"""TruthWidget: publishes the true pose of its robot, and moves it on request."""

from __future__ import annotations

import math

from libgz.base.geometry import GzCoordPoseSub, GzPose, GzQuatern, GzQuaternNormal, GzVector
from libgz.interfaces.truth import Truth
from libgz.legacy.model import Model
from libgz.models.motion import Motion
from libgz.models.parts import add_body
from libgz.models.serving import serve
from libgz.simulation.entity import Entity
from libgz.simulation.updates import Exchange, UpdateRows, replaced
from libgz.transport.guard import Guard
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

FARTHEST = 1e6  # [m]; largest coordinate that a client can request


class TruthWidget(Model):
    """The true global pose of the model it is nested in, or its own at the top level; without a shape.

    A client that writes `cmd_pos` and `cmd_rot` and then sets `cmd_new` moves that model there, at rest. It publishes
    and obeys in every step, also while the world is paused.
    """

    ROW_PARTS = Model.ROW_PARTS | {"truth", "parent"}

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

    def Update(self, step: float) -> None:  # noqa: D102
        pose = self._subject.GetPose()
        if not self.truth.lock():
            return
        new = self.truth.data.cmd_new
        wanted = self.truth.take_move()
        self.truth.publish(self.world.GetSimTime(), pose)
        self.truth.unlock()
        if wanted is not None and self.truth.intact() and self.guard.switch("cmd_new", new, False):
            self._move(wanted)
            self._publish()

    def MasterRowsOfUpdate(self, rows: UpdateRows) -> bool:
        """Describe `Update` as rows: native code publishes, Python moves the model."""
        subject = self._subject
        if replaced(self, TruthWidget, "Update") or replaced(subject, Entity, "GetPose", "GetBody"):
            return False
        motion, exchange = Motion(), Exchange(self.truth)
        exchange.switch("cmd_new", self.guard.switch_record("cmd_new"))
        exchange.now()
        exchange.doubles("pos", (motion, "position"), 3)
        if len(self.truth.data.rot) == 4:
            exchange.doubles("rot", (motion, "rotation"), 4)
        else:
            exchange.doubles("rot", (motion, "attitude"), 3)
        motion.add_row(rows, subject.GetBody())
        rows.share(self.Update, exchange)
        return True

    @property
    def _subject(self) -> Entity:
        return self.parent or self

    def _publish(self) -> None:
        pose = self._subject.GetPose()
        if self.truth.lock():
            self.truth.publish(self.world.GetSimTime(), pose)
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
