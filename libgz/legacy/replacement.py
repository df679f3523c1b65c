"""Replacement: a model in the place of another one in a running world, because its class or element was edited."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable
from typing import Any

from libgz.base.errors import USER_ERRORS, GazeboError, PluginError, pass_interrupt
from libgz.legacy.loader import ModelLoader
from libgz.legacy.model import Model
from libgz.legacy.world_joints import move_with_world_joints
from libgz.physics.body import Body
from libgz.simulation.motion import Motion, Placed
from libgz.simulation.plugins import own_place, own_traceback
from libgz.simulation.state import carry_state, decode, encode, get_state

__all__ = ["Replacement"]


class Replacement:
    """Builds a model again from its element, and puts it in the place of the one that runs.

    It has the poses and velocities of the former bodies of the same names; the declared state; its place in the order
    of the world; and the models that were attached. New interfaces have the memory of former ones of their names, so
    that clients stay connected.

    Args:
        loader: of the world.
        old: the model that runs.
        anew: whether the new one has a state of its own, as after an edit of its element, of which that may depend.
    """

    def __init__(self, loader: ModelLoader, old: Model, *, anew: bool = False) -> None:
        self._loader, self._world, self._old, self._anew = loader, loader.world, old, anew

    def run(self) -> Model:
        """Replace the model; the new one.

        Raises:
            PluginError: the new one fails; the former one runs on.
        """
        old, world, doing = self._old, self._world, "Load"
        interfaces = [one for one in world.gz_server.interfaces.values() if one.model_id == old.GetIntId()]
        holders = [(child, child.parentBody) for child in old.children]
        try:
            state = decode(encode(get_state(old)))
            new = self._loader.load_again(old)
            with world.gz_server.hand_over(interfaces):
                try:
                    self._place(new)
                    doing = "Init"
                    new._entity_start()
                    doing = "the return of its state"
                    if not self._anew:
                        self._carry(new, state)
                    doing = "the attachment of other models"
                    for child, body in holders:
                        kept = child.relPose
                        child._entity_attach(new, new.GetBody(body.bodyName if body is not None else None))
                        child.relPose = kept  # where one without a weld follows
                except BaseException:
                    self._undo(new, holders)
                    raise
                self._exchange(new)
        except GazeboError as error:
            reason = f"{doing} of the edited model {old.GetId()!r}: {error}{own_place(error)}"
            raise PluginError(f"{old._entity_place()}{reason}") from error
        except USER_ERRORS as error:
            pass_interrupt(error)
            text = f"{doing} of the edited model {old.GetId()!r} failed with\n{own_traceback(error)}"
            raise PluginError(f"{old._entity_place()}{text}") from error
        return new

    def _place(self, new: Model) -> None:
        """Place and move the new bodies as the former ones."""
        old = self._old
        pose = old.GetPose() if old.parentBody is None else old.relPose
        move_with_world_joints(new, lambda: self._world.SetModelPose(new, pose))
        if self._anew:
            new.initPose = old.initPose
        motion = Motion(self._placed(old))
        if motion.begun(old.GetPose()):
            motion.carry(self._placed(new))

    def _placed(self, model: Model) -> dict[Hashable, Placed]:
        """The bodies of a model by name, and by how many before them have the same one."""
        found: dict[Hashable, Placed] = {}
        counts: Counter[str | None] = Counter()
        for body, place in zip(model.bodies, self._loader.places.get(model, []), strict=False):
            found[body.bodyName, counts[body.bodyName]] = Placed(body, place)
            counts[body.bodyName] += 1
        return found

    @staticmethod
    def _carry(new: Model, state: Any) -> None:
        number, initialized = new.GetIntId(), new.initialized
        carry_state(new, state)
        new._number, new.initialized = number, initialized

    def _undo(self, new: Model, holders: list[tuple[Any, Body | None]]) -> None:
        """Let the former model continue."""
        for child, body in holders:
            if child.parent is not self._old:
                kept = child.relPose
                child._entity_attach(self._old, body)
                child.relPose = kept
        self._world.remove([new])

    def _exchange(self, new: Model) -> None:
        """Remove the former model, and give the new one its place."""
        world, old = self._world, self._old
        for kept in (world.entities, world.models):
            kept.remove(new)
            kept[kept.index(old)] = new
            kept.append(old)
        world.remove([old])
