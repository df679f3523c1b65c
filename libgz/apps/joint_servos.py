"""Joint servos: move joints of SDF models to where a user wants them, by ODE's motors."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator

from libgz.base.errors import GazeboError, NotFoundError, ParameterError, nearest
from libgz.sdfworld.joint import SdfJoint
from libgz.sdfworld.model import SdfModel
from libgz.simulation.world import World

__all__ = ["JointServos"]

GAIN = 5.0  # [1/s] velocity for each radian or metre that is missing
FASTEST = 2.0  # [rad/s] or [m/s]
STRENGTH = 20.0  # times the model's weight at 1 m, where the file limits no effort


class JointServos:
    """Holds joints at positions, until they are released or the world is reset. An extension of the world.

    Args:
        world: of SDF.
    """

    STATE = ("_targets",)

    def __init__(self, world: World) -> None:
        self._world = world
        self._targets: dict[tuple[str, str, int], float] = {}

    def hold(self, model: str, name: str, axis: int, position: float) -> None:
        """Move an axis of a joint to a position [rad] or [m], and hold it there against any effort of its motor.

        Raises:
            NotFoundError: there is no such joint.
            ParameterError: it has no such axis or no motor, or the position is not finite.
        """
        joint = self._joint(model, name)
        if not math.isfinite(position):
            raise ParameterError(f"the position of joint {name!r} is {position}; it must be finite")
        limits = joint.axis_at(axis)
        joint.get_param("fmax", axis)
        self._targets[model, name, axis] = min(max(position, limits.lower), limits.upper)

    def release(self, model: str) -> None:
        """Switch off the motors that hold a model's joints."""
        for key in [key for key in self._targets if key[0] == model]:
            del self._targets[key]
            joint = self._joint(*key[:2])
            joint.set_param("vel", 0.0, key[2])
            joint.set_param("fmax", joint.axis_at(key[2]).friction, key[2])

    def clear(self) -> None:
        """Forget all, after the world itself has set its joints anew."""
        self._targets.clear()

    @property
    def active(self) -> bool:
        """Whether a joint is held."""
        return bool(self._targets)

    @contextlib.contextmanager
    def replaced(self) -> Iterator[None]:
        """While a state is set, in which no joint was held, or others."""
        before = dict(self._targets)
        self._targets.clear()
        try:
            yield
        except BaseException:
            self._targets.update(before)
            raise

    def act(self) -> None:
        """Set the motors for the next step."""
        for key, target in list(self._targets.items()):
            model, name, axis = key
            try:
                joint = self._joint(model, name)
                missing = target - joint.position(axis)
                joint.set_param("vel", min(max(GAIN * missing, -FASTEST), FASTEST), axis)
                joint.set_param("fmax", self._effort(model, joint, axis), axis)
            except GazeboError:  # the model was deleted
                del self._targets[key]

    def _effort(self, model: str, joint: SdfJoint, axis: int) -> float:
        """What the motor may apply [N m] or [N]."""
        limit: float = joint.axis_at(axis).effort
        if 0.0 < limit < math.inf:
            return limit
        mass: float = sum(body.GetMass().mass for body in self._world.model(model).bodies if not body.dummy)
        return STRENGTH * 9.81 * max(mass, 0.1)

    def _joint(self, model: str, name: str) -> SdfJoint:
        entity = self._world.model(model)
        joints = entity.sdf_joints if isinstance(entity, SdfModel) else {}
        if name not in joints:
            raise NotFoundError(f"model {model!r} has no joint {name!r}{nearest(name, list(joints))}")
        return joints[name]
