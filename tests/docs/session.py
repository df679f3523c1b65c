"""Types what a page of the documents shows, as a reader does, and checks what the page says that it prints.

python session.py PAGE FOLDER [--until HEADING] [--installs]

In a page,

- a block of code after a paragraph that says "save this as `drive.py`", or that ends with "`drive.py`:", is a file;
- in a block of type `console`, lines after "$ " are commands, and the lines below are what they print: `...` stands for
  anything, alone on a line for any lines;
- a `gazebo` or `gzserver` that does not end by itself runs beside what follows, until the next server or the end;
- a block of type `python` without a name is a program.

This module needs the standard library only, because it also runs in roots where nothing else is installed.
"""

import argparse
import os
import re
import shlex
import subprocess
import sys
import time
from pathlib import Path

ENDLESS = re.compile(
    r"(\w+=\S+ )*(gazebo|gzserver|libgz player(?! wrong)) (?!.*(--steps|--iters| -h\b|--help|--version))"
)
INSTALLS = re.compile(r"(python3 -m venv|\. \S+/bin/activate|pip install|sudo )")
WITHOUT_CHECK = re.compile(r"<!-- not run: .*-->")
FILE = re.compile(r"[Ss]ave\s(?:\w+\s)*?as\s`([\w./-]+)`|`([\w./-]+\.\w+)`(?:, in the same directory)?:$")
READY = 60.0  # [s]


class Mismatch(AssertionError):
    """What a page shows is not what happens."""


def blocks(text):
    """(line, language, name of a file or None, lines) of each fenced block that is to be run."""
    lines, found, i = text.splitlines(), [], 0
    while i < len(lines):
        fence = re.fullmatch(r"```(\w*)", lines[i])
        if fence is None:
            i += 1
            continue
        end = lines.index("```", i + 1)
        before = "\n".join(lines[:i]).rstrip().rpartition("\n\n")[2]
        name = FILE.search(before)
        if not WITHOUT_CHECK.fullmatch(before):
            found.append((i + 2, fence[1], name and (name[1] or name[2]), lines[i + 1 : end]))
        i = end + 1
    return found


def commands(lines):
    """(command, lines that it prints) of a block of type console."""
    found = []
    for line in lines:
        if line.startswith("$ "):
            found.append((line[2:], []))
        elif found:
            found[-1][1].append(line)
    return found


def matches(expected, text):
    """Whether a text is what a page shows."""
    lines = [".*" if line == "..." else re.escape(line).replace(re.escape("..."), ".*") for line in expected]
    pattern = "".join(rf"(?:{line}\n)" if line != ".*" else r"(?s:.*)" for line in lines)
    return re.fullmatch(pattern, text if text.endswith("\n") or not text else text + "\n") is not None


class Session:
    """A shell in a folder, and the server that it has started."""

    def __init__(self, folder):
        self.folder = folder
        self.shell = subprocess.Popen(
            ["/bin/sh"], cwd=folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )
        self.servers = 0
        self.server = None  # (process id, log)

    def run(self, command, expected):
        """Run a command that ends, and compare what it prints, unless that is None.

        What shows no output of its own must end with exit code 0.
        """
        self.shell.stdin.write(f'{command}\necho " code:$?"\n')
        self.shell.stdin.flush()
        out = ""
        for line in self.shell.stdout:
            out += line
            if (end := re.search(r" code:(\d+)\n\Z", out)) is not None:
                break
        else:
            raise Mismatch(f"the shell ended in {command!r}: {out}")
        out = out[: end.start()]
        if expected in (None, [], ["..."]) and end[1] != "0":
            raise Mismatch(f"{command!r} ended with exit code {end[1]}: {out}")
        if expected is not None and not matches(expected, out):
            shown = "\n".join(expected) or "nothing"
            raise Mismatch(f"{command!r} printed\n{out}\ninstead of\n{shown}")
        return out

    def serve(self, command, expected):
        """Start a server, and wait until it has printed what the page shows and serves its world."""
        self.end_server()
        self.servers += 1
        log = self.folder / f".server{self.servers}"
        self.run(f"{command} > {shlex.quote(str(log))} 2>&1 &", None)
        number = self.run("echo $!", None).strip()
        self.server = (number, log)
        end = time.monotonic() + READY
        while not (self.ready(command) and (not expected or matches([*expected, "..."], log.read_text()))):
            alive = self.run(f"kill -0 {number} 2> /dev/null && echo alive || echo ended", None).strip() == "alive"
            if not alive or time.monotonic() > end:
                raise Mismatch(f"{command!r} is {'not ready' if alive else 'not running'}: {log.read_text()}")
            time.sleep(0.05)

    def ready(self, command):
        """Whether a server runs."""
        if command.split()[0] == "gzserver":
            time.sleep(1.0)  # clients wait for it
            return True
        user = os.environ.get("USER", "nobody")
        folders = Path(os.environ.get("TMP", "/tmp")).glob(f"gazebo-{user}-*")
        return any((folder / "sim.default").exists() for folder in folders)

    def end_server(self):
        """End the running server, as Ctrl-C does."""
        if self.server is not None:
            self.run(f"kill {self.server[0]}; wait {self.server[0]}; true", None)
            self.server = None

    def close(self):
        """End the server and the shell."""
        self.end_server()
        self.shell.stdin.close()
        self.shell.wait(30)


def play(page, folder, until=None, installs=False):
    """Do all that a page shows; returns how many commands and programs it was.

    Args:
        page: its path.
        folder: where to do it.
        until: a heading: the rest of the page is left out.
        installs: whether commands that install are run.
    """
    text = page.read_text()
    if until is not None:
        if f"\n## {until}\n" not in text:
            raise Mismatch(f"{page} has no heading {until!r}")
        text = text.partition(f"\n## {until}\n")[0]
    session, count = Session(folder), 0
    try:
        for line, language, name, lines in blocks(text):
            try:
                if name is not None:
                    (folder / name).parent.mkdir(parents=True, exist_ok=True)
                    (folder / name).write_text("\n".join(lines) + "\n")
                elif language == "console":
                    for command, expected in commands(lines):
                        if INSTALLS.match(command):
                            if not installs:
                                continue
                            expected = None  # what pip prints depends on the machine
                        (session.serve if ENDLESS.match(command) else session.run)(command, expected)
                        count += 1
                elif language == "python":
                    (folder / ".program.py").write_text("\n".join(lines) + "\n")
                    session.run("python3 .program.py", ["..."])
                    count += 1
            except Mismatch as error:
                raise Mismatch(f"{page}:{line}: {error}") from None
    finally:
        session.close()
    return count


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("page", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--until")
    parser.add_argument("--installs", action="store_true")
    options = parser.parse_args()
    try:
        print(play(options.page, options.folder, options.until, options.installs))
    except Mismatch as error:
        sys.exit(str(error))
