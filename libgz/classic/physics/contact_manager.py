"""ContactManager: the contacts of the last step, and topics that publish those of some collisions."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from libgz.base.errors import NotFoundError, ParameterError, nearest
from libgz.classic import msgs
from libgz.classic.names import takes_names
from libgz.classic.physics.contact import RECORD, Contact, contact_records, read_contacts
from libgz.classic.physics.contact_messages import contacts_message
from libgz.classic.transport import Node, Publisher
from libgz.simulation.event import unowned

if TYPE_CHECKING:
    from libgz.classic.physics.world import World

__all__ = ["ContactManager"]


@takes_names
class ContactManager:
    """The contacts of the last step. They are recorded from the first request on."""

    STATE = ("_never_drop", "_requested")  # `published` changes often, and is saved beside it
    _never_drop: bool
    _requested: bool

    def __init__(self, world: World) -> None:
        self._world = world
        self._read_at = (-1, -1)  # the step and the collision pass that `_contacts` are of
        self._contacts: list[Contact] = []
        self._sorted_at = (-1, -1)  # likewise, of `_records`
        self._records: list[bytes] = []
        self._points_of: dict[int, set[int]] = {}  # the numbers of the records in which the geom of a row takes part
        self._never_drop = False
        self._requested = False
        self._holders: set[object] = set()
        self._node: Node | None = None  # of the filters
        self._filters: dict[str, tuple[Publisher, frozenset[str]]] = {}
        self.published = -1  # the step whose contacts were published last

    def SaveState(self) -> list[tuple[str, list[str]]]:
        """The filters."""
        return [(name, sorted(collisions)) for name, (_, collisions) in self._filters.items()]

    def LoadState(self, state: Iterable[tuple[str, list[str]]]) -> None:
        """Take what SaveState returned."""
        wanted, published = dict(state), self.published
        for name in [name for name in self._filters if name not in wanted]:
            self.RemoveFilter(name)
        for name, collisions in wanted.items():
            if name not in self._filters:
                self.CreateFilter(name, collisions)
        self._filters = {name: self._filters[name] for name in wanted}
        self.published = published

    def forget(self) -> None:
        """Read the contacts of the last step again: the engine has others."""
        self._read_at = self._sorted_at = (-1, -1)

    def want(self) -> None:
        """Record contacts from the next step on."""
        self._requested = True
        self._world.core.engine.record_contacts = True

    def hold(self, holder: object) -> None:
        """Record contacts until `holder` releases them."""
        self._holders.add(holder)
        self._world.core.engine.record_contacts = True

    def release(self, holder: object) -> None:
        """End the request of `holder`; contacts are recorded as long as there is another."""
        self._holders.discard(holder)
        if not (self._requested or self._holders):
            self._world.core.engine.record_contacts = False

    def SetNeverDropContacts(self, neverDrop: bool) -> None:
        """Record contacts even without a request."""
        self._never_drop = bool(neverDrop)
        if neverDrop:
            self.want()

    def NeverDropContacts(self) -> bool:
        """Whether contacts are recorded even without a request."""
        return self._never_drop

    def GetContactCount(self) -> int:
        """The number of contacts, one for each pair of collisions."""
        return len(self.GetContacts())

    def GetContact(self, index: int) -> Contact | Any:
        """A contact by index; None if there is none."""
        found = self.GetContacts()
        return found[index] if 0 <= index < len(found) else None

    def GetContacts(self) -> list[Contact]:
        """The contacts of the last step, one for each pair of collisions."""
        self.want()
        return self.read()

    def ResetCount(self) -> None:
        """Forget the contacts of the last step; those of the next one are recorded again."""
        engine = self._world.core.engine
        self._read_at, self._contacts = (engine.steps, engine.collisions), []

    def read(self) -> list[Contact]:
        """The recorded contacts of the last step; does not request recording."""
        engine = self._world.core.engine
        now = engine.steps, engine.collisions
        if self._read_at != now:
            self._read_at = now
            self._contacts = read_contacts(self._world, contact_records(self._world, engine.contacts))
        return self._contacts

    def records_of(self, rows: frozenset[int]) -> bytes:
        """The recorded points of the last step in which geoms of these rows take part, see `contact_records`."""
        engine = self._world.core.engine
        now = engine.steps, engine.collisions
        if self._sorted_at != now:
            self._sorted_at, points = now, engine.contacts
            records, size = contact_records(self._world, points).tobytes(), RECORD.itemsize
            self._records = [records[i : i + size] for i in range(0, len(records), size)]
            self._points_of = {}
            for column in ("geom1", "geom2"):
                for i, row in enumerate(points[column].tolist()):
                    self._points_of.setdefault(row, set()).add(i)
        found = sorted(set().union(*(self._points_of.get(row, ()) for row in rows)))
        return b"".join([self._records[i] for i in found])

    # Filters -----------------------------------------------------------------------------------------------------

    def CreateFilter(self, name: str, collisions: str | Iterable[str]) -> str:
        """Publish the contacts of some collisions, by scoped name, in each iteration; returns the topic's name.

        Raises:
            ParameterError: there is a filter of this name, or no collision is given.
        """
        name = name.replace("::", "/")
        wanted = [collisions] if isinstance(collisions, str) else list(collisions)
        if name in self._filters:
            raise ParameterError(f"there is a contact filter {name!r} already")
        if not wanted:
            raise ParameterError(f"contact filter {name!r} has no collisions")
        if self._node is None:
            self._node = Node()
            self._node.Init(self._world.core.topic_space)
            self.published = self._world.core.engine.steps
        prefix = f"{self._world.Name()}::"
        topic = f"~/{name}/contacts"
        with unowned():
            publisher = self._node.Advertise(msgs.Contacts, topic)
        self._filters[name] = publisher, frozenset(one.removeprefix(prefix) for one in wanted)
        return topic

    def RemoveFilter(self, name: str) -> None:
        """Remove a filter, and its topic.

        Raises:
            NotFoundError: there is no filter of this name.
        """
        name = name.replace("::", "/")
        if name not in self._filters:
            raise NotFoundError(f"there is no contact filter {name!r}{nearest(name, self._filters)}")
        publisher, _ = self._filters.pop(name)
        publisher.Fini()
        self.release(publisher)

    def HasFilter(self, name: str) -> bool:
        """Whether there is a filter of this name."""
        return name.replace("::", "/") in self._filters

    def GetFilterCount(self) -> int:
        """The number of filters."""
        return len(self._filters)

    @property
    def filtered(self) -> bool:
        """Whether there are filters."""
        return bool(self._filters)

    def PublishContacts(self) -> None:
        """Publish the contacts of the last step on the topics that have subscribers; called in every iteration."""
        step = self._world.core.engine.steps
        if not self._filters or step == self.published:
            return
        self.published = step
        for publisher, names in self._filters.values():
            if not publisher.HasConnections():
                self.release(publisher)
                continue
            self.hold(publisher)
            found = [one for one in self.read() if not names.isdisjoint(one.names)]
            publisher.Publish(contacts_message(found, self._world.SimTime()))
