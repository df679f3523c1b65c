"""JointTable: the joints of a model, or of the world itself, by their names."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any
from weakref import WeakValueDictionary

from libgz.base.errors import StateError
from libgz.sdfworld.joint import Place, SdfJoint

if TYPE_CHECKING:
    from libgz.physics.body import Body
    from libgz.sdf.element import Element
    from libgz.simulation.world import World

__all__ = ["NO_JOINTS", "JointTable"]

NO_JOINTS: tuple[int, tuple[Any, ...]] = (0, ())  # what `JointTable.save` returns where there never were any


class JointTable(dict[str, SdfJoint]):
    """Joints by name, in the order in which they act; states have them.

    Each has a number, in order of arrival. A joint that was removed returns with a state as the same object while
    somebody refers to it, such as a plugin that took it when it was loaded.

    Args:
        world: where they are.
        holder: contains the `<joint>` elements of the file.

    Attributes:
        count: how many joints have come so far.
    """

    def __init__(self, world: World, holder: Element) -> None:
        self._world, self._holder = world, holder
        self.count = 0
        self._removed: WeakValueDictionary[int, SdfJoint] = WeakValueDictionary()

    def add(self, joint: SdfJoint) -> None:
        """Add a joint under its name, which must be free."""
        self.count += 1
        self._take(joint.name, self.count, joint)
        self._changed()

    def remove(self, name: str) -> bool:
        """Destroy a joint; false if there is none of this name."""
        joint = self.release(name)
        if joint is None:
            return False
        self._removed[joint.number] = joint
        joint.close()
        return True

    def release(self, name: str) -> SdfJoint | None:
        """Take a joint out as it is; None if there is none of this name."""
        joint = self.pop(name, None)
        if joint is not None:
            joint.table = None
            self._changed()
        return joint

    def save(self) -> tuple[Any, ...]:
        """What states have of them, beside their efforts and what the engine has, as plain data."""
        return self.count, [(name, joint.number, joint.save(self._holder)) for name, joint in self.items()]

    def remove_others(self, state: Sequence[Any]) -> None:
        """Destroy the joints that a state has not."""
        wanted = {name: row for name, *row in state[1]}
        for joint in list(self.values()):
            if joint.name not in wanted or not joint.fits(joint.name, *wanted[joint.name]):
                self.remove(joint.name)

    def load(self, state: Sequence[Any]) -> None:
        """Take what `save` returned: joints that are missing are made again, those that came since are destroyed.

        They are in the order of the state then.

        Raises:
            StateError: a link that a joint holds is missing.
        """
        self.remove_others(state)
        self.count, kept = state
        before = dict(self)
        self.clear()
        try:
            for name, number, saved in kept:
                joint = before.get(name) or self._removed_one(name, number, saved) or self._made(name, saved)
                self._take(name, number, joint)
                joint.load(saved, self._find)
        finally:
            for name, joint in before.items():  # of a damaged state, of which only some could be taken
                self.setdefault(name, joint)
            self._changed()

    def _take(self, name: str, number: int, joint: SdfJoint) -> None:
        self[name] = joint
        joint.number, joint.table, joint.on_change = number, self, self._world.update_rows_changed

    def _changed(self) -> None:
        self._world.update_rows_changed()

    def _removed_one(self, name: str, number: int, saved: Sequence[Any]) -> SdfJoint | None:
        joint = self._removed.get(number)
        return joint if joint is not None and joint.table is None and joint.fits(name, number, saved) else None

    def _made(self, name: str, saved: Sequence[Any]) -> SdfJoint:
        element = next((one for one in self._holder.named("joint") if one.Get(str, "name") == name), None)
        return SdfJoint(self._world.engine, SdfJoint.saved_plan(name, saved, self._find, element))

    def _find(self, place: Place) -> Body | None:
        if place is None:
            return None
        owner, number = place
        bodies: list[Body] = self._world.model(owner).bodies
        if number >= len(bodies):
            raise StateError(f"a joint of this state is attached to link {number + 1} of {owner!r}, which is not there")
        return bodies[number]
