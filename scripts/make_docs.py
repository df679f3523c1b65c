"""Write the documents: a copy of the hand-written pages, with all that are generated, for the site and for the wheel.

python scripts/make_docs.py FOLDER      # the source of the site; `make docs` builds it in build/docs
python scripts/make_docs.py --man FOLDER  # the man pages only

The generated pages follow from parsers, declarations, docstrings and the description of SDF; none is committed.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

from libgz._version import __version__
from libgz.apps.api_pages import api_pages
from libgz.apps.command_line import EXIT_CODES, command_parsers
from libgz.classic_cxx.pages import api_page
from libgz.interfaces.reference import reference
from libgz.reference.classic_pages import classic_pages
from libgz.reference.markdown import NOTE, cell
from libgz.reference.pages import pages as model_pages, write_changed
from libgz.reference.player_devices import player_devices_page
from libgz.reference.sdf_elements import sdf_elements_page

ROOT = Path(__file__).parent.parent
COPIED = ("docs", "examples")  # what the site is made of, besides the pages at the top
COLUMN = {"gazebo": 0, "libgz": 1, "gz": 1, "gzserver": 2, "gzclient": 2}  # of EXIT_CODES


def generated_pages() -> dict[str, str]:
    """Path below docs -> text of all generated pages."""
    folders = {"models": model_pages(), "api": api_pages(), "classic": classic_pages()}
    found = {f"{folder}/{name}": text for folder, pages in folders.items() for name, text in pages.items()}
    return {
        "commands.md": commands_page(),
        "cxx_api.md": api_page(),
        "player_devices.md": player_devices_page(),
        "sdf_elements.md": sdf_elements_page(),
        "structs.md": reference(),
        **found,
    }


def write_source(folder: Path) -> None:
    """Write what Sphinx reads: the hand-written pages, the generated ones, and links to the files that pages name."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for path in ROOT.iterdir():
        if path.name in COPIED:
            shutil.copytree(path, folder / path.name, ignore=shutil.ignore_patterns("__pycache__"))
        elif path.suffix == ".md":
            shutil.copy(path, folder)
        elif path.name[0] != "." and path.name != "build":
            (folder / path.name).symlink_to(path)
    write_changed(folder / "docs", generated_pages())


# Commands ------------------------------------------------------------------------------------------------------------


def commands_page() -> str:
    """The commands and all their options, from the parsers."""
    parts = [
        NOTE,
        "# The commands in full\n",
        "All commands and options, as `-h` prints them. [Tools](tools.md) explains them with examples, and has a table "
        "of [exit codes](tools.md#exit-codes).\n",
    ]
    for name, parser in command_parsers().items():
        parts += list(command(name, parser, 2))
    return "\n".join(parts)


def command(name: str, parser: argparse.ArgumentParser, level: int) -> Iterator[str]:
    """The section of a command, and those of its subcommands."""
    yield f"{'#' * level} {name}\n"
    if parser.description:
        yield " ".join(parser.description.split()).replace("<", "\\<") + "\n"
    rows, below = [], []
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            below = [(word, sub) for word, sub in action.choices.items() if word != "help"]
        elif action.help is not argparse.SUPPRESS and not isinstance(action, argparse._HelpAction):
            rows.append(f"| {option(action)} | {cell(meaning(parser, action))} |")
    if rows:
        yield "\n".join(["| option or argument | meaning |", "|---|---|", *rows, ""])
    for word, sub in below:
        yield from command(f"{name} {word}", sub, min(level + 1, 4))


def option(action: argparse.Action) -> str:
    """An option with its argument, or an argument."""
    names = action.metavar or ("" if action.nargs == 0 else action.dest.upper())
    if action.choices is not None and action.metavar is None:
        names = "{" + ",".join(map(str, action.choices)) + "}"
    word = " ".join(names) if isinstance(names, tuple) else names
    if not action.option_strings:
        return f"`{word}`".replace("|", "\\|")
    ending = f" {word}" if action.nargs != 0 else ""
    if action.nargs == "?":
        ending = f" [{word}]"
    return ", ".join(f"`{name}{ending}`" for name in action.option_strings).replace("|", "\\|")


def meaning(parser: argparse.ArgumentParser, action: argparse.Action) -> str:
    """The help text with its values filled in."""
    values = {**vars(action), "prog": parser.prog}
    return (action.help or "") % {key: value for key, value in values.items() if value is not argparse.SUPPRESS}


# Man pages -----------------------------------------------------------------------------------------------------------


def man_pages() -> dict[str, str]:
    """Name -> text of the man pages."""
    os.environ["COLUMNS"] = "100"  # argparse wraps the synopsis by it
    from argparse_manpage.manpage import Manpage

    found = {}
    parsers = command_parsers()
    for name, parser in parsers.items():
        codes = ((code, row[COLUMN[name]]) for code, row in EXIT_CODES.items() if row[COLUMN[name]])
        others = ", ".join(f"\\fB{other}\\fP(1)" for other in parsers if other != name)
        status = "\n".join(
            f".TP\n\\fB{code}\\fP\n{meaning.replace('`', '').replace('-', chr(92) + '-')}" for code, meaning in codes
        )
        parser._manpage = [
            {"heading": "exit status", "content": status},
            {"heading": "see also", "content": f"{others}\n.br\nThe documents of libgz: docs/ in its sources."},
        ]
        summary = re.sub(r"\.$", "", (parser.description or "").split(" -- ")[-1].split(". ")[0])
        data = {
            "project_name": "libgz",
            "version": __version__,
            "date": __version__,
            "manual_title": "libgz",
            "description": summary[0].lower() + summary[1:],
        }
        found[f"{name}.1"] = str(Manpage(parser, data, format="single-commands-section"))
    return found


if __name__ == "__main__":
    target = Path(sys.argv[-1])
    if sys.argv[1:2] == ["--man"]:
        write_changed(target, man_pages())
    else:
        write_source(target)
