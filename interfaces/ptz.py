"""ptz: a camera head that pans, tilts and zooms."""

from __future__ import annotations

from libgz.interfaces.sample import SampleData, SampleInterface
from libgz.physics.check import finite
from libgz.transport.layout import CLIENT, SERVER, double, layout
from libgz.transport.legacy import LegacyFunctions

__all__ = [
    "Ptz",
    "PtzData",
    "gz_ptz_alloc",
    "gz_ptz_close",
    "gz_ptz_create",
    "gz_ptz_destroy",
    "gz_ptz_free",
    "gz_ptz_lock",
    "gz_ptz_open",
    "gz_ptz_post",
    "gz_ptz_unlock",
]


@layout
class PtzData(SampleData):
    """gz_ptz_data_t."""

    time: float = double(SERVER, "s", "sim time of this sample")
    pan: float = double(SERVER, "rad", "measured pan, left positive")
    tilt: float = double(SERVER, "rad", "measured tilt, down positive")
    zoom: float = double(SERVER, "rad", "horizontal field of view")
    cmd_pan: float = double(CLIENT, "rad", "wanted pan")
    cmd_tilt: float = double(CLIENT, "rad", "wanted tilt")
    cmd_zoom: float = double(
        CLIENT, "rad", "wanted field of view; the server writes pi, which is no zoom, at the start"
    )


class Ptz(SampleInterface[PtzData]):
    """A pan-tilt-zoom head."""

    type = "ptz"
    data_class = PtzData

    @property
    def pan(self) -> float:
        """Measured pan [rad], left positive."""
        return self.data.pan

    @property
    def tilt(self) -> float:
        """Measured tilt [rad], down positive."""
        return self.data.tilt

    @property
    def zoom(self) -> float:
        """Horizontal field of view [rad]."""
        return self.data.zoom

    def command(self, pan: float | None = None, tilt: float | None = None, zoom: float | None = None) -> None:
        """Command the head; the commands that are None stay unchanged.

        Args:
            pan: [rad], left positive.
            tilt: [rad], down positive.
            zoom: horizontal field of view [rad].

        Raises:
            ParameterError: a command is NaN or infinite.
        """
        commands = {"cmd_pan": pan, "cmd_tilt": tilt, "cmd_zoom": zoom}
        given = {name: finite(value, f"{name} [rad]") for name, value in commands.items() if value is not None}
        with self.locked() as data:
            for name, value in given.items():
                setattr(data, name, value)


_functions = LegacyFunctions(Ptz)
gz_ptz_alloc = _functions.alloc
gz_ptz_free = _functions.free
gz_ptz_create = _functions.create
gz_ptz_destroy = _functions.destroy
gz_ptz_open = _functions.open
gz_ptz_close = _functions.close
gz_ptz_lock = _functions.lock
gz_ptz_unlock = _functions.unlock
gz_ptz_post = _functions.post
