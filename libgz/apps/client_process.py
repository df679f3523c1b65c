"""The client of `gazebo`: a gzclient in a process of its own, for plugins that only a client runs."""

from __future__ import annotations

import argparse
import contextlib
import logging
import subprocess
import threading
from collections.abc import Callable, Sequence

from libgz.base.closing import Closing
from libgz.base.python import start_module
from libgz.base.trust import UntrustedError, check_trusted
from libgz.classic.gui.named import named_plugins
from libgz.sdf.element import Element

__all__ = ["ClientProcess", "client_words", "wants_client"]

log = logging.getLogger("libgz.classic")

PATIENCE = 5.0  # [s] for the client to end, whose plugins end with it


def wants_client(options: argparse.Namespace, world: Element | None) -> bool:
    """Whether the command line, gui.ini or the world names plugins of a client that may be loaded.

    Args:
        options: of gzserver.
        world: the element of the world.
    """
    names = [*(options.gui_plugin or ()), *(one[0] for one in named_plugins(options.gui_client_plugin or (), world))]
    wanted = [_may_be_loaded(name) for name in names if name]
    return any(wanted)


def _may_be_loaded(name: str) -> bool:
    """Whether files are trusted; if not, a warning says that the plugin is left out."""
    try:
        check_trusted(f"plugin {name!r} of the client")
    except UntrustedError as error:
        log.warning("%s", error)
        return False
    return True


def client_words(options: argparse.Namespace) -> list[str]:
    """The command line of a gzclient beside a gzserver with these options."""
    words = [f"--gui-client-plugin={name}" for name in options.gui_client_plugin or ()]
    words += [f"--gui-plugin={name}" for name in options.gui_plugin or ()]
    words += [f"--view-port={options.view_port}", f"--view-host={options.view_host}"]
    words += [f"--gl={options.gl}"] if options.gl is not None else []
    words += [f"--{name}" for name in ("open", "verbose") if getattr(options, name)]
    return words + (options.unknown if options.gui_plugin else [])


class ClientProcess(Closing):
    """The process of a gzclient.

    Args:
        words: its command line.
        uri: GAZEBO_MASTER_URI of the server.
        ended: called in a thread when it has ended by itself.
    """

    def __init__(self, words: Sequence[str], uri: str, ended: Callable[[], object]) -> None:
        self._ended, self._closing = ended, threading.Event()
        self._process = start_module(
            "libgz.apps.gzclient",
            *words,
            changes={"GAZEBO_MASTER_URI": uri},
            stdin=subprocess.DEVNULL,
            start_new_session=True,  # Ctrl-C in the terminal is for the server, which ends it
        )
        self._watch = threading.Thread(target=self._wait, name="gzclient", daemon=True)
        self._watch.start()

    def _wait(self) -> None:
        code = self._process.wait()
        if self._closing.is_set():
            return
        if code == 0:
            log.info("The client has ended; the server ends with it.")
        else:
            how = f"exit code {code}" if code > 0 else f"signal {-code}"
            log.error("The client has ended with %s; the server ends with it. gzserver runs without a client.", how)
        self._ended()

    def close(self) -> None:
        """End the client and wait for it; one whose plugins keep it from ending is killed. Can be called twice."""
        self._closing.set()
        self._process.terminate()
        self._watch.join(PATIENCE)
        if self._watch.is_alive():
            log.warning("The client did not end within %g s and is killed.", PATIENCE)
            with contextlib.suppress(ProcessLookupError):
                self._process.kill()
            self._watch.join(PATIENCE)
