"""Shared by gazebo and gzserver: the options that record a log."""

from __future__ import annotations

import argparse
import contextlib
from collections.abc import Iterator
from typing import TYPE_CHECKING

from libgz.apps.console import number_from_zero
from libgz.front import World

if TYPE_CHECKING:
    from libgz.recording.capture import Capture

__all__ = ["add_mcap_option", "record_mcap"]


def add_mcap_option(parser: argparse.ArgumentParser) -> None:
    """Add --mcap and --mcap-period."""
    add = parser.add_argument
    add("--mcap", metavar="FILE", help="record interfaces, states, scene and topics to a log; see `libgz play`")
    add(
        "--mcap-period",
        type=number_from_zero("number of seconds"),
        default=0.0,
        metavar="SEC",
        help="sim time between two states of all bodies in that log [s] (default: every step)",
    )


@contextlib.contextmanager
def record_mcap(world: World, options: argparse.Namespace) -> Iterator[Capture | None]:
    """The log that the options ask for; None if they ask for none.

    Raises:
        LibraryError: a package of the extra [log] is not installed.
        ParameterError: the file cannot be written.
    """
    if options.mcap is None:
        yield None
        return
    from libgz.recording.capture import Capture  # other runs do without it

    with contextlib.closing(Capture(world, options.mcap, options.mcap_period)) as capture:
        yield capture
