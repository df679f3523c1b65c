"""gazebo_grasp_fix: fixes what a hand grips to its palm, until the hand opens."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING, NamedTuple

from libgz.base.errors import NotFoundError, ParameterError, nearest
from libgz.classic.event import Events
from libgz.classic.math import Vector3d
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin

if TYPE_CHECKING:
    from libgz.classic.physics import Link, Model
    from libgz.sdf.element import Element


class Hand(NamedTuple):
    """A hand of the robot: its name, its palm, and the links that grip."""

    name: str
    palm: Link
    fingers: tuple[Link, ...]


class GazeboGraspFix(ModelPlugin):
    """Fixes a link to a palm while links of the hand press it from opposite sides.

    At each update a link counts one more, up to a maximum, if two forces of the hand on it have an angle of at least
    the tolerance, and else one less. Above the threshold it is fixed to the palm, where it is. It is free again when a
    finger that pressed it has moved away from it by more than the release tolerance.

    Elements:
        arm: several; `arm_name`, `palm_link`, `gripper_link` (several, the palm may be one).
        forces_angle_tolerance: least angle of two forces [deg] (120).
        update_rate: [Hz] (5).
        grip_count_threshold: (3).
        max_grip_count: (2 times the threshold).
        release_tolerance: [m] (0.005).
        disable_collisions_on_attach: whether what is held touches nothing (false).
        contact_topic: read, and not needed: all contacts of the hand count.
    """

    STATE = ("counts", "held", "next")

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the links.

        Raises:
            NotFoundError: there is no such link, or no arm.
            ParameterError: a number is not allowed.
        """
        self.model, self.world = model, model.GetWorld()
        self.hands = [self._hand(element) for element in sdf.named("arm")]
        if not self.hands:
            raise NotFoundError(f"{sdf.where}: <arm> is missing; it names a palm and the links that grip")
        self.angle = math.radians(sdf.Get(float, "forces_angle_tolerance", 120.0)[0])
        rate = sdf.Get(float, "update_rate", 5.0)[0]
        self.threshold = sdf.Get(int, "grip_count_threshold", 3)[0]
        self.most = max(sdf.Get(int, "max_grip_count", 2 * self.threshold)[0], self.threshold + 1)
        self.tolerance = sdf.Get(float, "release_tolerance", 0.005)[0]
        self.ghosts = sdf.Get(bool, "disable_collisions_on_attach", False)[0]
        if not (rate > 0.0 and self.threshold >= 0 and self.tolerance >= 0.0 and math.isfinite(self.angle)):
            raise ParameterError(
                f"{sdf.where}: <update_rate> must be positive; <grip_count_threshold> and <release_tolerance> must not "
                "be negative"
            )
        self.period = 1.0 / rate
        self.contacts = self.world.Physics().GetContactManager()
        self.contacts.SetNeverDropContacts(True)
        self.Reset()
        self.connection = Events.ConnectWorldUpdateEnd(self.OnUpdate)

    def _hand(self, element: Element) -> Hand:
        names = [one.Get(str).strip() for one in element.named("gripper_link")]
        palm = element.Get(str, "palm_link").strip()
        fingers = [link for name in names if (link := self.model.GetLink(name)) is not None]
        found = self.model.GetLink(palm)
        if found is None or not fingers:
            known = [link.GetName() for link in self.model.GetLinks()]
            missing = palm if found is None else ", ".join(names)
            near = nearest(missing, known)
            raise NotFoundError(f"{element.where}: <arm>: model {self.model.GetName()!r} has no link {missing!r}{near}")
        return Hand(element.Get(str, "arm_name").strip() or palm, found, tuple(fingers))

    def Reset(self) -> None:
        """Hold nothing."""
        for hand in self.hands:
            self.model.RemoveJoint(self._joint(hand))
        self.counts: dict[str, int] = {}  # hand and link -> updates
        self.held: dict[str, tuple[str, dict[str, float]]] = {}  # hand -> link, distances of the fingers [m]
        self.next = 0.0

    @staticmethod
    def _joint(hand: Hand) -> str:
        return f"{hand.name}__grasp_fix__"

    def OnUpdate(self) -> None:
        """Count, fix and free."""
        now = self.world.SimTime().Double()
        if now < self.next - 1e-9:
            return
        self.next = now + self.period
        for hand in self.hands:
            pressed = self._pressed(hand)
            self._count(hand, pressed)
            if hand.name in self.held:
                self._release_if_open(hand)
            else:
                self._fix_if_held(hand, pressed)

    def _pressed(self, hand: Hand) -> dict[str, tuple[Link, dict[str, list[Vector3d]]]]:
        """Links that the hand touches, with the directions in which each finger presses them."""
        found: dict[str, tuple[Link, dict[str, list[Vector3d]]]] = {}
        for contact in self.contacts.GetContacts():
            ends = contact.collision1.GetLink(), contact.collision2.GetLink()
            fingers = [link in hand.fingers for link in ends]
            finger, other = ends if fingers[0] else ends[::-1]
            if fingers[0] == fingers[1] or other.model is self.model or other.IsStatic():
                continue
            sign = -1.0 if fingers[0] else 1.0  # normals point towards the first one
            presses = found.setdefault(other.GetScopedName(), (other, {}))[1]
            presses.setdefault(finger.GetName(), []).extend(normal * sign for normal in contact.normals)
        return found

    def _grips(self, presses: dict[str, list[Vector3d]]) -> bool:
        """Whether two directions have the angle."""
        ways = [way for found in presses.values() for way in found]
        limit = math.cos(self.angle)
        return any(one.Dot(two) <= limit + 1e-9 for one, two in itertools.combinations(ways, 2))

    def _count(self, hand: Hand, pressed: dict[str, tuple[Link, dict[str, list[Vector3d]]]]) -> None:
        for name, (_, presses) in pressed.items():
            if self._grips(presses):
                key = f"{hand.name} {name}"
                self.counts[key] = min(self.counts.get(key, 0) + 2, self.most + 1)  # one is taken below
        own = f"{hand.name} "
        for key in [key for key in self.counts if key.startswith(own)]:
            self.counts[key] -= 1
            if self.counts[key] <= 0:
                del self.counts[key]

    def _fix_if_held(self, hand: Hand, pressed: dict[str, tuple[Link, dict[str, list[Vector3d]]]]) -> None:
        for name, (link, presses) in sorted(pressed.items()):
            if self.counts.get(f"{hand.name} {name}", 0) > self.threshold and self._grips(presses):
                self.model.CreateJoint(self._joint(hand), "fixed", hand.palm, link)
                self.held[hand.name] = name, {finger: self._distance(finger, link) for finger in presses}
                self._set_collisions(link, not self.ghosts)
                return

    def _distance(self, finger: str, link: Link) -> float:
        own = self.model.GetLink(finger)
        return own.WorldPose().Pos().Distance(link.WorldPose().Pos()) if own is not None else 0.0

    def _release_if_open(self, hand: Hand) -> None:
        name, distances = self.held[hand.name]
        model = self.world.ModelByName(name.partition("::")[0])
        link = model.GetLink(name.partition("::")[2]) if model is not None else None
        if link is not None and all(
            self._distance(finger, link) - before <= self.tolerance for finger, before in distances.items()
        ):
            return
        self.model.RemoveJoint(self._joint(hand))
        del self.held[hand.name]
        self.counts.clear()
        if link is not None:
            self._set_collisions(link, True)

    def _set_collisions(self, link: Link, collide: bool) -> None:
        if self.ghosts:
            link.SetCollideMode("all" if collide else "none")


GZ_REGISTER_MODEL_PLUGIN(GazeboGraspFix)
