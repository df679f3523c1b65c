"""libgz export: write what is in a log as tables of text."""

from __future__ import annotations

import argparse
import csv
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

from libgz.apps.console import say
from libgz.apps.series import Series, read_logs
from libgz.apps.untrusted import add_untrusted_option
from libgz.base.errors import ParameterError
from libgz.base.files import new_file
from libgz.base.visible import one_line
from libgz.recording.capture import check_packages
from libgz.recording.own_messages import read_json, understood

if TYPE_CHECKING:  # needs the extra `log`
    from libgz.recording.reader import LogReader

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    add_untrusted_option(parser)
    add = parser.add_argument
    add("log", metavar="LOG", help="a log that gazebo --mcap or gzserver --mcap recorded")
    add("targets", nargs="*", metavar="TARGET", help="position.robot1, state.robot1, ~/topic (default: all)")
    add("--csv", action="store_true", help="write comma-separated values, a file for each target (the default)")
    add("-o", dest="output", metavar="FOLDER", help="where to (default: a folder named like the log)")


def run(options: argparse.Namespace) -> int:
    """Write the files.

    Raises:
        NotFoundError: the log has no such target.
        ParameterError: the log cannot be read, or a file cannot be written.
        LibraryError: a package of the extra [log] is not installed.
    """
    check_packages()
    from libgz.recording.reader import LogReader  # needs the extra `log`

    with LogReader(options.log) as log:
        folder = Path(options.output) if options.output is not None else log.path.with_suffix("")
        if folder == log.path:
            raise ParameterError(f"the folder {str(folder)!r} would be the log itself; name another one with -o")
        with understood("a scene"):
            targets = options.targets or _all_targets(log)
        used: Counter[str] = Counter()
        for target, series in zip(targets, read_logs(log, [(target, []) for target in targets]), strict=True):
            if not series.lines:
                continue  # nothing but text
            path = folder / _file_name(target, used)
            _write(path, series)
            say(f"{path}: {len(series.times)} rows")
    return 0


def _all_targets(log: LogReader) -> list[str]:
    """Interfaces, moving bodies and topics of a log."""
    found = []
    world = f"/gazebo/{log.about.get('world', 'default')}/"
    for channel in log.channels.values():
        if channel.kind == "interface":
            found.append(f"{channel.about['type']}.{channel.about['id']}")
        elif channel.kind == "topic":
            found.append("~/" + channel.topic.removeprefix(world) if channel.topic.startswith(world) else channel.topic)
    bodies = {
        f"state.{entity['id']}::{body['name']}": None
        for message in log.messages(topics=("/gz/scene",))
        for entity in read_json(message.data)["entities"]
        for body in entity["bodies"]
        if not body["static"]
    }
    return [*dict.fromkeys(found), *bodies]


def _file_name(target: str, used: Counter[str]) -> str:
    """The name of a target's file, whatever a log calls it; none of those that were used, which are counted."""
    name = found = one_line(target.strip("~/").replace("::", ".").replace("/", "_"))
    while used[found]:
        used[name] += 1
        found = f"{name}_{used[name]}"
    used[found] += 1
    return f"{found}.csv"


def _write(path: Path, series: Series) -> None:
    labels = [f"{label} [{series.units[label]}]" if series.units[label] else label for label in series.lines]
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with open(path, "w", newline="", encoding="utf-8", opener=new_file) as file:
            table = csv.writer(file)
            table.writerow(["sim time [s]", *labels])
            for i, time in enumerate(series.times):
                numbers = (line[i] for line in series.lines.values())
                table.writerow([f"{time:.9g}", *("" if number is None else repr(number) for number in numbers)])
    except OSError as error:
        raise ParameterError(f"{path} cannot be written: {error.strerror}") from None
