"""Charts of what interfaces hold now, for notebooks; by matplotlib, the extra [plot]."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np

from libgz.base.errors import LibraryError, ParameterError
from libgz.base.extras import install
from libgz.transport.interface import Interface
from libgz.transport.layout import CLIENT, fields_of

__all__ = ["figure_of"]


def figure_of(interfaces: list[Interface[Any]]) -> Any:
    """A matplotlib figure of the present data: scans from above, images, and all other numbers as bars.

    Raises:
        LibraryError: matplotlib is not installed.
        ParameterError: there is nothing to plot.
    """
    if not interfaces:
        raise ParameterError("there is nothing to plot: name a model or an interface that serves data")
    try:
        module = importlib.import_module("matplotlib.figure")
    except ImportError:
        raise LibraryError(f"plots need matplotlib, which is not installed: {install('plot')}") from None
    columns = min(len(interfaces), 3)
    rows = -(-len(interfaces) // columns)
    figure = module.Figure(figsize=(5.0 * columns, 4.0 * rows), layout="constrained")
    for number, interface in enumerate(interfaces, 1):
        axes = figure.add_subplot(rows, columns, number)
        axes.set_title(f"{interface.type}.{interface.id}")
        _plot(axes, interface)
    return figure


def _plot(axes: Any, interface: Any) -> None:
    if interface.type == "laser":
        angles, ranges = interface.angles, interface.ranges
        axes.fill(np.append(ranges * np.cos(angles), 0.0), np.append(ranges * np.sin(angles), 0.0), alpha=0.3)
        axes.plot(ranges * np.cos(angles), ranges * np.sin(angles), ".", markersize=2)
        axes.plot(0.0, 0.0, "k>")
        axes.set(xlabel="x, ahead [m]", ylabel="y, left [m]", aspect="equal")
        axes.grid(alpha=0.3)
    elif interface.type in ("camera", "guicam", "stereo"):
        image = interface.left_image if interface.type == "stereo" else interface.image
        if image.size:
            axes.imshow(image)
        axes.set_axis_off()
    else:
        _bars(axes, interface)


def _bars(axes: Any, interface: Any) -> None:
    """All numbers but commands."""
    names, values = [], []
    for name, field in fields_of(interface.layout).items():
        if field.writer == CLIENT:
            continue
        if not field.shape and name != "time" and hasattr(field.ctype, "_type_") and field.unit != "byte":
            names.append(f"{name} [{field.unit}]" if field.unit else name)
            values.append(float(getattr(interface.data, name)))
        elif len(field.shape) == 1 and field.shape[0] <= 48 and hasattr(field.ctype, "_type_"):
            unit = f" [{field.unit}]" if field.unit else ""
            array = np.atleast_1d(interface.array(name))
            count = {"sonar_ranges": "sonar_count", "ir_ranges": "ir_count", "levels": None}.get(name, "")
            shown = array[: getattr(interface.data, count)] if count else array[:1] if count is None else array
            names += [f"{name}[{i}]{unit}" for i in range(len(shown))]
            values += [float(one) for one in shown]
    axes.barh(names[::-1], values[::-1])
    axes.grid(axis="x", alpha=0.3)
    axes.tick_params(axis="y", labelsize="small")
