"""TouchPlugin: reports when a model has touched one other model for some time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.base.errors import NotFoundError, nearest
from libgz.classic import msgs, transport
from libgz.classic.event import Events
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element


class TouchPlugin(ModelPlugin):
    """Publishes an Int 1 on /<namespace>/touched when this model has touched the target, and nothing else, for a time.

    Then it is disabled. An Int on /<namespace>/enable enables (1) and disables (0) it.

    Elements:
        sensor: the name of a contact sensor of the model, whose collisions count; several. None: all collisions count.
        target: the name of a model, or the beginning of scoped names of collisions.
        time: how long [s].
        namespace: of the topics.
        enabled: whether it runs from the start on (false).
    """

    STATE = ("enabled", "since")

    def Load(self, model: Model, sdf: Element) -> None:
        """Read the elements, and subscribe.

        Raises:
            NotFoundError: an element, or a contact sensor, is missing.
        """
        for tag in ("target", "time", "namespace"):
            if not sdf.HasElement(tag):
                raise NotFoundError(f"{sdf.where}: <{tag}> is missing")
        self.model, self.target = model, sdf.Get(str, "target").strip()
        self.time, space = sdf.Get(float, "time"), sdf.Get(str, "namespace").strip().strip("/")
        self.start = sdf.Get(bool, "enabled", False)[0]
        self.watched = [name for element in sdf.named("sensor") for name in self._collisions(element)]
        self.contacts = model.GetWorld().Physics().GetContactManager()
        self.contacts.SetNeverDropContacts(True)
        self.node = transport.Node()
        self.node.Init(space)
        self.publisher = self.node.Advertise(msgs.Int, f"/{space}/touched")
        self.subscriber = self.node.Subscribe(f"/{space}/enable", self.OnEnable, kind="Int")
        self.Reset()
        self.connection = Events.ConnectWorldUpdateEnd(self.OnUpdate)

    def _collisions(self, element: Element) -> list[str]:
        """Scoped names of the collisions of the contact sensor that a `<sensor>` of the plugin names."""
        name, known = element.Get(str).strip(), []
        for link in self.model.family_links():
            described = link.GetSDF()
            for sensor in described.named("sensor") if described is not None else ():
                if sensor.Get(str, "type") != "contact":
                    continue
                known.append(sensor.Get(str, "name"))
                if known[-1] == name:
                    parts = sensor.child("contact").named("collision")
                    return [f"{link.GetScopedName()}::{part.Get(str).strip()}" for part in parts]
        raise NotFoundError(
            f"{element.where}: <sensor> is {name!r}; model {self.model.GetName()!r} has the contact sensors "
            f"{', '.join(known) or 'none'}{nearest(name, known)}"
        )

    def Reset(self) -> None:
        """Return to the state of the start."""
        self.enabled = self.start
        self.since: float | None = None  # [s] of sim time

    def OnEnable(self, message: Any) -> None:
        """Enable or disable."""
        self.enabled, self.since = bool(message.data), None

    def OnUpdate(self) -> None:
        """Look at the contacts of the last step."""
        if not self.enabled:
            return
        touched = self._touched()
        if not touched or not all(self._is_target(name) for name in touched):
            self.since = None
            return
        now = self.model.GetWorld().SimTime().Double()
        if self.since is None:
            self.since = now
        if now - self.since >= self.time:
            self.enabled, self.since = False, None
            self.publisher.Publish(msgs.Int(data=1))

    def _touched(self) -> set[str]:
        """Scoped names of the collisions of other models that touch this one."""
        mine, found = f"{self.model.GetScopedName()}::", set()
        for contact in self.contacts.GetContacts():
            one, two = (collision.GetScopedName() for collision in (contact.collision1, contact.collision2))
            if one.startswith(mine) != two.startswith(mine):
                own, other = (one, two) if one.startswith(mine) else (two, one)
                if not self.watched or own in self.watched:
                    found.add(other)
        return found

    def _is_target(self, name: str) -> bool:
        return name.startswith(self.target)


GZ_REGISTER_MODEL_PLUGIN(TouchPlugin)
