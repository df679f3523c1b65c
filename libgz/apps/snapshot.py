"""libgz snapshot: save and restore the state of a running server, or rewind it: libgz snapshot save before.state."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from libgz.apps.console import number_from_zero, say
from libgz.apps.target import add_server
from libgz.apps.untrusted import add_untrusted_option
from libgz.base.errors import ParameterError
from libgz.base.files import open_file, write_whole
from libgz.base.trust import trusted
from libgz.transport.control import MOST, ask

__all__ = ["configure", "run"]

BEGINNING = b"libgz state "  # of all versions; the server knows which one it takes


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the subcommands and options."""
    commands = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    save = commands.add_parser("save", help="write the state of the running world to a file")
    save.add_argument("file", metavar="FILE")
    restore = commands.add_parser("restore", help="bring the running world into the state of a file")
    restore.add_argument("file", metavar="FILE", help="written by `save`, of a server with the same world")
    rewind = commands.add_parser("rewind", help="bring the running world back by some seconds of sim time")
    rewind.add_argument(
        "seconds",
        metavar="SECONDS",
        type=number_from_zero("number of seconds"),
        help="how far back; the server was started with --rewind",
    )
    for command in (save, restore, rewind):
        add_server(command)
    add_untrusted_option(restore)


def run(options: argparse.Namespace) -> int:
    """Send the request, and print what was done.

    Raises:
        ServerError: there is no such server, or it cannot do it.
        ParameterError: the file cannot be read or written.
    """
    if options.action == "save":
        state = ask(options.server_id, "save")
        try:
            write_whole(Path(options.file), state)
        except OSError as error:
            raise ParameterError(f"cannot write {options.file!r}: {error.strerror}") from None
        say(f"saved {len(state)} bytes to {options.file}")
        return 0
    if options.action == "restore":
        verb = "restore" if trusted() else "restore_untrusted"  # it is the server that loads plugins
        now = ask(options.server_id, verb, content=_read_state(options.file))
    else:
        now = ask(options.server_id, "rewind", repr(options.seconds))
    say(f"sim time is {now.decode()} s")
    return 0


def _read_state(name: str) -> bytes:
    """The bytes of a file that `save` wrote; of others only the first ones are read.

    Raises:
        ParameterError: the file cannot be read, or is none of these.
    """
    try:
        with open_file(name) as file:
            state = file.read(len(BEGINNING))
            if state != BEGINNING:
                raise ParameterError(f"{name!r} is no state: it was not written by `libgz snapshot save`")
            if os.fstat(file.fileno()).st_size > MOST:
                raise ParameterError(f"{name!r} is larger than {MOST >> 20} MiB, which a server takes")
            return state + file.read()
    except OSError as error:
        raise ParameterError(f"cannot read {name!r}: {error.strerror}") from None
