"""Writes the man pages of the commands, docs/man/*.1, from their parsers.

python scripts/make_man_pages.py
"""

from __future__ import annotations

import os
import re
from pathlib import Path

from libgz._version import __version__

FOLDER = Path(__file__).parent.parent / "docs" / "man"
COLUMN = {"gazebo": 0, "libgz": 1, "gz": 1, "gzserver": 2, "gzclient": 2}  # of EXIT_CODES


def pages() -> dict[str, str]:
    """The man pages by the names of their files."""
    os.environ["COLUMNS"] = "100"  # argparse wraps the synopsis by it
    from argparse_manpage.manpage import Manpage

    from libgz.apps.command_line import EXIT_CODES, command_parsers

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
    FOLDER.mkdir(exist_ok=True)
    for name, text in pages().items():
        (FOLDER / name).write_text(text)
