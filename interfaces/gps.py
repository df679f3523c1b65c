"""gps: a satellite navigation receiver."""

from __future__ import annotations

from libgz.interfaces.sample import SampleData, SampleInterface
from libgz.transport.layout import SERVER, double, int32, layout
from libgz.transport.legacy import LegacyFunctions

__all__ = [
    "Gps",
    "GpsData",
    "gz_gps_alloc",
    "gz_gps_close",
    "gz_gps_create",
    "gz_gps_destroy",
    "gz_gps_free",
    "gz_gps_lock",
    "gz_gps_open",
    "gz_gps_post",
    "gz_gps_unlock",
]


@layout
class GpsData(SampleData):
    """gz_gps_data_t."""

    time: float = double(SERVER, "s", "sim time of this fix")
    utc_time: float = double(SERVER, "s", "UTC of this fix")
    latitude: float = double(SERVER, "deg", "north positive")
    longitude: float = double(SERVER, "deg", "east positive")
    altitude: float = double(SERVER, "m", "altitude")
    utm_e: float = double(SERVER, "m", "UTM easting")
    utm_n: float = double(SERVER, "m", "UTM northing")
    satellites: int = int32(SERVER, "", "satellites in view")
    quality: int = int32(SERVER, "", "0 no fix, 1 GPS, 2 differential GPS")
    hdop: float = double(SERVER, "", "horizontal dilution of precision")
    vdop: float = double(SERVER, "", "vertical dilution of precision")
    err_horz: float = double(SERVER, "m", "horizontal error")
    err_vert: float = double(SERVER, "m", "vertical error")


class Gps(SampleInterface[GpsData]):
    """A receiver's latest fix."""

    type = "gps"
    data_class = GpsData

    @property
    def latitude(self) -> float:
        """Latitude [deg], north positive."""
        return self.data.latitude

    @property
    def longitude(self) -> float:
        """Longitude [deg], east positive."""
        return self.data.longitude

    @property
    def utm(self) -> tuple[float, float, float]:
        """Easting, northing and altitude [m], read together under the lock."""
        with self.locked() as data:
            return data.utm_e, data.utm_n, data.altitude


_functions = LegacyFunctions(Gps)
gz_gps_alloc = _functions.alloc
gz_gps_free = _functions.free
gz_gps_create = _functions.create
gz_gps_destroy = _functions.destroy
gz_gps_open = _functions.open
gz_gps_close = _functions.close
gz_gps_lock = _functions.lock
gz_gps_unlock = _functions.unlock
gz_gps_post = _functions.post
