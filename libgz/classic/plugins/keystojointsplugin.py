"""KeysToJointsPlugin: moves joints by keys."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from libgz.base.errors import NotFoundError, nearest
from libgz.classic import transport
from libgz.classic.common import PID, gzwarn
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import find_joint

if TYPE_CHECKING:
    from libgz.classic.physics import Joint, Model
    from libgz.sdf.element import Element

KINDS = ("force", "position", "velocity")


@dataclass
class Key:
    """What a key does to a joint: `scale` is a step [rad] or [m], a velocity [rad/s] or [m/s], or an effort."""

    number: int
    joint: Joint
    kind: str
    scale: float


class KeysToJointsPlugin(ModelPlugin):
    """Subscribes to ~/keyboard/keypress, where libKeyboardGUIPlugin publishes, and moves joints of its model.

    Elements:
        map: one for each pair of a key and a joint; a key may move several. Attributes:
            key: number of the key.
            joint: name of the joint.
            type: position: the target is `scale` from where the joint is; velocity: it is `scale`; force: `scale` is
                applied for one iteration.
            scale: [rad] or [m], [rad/s] or [m/s], [N m] or [N].
            kp, ki, kd: gains of the joint's controller (0, 0, 0).
    """

    STATE = ()  # targets belong to the joint controller

    def Load(self, model: Model, sdf: Element) -> None:
        """Set the gains, and subscribe to keys."""
        self.controller = model.GetJointController()
        self.keys: list[Key] = []
        for element in sdf.named("map"):
            try:
                self.keys.append(self._key(model, element))
            except NotFoundError as error:
                gzwarn(f"{error}; the map has no effect")
        self.node = transport.Node()
        self.node.Init(model.GetWorld().Name())
        self.subscriber = self.node.Subscribe("~/keyboard/keypress", self.OnKeyPress, kind="Any")

    def _key(self, model: Model, element: Element) -> Key:
        for name in ("key", "joint", "scale", "type"):
            if not element.HasAttribute(name):
                raise NotFoundError(f"{element.where}: attribute {name!r} is missing")
        kind = element.Get(str, "type")
        if kind not in KINDS:
            raise NotFoundError(
                f"{element.where}: type is {kind!r}; allowed are {', '.join(KINDS)}{nearest(kind, KINDS)}"
            )
        try:
            joint = find_joint(model, element.Get(str, "joint"))
        except NotFoundError as error:
            raise NotFoundError(f"{element.where}: {error}") from None
        if kind != "force":
            pid = PID(*(element.Get(float, gain) if element.HasAttribute(gain) else 0.0 for gain in ("kp", "ki", "kd")))
            setter = self.controller.SetPositionPID if kind == "position" else self.controller.SetVelocityPID
            setter(joint.GetScopedName(), pid)
        return Key(element.Get(int, "key"), joint, kind, element.Get(float, "scale"))

    def OnKeyPress(self, message: Any) -> None:
        """A key was pressed."""
        for key in self.keys:
            if key.number != message.int_value:
                continue
            name = key.joint.GetScopedName()
            if key.kind == "position":
                self.controller.SetPositionTarget(name, key.joint.Position(0) + key.scale)
            elif key.kind == "velocity":
                self.controller.SetVelocityTarget(name, key.scale)
            else:
                key.joint.SetForce(0, key.scale)


GZ_REGISTER_MODEL_PLUGIN(KeysToJointsPlugin)
