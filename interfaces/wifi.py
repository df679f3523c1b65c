"""wifi: the wireless links of a robot."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from libgz.interfaces.sample import SampleData, SampleInterface
from libgz.interfaces.views import filled
from libgz.transport.interface import View
from libgz.transport.layout import SERVER, Array, Element, char, double, elements, layout, uint16
from libgz.transport.legacy import LegacyFunctions

__all__ = [
    "GAZEBO_WIFI_MAX_LINKS",
    "GAZEBO_WIFI_QUAL_DBM",
    "Wifi",
    "WifiData",
    "WifiLink",
    "gz_wifi_alloc",
    "gz_wifi_close",
    "gz_wifi_create",
    "gz_wifi_destroy",
    "gz_wifi_free",
    "gz_wifi_lock",
    "gz_wifi_open",
    "gz_wifi_unlock",
]


GAZEBO_WIFI_MAX_LINKS = 16
GAZEBO_WIFI_QUAL_DBM = 1


@layout
class WifiLink(Element):
    """gz_wifi_link_t: one link."""

    ip: bytes = char(SERVER, "", "address of the remote robot, as dotted text", 32)
    qual: int = uint16(SERVER, "", "GAZEBO_WIFI_QUAL_DBM")
    level: int = uint16(SERVER, "dBm", "signal level, as the low 16 bits of a signed number")
    noise: int = uint16(SERVER, "dBm", "noise level, as the low 16 bits of a signed number")


@layout
class WifiData(SampleData):
    """gz_wifi_data_t."""

    time: float = double(SERVER, "s", "sim time of this sample")
    links: Array[WifiLink] = elements(WifiLink, SERVER, "the links", GAZEBO_WIFI_MAX_LINKS)
    link_count: int = uint16(SERVER, "", "number of links, at most 16")


class Wifi(SampleInterface[WifiData]):
    """A robot's wireless links."""

    type = "wifi"
    data_class = WifiData
    has_post = False

    all_links = View("links")

    @property
    def links(self) -> NDArray[np.void]:
        """The links: records of the fields of `WifiLink`, shape (link_count,); a view of the shared memory."""
        return filled(self.all_links, self.data.link_count)


_functions = LegacyFunctions(Wifi)
gz_wifi_alloc = _functions.alloc
gz_wifi_free = _functions.free
gz_wifi_create = _functions.create
gz_wifi_destroy = _functions.destroy
gz_wifi_open = _functions.open
gz_wifi_close = _functions.close
gz_wifi_lock = _functions.lock
gz_wifi_unlock = _functions.unlock
