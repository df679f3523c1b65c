"""libgz echo: print the data of an interface live, as text or JSON, or plot it."""

from __future__ import annotations

import argparse
import contextlib
import importlib
import json
import math
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from libgz.apps.target import add_target, connect, element_values, find_field, open_target, unit_of, values_of
from libgz.errors import GazeboError, LibraryError, ParameterError, ServerGoneError
from libgz.interfaces.client import Client
from libgz.transport.interface import Interface

__all__ = ["configure", "run"]

PATIENCE = 5.0  # [s] without data from the server


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    add_target(parser)
    add = parser.add_argument
    add(
        "fields",
        nargs="*",
        default=[],
        metavar="FIELD",
        help="fields to print, such as pos, pos[0] or joints[2].angle (default: all)",
    )
    add("--json", action="store_true", help="print one JSON object per line, long arrays included")
    add(
        "--rate",
        type=float,
        default=10.0,
        metavar="HZ",
        help="largest number of lines per second of real time (default 10)",
    )
    add("--count", type=int, default=None, metavar="N", help="number of samples (default: until interrupted)")
    add("--once", action="store_true", help="print the present sample only, like --count 1")
    add(
        "--seconds",
        type=float,
        default=None,
        metavar="S",
        help="duration in real time [s] (default: until interrupted)",
    )
    add(
        "--plot", metavar="FILE.png", help="plot the fields over sim time to an image file at the end; needs matplotlib"
    )
    add(
        "-c",
        dest="client_id",
        type=int,
        default=7,
        metavar="N",
        help="client id used to wait for data, 0 to 7 (default 7)",
    )


def run(options: argparse.Namespace) -> int:
    """Print or plot samples.

    Raises:
        ParameterError: a field or an option is not allowed.
        InterfaceError: the server does not serve the interface.
        LibraryError: a plot is wanted and matplotlib is not installed.
    """
    if not 0.0 < options.rate < math.inf:
        raise ParameterError(f"--rate is {options.rate:g}; it must be above zero")
    count = 1 if options.once else options.count
    if count is not None and count < 1:
        raise ParameterError(f"--count is {count}; it must be at least 1")
    if options.seconds is not None and not 0.0 <= options.seconds < math.inf:
        raise ParameterError(f"--seconds is {options.seconds:g}; it must be finite and not negative")
    if options.plot and count is None and options.seconds is None:
        raise ParameterError("--plot needs a duration: add --count or --seconds")
    pyplot = _pyplot() if options.plot else None
    with connect(options, options.client_id) as client, contextlib.suppress(KeyboardInterrupt):
        interface = open_target(client, options.target)
        places = [find_field(interface, text) for text in options.fields]
        samples = _samples(client, interface, 1.0 / options.rate, count, options.seconds)
        if pyplot is None:
            for _ in samples:
                print(_line(interface, places, options), flush=True)
        elif not places:
            raise ParameterError("--plot needs a field: add one after the interface")
        else:
            _plot(pyplot, interface, dict(zip(options.fields, places, strict=True)), samples, Path(options.plot))
    return 0


def _samples(
    client: Client, interface: Interface[Any], period: float, count: int | None, seconds: float | None
) -> Iterator[float]:
    """The time of each new sample [s], at most one per period [s]."""
    begin = time.monotonic()
    end = math.inf if seconds is None else begin + seconds
    last: float | None = None
    while count is None or count > 0:
        now = _time(interface)
        if last is None or now != last:
            last = now
            yield now
            count = None if count is None else count - 1
            if count == 0:
                return
        due = time.monotonic() + period
        while (left := min(due, end) - time.monotonic()) > 0.0:
            time.sleep(left)
        if time.monotonic() >= end:
            return
        if not client.wait(timeout=PATIENCE):
            raise GazeboError(f"the server sent no data for {PATIENCE:g} s")


def _time(interface: Interface[Any]) -> float:
    """The time of the sample [s]: sim time, plus pause time where the interface has it."""
    data = interface.data
    if hasattr(data, "time"):
        return float(data.time)
    return float(data.sim_time + data.pause_time)


def _line(
    interface: Interface[Any], places: list[tuple[str, tuple[int, ...], str]], options: argparse.Namespace
) -> str:
    """One sample as text."""
    if places:
        with interface.locked() as data:
            found = {
                text: list(element_values(data, place)) for text, place in zip(options.fields, places, strict=True)
            }
        values: dict[str, Any] = {text: row[0] if len(row) == 1 else row for text, row in found.items()}
    else:
        values = values_of(interface, everything=options.json)
    if options.json:
        return json.dumps({name: _json(value) for name, value in values.items()})
    return "  ".join(f"{name} {_text(value)}" for name, value in values.items())


def _json(value: Any) -> Any:
    """Replace numbers that JSON cannot represent with null."""
    if isinstance(value, dict):
        return {name: _json(item) for name, item in value.items()}
    if isinstance(value, list):
        return [_json(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _text(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + " ".join(f"{name} {_text(item)}" for name, item in value.items()) + "}"
    if isinstance(value, list):
        return "(" + " ".join(map(_text, value)) + ")"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _pyplot() -> Any:
    try:
        importlib.import_module("matplotlib").use("agg")
        return importlib.import_module("matplotlib.pyplot")
    except ImportError:
        raise LibraryError("--plot needs matplotlib, which is not installed: pip install 'libgz[plot]'") from None


def _plot(
    pyplot: Any,
    interface: Interface[Any],
    places: dict[str, tuple[str, tuple[int, ...], str]],
    samples: Iterator[float],
    path: Path,
) -> None:
    """Collect samples and plot them."""
    times: list[float] = []
    lines: dict[str, list[float]] = {}
    with contextlib.suppress(ServerGoneError):  # the samples until then are plotted
        for now in samples:
            times.append(now)
            with interface.locked() as data:
                for text, place in places.items():
                    row, unit = list(element_values(data, place)), unit_of(data, place)
                    for i, value in enumerate(row):
                        label = text if len(row) == 1 else f"{text}[{i}]"
                        lines.setdefault(f"{label} [{unit}]" if unit else label, []).append(value)
    figure, axes = pyplot.subplots(figsize=(8, 4.5))
    for label, values in lines.items():
        axes.plot(times, values, label=label, marker="." if len(times) < 50 else None)
    axes.set(xlabel="sim time [s]", title=f"{interface.type}.{interface.id}")
    axes.grid(alpha=0.3)
    axes.legend()
    try:
        figure.savefig(path, dpi=100)
    except (OSError, ValueError) as error:
        raise ParameterError(f"the plot cannot be written to {str(path)!r}: {error}") from None
    finally:
        pyplot.close(figure)
    print(f"{len(times)} samples plotted to {path}")
