"""Channels: what pages get beside scene and states, as far as they want it: images, ranges, contacts, fields ..."""

from __future__ import annotations

import base64
import contextlib
import io
import json
import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from libgz.base.errors import ClosedError, GazeboError
from libgz.view.fields import KEY, value_of
from libgz.view.pages import Page
from libgz.view.protocol import as_float32, image_message
from libgz.view.source import Controls, Overlay

__all__ = ["Channels"]

VALUE_PERIOD = 0.05  # [s]
IMAGE_PERIOD, READING_PERIOD, CONTACT_PERIOD, CONSOLE_PERIOD, OVERLAY_PERIOD = 0.2, 0.1, 0.2, 0.5, 0.25  # [s]
CAMERAS = ("camera", "guicam", "stereo")
MOST_IMAGES, MOST_RANGES, MOST_FIELDS = 32, 200, 200  # of all pages together
QUALITY = 80  # of JPEGs

Ask = Callable[..., None]
Post = Callable[[str, str, "bytes | str"], None]


class Channels:
    """Reads what pages want, and posts it to those that want it.

    Args:
        pages: all that are open.
        ask: sends a request to the server: verb, what is called with the answer, content.
        overlays: the panels of GUI plugins, by name.
    """

    def __init__(self, pages: Any, ask: Ask, overlays: Callable[[], Mapping[str, Overlay]] | None) -> None:
        self._pages, self._ask, self._overlays = pages, ask, overlays
        self._images: dict[str, bytes | None] = {}  # raw
        self._jpegs: dict[str, bytes] = {}
        self._sensor_ranges: dict[str, list[float]] = {}
        self._messages: list[dict[str, Any]] = []
        self._seen = 0  # of the server's problems
        self._shown = ""  # of the overlays
        self._encoded: dict[int, tuple[Any, str]] = {}
        self._next: dict[str, float] = {}
        self.pending: set[str] = set()

    def clear(self) -> None:
        """Forget what belongs to another run."""
        self._images, self._jpegs, self._messages, self._seen = {}, {}, [], 0

    def wanted(self, channel: str) -> set[str]:
        """The names that pages want of a channel."""
        return {name for page in self._pages for name in page.wants.get(channel, ())}

    def welcome(self, page: Page, channel: str) -> None:
        """Send a page what a channel has already."""
        if channel == "console" and self._messages:
            page.post("messages", json.dumps({"messages": self._messages}))
        elif channel == "overlays" and self._shown:
            page.post("overlays", self._shown)
        elif channel == "images":
            for name in page.wants.get(channel, ()):
                if name in self._jpegs:
                    page.post(f"image {name}", image_message(name, self._jpegs[name]))

    def _post(self, channel: str, key: str, message: bytes | str, name: str = "") -> None:
        for page in self._pages:
            wants = page.wants.get(channel, ())
            if wants and page.visible and (not name or name in wants):
                page.post(key, message)

    def show(
        self, now: float, time: float, controls: Controls | None, can: frozenset[str], scene: dict[str, Any]
    ) -> None:
        """Post what is due.

        Args:
            now: real time [s].
            time: sim time [s].
            controls: of the server.
            can: its abilities.
            scene: of the present state.
        """
        if self._overlays is not None and self._is_due("overlays", OVERLAY_PERIOD, now):
            self._show_overlays(self._overlays())
        if controls is None:
            return
        if names := self.wanted("fields"):
            self._show_fields(sorted(names)[:MOST_FIELDS], time, controls)
            if "values" in can and self._is_due("values", VALUE_PERIOD, now):
                probes = sorted(name for name in self._wanted_by_trusted("fields") if name.startswith("["))
                if probes:
                    self._ask("values", self._learn_values, names=probes[:MOST_FIELDS])
        images, ranges = self.wanted("images"), self.wanted("ranges")
        if images and self._is_due("images", IMAGE_PERIOD, now):
            self._show_images(sorted(images)[:MOST_IMAGES], controls, scene)
        if ranges and self._is_due("ranges", READING_PERIOD, now):
            self._show_ranges(sorted(ranges)[:MOST_RANGES], controls)
        sensors = sorted(name for name in {*images, *ranges} if "::" in name)
        if sensors and "readings" in can and self._is_due("readings", IMAGE_PERIOD, now):
            self._ask("readings", self._learn_readings, names=sensors[: MOST_IMAGES + MOST_RANGES])
        if self.wanted("contacts") and "contacts" in can and self._is_due("contacts", CONTACT_PERIOD, now):
            self._ask("contacts", self._learn_contacts)
        if self.wanted("console") and "problems" in can and self._is_due("console", CONSOLE_PERIOD, now):
            self._ask("problems", self._learn_problems, since=self._seen)

    def _wanted_by_trusted(self, channel: str) -> set[str]:
        """The names that pages want of a channel whose address has the token."""
        return {name for page in self._pages if page.may_control for name in page.wants.get(channel, ())}

    def _learn_values(self, answer: Any) -> None:
        """Numbers of topics and plugins."""
        series = {key: [answer["time"], value] for key, value in answer["values"].items()}
        if series:
            self._post("fields", "values", json.dumps({"series": series}))

    def _learn_contacts(self, answer: Any) -> None:
        self._post("contacts", "contacts", json.dumps({"contacts": answer or []}))

    def _is_due(self, name: str, period: float, now: float) -> bool:
        if name in self.pending or now < self._next.get(name, 0.0):
            return False
        self._next[name] = now + period
        return True

    # Images ----------------------------------------------------------------------------------------------------------

    def _show_images(self, names: list[str], controls: Controls, scene: dict[str, Any]) -> None:
        served = {
            one["id"]: one["type"]
            for entity in scene["entities"]
            for one in entity["interfaces"]
            if one["type"] in CAMERAS
        }
        for name in names:
            if name not in served:
                continue
            with contextlib.suppress(GazeboError, ClosedError):
                interface = controls.interface(served[name], name)
                image = np.array(interface.left_image if served[name] == "stereo" else interface.image)
                raw = image.tobytes()
                if image.size and raw != self._images.get(name):
                    self._images[name] = raw
                    self._show_image(name, jpeg_of(image))

    def _show_image(self, name: str, jpeg: bytes) -> None:
        self._jpegs[name] = jpeg
        self._post("images", f"image {name}", image_message(name, jpeg), name)

    def _learn_readings(self, answer: Any) -> None:
        """Last images and ranges of sensors of SDF worlds."""
        for name, text in answer["images"].items():
            jpeg = base64.b64decode(text)
            if jpeg != self._jpegs.get(name):
                self._show_image(name, jpeg)
        ranges = answer["ranges"]
        if ranges:
            self._sensor_ranges = {name: as_float32(values) for name, values in ranges.items()}

    # Ranges ----------------------------------------------------------------------------------------------------------

    def _show_ranges(self, names: list[str], controls: Controls) -> None:
        ranges, rings = dict(self._sensor_ranges), {}
        for name in names:
            kind, _, owner = name.partition(".")
            if kind not in ("laser", "sonar", "ir"):
                continue
            with contextlib.suppress(GazeboError, ClosedError):
                interface = controls.interface(kind, owner)
                if kind == "laser":
                    ranges[name] = as_float32(interface.ranges)
                elif interface.count:
                    found = interface.positions, interface.directions, interface.ranges
                    places, turns, reach = (np.asarray(one, dtype=float) for one in found)
                    if np.isfinite(places).all() and np.isfinite(turns).all():
                        rings[name] = {
                            "positions": places.tolist(),
                            "directions": turns.tolist(),
                            "ranges": as_float32(reach),
                        }
        self._post("ranges", "ranges", json.dumps({"ranges": ranges, "rings": rings}))

    # Fields ----------------------------------------------------------------------------------------------------------

    def _show_fields(self, keys: list[str], time: float, controls: Controls) -> None:
        opened: dict[tuple[str, str], Any] = {}
        series = {}
        for key in keys:
            found = KEY.fullmatch(key)
            if found is None:
                continue
            owner = found["type"], found["id"]
            with contextlib.suppress(GazeboError, ClosedError):
                if owner not in opened:
                    opened[owner] = None
                    opened[owner] = controls.interface(*owner)
                interface = opened[owner]
                if interface is not None:
                    value = value_of(interface, found["path"])
                    if value is not None:
                        series[key] = [time, value]
        if series:
            self._post("fields", "series", json.dumps({"series": series}))

    # Messages and overlays -------------------------------------------------------------------------------------------

    def _learn_problems(self, answer: Any) -> None:
        """New warnings and errors of the world, its models and plugins."""
        messages = answer["problems"]
        self._seen = answer["count"]
        if messages:
            self._messages = [*self._messages, *messages][-1000:]
            self._post("console", f"messages {self._seen}", json.dumps({"messages": messages}))

    def _show_overlays(self, overlays: Mapping[str, Overlay]) -> None:
        shown = []
        encoded: dict[int, tuple[Any, str]] = {}
        for name, overlay in overlays.items():
            if overlay.visible:
                images = {label: self._address(image, encoded) for label, image in dict(overlay.images).items()}
                plots = {
                    label: {"x": _plain(x), "lines": {one: _plain(values) for one, values in lines.items()}}
                    for label, (x, lines) in dict(overlay.plots).items()
                }
                buttons = overlay.Buttons()
                shown.append({"name": name, "text": overlay.text, "buttons": buttons, "images": images, "plots": plots})
        self._encoded = encoded
        text = json.dumps({"overlays": shown})
        if text != self._shown:
            self._shown = text
            self._post("overlays", "overlays", text)

    def _address(self, image: NDArray[np.uint8], encoded: dict[int, tuple[Any, str]]) -> str:
        """An image as a data URL; the same object stands for the same image."""
        former = self._encoded.get(id(image))
        if former is None or former[0] is not image:
            former = image, f"data:image/jpeg;base64,{base64.b64encode(jpeg_of(image)).decode()}"
        encoded[id(image)] = former
        return former[1]


def _plain(values: Any) -> list[float | None]:
    return [float(value) if math.isfinite(value) else None for value in np.asarray(values, dtype=float)]


def jpeg_of(image: NDArray[Any]) -> bytes:
    """An image, shape (height, width, 3) or (height, width), as JPEG."""
    file = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(image, dtype=np.uint8)).convert("RGB").save(file, "jpeg", quality=QUALITY)
    return file.getvalue()
