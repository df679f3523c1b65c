"""gazebo_ros_link_attacher: joins links of any two models while the world runs, without ROS."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Any

from libgz.base.errors import GazeboError, NotFoundError, nearest
from libgz.classic import msgs, transport
from libgz.classic.plugin import GZ_REGISTER_WORLD_PLUGIN, WorldPlugin

if TYPE_CHECKING:
    from libgz.classic.physics import Link, Model, World
    from libgz.sdf.element import Element

log = logging.getLogger("libgz.classic")

SPACE = "/link_attacher_node"


class GazeboRosLinkAttacher(WorldPlugin):
    """Attaches two links as they stand, and detaches them.

    In place of ROS's services there are the topics /link_attacher_node/attach and /link_attacher_node/detach, which
    take a GzString_V: model 1, link 1, model 2, link 2. Each one done, or refused, is a GzString on
    /link_attacher_node/status: `attached m1 l1 m2 l2`, or `error: ...`. Links that are attached stay so when that is
    asked for again. A link of a static model holds the other one where it is.

    Elements: none.
    """

    STATE = ()  # joints belong to the first model that is not static

    def Load(self, world: World, sdf: Element) -> None:
        """Subscribe."""
        self.world = world
        self.node = transport.Node()
        self.node.Init(world.Name())
        self.publisher = self.node.Advertise(msgs.GzString, f"{SPACE}/status")
        self.subscribers = [
            self.node.Subscribe(
                f"{SPACE}/attach", lambda message: self._do("attached", self.attach, message), kind="GzString_V"
            ),
            self.node.Subscribe(
                f"{SPACE}/detach", lambda message: self._do("detached", self.detach, message), kind="GzString_V"
            ),
        ]

    def _do(self, what: str, act: Any, message: Any) -> None:
        words = [word.strip() for word in message.data]
        try:
            if len(words) != 4:
                raise NotFoundError(f"{len(words)} names are given; there must be 4: model, link, model, link")
            act(*words)
            text = f"{what} {' '.join(words)}"
        except GazeboError as error:
            log.error("link attacher: %s", error)
            text = f"error: {error}"
        self.publisher.Publish(msgs.GzString(data=text))

    def _link(self, model_name: str, name: str) -> Link:
        model = self.world.ModelByName(model_name)
        if model is None:
            near = nearest(model_name, [one.GetName() for one in self.world.Models()])
            raise NotFoundError(f"there is no model {model_name!r}{near}")
        link = model.GetLink(name)
        if link is None:
            near = nearest(name, [one.GetName() for one in model.GetLinks()])
            raise NotFoundError(f"model {model_name!r} has no link {name!r}{near}")
        return link

    def _joint(self, *words: str) -> tuple[Model, str, Link, Link]:
        """The model that holds the joint, its name, and both links.

        Raises:
            NotFoundError: there is no such link, or both are static, or one.
        """
        one, two = self._link(words[0], words[1]), self._link(words[2], words[3])
        holder = next((link.model for link in (one, two) if not link.IsStatic()), None)
        if holder is None or one is two:
            raise NotFoundError(f"{words[0]}::{words[1]} and {words[2]}::{words[3]} do not move against each other")
        return holder, f"attached_{'__'.join(words)}", one, two

    def attach(self, *words: str) -> None:
        """Attach two links by the names of model and link, model and link.

        Raises:
            NotFoundError: there is no such link.
        """
        holder, name, one, two = self._joint(*words)
        if holder.GetJoint(name) is None:
            ends = [link if not link.IsStatic() else None for link in (one, two)]
            holder.CreateJoint(name, "fixed", *(ends if ends[1] is not None else reversed(ends)))

    def detach(self, *words: str) -> None:
        """Detach them.

        Raises:
            NotFoundError: there is no such link, or they are not attached.
        """
        for names in (words, (*words[2:], *words[:2])):
            holder, name, _, _ = self._joint(*names)
            if holder.RemoveJoint(name):
                return
        raise NotFoundError(f"{words[0]}::{words[1]} and {words[2]}::{words[3]} are not attached")


GZ_REGISTER_WORLD_PLUGIN(GazeboRosLinkAttacher)
