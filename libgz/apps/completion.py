"""libgz completion: print the completion of all commands for a shell."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Iterator

import shtab

from libgz.apps.command_line import command_parsers
from libgz.apps.console import say
from libgz.models import MODELS
from libgz.worldfile.search import ready_worlds

__all__ = ["SHELLS", "configure", "run", "script"]

SHELLS = ("bash", "zsh", "fish")
_WORLDS = {"world", "worldfile", "worldfiles"}  # names of arguments that are worlds
_FILES = {"FILE", "LOG", "ID=FILE"}
_FOLDERS = {"DIR", "PREFIX"}


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("shell", choices=SHELLS, help="the shell")


def run(options: argparse.Namespace) -> int:
    """Print the completion of all commands."""
    say(script(options.shell))
    return 0


def script(shell: str) -> str:
    """The completion of all commands for a shell of SHELLS, to be evaluated by it."""
    parts = []
    for number, (name, parser) in enumerate(command_parsers().items()):
        for action in _actions(parser):
            complete = _complete(action)
            if complete is not None:
                action.complete = complete  # type: ignore[attr-defined]
        parts.append(shtab.complete(parser, shell, root_prefix=f"_libgz_complete_{number}_{name}"))
    return "\n".join(parts)


def _actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                yield from _actions(command)
        elif action.nargs != 0:
            yield action


def _complete(action: argparse.Action) -> shtab.CompleteType | None:
    """What completes an argument; None where nothing is known, or shtab sees it itself."""
    metavar = action.metavar if isinstance(action.metavar, str) else ""
    if action.choices is not None:
        return None
    if action.dest in _WORLDS or (action.dest == "name" and metavar == "WORLD"):
        return _worlds()
    if action.dest == "name" and metavar == "MODEL":
        return shtab.cmd(f"printf '%s\\n' {shlex.join(sorted(MODELS))}")
    if metavar in _FILES:
        return shtab.FILE
    return shtab.DIRECTORY if metavar in _FOLDERS else None


def _worlds() -> shtab.CompleteType:
    """Worldfiles and folders, and the names of the worlds of libgz."""
    names = " ".join(world.name for world in ready_worlds())
    return {
        "bash": "_libgz_worlds",
        "zsh": "_libgz_worlds",
        "fish": "(_libgz_worlds)",
        "preamble": {
            "bash": f"""
_libgz_worlds() {{
  compgen -W "{names}" -- "$1"
  compgen -f -X '!*.world' -- "$1"
  compgen -f -X '!*.sdf' -- "$1"
  compgen -d -S / -- "$1"
}}""",
            "zsh": f"""
_libgz_worlds() {{
  _alternative 'worlds:world of libgz:({names})' 'files:file:_files -g "*.(world|sdf)"'
}}""",
            "fish": f"""
function _libgz_worlds
  string split " " "{names}"
  __fish_complete_suffix .world
  __fish_complete_suffix .sdf
end""",
        },
    }
