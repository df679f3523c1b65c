"""JointController: controls the positions, velocities and forces of a model's joints."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from ctypes import c_double
from typing import TYPE_CHECKING, Any

from libgz.base.errors import GazeboError, ParameterError, nearest
from libgz.base.law import LawError, Number, constant, law, unrecorded, usually
from libgz.classic.common import PID, Time
from libgz.classic.common.time import sim_nanoseconds
from libgz.classic.names import takes_names
from libgz.physics.check import finite

if TYPE_CHECKING:
    from libgz.classic.physics.joint import Joint
    from libgz.classic.physics.world import Model

__all__ = ["JointController"]

log = logging.getLogger("libgz.classic")

DEFAULT_GAINS = (1.0, 0.1, 0.01, 1.0, -1.0, 1000.0, -1000.0)  # p, i, d, imax, imin, cmdMax, cmdMin; Gazebo's
NEW_PID = PID(*DEFAULT_GAINS).SaveState()


@takes_names
class JointController:
    """PID control of the joints of a model, applied in every iteration; joints are given by scoped name or name."""

    def __init__(self, model: Model) -> None:
        self._model = model
        self._joints: dict[str, Joint] = {}
        self._position_pids: dict[str, PID] = {}
        self._velocity_pids: dict[str, PID] = {}
        # Targets are where native code finds them: a new one of a joint that had one is set there.
        self._forces: dict[str, c_double] = {}
        self._positions: dict[str, c_double] = {}
        self._velocities: dict[str, c_double] = {}
        self._clock = model.GetWorld().core.clock
        self._last = sim_nanoseconds(self._clock)
        for joint in model.all_joints():
            self.AddJoint(joint)

    _last = Number()  # sim time of the last update [ns]

    def _changed(self) -> None:
        """Joints, gains or the presence of targets have changed."""
        self._model.GetWorld().core.update_rows_changed()

    def match(self) -> None:
        """Have the joints that the model has now, each with its gains if it had any."""
        joints = {joint.GetScopedName(): joint for joint in self._model.all_joints()}
        for joint in [joint for name, joint in self._joints.items() if joints.get(name) is not joint]:
            self.RemoveJoint(joint)
        for name, joint in joints.items():
            if name not in self._joints:
                self.AddJoint(joint)
        self._joints = {name: self._joints[name] for name in joints}  # Update acts in this order

    @property
    def blank(self) -> bool:
        """Whether it is as one that is made now: without targets, with the default gains."""
        pids = (*self._position_pids.values(), *self._velocity_pids.values())
        return not self._targets() and all(pid.SaveState() == NEW_PID for pid in pids)

    def _tables(self) -> tuple[dict[str, c_double], ...]:
        return self._forces, self._positions, self._velocities

    def _targets(self) -> bool:
        return any(self._tables())

    def _changed_pids(self) -> list[dict[str, tuple[float, ...]]]:
        return [
            {name: state for name, pid in sorted(pids.items()) if (state := pid.SaveState()) != NEW_PID}
            for pids in (self._position_pids, self._velocity_pids)
        ]

    def SaveState(self) -> tuple[Any, ...]:
        """Targets, and the PIDs that are not as new."""
        return *map(_values, self._tables()), int(self._last), self._changed_pids()

    def LoadState(self, state: Sequence[Any] | None) -> None:
        """Take what SaveState returned; None for what a new one has."""
        self.match()
        *targets, last, changed = state or ({}, {}, {}, sim_nanoseconds(self._clock), ({}, {}))
        for table, values in zip(self._tables(), targets, strict=True):
            table.clear()
            table.update({name: c_double(value) for name, value in values.items()})
        self._last = float(last)
        self._changed()
        for pids, states in zip((self._position_pids, self._velocity_pids), changed, strict=True):
            for name, pid in pids.items():
                pid.LoadState(states.get(name, NEW_PID))

    def AddJoint(self, joint: Joint) -> None:
        """Add a joint."""
        name = joint.GetScopedName()
        self._joints[name] = joint
        self._changed()
        self._position_pids[name], self._velocity_pids[name] = PID(*DEFAULT_GAINS), PID(*DEFAULT_GAINS)

    def RemoveJoint(self, joint: Joint) -> None:
        """Remove a joint, its gains and targets."""
        name = joint.GetScopedName()
        if self._joints.get(name) is not joint:
            return
        for rows in (self._joints, self._position_pids, self._velocity_pids):
            rows.pop(name, None)
        self.drop_targets(name)

    def renamed(self) -> None:
        """Know the joints by the names that they have now."""
        names = {before: joint.GetScopedName() for before, joint in self._joints.items()}
        tables: tuple[dict[str, Any], ...] = (self._joints, self._position_pids, self._velocity_pids)
        for table in (*tables, *self._tables()):
            rows = [(names.get(name, name), value) for name, value in table.items()]
            table.clear()
            table.update(rows)
        self._changed()

    def drop_targets(self, name: str) -> None:
        """Apply no force to a joint any more, by its scoped name, and let it go where it will."""
        for targets in self._tables():
            targets.pop(name, None)
        self._changed()

    def scoped_name(self, name: str) -> str | None:
        """The scoped name of a joint; None if there is none."""
        if name in self._joints:
            return name
        return next((full for full in self._joints if full.endswith(f"::{name}")), None)

    def _known(self, name: str) -> str | None:
        """The scoped name of a joint; an unknown one is logged, and None."""
        found = self.scoped_name(name)
        if found is None:
            model = self._model.GetScopedName()
            log.error("Could not find joint with name[%s] in model %r%s", name, model, nearest(name, self._joints))
        return found

    def _set(self, targets: dict[str, c_double], name: str, value: float) -> bool:
        found = self.scoped_name(name)
        if found is None:
            return False
        number = finite(value, f"target of joint {found!r}")
        if found in targets:
            targets[found].value = number
        else:
            targets[found] = c_double(number)
            self._changed()
        return True

    def SetForce(self, jointName: str, force: float) -> bool:
        """Set the force on a joint from now on [N m] or [N]; returns whether there is such a joint."""
        return self._set(self._forces, jointName, force)

    def SetPositionTarget(self, jointName: str, target: float) -> bool:
        """Set the target position of a joint [rad] or [m]; returns whether there is such a joint."""
        return self._set(self._positions, jointName, target)

    def SetVelocityTarget(self, jointName: str, target: float) -> bool:
        """Set the target velocity of a joint [rad/s] or [m/s]; returns whether there is such a joint."""
        return self._set(self._velocities, jointName, target)

    def SetPositionPID(self, jointName: str, pid: PID) -> None:
        """Set the PID for the position of a joint; an unknown joint is logged."""
        name = self._known(jointName)
        if name is not None:
            self._position_pids[name] = _checked(pid)
            self._changed()

    def SetVelocityPID(self, jointName: str, pid: PID) -> None:
        """Set the PID for the velocity of a joint; an unknown joint is logged."""
        name = self._known(jointName)
        if name is not None:
            self._velocity_pids[name] = _checked(pid)
            self._changed()

    def GetJoints(self) -> dict[str, Joint]:
        """The joints by scoped name."""
        return dict(self._joints)

    def GetPositionPIDs(self) -> dict[str, PID]:
        """The PIDs for positions, by scoped name."""
        return dict(self._position_pids)

    def GetVelocityPIDs(self) -> dict[str, PID]:
        """The PIDs for velocities, by scoped name."""
        return dict(self._velocity_pids)

    def GetForces(self) -> dict[str, float]:
        """The forces that were set [N m] or [N], by scoped name."""
        return _values(self._forces)

    def GetPositions(self) -> dict[str, float]:
        """The target positions [rad] or [m], by scoped name."""
        return _values(self._positions)

    def GetVelocities(self) -> dict[str, float]:
        """The target velocities [rad/s] or [m/s], by scoped name."""
        return _values(self._velocities)

    def SetJointPosition(self, joint: str | Joint, position: float, index: int = 0) -> None:
        """Set the position of a joint [rad] or [m] at once; an unknown joint is logged."""
        name = self._known(joint if isinstance(joint, str) else joint.GetScopedName())
        if name is not None:
            self._joints[name].SetPosition(index, position)

    def SetJointPositions(self, jointPositions: dict[str, float]) -> None:
        """Set the positions of several joints [rad] or [m] at once."""
        for name, position in jointPositions.items():
            self.SetJointPosition(name, position)

    def GetLastUpdateTime(self) -> Time:
        """The sim time of the last update."""
        return Time(0, int(self._last))

    def Reset(self) -> None:
        """Remove all targets, and reset the PIDs."""
        for targets in self._tables():
            targets.clear()
        for pid in (*self._position_pids.values(), *self._velocity_pids.values()):
            pid.Reset()
        self._last = sim_nanoseconds(self._clock)
        self._changed()

    @law
    def Update(self) -> None:
        """Apply efforts for one step; called in every iteration."""
        now = sim_nanoseconds(self._clock)
        passed = (now - self._last) / 1e9
        self._last = now
        if not usually(passed > 0.0):
            return
        for control in self._controls():
            try:
                self._apply(passed, *control)
            except LawError:
                raise
            except GazeboError as error:  # the joint was destroyed, or the effort is not finite
                self._give_up(control[0], error)

    @constant
    def _controls(self) -> list[tuple[Any, ...]]:
        """(name, joint, force; target and PID of its position and of its velocity) of the joints with targets."""
        found = []
        for name in dict.fromkeys((*self._forces, *self._positions, *self._velocities)):
            force, position, velocity = (table.get(name) for table in self._tables())
            pids = self._position_pids[name], self._velocity_pids[name]
            found.append((name, self._joints[name], force, position, pids[0], velocity, pids[1]))
        return found

    @law
    def _apply(
        self,
        passed: float,
        _name: str,
        joint: Joint,
        force: c_double | None,
        position: c_double | None,
        position_pid: PID,
        velocity: c_double | None,
        velocity_pid: PID,
    ) -> None:
        if force is not None:
            joint.SetForce(0, force.value)
        if position is not None:
            joint.SetForce(0, position_pid.Update(joint.Position(0) - position.value, passed))
        if velocity is not None:
            joint.SetForce(0, velocity_pid.Update(joint.GetVelocity(0) - velocity.value, passed))

    @unrecorded
    def _give_up(self, name: str, error: GazeboError) -> None:
        log.error("joint %s is not controlled any more: %s", name, error)
        self.drop_targets(name)


def _values(targets: dict[str, c_double]) -> dict[str, float]:
    return {name: target.value for name, target in targets.items()}


def _checked(pid: PID) -> PID:
    if not isinstance(pid, PID):
        raise ParameterError(f"{pid!r} is not a PID")
    return pid
