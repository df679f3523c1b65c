"""Panel: the page's buttons, sliders and texts. It holds no state of the world; what users do is passed on."""

from __future__ import annotations

import functools
import html
import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Protocol

import numpy as np
import viser
from numpy.typing import NDArray

from libgz.view.log_slider import LogSlider
from libgz.view.marks import SWITCHES
from libgz.view.parts import Part

__all__ = ["Overlay", "Panel"]

NONE = "(none)"
PLUGINS = 1e6  # order of their panels: below all else
LINES = ("#1c7ed6", "#e8590c", "#2f9e44", "#9c36b5", "#c92a2a", "#0b7285")  # colours of plots
CAMERA = "free camera"


class Overlay(Protocol):
    """What a GUI plugin shows: `libgz.classic.gui.GUI` is one."""

    text: str
    visible: bool
    images: dict[str, NDArray[np.uint8]]
    plots: dict[str, tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]]

    def Buttons(self) -> list[str]:
        """The labels of its buttons."""

    def Press(self, label: str) -> None:
        """Press a button."""


class Panel:
    """The page's controls.

    Args:
        page: the page's server.
        abilities: what works; other controls are left out.
        do: called with a function for each thing that a user did, to be called between two frames.
        handler: its methods are what users can do.
    """

    def __init__(
        self,
        page: viser.ViserServer,
        abilities: frozenset[str],
        do: Callable[[Callable[[], object]], None],
        handler: Any,
    ) -> None:
        self.page, self._do, self._handler, self._can = page, do, handler, abilities
        self._setting = False  # whether this program changes a control, not a user
        self._overlays: dict[str, _OverlayPanel] = {}
        self._parts: dict[str, list[Any]] = {}
        self._images: dict[str, Any] = {}
        gui = page.gui
        gui.configure_theme(control_width="small", show_logo=False, show_share_button=False)
        gui.main_panel.dock_right()  # beside the scene, which it does not cover
        self.status = gui.add_html("")
        self._run_buttons()
        self._tabs = gui.add_tab_group()
        if "interfaces" in abilities or "publish" in abilities:
            with self._tabs.add_tab("Drive"):
                self._drive_tab()
        with self._tabs.add_tab("Model"):
            self._model_tab()
        with self._tabs.add_tab("Show"):
            self._show_tab()
        if abilities & {"keep", "insert", "write"}:
            with self._tabs.add_tab("World"):
                self._world_tab()

    def _on(self, handle: Any, action: Callable[[Any], object]) -> None:
        """Call an action with the value of a control that a user changed."""

        async def changed(event: Any) -> None:
            if event.client_id is not None:
                value = event.target.value
                self._do(lambda: action(value))

        handle.on_update(changed)

    def _button(self, label: str, action: Callable[[], object], icon: Any = None, color: Any = None) -> Any:
        button = self.page.gui.add_button(label, icon=icon, color=color)

        async def clicked(_event: Any) -> None:
            self._do(action)

        button.on_click(clicked)
        return button

    def _run_buttons(self) -> None:
        gui, can, handler = self.page.gui, self._can, self._handler
        labels = [
            label
            for label, verb in (("Pause", "pause"), ("Run", "pause"), ("Step", "step"), ("Reset", "reset"))
            if verb in can
        ]
        if labels:
            group = gui.add_button_group("Time", labels)

            async def clicked(event: Any) -> None:
                label = str(event.target.value).lower()
                self._do(lambda: handler.press(label))

            group.on_click(clicked)
        if "speed" in can:
            self.speed = gui.add_slider("Speed", min=0.1, max=5.0, step=0.1, initial_value=1.0)
            self._on(self.speed, handler.set_speed)
        if "seek" in can:
            self.log = LogSlider(self.page, self._do, handler.seek)

    def _drive_tab(self) -> None:
        gui, handler = self.page.gui, self._handler
        self.robot = gui.add_dropdown("Robot", [CAMERA])
        self._on(self.robot, lambda label: handler.choose_robot("" if label == CAMERA else label))
        self.fastest = gui.add_slider("Speed [m/s]", min=0.05, max=3.0, step=0.05, initial_value=0.4)
        self.turn = gui.add_slider("Turn [rad/s]", min=0.1, max=3.0, step=0.1, initial_value=0.8)
        self._on(self.fastest, lambda value: handler.set_drive(speed=value))
        self._on(self.turn, lambda value: handler.set_drive(turn=value))
        gui.add_html(_small("W A S D, arrow keys, or the stick; R and F: up and down"))
        self.robot_folder = gui.add_folder("Joints and heads", expand_by_default=True, visible=False)

    def _model_tab(self) -> None:
        gui, handler, can = self.page.gui, self._handler, self._can
        self.model = gui.add_dropdown("Model", [NONE])
        self._on(self.model, lambda label: handler.select("" if label == NONE else label))
        self.follow = gui.add_checkbox("Follow", False, hint="the view moves with the model")
        self._on(self.follow, handler.set_follow)
        if "move" in can:
            self.handles = gui.add_checkbox("Handles", False, hint="move and turn the model by its handles")
            self._on(self.handles, handler.set_handles)
        self.info = gui.add_html(_small("Click a model in the scene."))
        self.model_folder = gui.add_folder("Joints and lights", expand_by_default=True, visible=False)
        if "delete" in can:
            self._button("Delete", handler.delete, viser.Icon.TRASH, "red")

    def _show_tab(self) -> None:
        self.live = self.page.gui.add_checkbox("Camera images", False)
        self._image_folder = self.page.gui.add_folder("Images", visible=False)
        for name, label in SWITCHES.items():
            if name == "contacts" and "contacts" not in self._can:
                continue
            box = self.page.gui.add_checkbox(label, False)
            self._on(box, functools.partial(self._handler.set_mark, name))
        self.shadows = self.page.gui.add_checkbox("Shadows", True, hint="faster without, where there is no GPU")
        self._on(self.shadows, lambda _on: self._handler.choose_shadows())
        for name, label in (("wireframe", "Wireframe"), ("collisions", "Collision shapes")):
            box = self.page.gui.add_checkbox(label, False)
            self._on(box, functools.partial(self._handler.set_look, name))

    def _world_tab(self) -> None:
        gui, handler, can = self.page.gui, self._handler, self._can
        if "keep" in can:
            self.keep = gui.add_checkbox("Record 60 s", False, hint="for the time line; costs some speed")
            self._on(self.keep, handler.set_keep)
            self.back = gui.add_slider("Time line [s]", min=-60.0, max=0.0, step=0.5, initial_value=0.0)
            self._button(
                "Rewind to there", lambda: handler.rewind(-float(self.back.value)), viser.Icon.PLAYER_TRACK_PREV
            )
        if "insert" in can:
            self.catalogue = gui.add_dropdown("Insert", [NONE])
            self._button("Insert", self._insert, viser.Icon.PLUS)
        if "write" in can:
            self._button("Save the world", self._ask_to_save, viser.Icon.DEVICE_FLOPPY)

    def _ask_to_save(self) -> None:
        modal = self.page.gui.add_modal("Save the world?")

        def save() -> None:
            modal.close()
            self._handler.save()

        with modal:
            text = "Poses that changed are written to the world's file; the file as it is now is kept as NAME.bak."
            self.page.gui.add_html(_small(text))
            self._button("Save", save, viser.Icon.DEVICE_FLOPPY)
            self._button("Cancel", modal.close)

    def _insert(self) -> None:
        if self.catalogue.value in self.catalogue.options[1:]:  # whatever a page sends
            self._handler.insert(self.catalogue.value)

    # What is shown ---------------------------------------------------------------------------------------------------

    def set_status(self, rows: Mapping[str, str], warning: str = "") -> None:
        """Show times and rates, or a warning."""
        cells = "".join(
            f"<span style='opacity:.6'>{html.escape(name)}</span><b style='font-variant-numeric:tabular-nums'>"
            f"{html.escape(value)}</b>"
            for name, value in rows.items()
        )
        note = f"<div style='color:#c92a2a;font-weight:600'>{html.escape(warning)}</div>" if warning else ""
        grid = "display:grid;grid-template-columns:auto 1fr auto 1fr;gap:0 8px;white-space:nowrap"
        table = f"{note}<div style='{grid}'>{cells}</div>"
        text = f"<div id='libgz-status' style='font-size:12px;padding:0 10px'>{table}</div>"
        if text != self.status.content:
            self.status.content = text

    def set_info(self, rows: Iterable[tuple[str, str]]) -> None:
        """Show what is known of the selected model."""
        lines = "".join(
            f"<tr><td style='opacity:.6;vertical-align:top;padding-right:8px;white-space:nowrap'>{html.escape(k)}</td>"
            f"<td style='font-variant-numeric:tabular-nums;overflow-wrap:anywhere'>{html.escape(v)}</td></tr>"
            for k, v in rows
        )
        text = (
            f"<div id='libgz-model' style='font-size:12px;padding:0 10px'><table>{lines}</table></div>" if lines else ""
        )
        text = text or _small("Click a model in the scene.")
        if text != self.info.content:
            self.info.content = text

    def set_options(self, name: str, options: Iterable[str], value: str = "") -> None:
        """Fill one of the lists: model, robot, catalogue."""
        handle = getattr(self, name, None)
        if handle is None:
            return
        everything = (CAMERA if name == "robot" else NONE, *options)
        if tuple(handle.options) != everything:
            handle.options = everything
        wanted = value if value in everything else everything[0]
        if handle.value != wanted:
            handle.value = wanted

    def set_overlays(self, overlays: Mapping[str, Overlay]) -> None:
        """Show the panels of GUI plugins."""
        shown = {name: overlay for name, overlay in overlays.items() if overlay.visible}
        for name in set(self._overlays) - set(shown):
            self._overlays.pop(name).folder.remove()
        for name, overlay in shown.items():
            known = self._overlays.get(name)
            if known is not None and known.buttons != overlay.Buttons():
                known.folder.remove()
                known = None
            if known is None:
                known = self._overlays[name] = _OverlayPanel(self.page.gui, name, overlay.Buttons())
                with known.folder:
                    for label in known.buttons:
                        self._button(label, functools.partial(self._handler.press_overlay, overlay, label))
            known.show(overlay)

    def set_parts(self, place: str, parts: Iterable[Part]) -> None:
        """Fill a folder, "robot" of the driven one or "model" of the selected one, with sliders and buttons."""
        for handle in self._parts.pop(place, []):
            handle.remove()
        folder = getattr(self, f"{place}_folder", None)
        if folder is None:
            return
        with folder:
            made = self._parts[place] = [self._part(part) for part in parts]
        folder.visible = bool(made)

    def _part(self, part: Part) -> Any:
        gui = self.page.gui
        if part.kind == "button":
            return self._button(part.label, functools.partial(part.action, None))
        if part.kind == "color":
            handle: Any = gui.add_rgb(part.label, part.color)
        else:
            # Few digits: the page writes the limits below the slider, side by side.
            digits = 2 if part.limits[1] - part.limits[0] > 0.5 else 4
            unit = 10.0**-digits
            least, most = (round(limit, digits) + 0.0 for limit in part.limits)
            most = max(most, least + unit)
            start = round(min(max(part.value, least), most), digits) + 0.0 if math.isfinite(part.value) else least
            step = max(round((most - least) / 200.0, digits), unit)
            handle = gui.add_slider(part.label, min=least, max=most, step=step, initial_value=start)
        self._on(handle, part.action)
        return handle

    def set_images(self, images: Mapping[str, NDArray[np.uint8]]) -> None:
        """Show the cameras' images."""
        for name, handle in self._images.items():
            if handle.visible != (name in images):
                handle.visible = name in images
        for name, image in images.items():
            if name not in self._images:
                with self._image_folder:
                    self._images[name] = self.page.gui.add_image(image, label=name, format="jpeg", jpeg_quality=80)
            elif self._images[name].image is not image:
                self._images[name].image = image
        if self._image_folder.visible != bool(images):
            self._image_folder.visible = bool(images)


class _OverlayPanel:
    """The panel of a GUI plugin."""

    def __init__(self, gui: viser.GuiApi, name: str, buttons: list[str]) -> None:
        self._gui, self.buttons = gui, buttons
        self._images: dict[str, Any] = {}
        self._plots: dict[str, Any] = {}
        self._shown: dict[str, Any] = {}  # what the handles show
        self.folder = gui.add_folder(name, order=PLUGINS)
        with self.folder:
            self._text = gui.add_html("")

    def show(self, overlay: Overlay) -> None:
        """Bring text, images and plots up to date."""
        content = _small(overlay.text) if overlay.text else ""
        if self._text.content != content:
            self._text.content = content
        images, plots = dict(overlay.images), dict(overlay.plots)
        for handles, wanted in ((self._images, images), (self._plots, plots)):
            for name in [name for name in handles if name not in wanted]:
                handles.pop(name).remove()
        for name, image in images.items():
            if name not in self._images:
                with self.folder:
                    self._images[name] = self._gui.add_image(image, label=name, format="jpeg", jpeg_quality=85)
            elif self._shown.get(name) is not image:
                self._images[name].image = image
            self._shown[name] = image
        for name, plot in plots.items():
            self._show_plot(name, *plot)

    def _show_plot(self, name: str, x: NDArray[Any], lines: dict[str, NDArray[Any]]) -> None:
        data, labels = (x, *lines.values()), list(lines)
        known = self._plots.get(name)
        if known is not None and self._shown.get(f"lines of {name}") != labels:
            known.remove()
            known = None
        if known is None:
            series = (
                viser.uplot.Series(label="x"),
                *(viser.uplot.Series(label=one, stroke=LINES[i % len(LINES)]) for i, one in enumerate(labels)),
            )
            with self.folder:
                self._plots[name] = self._gui.add_uplot(
                    data,
                    series,
                    title=name,
                    scales={"x": {"time": False, "auto": True}, "y": {"auto": True}},
                    aspect=1.4,
                )
            self._shown[f"lines of {name}"] = labels
        elif self._shown.get(f"data of {name}") is not x:
            known.data = data
        self._shown[f"data of {name}"] = x


def _small(text: str) -> str:
    return f"<div style='font-size:12px;padding:2px 10px;opacity:.75'>{html.escape(text)}</div>"
