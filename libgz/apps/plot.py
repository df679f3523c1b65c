"""libgz plot: plot fields of a log or of a running server over sim time."""

from __future__ import annotations

import argparse
import importlib
import math
import time
from pathlib import Path
from typing import Any

from libgz.apps.console import number_above_zero, say
from libgz.apps.series import InterfaceValues, Series, StateValues, is_target, observe, read_logs
from libgz.apps.target import add_server, connect, open_target
from libgz.apps.untrusted import add_untrusted_option
from libgz.base.errors import LibraryError, ParameterError, ServerGoneError
from libgz.base.extras import install
from libgz.recording.capture import check_packages
from libgz.transport.observer import Observer

__all__ = ["configure", "pyplot", "run", "save_plot"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    add_untrusted_option(parser)
    add_server(parser)
    add = parser.add_argument
    add(
        "words",
        nargs="+",
        metavar="LOG|TARGET|FIELD",
        help="a log (.mcap), or none for the running server; then targets, each with its fields: "
        "position.robot1 pos rot[2], state.robot1::canonical pos vel, in a log also ~/topic data.x",
    )
    add("-o", dest="output", metavar="FILE", default="plot.png", help="image file: .png, .svg, .pdf (default plot.png)")
    positive = number_above_zero("number")
    add("--seconds", type=positive, default=5.0, metavar="SEC", help="of a running server: real time [s] (default 5)")
    add("--rate", type=positive, default=50.0, metavar="HZ", help="of a running server: most samples (default 50)")
    add("--from", dest="begin", type=float, default=-math.inf, metavar="SEC", help="of a log: first sim time [s]")
    add("--to", dest="end", type=float, default=math.inf, metavar="SEC", help="of a log: last sim time [s]")


def run(options: argparse.Namespace) -> int:
    """Write the plot.

    Raises:
        ParameterError: the command line is incomplete, or there is no such field.
        NotFoundError: there is no such target.
        LibraryError: matplotlib is not installed.
    """
    words = list(options.words)
    log = words.pop(0) if not is_target(words[0]) else None
    wanted = _targets(words)
    plotter = pyplot("libgz plot")
    if log is None:
        found = _sample(options, wanted)
    else:
        check_packages()
        from libgz.recording.reader import LogReader  # needs the extra `log`

        with LogReader(log) as reader:
            found = dict(zip(wanted, read_logs(reader, list(wanted.items())), strict=True))
        for series in found.values():
            _cut(series, options.begin, options.end)
    if not any(series.times for series in found.values()):
        raise ParameterError("there is nothing to plot: no sample in this time")
    save_plot(plotter, found, Path(options.output))
    count = max(len(series.times) for series in found.values())
    say(f"{count} samples plotted to {options.output}")
    return 0


def _targets(words: list[str]) -> dict[str, list[str]]:
    """Target -> its fields.

    Raises:
        ParameterError: a target has no field, or there is none.
    """
    wanted: dict[str, list[str]] = {}
    for word in words:
        if is_target(word):
            fields = wanted.setdefault(word, [])
        elif not wanted:
            raise ParameterError(f"{word!r} is neither a log (.mcap) nor a target such as position.robot1")
        else:
            fields.append(word)
    for target, fields in wanted.items():
        if not fields:
            raise ParameterError(f"{target} has no field to plot; add one, such as `{target} pos`")
    if not wanted:
        raise ParameterError("no target is given: add one and a field, such as position.robot1 pos")
    return wanted


def _cut(series: Series, begin: float, end: float) -> None:
    kept = [i for i, moment in enumerate(series.times) if begin <= moment <= end]
    series.times = [series.times[i] for i in kept]
    series.lines = {label: [line[i] for i in kept] for label, line in series.lines.items()}


def _sample(options: argparse.Namespace, wanted: dict[str, list[str]]) -> dict[str, Series]:
    """Sample a running server."""
    found = {target: Series() for target in wanted}
    end = time.monotonic() + options.seconds
    with connect(options) as client:
        opened: dict[str, Any] = {}
        for target in wanted:
            if target[0] in "~/":
                raise ParameterError(f"{target}: topics are plotted from a log; `libgz topic` shows those of a server")
            if not target.startswith("state."):
                opened[target] = InterfaceValues(open_target(client, target))
        states = {target: StateValues(target.removeprefix("state.")) for target in wanted if target not in opened}
        sim = client.sim()
        observer = Observer(options.server_id) if states else None
        try:
            while time.monotonic() < end:
                moment = sim.sim_time
                for target, values in opened.items():
                    _add(found[target], moment, values, wanted[target])
                for target, values in states.items():
                    if observer is not None:
                        _add(found[target], observe(observer, values), values, wanted[target])
                time.sleep(1.0 / options.rate)
        except ServerGoneError:
            pass  # what was sampled until then is plotted
        finally:
            if observer is not None:
                observer.close()
    return found


def _add(series: Series, moment: float, values: Any, fields: list[str]) -> None:
    if not series.times or series.times[-1] != moment:
        series.add(moment, values.row(fields))


def pyplot(what: str) -> Any:
    """matplotlib's pyplot, without a window.

    Raises:
        LibraryError: it is not installed.
    """
    try:
        importlib.import_module("matplotlib").use("agg")
        return importlib.import_module("matplotlib.pyplot")
    except ImportError:
        raise LibraryError(f"{what} needs matplotlib, which is not installed: {install('plot')}") from None


def save_plot(plotter: Any, found: dict[str, Series], path: Path) -> None:
    """Write a figure with one diagram for each target.

    Raises:
        ParameterError: the file cannot be written.
    """
    figure, rows = plotter.subplots(len(found), 1, figsize=(8, 1.5 + 3 * len(found)), sharex=True, squeeze=False)
    for axes, (target, series) in zip(rows[:, 0], found.items(), strict=True):
        for label, line in series.lines.items():
            unit = series.units[label]
            numbers = [math.nan if number is None else number for number in line]
            marker = "." if len(series.times) < 50 else None
            axes.plot(series.times, numbers, label=f"{label} [{unit}]" if unit else label, marker=marker)
        axes.set_title(target)
        axes.grid(alpha=0.3)
        if 1 <= len(series.lines) <= 12:
            axes.legend(loc="best", fontsize="small")
    rows[-1, 0].set_xlabel("sim time [s]")
    figure.tight_layout()
    try:
        figure.savefig(path, dpi=100)
    except (OSError, ValueError) as error:
        raise ParameterError(f"the plot cannot be written to {str(path)!r}: {error}") from None
    finally:
        plotter.close(figure)
