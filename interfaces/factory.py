"""factory: adding models to a running world."""

from __future__ import annotations

import numpy as np

from libgz.base.errors import ParameterError
from libgz.base.files import xml_text
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

    time: float = double(SERVER, "s", "sim time at which the server last read the string")
    string: Array[int] = byte(
        CLIENT, "", "XML of one model, with a zero at the end; the server clears it", GAZEBO_FACTORY_MAX_STRING
    )


class Factory(Interface[FactoryData]):
    """A queue of one request to add or remove a model."""

    type = "factory"
    data_class = FactoryData
    has_post = False

    string = View("string")

    def create_model(self, xml: str) -> None:
        """Request a new model.

        The server clears the string when it has read it: see `busy`. It logs a warning about XML that it cannot use.

        Args:
            xml: one element of a model, as in a worldfile, without a root element.

        Raises:
            ParameterError: the XML has more than 4095 bytes.
        """
        self._send(xml)

    def delete_model(self, id: str) -> None:
        """Request the removal of the model of this id, and of the models that are attached to it.

        Raises:
            ParameterError: the id is too long.
        """
        self._send(f"<delete>{xml_text(id)}</delete>")

    @property
    def busy(self) -> bool:
        """Whether the server has not yet read the last request."""
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
