"""Factory: lets clients add models to the running world, and remove them."""

from __future__ import annotations

import ctypes
import logging
import re
from typing import ClassVar
from xml.sax.saxutils import unescape

from libgz.base.errors import GazeboError
from libgz.interfaces.factory import GAZEBO_FACTORY_MAX_STRING, Factory as FactoryInterface
from libgz.legacy.model import Model
from libgz.legacy.world import LegacyWorld
from libgz.models.parts import add_body
from libgz.models.serving import serve
from libgz.simulation.exchange import Exchange
from libgz.simulation.plan import Plan, handler
from libgz.transport.tally import Tally
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

log = logging.getLogger("libgz.models")

MOST_REASONS = 20  # for which requests fail that are logged apart
# A request to remove a model, an addition of libgz: Gazebo 0.7 had none.
DELETE = re.compile(r"\s*<delete>([^<]*)</delete>\s*")


class Factory(Model):
    """Adds models whose XML clients write to its interface; a model is simulated from the second step after that.

    A text is read when it has not changed for two steps, because old clients write it without the lock. Then the string
    is cleared. An invalid text is reported as a warning and leaves the world unchanged.
    """

    STATE: ClassVar[tuple[str, ...]] = ("_seen",)

    active_while_paused = True
    behaviour = "adding and removing models on request"
    interfaces = ("factory",)

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        add_body(self, dummy=True)

    def Init(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        self.interface = FactoryInterface()
        serve(self, self.interface)
        self._text = ctypes.create_string_buffer(GAZEBO_FACTORY_MAX_STRING)  # of the last step; zeros: none
        self._tally = Tally(MOST_REASONS)  # of failed requests

    def Fini(self) -> None:  # noqa: D102
        self.interface.destroy()

    def plan_update(self, plan: Plan) -> None:  # noqa: D102
        plan.exchange(self.interface, None, unless=self._expect, otherwise=self._read)

    def _expect(self, exchange: Exchange) -> None:
        """The condition that there is no text, or one that has changed."""
        exchange.text("string", self._text, "time")

    @handler
    def _read(self) -> None:
        """Read a text, and obey one that has not changed."""
        if not self.interface.lock():  # locking also restores a file that a client has truncated
            return
        string = self.interface.string
        if not string[0]:
            self.interface.unlock()
            return
        content = string.tobytes()
        taken = content == self._seen
        if taken:
            string[:] = 0
        self._seen = b"" if taken else content
        self.interface.data.time = self.world.GetSimTime()
        self.interface.unlock()
        if taken and self.interface.intact():
            self.world.after_step(lambda: self.obey(content))

    @property
    def _seen(self) -> bytes:
        """The text of the last step; empty without one."""
        return self._text.raw if self._text.raw[0] else b""

    @_seen.setter
    def _seen(self, text: bytes) -> None:
        self._text.raw = text.ljust(len(self._text), b"\0")

    def obey(self, content: bytes) -> None:
        """Carry out a request, or warn."""
        request, end, _ = content.partition(b"\0")
        text = request.decode(errors="replace")
        try:
            if not end:
                raise GazeboError(f"the text has no terminating zero within {len(content)} bytes")
            if not request.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"<"):
                raise GazeboError("the text is not XML: it does not begin with '<'")
            deletion = DELETE.fullmatch(text)
            if deletion:
                self.world.DeleteModel(unescape(deletion[1]).strip())
            else:
                for model in self.world.extension(LegacyWorld).insert(text, f"factory.{self.GetId()}"):
                    log.info("factory %r added %r", self.GetId(), model)
        except GazeboError as error:
            reason = str(error)
            if self._tally.due(reason):
                times = self._tally.times(reason)
                log.warning("factory %r: a client's request failed: %s%s", self.GetId(), reason, times)
