"""libgz echo: print the data of an interface live, as text or JSON, or plot it."""

from __future__ import annotations

import argparse
import contextlib
import json
import math
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from libgz.apps.console import say
from libgz.apps.plot import pyplot, save_plot
from libgz.apps.series import InterfaceValues, Series
from libgz.apps.target import add_target, connect, element_values, find_field, open_target, values_of
from libgz.base.errors import GazeboError, ParameterError, ServerGoneError
from libgz.base.visible import one_line
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
        "--plot",
        metavar="FILE.png",
        help="plot the fields over sim time to an image file at the end; `libgz plot` can do more",
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
    plotter = pyplot("--plot") if options.plot else None
    with connect(options, options.client_id) as client, contextlib.suppress(KeyboardInterrupt):
        interface = open_target(client, options.target)
        places = [find_field(interface, text) for text in options.fields]
        samples = _samples(client, interface, 1.0 / options.rate, count, options.seconds)
        if plotter is None:
            for _ in samples:
                say(_line(interface, places, options), flush=True)
        elif not places:
            raise ParameterError("--plot needs a field: add one after the interface")
        else:
            series, values = Series(), InterfaceValues(interface)
            with contextlib.suppress(ServerGoneError):  # the samples until then are plotted
                for now in samples:
                    series.add(now, values.row(options.fields))
            save_plot(plotter, {options.target: series}, Path(options.plot))
            say(f"{len(series.times)} samples plotted to {options.plot}; `libgz plot` has more")
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
    return one_line("  ".join(f"{name} {_text(value)}" for name, value in values.items()))


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
