"""factory: adding models to a running world."""

from __future__ import annotations

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

        Raises:
            ParameterError: the text does not fit.
        """
        text = xml.encode()
        if len(text) >= GAZEBO_FACTORY_MAX_STRING:
            raise ParameterError(f"the model's XML has {len(text)} bytes; {GAZEBO_FACTORY_MAX_STRING - 1} are allowed")
        with self.locked():
            self.string[: len(text)] = list(text)
            self.string[len(text)] = 0


_functions = LegacyFunctions(Factory)
gz_factory_alloc = _functions.alloc
gz_factory_free = _functions.free
gz_factory_create = _functions.create
gz_factory_destroy = _functions.destroy
gz_factory_open = _functions.open
gz_factory_close = _functions.close
gz_factory_lock = _functions.lock
gz_factory_unlock = _functions.unlock
