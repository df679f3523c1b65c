"""factory: adding models to a running world."""

from __future__ import annotations

from xml.sax.saxutils import escape

import numpy as np

from libgz.errors import ParameterError
from libgz.transport.interface import Interface, View
from libgz.transport.layout import CLIENT, SERVER, Array, Data, byte, double, layout
from libgz.transport.legacy import LegacyFunctions

__all__ = [
    "GAZEBO_FACTORY_MAX_STRING",
    "Factory",
    "FactoryData",
    "gz_factory_alloc",
    "gz_factory_close",
    "gz_factory_create",
    "gz_factory_destroy",
    "gz_factory_free",
    "gz_factory_lock",
    "gz_factory_open",
    "gz_factory_unlock",
]


GAZEBO_FACTORY_MAX_STRING = 4096


@layout
class FactoryData(Data):
    """gz_factory_data_t."""

    time: float = double(SERVER, "s", "sim time of the last look at the string")
    string: Array[int] = byte(
        CLIENT, "", "XML of one model, ended by a zero; the server empties it", GAZEBO_FACTORY_MAX_STRING
    )


class Factory(Interface[FactoryData]):
    """A letter-box for models."""

    type = "factory"
    data_class = FactoryData
    has_post = False

    string = View("string")

    def create_model(self, xml: str) -> None:
        """Ask the server to add a model: its one XML element, as in a worldfile, without a root around it.

        The server warns, on its own console, of a text it cannot use. It empties the string when it has taken it:
        see `busy`.

        Raises:
            ParameterError: the text does not fit.
        """
        self._send(xml)

    def delete_model(self, id: str) -> None:
        """Ask the server to remove a model, by its id, and all that is attached to it.

        Raises:
            ParameterError: the id does not fit.
        """
        self._send(f"<delete>{escape(id)}</delete>")

    @property
    def busy(self) -> bool:
        """Whether the last text still waits for the server."""
        return bool(self.string[0])

    def _send(self, xml: str) -> None:
        text = xml.encode()
        if len(text) >= GAZEBO_FACTORY_MAX_STRING:
            raise ParameterError(f"the XML has {len(text)} bytes; {GAZEBO_FACTORY_MAX_STRING - 1} are allowed")
        with self.locked():
            self.string[len(text)] = 0
            self.string[: len(text)] = np.frombuffer(text, np.uint8)


_functions = LegacyFunctions(Factory)
gz_factory_alloc = _functions.alloc
gz_factory_free = _functions.free
gz_factory_create = _functions.create
gz_factory_destroy = _functions.destroy
gz_factory_open = _functions.open
gz_factory_close = _functions.close
gz_factory_lock = _functions.lock
gz_factory_unlock = _functions.unlock
