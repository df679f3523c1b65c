"""KeysToJointsPlugin: moves joints by keys."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from libgz.classic import transport
from libgz.classic.math import PID
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import find_joint
from libgz.errors import NotFoundError, ParameterError

if TYPE_CHECKING:
    from libgz.classic.physics import Joint, Model
    from libgz.sdf.element import Element

KINDS = ("position", "velocity", "force")


@dataclass
class Key:
    """What a key does: a joint, one of KINDS, and by how much."""

    joint: Joint
    kind: str
    scale: float


class KeysToJointsPlugin(ModelPlugin):
    """Moves joints when keys come on ~/keyboard/keypress, as libKeyboardGUIPlugin sends them.

    Elements:
        map: one a key, with attributes.
            key: its number, such as 117 for u.
            joint: the name of a joint.
            type: position: its target becomes its position plus the scale; velocity: its target becomes the scale;
                force: the scale is applied for one iteration.
            scale: [rad], [rad/s] or [N m]; [m], [m/s] or [N].
            kp, ki, kd: gains of the controller of position or velocity (1, 0.1, 0.01).
    """

    STATE = ()  # targets belong to the joint controller

    def Load(self, model: Model, sdf: Element) -> None:
        """Read the keys, and subscribe.

        Raises:
            NotFoundError: there is no key or no such joint.
            ParameterError: a kind is unknown.
        """
        self.controller = model.GetJointController()
        self.keys: dict[int, list[Key]] = {}
        for element in sdf.named("map"):
            for name in ("key", "joint"):
                if not element.Get(str, name).strip():
                    raise NotFoundError(f"{element.where}: <map> has no attribute {name!r}")
            kind = element.Get(str, "type", KINDS[0])[0].strip()
            if kind not in KINDS:
                raise ParameterError(f"{element.where}: type is {kind!r}; it must be {', '.join(KINDS)}")
            key = Key(find_joint(model, element.Get(str, "joint").strip()), kind, element.Get(float, "scale", 1.0)[0])
            self.keys.setdefault(element.Get(int, "key"), []).append(key)
            if kind != "force":
                self._set_gains(key, _pid(element))
        if not self.keys:
            raise NotFoundError(f"{sdf.where}: <map> is missing; there must be one for each key")
        self.node = transport.Node()
        self.node.Init(model.GetWorld().Name())
        self.subscriber = self.node.Subscribe("~/keyboard/keypress", self.OnKeyPress)

    def _set_gains(self, key: Key, pid: PID) -> None:
        name = key.joint.GetScopedName()
        if key.kind == "position":
            self.controller.SetPositionPID(name, pid)
        else:
            self.controller.SetVelocityPID(name, pid)

    def OnKeyPress(self, message: Any) -> None:
        """A key was pressed."""
        for key in self.keys.get(message.int_value, ()):
            name = key.joint.GetScopedName()
            if key.kind == "position":
                self.controller.SetPositionTarget(name, key.joint.Position(0) + key.scale)
            elif key.kind == "velocity":
                self.controller.SetVelocityTarget(name, key.scale)
            else:
                key.joint.SetForce(0, key.scale)


def _pid(element: Element) -> PID:
    """The controller of a `<map>`; what it does not give is as of Gazebo's joint controllers."""
    p, i, d = (element.Get(float, name, gain)[0] for name, gain in (("kp", 1.0), ("ki", 0.1), ("kd", 0.01)))
    return PID(p, i, d, 1.0, -1.0, 1000.0, -1000.0)


GZ_REGISTER_MODEL_PLUGIN(KeysToJointsPlugin)
