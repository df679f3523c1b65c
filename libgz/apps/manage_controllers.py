"""controller_manager: the script of this name, which lists, loads, starts, stops and unloads controllers."""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Callable, Sequence
from typing import Any

from libgz.apps.console import Parser, as_command, say, set_up_messages
from libgz.base.errors import GazeboError
from libgz.base.visible import one_line
from libgz.ros.client import RosClient
from libgz.ros.names import read_names

__all__ = ["main"]

log = logging.getLogger("libgz.ros")

SHORT = {"lc": "list", "lt": "list-types", "sp": "spawn", "kl": "kill"}  # other names of what can be done
STRICT = 2


class _Manager:
    """The controller manager of a robot, in the namespace of this program."""

    def __init__(self, client: RosClient) -> None:
        self.client = client

    def list(self, _names: Sequence[str]) -> bool:
        """Print the controllers, with the interfaces that they use."""
        found = self._call("list_controllers", "ListControllers").controller
        for one in found:
            kinds = dict.fromkeys(claim.hardware_interface for claim in one.claimed_resources)
            say(one_line(f"'{one.name}' - '{'+'.join(kinds)}' ( {one.state} )"))
        if not found:
            say("No controllers are loaded in mechanism control")
        return True

    def list_types(self, _names: Sequence[str]) -> bool:
        """Print the types of controllers."""
        for name in self._call("list_controller_types", "ListControllerTypes").types:
            say(one_line(name))
        return True

    def load(self, names: Sequence[str]) -> bool:
        """Load controllers."""
        return self._each("load_controller", "LoadController", names, "Loaded {!r}", "Error when loading {!r}")

    def unload(self, names: Sequence[str]) -> bool:
        """Unload controllers."""
        said = "Unloaded {!r} successfully", "Error when unloading {!r}"
        return self._each("unload_controller", "UnloadController", names, *said)

    def start(self, names: Sequence[str]) -> bool:
        """Start controllers."""
        return self._switch("start_controllers", names, "Started {!r} successfully", "Error when starting {!r}")

    def stop(self, names: Sequence[str]) -> bool:
        """Stop controllers."""
        return self._switch("stop_controllers", names, "Stopped {!r} successfully", "Error when stopping {!r}")

    def spawn(self, names: Sequence[str]) -> bool:
        """Load and start controllers."""
        loaded = self.load(names)
        return self.start(names) and loaded

    def kill(self, names: Sequence[str]) -> bool:
        """Stop and unload controllers."""
        stopped = self.stop(names)
        return self.unload(names) and stopped

    def reload_libraries(self, _names: Sequence[str]) -> bool:
        """Unload all controllers."""
        good = bool(self._call("reload_controller_libraries", "ReloadControllerLibraries", force_kill=True).ok)
        say("Successfully reloaded libraries" if good else "Failed to reload libraries")
        return good

    def _each(self, service: str, kind: str, names: Sequence[str], done: str, failed: str) -> bool:
        good = True
        for name in names:
            ok = bool(self._call(service, kind, name=name).ok)
            say((done if ok else failed).format(name))
            good = good and ok
        return good

    def _switch(self, field: str, names: Sequence[str], done: str, failed: str) -> bool:
        good = True
        for name in names:
            wanted = {"start_controllers": [], "stop_controllers": [], field: [name]}
            ok = bool(self._call("switch_controller", "SwitchController", strictness=STRICT, **wanted).ok)
            say((done if ok else failed).format(name))
            good = good and ok
        return good

    def _call(self, service: str, kind: str, **values: Any) -> Any:
        name, full = f"controller_manager/{service}", f"controller_manager_msgs/{kind}"
        return self.client.call(name, full, waiting=log.info, **values)


VERBS: dict[str, Callable[[_Manager, Sequence[str]], bool]] = {
    "list": _Manager.list,
    "list-types": _Manager.list_types,
    "load": _Manager.load,
    "unload": _Manager.unload,
    "start": _Manager.start,
    "stop": _Manager.stop,
    "spawn": _Manager.spawn,
    "kill": _Manager.kill,
    "reload-libraries": _Manager.reload_libraries,
}


def make_parser() -> Parser:
    """The words of controller_manager's script."""
    parser = Parser(prog="controller_manager", description="List, load, start, stop and unload controllers of a robot")
    parser.add_argument("verb", choices=(*VERBS, *SHORT), metavar="VERB", help=", ".join(VERBS))
    parser.add_argument(
        "controllers", nargs="*", metavar="CONTROLLER", help="its name, and namespace of its parameters"
    )
    return parser


@as_command("controller_manager", failed=1)
def main(arguments: Sequence[str] | None = None) -> int:
    """The command. Exit codes: 0 done, 1 failed."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    set_up_messages(1, None)
    options = make_parser().parse_args([word for word in words if ":=" not in word])
    try:
        manager = _Manager(RosClient(read_names(words, name=f"controller_manager_{os.getpid()}")))
        return 0 if VERBS[SHORT.get(options.verb, options.verb)](manager, options.controllers) else 1
    except GazeboError as error:
        log.error("%s", error)
        return 1


if __name__ == "__main__":
    sys.exit(main())
