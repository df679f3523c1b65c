"""Factory: a letter-box through which clients add models to the running world, and remove them."""

from __future__ import annotations

import logging
import re
from xml.sax.saxutils import unescape

from libgz.errors import GazeboError
from libgz.interfaces.factory import Factory as FactoryInterface
from libgz.legacy.model import Model
from libgz.legacy.world import LegacyWorld
from libgz.physics.body import Body
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

log = logging.getLogger("libgz.models")

# What clients of libgz write to have a model removed; Gazebo 0.7 had no word for it.
DELETE = re.compile(r"\s*<delete>([^<]*)</delete>\s*")


class Factory(Model):
    """Takes the XML of one model from its interface; the model takes part from the next step but one.

    A text is taken once it has been the same for two steps, for old clients write it without the lock. Then the string
    is emptied. What cannot be used is a warning, and nothing of it stays in the world.
    """

    interfaces = ("factory",)

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        self.AddBody(Body(self.world, dummy=True), True)

    def Init(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        self.box = FactoryInterface()
        self.box.create(self.world.gz_server, self.GetId(), self.GetName(), self.GetIntId(), self.GetParentIntId())
        self._letter = self.box.string
        self._seen = b""

    def Fini(self) -> None:  # noqa: D102
        self.box.destroy()

    def Update(self, step: float) -> None:  # noqa: D102
        if not self.box.lock():  # without it, a file that a client cut short would not be mended before it is read
            return
        if not self._letter[0]:
            self.box.unlock()
            return
        content = self._letter.tobytes()
        taken = content == self._seen
        if taken:
            self._letter[:] = 0
        self._seen = b"" if taken else content
        self.box.data.time = self.world.GetSimTime()
        self.box.unlock()
        if taken:
            self.world.after_step(lambda: self.obey(content))

    def obey(self, content: bytes) -> None:
        """Do what a letter asks for, or warn."""
        letter, end, _ = content.partition(b"\0")
        text = letter.decode(errors="replace")
        try:
            if not end:
                raise GazeboError(f"the text has no end within {len(content)} bytes")
            deletion = DELETE.fullmatch(text)
            if deletion:
                self.world.DeleteModel(unescape(deletion[1]).strip())
            else:
                for model in self.world.extension(LegacyWorld).insert(text, f"factory.{self.GetId()}"):
                    log.info("factory %r added %r", self.GetId(), model)
        except GazeboError as error:
            log.warning("factory %r: a client's request was not carried out: %s", self.GetId(), error)
