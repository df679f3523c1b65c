"""libgz_position: a model of an SDF world, driven by legacy clients."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN
from libgz.classic.plugins._names import named_joint
from libgz.classic.plugins._position_drive import PositionDrive, positive

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element


class PositionPlugin(PositionDrive):
    """Serves the libgazebo interface `position` for a model with two driven wheels.

    Legacy clients drive it: `libgz.Client().position("robot1").command(vx=0.3)`, Player's driver, or a C program with
    libgazebo, if the world runs with a server id (`gzserver --server-id 0`). Speed forward, yaw rate left positive.
    Odometry is computed from the wheels, from zero at the start and after a reset. A command is valid until the next.

    Elements:
        leftJoint, rightJoint: names of the wheels' joints (also left_joint, right_joint).
        wheelSeparation: [m]; by default the distance between the joints.
        wheelDiameter: [m]; by default that of the left wheel's shape.
        torque: maximum torque of each wheel's motor [N m] (5).
        updateRate: updates of the interface per second of sim time [Hz] (10).
        id: of the interface; by default the model's name.
    """

    STATE = ()

    def Load(self, model: Model, sdf: Element) -> None:
        """Read the elements, and create the interface."""
        self.serve(
            model,
            [named_joint(model, sdf, "leftJoint", "left_joint")],
            [named_joint(model, sdf, "rightJoint", "right_joint")],
            torque=positive(sdf, "torque", 5.0),
            rate=positive(sdf, "updateRate", 10.0),
            name=sdf.Get(str, "id").strip() or model.GetName(),
            diameter=positive(sdf, "wheelDiameter", 0.0) if sdf.HasElement("wheelDiameter") else None,
            distance=positive(sdf, "wheelSeparation", 0.0) if sdf.HasElement("wheelSeparation") else None,
        )


GZ_REGISTER_MODEL_PLUGIN(PositionPlugin)
