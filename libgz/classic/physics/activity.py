"""Activity: joint controllers, batteries and animations, updated in every iteration before physics."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from libgz.base.errors import ParameterError
from libgz.base.geometry import GzCoordPoseAdd, GzPose
from libgz.classic.physics.animations import Animations
from libgz.classic.physics.base import Entity
from libgz.classic.physics.collision import Collision
from libgz.classic.physics.joint import Joint
from libgz.classic.physics.link import Link
from libgz.classic.physics.model import Model
from libgz.classic.physics.place import found_at, place_if_there, place_of
from libgz.sdf.element import Element
from libgz.simulation.event import Event
from libgz.simulation.state import get_state, set_state

if TYPE_CHECKING:
    from libgz.classic.common import Battery
    from libgz.classic.physics.joint_controller import JointController
    from libgz.classic.physics.world import World
    from libgz.simulation.plan import Plan

__all__ = ["Activity"]

log = logging.getLogger("libgz.classic")


class Activity:
    """Joint controllers, batteries, animations and attached models of a world.

    Attributes:
        animations: the running animations.
        joint_update: the event of Joint.ConnectJointUpdate.
        edited: links and collisions with values of their own that the engine does not have.
        waiting: what is called before the joint controllers of the next iteration; any thread may append.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self.animations = Animations(world)
        self.joint_update = Event("JointUpdate")
        self._controllers: dict[Model, JointController] = {}
        self._batteries: dict[Link, list[Battery]] = {}
        self._all_batteries: list[Battery] | None = None  # None after models were added or removed
        self._attached: list[tuple[Model, Model, GzPose]] = []
        self.edited: dict[Link | Collision, None] = {}
        self.waiting: deque[Callable[[], None]] = deque()

    # Controllers -------------------------------------------------------------------------------------------------

    def controller_of(self, model: Model) -> JointController:
        """The joint controller of a model, created on first use; one of a removed model has no effect."""
        found = self._controllers.get(model)
        if found is None:
            from libgz.classic.physics.joint_controller import JointController

            found = JointController(model)
            if model.core in self._world.core.models:
                known = {**self._controllers, model: found}
                self._controllers = {one: known[one] for one in self._world.all_models() if one in known}
                self._world.core.update_rows_changed()
        return found

    def refresh_controllers(self) -> None:
        """Match the controllers with joints that were built again; those that no state has become as new."""
        for controller in self._controllers.values():
            if controller.blank:
                controller.LoadState(None)
            else:
                controller.match()

    def joint_added(self, joint: Joint) -> None:
        """Add a joint to the controllers of its model and of the models around that."""
        for controller in self._controllers_of(joint):
            controller.AddJoint(joint)

    def joint_removed(self, joint: Joint) -> None:
        """Remove a joint from the controllers that have it."""
        for controller in self._controllers_of(joint):
            controller.RemoveJoint(joint)

    def renamed(self) -> None:
        """A view was renamed."""
        for controller in self._controllers.values():
            controller.renamed()

    def _controllers_of(self, joint: Joint) -> Iterator[JointController]:
        part = joint.model_around()
        while isinstance(part, Model):
            if part in self._controllers:
                yield self._controllers[part]
            part = part.GetParent()

    # Batteries ---------------------------------------------------------------------------------------------------

    def batteries_of(self, link: Link) -> list[Battery]:
        """The batteries of a link, in the order of the file."""
        if link not in self._batteries:
            sdf = link.GetSDF()
            elements = sdf.named("battery") if sdf is not None else ()
            self._batteries[link] = [_battery_of(element) for element in elements]
        return self._batteries[link]

    # Attached models ---------------------------------------------------------------------------------------------

    def attach(self, parent: Model, model: Model, offset: GzPose) -> None:
        """Move a model with another, at an offset [m].

        Raises:
            ClosedError: one of them was removed.
            ParameterError: a model is to move with itself, or with what moves with it.
        """
        for one in (parent, model):
            one.pose()  # raises if it was removed
        leaders = {parent}
        while more := {leader for leader, led, _ in self._attached if led in leaders} - leaders:
            leaders |= more
        if model in leaders:
            raise ParameterError(f"model {model.GetName()!r} cannot move with {parent.GetName()!r}, which follows it")
        model.SetEnabled(False)
        self._attached.append((parent, model, offset))

    def detach(self, parent: Model, name: str) -> None:
        """Undo `attach` for a model by name."""
        self._attached = [
            row
            for row in self._attached
            if not (row[0] is parent and name in (row[1].GetName(), row[1].GetScopedName()))
        ]

    # State -------------------------------------------------------------------------------------------------------

    def save(self) -> tuple[Any, ...]:
        """Its state as plain data."""
        if not (self._controllers or self._batteries_of_all() or self._attached or self.edited):
            return [], [], self.animations.save(), [], []
        return (
            [(place_of(model), one.SaveState()) for model, one in self._controllers.items() if not one.blank],
            [get_state(battery) for battery in self._batteries_of_all()],
            self.animations.save(),
            [(place_of(parent), place_of(model), offset) for parent, model, offset in self._attached],
            [(place, get_state(view)) for view in self.edited if (place := place_if_there(view)) is not None],
        )

    def load(self, state: Sequence[Any]) -> None:
        """Take what `save` returned."""
        world = self._world
        controllers, batteries, animations, attached, edited = state
        kept = {found_at(world, place): one for place, one in controllers}
        for model in kept:
            self.controller_of(model)
        for model, controller in self._controllers.items():
            controller.LoadState(kept.get(model))
        for battery, one in zip(self._batteries_of_all(), batteries, strict=False):
            set_state(battery, one)
        self.animations.load(animations)
        self._attached = [(found_at(world, a), found_at(world, b), offset) for a, b, offset in attached]
        pristine, self.edited = self.edited, {}
        for place, one in edited:
            view = found_at(world, place)
            pristine.pop(view, None)
            set_state(view, one)
            self.edited[view] = None
        for view in pristine:
            view.forget_edits()

    # Changes and updates -----------------------------------------------------------------------------------------

    def models_changed(self) -> None:
        """Models were added or removed."""
        self._all_batteries = None

    def forget(self, model: Model) -> None:
        """Drop all that belongs to a model that is being removed."""
        if self._controllers.pop(model, None) is not None:
            self._world.core.update_rows_changed()
        for part in model.tree():
            if isinstance(part, Entity):
                self.animations.stop(part)
            if isinstance(part, Link):
                self._batteries.pop(part, None)
            if isinstance(part, Link | Collision):
                self.edited.pop(part, None)
        self._attached = [row for row in self._attached if model not in row[:2]]

    def reset_model(self, model: Model) -> None:
        """Reset batteries and controller of a model."""
        for link in model.GetLinks():
            for battery in self.batteries_of(link):
                battery.ResetVoltage()
        if model in self._controllers:
            self._controllers[model].Reset()

    @property
    def idle(self) -> bool:
        """Whether `prepare` and `update` have nothing to do."""
        return not (
            self.waiting or self._attached or self.joint_update or self.animations.running or self._batteries_of_all()
        )

    def plan(self, plan: Plan) -> None:
        """Add the joint controllers."""
        for controller in self._controllers.values():
            plan.call(controller.Update)

    def prepare(self) -> None:
        """Call what waits, ahead of the joint controllers."""
        for _ in range(len(self.waiting)):
            self.waiting.popleft()()

    def update(self) -> None:
        """Act for one iteration, after the joint controllers and before physics."""
        for battery in self._batteries_of_all():
            battery.Update()
        if self.joint_update:
            self.joint_update()
        self.animations.update()
        for row in list(self._attached):
            parent, model, offset = row
            try:
                model.move(GzCoordPoseAdd(offset, parent.pose()))
            except ParameterError as error:  # the parent is farther away than a model may be placed
                self._attached.remove(row)
                log.error("model %s is not attached to %s any more: %s", model.GetName(), parent.GetName(), error)

    def _batteries_of_all(self) -> list[Battery]:
        if self._all_batteries is None:
            models = self._world.all_models()
            self._all_batteries = [b for model in models for link in model.GetLinks() for b in self.batteries_of(link)]
        return self._all_batteries


def _battery_of(element: Element) -> Battery:
    """The battery of an element; one without voltage where that is invalid, as in Gazebo."""
    from libgz.classic.common.battery import Battery  # few links have one

    name = element.Get(str, "name")
    try:
        return Battery(name, element.Get(float, "voltage"))
    except ParameterError as error:
        log.error("%s: <battery>: %s; battery %r has 0 V", element.where, error, name)
        return Battery(name, 0.0)
