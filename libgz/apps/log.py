"""libgz log: read log files of SDF worlds, and start and stop recording in a running server."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator
from pathlib import Path

from lxml import etree

from libgz.apps.console import say
from libgz.apps.server_link import add_world, publish, world_node
from libgz.apps.untrusted import add_untrusted_option
from libgz.base.budget import ELEMENT, Budget, BudgetError
from libgz.base.errors import ParameterError, WorldFileError
from libgz.base.visible import one_line, visible_xml
from libgz.classic import msgs
from libgz.classic.log import ENCODINGS, LogReader, LogState, LogWriter, NamePattern, read_states
from libgz.sdf.upgrade import NEWEST
from libgz.simulation.rate import TIME_SLACK

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    add_untrusted_option(parser)
    add = parser.add_argument
    add_world(parser)
    add("-f", "--file", metavar="FILE", help="the log file (gzserver -r writes state.log)")
    add("-i", "--info", action="store_true", help="print a summary of the file (default)")
    add("--json", action="store_true", help="print the summary as a JSON object")
    add("-e", "--echo", action="store_true", help="print the states")
    add("-o", "--output", type=Path, metavar="LOG", help="write the states to another log file")
    add("--filter", default="", metavar="NAMES", help="with -e, -o: names of models, a pattern with * or a regex")
    add("-z", "--hz", type=float, metavar="HZ", help="with -e, -o: largest number of states per second of sim time")
    add("-d", "--record", choices=("0", "1"), help="start (1) or stop (0) recording in the running server")
    help_ = "with -d 1, -o: encoding of the states (default zlib, or that of the file)"
    add("-n", "--encoding", choices=tuple(ENCODINGS), help=help_)
    add("--path", default="", metavar="FOLDER", help="with -d 1: directory of state.log")


def run(options: argparse.Namespace) -> int:
    """Print a log, or start or stop recording.

    Raises:
        ParameterError: the command line is incomplete.
        WorldFileError: the file cannot be read, is not a log, or is damaged.
        ServerError: there is no server.
        GazeboError: the server does not subscribe to the topic.
    """
    if options.record is not None:
        message = msgs.LogControl()
        message.start, message.stop = options.record == "1", options.record == "0"
        message.encoding, message.base_path = options.encoding or "zlib", options.path
        with world_node(options) as (node, _link):
            publish(node, "~/log/control", message)
        return 0
    if options.file is None:
        raise ParameterError("no log file is given; use -f FILE, or -d 1 and -d 0 for a running server")
    if options.hz is not None and not options.hz > 0.0:
        raise ParameterError(f"--hz is {options.hz:g}; it must be above 0")
    reader = LogReader(options.file)
    try:
        if options.output is not None:
            _write(reader, options)
        elif options.echo:
            for text in _texts(reader, options):
                sys.stdout.write(visible_xml(text))
        else:
            _print_info(reader, options.json)
    except BudgetError as error:
        raise WorldFileError(f"{options.file}: {error}") from None
    return 0


def _write(reader: LogReader, options: argparse.Namespace) -> None:
    """Write the world of a log, and the states that the options choose, to another one."""
    if options.output.exists() and options.output.samefile(reader.path):
        raise ParameterError(f"--output is {options.output}, the log itself; name another file")
    encoding = options.encoding or next((encoding for encoding, _ in reader.chunks()), "zlib")
    with LogWriter(options.output, encoding, reader.header.rand_seed) as log:
        for document in reader.documents():
            if document.find("state") is None:
                log.add(etree.tostring(document, encoding="unicode", with_tail=False) + "\n")
        for text in _texts(reader, options):
            log.add(text)


def _thinned(states: Iterator[LogState], rate: float | None) -> Iterator[LogState]:
    """States at no more than a rate [Hz]; each includes the changes of the omitted states before it.

    Raises:
        BudgetError: those are too many.
    """
    due, omitted, held = -float("inf"), LogState(0.0), Budget()
    for state in states:
        texts = *state.insertions, *state.deletions, *(name for name in state.poses if name not in omitted.poses)
        held.take(sum(map(len, texts)) + ELEMENT * len(texts))
        omitted.poses.update(state.poses)
        omitted.velocities.update(state.velocities)
        omitted.insertions += state.insertions
        omitted.deletions += state.deletions
        if rate is None or state.sim_time >= due - TIME_SLACK:
            due = state.sim_time + (1.0 / rate if rate else 0.0)
            state.poses, state.velocities = omitted.poses, omitted.velocities
            state.insertions, state.deletions = omitted.insertions, omitted.deletions
            yield state
            omitted, held = LogState(0.0), Budget()


def _texts(reader: LogReader, options: argparse.Namespace) -> Iterator[str]:
    """The states that the options choose, as SDF."""
    wanted = NamePattern(options.filter)
    for state in _thinned(read_states(reader), options.hz):
        state.poses = {n: pose for n, pose in state.poses.items() if wanted(n.rpartition("::")[0] or n)}
        if state.poses or state.insertions or state.deletions:
            yield state.text(NEWEST)


def _print_info(reader: LogReader, as_json: bool) -> None:
    """Print a summary in the format of classic's tool, or as JSON."""
    count, first, last, held = 0, None, 0.0, Budget()
    models: set[str] = set()
    for state in read_states(reader):
        first = state.sim_time if first is None else first
        count, last = count + 1, state.sim_time
        new = {name.partition("::")[0] for name in state.poses if "::" in name} - models
        held.take(sum(map(len, new)) + ELEMENT * len(new))
        models |= new
    encoding = next((encoding for encoding, _ in reader.chunks()), "none")
    header = reader.header
    if as_json:
        row = {
            "log_version": header.log_version,
            "gazebo_version": header.gazebo_version,
            "seed": header.rand_seed,
            "start_time": first or 0.0,
            "end_time": last,
            "steps": count,
            "bytes": reader.path.stat().st_size,
            "encoding": encoding,
            "models": sorted(models),
        }
        say(json.dumps(row))
        return
    say(f"Log Version:    {one_line(header.log_version)}")
    say(f"Gazebo Version: {one_line(header.gazebo_version)}")
    say(f"Random Seed:    {header.rand_seed}")
    say(f"Start Time:     {first or 0.0:.6f} s")
    say(f"End Time:       {last:.6f} s")
    say(f"Duration:       {last - (first or 0.0):.6f} s")
    say(f"Steps:          {count}")
    say(f"Size:           {reader.path.stat().st_size / 2**20:.3f} MB")
    say(f"Encoding:       {encoding}")
    say(f"Models:         {one_line(', '.join(sorted(models))) or 'none'}")
