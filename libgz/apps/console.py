"""Shared by the commands: argument types, one-sentence errors, exit codes, and log messages on the console."""

from __future__ import annotations

import argparse
import contextlib
import errno
import functools
import logging
import math
import os
import re
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NoReturn, TextIO, TypeAlias, TypeVar

from libgz.base.errors import GazeboError, Interrupted, ParameterError, nearest
from libgz.base.visible import visible

__all__ = [
    "INTERRUPTED",
    "MACRO_ARGUMENT",
    "NO_READER",
    "STRICT",
    "STRICT_HELP",
    "TERMINATED",
    "USAGE_ERROR",
    "Hints",
    "LogFile",
    "Parser",
    "as_command",
    "finite_number",
    "number_above_zero",
    "number_from_zero",
    "port_number",
    "read_text",
    "say",
    "set_up_messages",
    "whole_number",
    "wire_version",
    "writing",
]

USAGE_ERROR = 2
STRICT = 3  # exit code of a run that --strict has ended
STRICT_HELP = "end with exit code 3 at the first error of a model or plugin, or warning about the world"
DISK_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
LONGEST_TEXT = 64 << 20  # characters of a file that a command sends
MACRO_ARGUMENT = re.compile(r"((?!_)[^\s:=/]+):=(.*)", re.DOTALL)  # ROS's own, such as __name:=gazebo, begin with _
# The exit codes of shells.
INTERRUPTED, NO_READER, TERMINATED = 128 + signal.SIGINT, 128 + signal.SIGPIPE, 128 + signal.SIGTERM
WIRE_VERSIONS = {"0x050": 0x050, "0.5": 0x050, "0x060": 0x060, "0.6": 0x060, "0.7": 0x060}
PREFIXES = {logging.WARNING: "warning : ", logging.ERROR: "error   : ", logging.CRITICAL: "error   : "}


class _Help(argparse.HelpFormatter):
    """As wide as the terminal; argparse would ask shutil, which imports readers of archives, with each argument."""

    def __init__(self, prog: str) -> None:
        super().__init__(prog, width=_terminal_width() - 2)


def _terminal_width() -> int:
    """Its columns: those of the environment, else of standard output, else 80."""
    with contextlib.suppress(ValueError):
        if (given := int(os.environ.get("COLUMNS", ""))) > 0:
            return given
    with contextlib.suppress(AttributeError, ValueError, OSError):  # there is none, or it is no terminal
        if (found := os.get_terminal_size(sys.__stdout__.fileno()).columns) > 0:  # type: ignore[union-attr]
            return found
    return 80


class Hints(argparse.ArgumentParser):
    """An argument parser that names the nearest choice or option for one that does not exist.

    An argument without a type, or with Path, is a name: it is not empty, unless that is its default. `str` is any text.
    """

    _with_macros = False

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **{"formatter_class": _Help, **options})

    def add_macro_arguments(self) -> None:
        """Take words NAME:=VALUE, as the command xacro does, and put them into `arguments` of the options."""
        self._with_macros = True
        self.add_argument_group("macros", "NAME:=VALUE gives an argument of the macros (xacro) of a robot description")

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse the arguments that are known; NAME:=VALUE may stand anywhere among them."""
        if not self._with_macros:
            return super().parse_known_args(args, namespace)
        words = list(sys.argv[1:] if args is None else args)
        given = {match[1]: match[2] for word in words if (match := MACRO_ARGUMENT.fullmatch(word))}
        options, unknown = super().parse_known_args([w for w in words if not MACRO_ARGUMENT.fullmatch(w)], namespace)
        options.arguments = given
        return options, unknown

    def _get_value(self, action: argparse.Action, arg_string: str) -> Any:
        named = action.type in (None, Path) and action.choices is None and action.default != ""
        if named and not arg_string.strip():  # as where a variable of a script is not set
            raise argparse.ArgumentError(action, "the name is empty")
        return super()._get_value(action, arg_string)

    def _print_message(self, message: str, file: Any = None) -> None:
        """Print help, or an error; argparse would ignore that the output cannot be written."""
        if message:
            (file or sys.stderr).write(message)

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is None or value in action.choices:
            return
        choices = [str(choice) for choice in action.choices]
        if isinstance(action, argparse._SubParsersAction):
            message = f"{value!r} is not a command{nearest(str(value), choices) or f'; there are {_listed(choices)}'}"
            raise argparse.ArgumentError(None, message)
        message = f"{value!r} is not allowed; allowed are {_listed(choices)}{nearest(str(value), choices)}"
        raise argparse.ArgumentError(action, message)

    def option_names(self) -> list[str]:
        """The options of this parser and of its subcommands."""
        names = list(self._option_string_actions)
        for action in self._actions:
            if isinstance(action, argparse._SubParsersAction):
                names += [name for parser in action.choices.values() for name in parser.option_names()]
        return names

    def unknown(self, words: Sequence[str]) -> str:
        """The message about words that the parser does not know, each option with the nearest one."""
        names = self.option_names()
        hints = {word: nearest(word.partition("=")[0], names) if word.startswith("-") else "" for word in words}
        shown = " ".join(word or "''" for word in words)
        return f"unrecognized arguments: {shown}{next(filter(None, hints.values()), '')}"


def _listed(words: Sequence[str]) -> str:
    return ", ".join(words)


class Parser(Hints):
    """An argument parser whose errors are one sentence."""

    def parse_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse all arguments; unknown ones end the program with a message."""
        options, unknown = self.parse_known_args(args, namespace)
        if unknown:
            parser = self._chosen(options)
            parser.error(parser.unknown(unknown))
        return options

    def _chosen(self, options: argparse.Namespace) -> Parser:
        """The parser of the subcommand that was given, which knows its options; this one, if there are none."""
        for action in self._actions:
            if isinstance(action, argparse._SubParsersAction):
                chosen: Parser = action.choices[getattr(options, action.dest)]
                return chosen._chosen(options)
        return self

    def error(self, message: str) -> NoReturn:
        """Report the error and exit with code 2."""
        self.exit(USAGE_ERROR, visible(f"{self.prog}: {message}; {self.prog} -h lists what is allowed\n"))


N = TypeVar("N", int, float)


def _number(name: str, convert: Callable[[str], N], allowed: Callable[[N], bool], rule: str) -> Callable[[str], N]:
    def read(text: str) -> N:
        with contextlib.suppress(ValueError):
            number = convert(text)
            if allowed(number):
                return number
        raise argparse.ArgumentTypeError(f"invalid {name} value: {text!r}; it must be {rule}")

    return read


def wire_version(text: str) -> int:
    """An argument type: a version of libgazebo's structs, or the release of Gazebo that has it."""
    if text not in WIRE_VERSIONS:
        raise argparse.ArgumentTypeError(f"{text!r} is not a wire version; allowed are {', '.join(WIRE_VERSIONS)}")
    return WIRE_VERSIONS[text]


def whole_number(name: str) -> Callable[[str], int]:
    """An argument type: whole numbers from 0; `name` is its name in error messages."""
    return _number(name, int, lambda number: number >= 0, "a whole number, at least 0")


port_number = _number("port", int, lambda number: 0 <= number <= 65535, "a whole number from 0 to 65535")


def number_from_zero(name: str) -> Callable[[str], float]:
    """An argument type: finite numbers from 0; `name` is its name in error messages."""
    return _number(name, float, lambda number: 0.0 <= number < math.inf, "a finite number, at least 0")


def number_above_zero(name: str) -> Callable[[str], float]:
    """An argument type: numbers above 0; `name` is its name in error messages."""
    return _number(name, float, lambda number: number > 0.0, "a number above 0")


def finite_number(name: str) -> Callable[[str], float]:
    """An argument type: finite numbers; `name` is its name in error messages."""
    return _number(name, float, math.isfinite, "a finite number")


def say(*words: object, end: str = "\n", file: TextIO | None = None, flush: bool = False) -> None:
    """Print, as all commands do; what files and peers have put into the words cannot command the terminal."""
    print(visible(" ".join(map(str, words))), end=end, file=file, flush=flush)


def read_text(path: str, what: str) -> str:
    """The text of a file, which may be a pipe.

    Raises:
        ParameterError: the file cannot be read as text, or is too long; `what` is what the message calls its contents.
    """
    try:
        with open(path, encoding="utf-8") as file:  # noqa: PTH123
            text = file.read(LONGEST_TEXT + 1)
    except OSError as error:
        raise ParameterError(f"{what} cannot be read from {path!r}: {error.strerror}") from None
    except UnicodeDecodeError:
        raise ParameterError(f"{what} cannot be read from {path!r}: it is no text") from None
    if len(text) > LONGEST_TEXT:
        raise ParameterError(f"{what} cannot be read from {path!r}: it is larger than {LONGEST_TEXT >> 20} MiB")
    return text


@contextlib.contextmanager
def writing() -> Iterator[None]:
    """Report a file that cannot be written.

    Raises:
        GazeboError: an OSError occurred in the block.
    """
    try:
        yield
    except OSError as error:
        raise GazeboError(f"cannot write {error.filename}: {error.strerror}") from None


_Main: TypeAlias = Callable[[Sequence[str] | None], int]


def as_command(name: str, failed: int = 1) -> Callable[[_Main], Callable[..., int]]:
    """Make a function a command: an error of a stream, a file or memory ends it with a sentence, or none, and a code.

    Args:
        name: of the command.
        failed: exit code after such an error.
    """

    def decorate(main: _Main) -> Callable[..., int]:
        @functools.wraps(main)
        def command(arguments: Sequence[str] | None = None) -> int:
            _open_streams()
            try:
                try:
                    return main(arguments)
                finally:
                    if not sys.stdout.closed:  # as a language server leaves it
                        sys.stdout.flush()
            except Interrupted as error:
                return 128 + error.number
            except KeyboardInterrupt:
                return INTERRUPTED
            except BrokenPipeError:  # the reader has closed the pipe, such as `| head`
                _discard_unwritten(sys.stdout)
                return NO_READER
            except MemoryError:
                with contextlib.suppress(OSError):
                    say(f"{name}: there is not enough memory", file=sys.stderr)
                return failed
            except OSError as error:
                _discard_unwritten(sys.stdout)
                with contextlib.suppress(OSError):
                    where = error.filename or ("its output" if error.errno in DISK_FULL else None)
                    text = f"{name}: {where}: {error.strerror}" if where else f"{name}: {error}"
                    say(text, file=sys.stderr)
                return failed
            finally:
                _discard_unwritten(sys.stderr)  # for what nobody can read

        return command

    return decorate


def _open_streams() -> None:
    """Open standard streams that are closed; otherwise the next opened file would get their output."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest free number
    if sys.stdout is None:
        sys.stdout = open(os.devnull, "w")  # noqa: PTH123, SIM115 - for the rest of the process
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w")  # noqa: PTH123, SIM115 - for the rest of the process


def _discard_unwritten(stream: TextIO) -> None:
    """Discard buffered output that cannot be written; it would fail again when Python exits, with the code 120."""
    try:
        stream.flush()
    except (OSError, ValueError):
        with contextlib.suppress(OSError, ValueError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, stream.fileno())
            os.close(nowhere)


class _Console(logging.StreamHandler[TextIO]):
    """Log messages to a stream; errors of the stream itself are ignored."""

    def handleError(self, record: logging.LogRecord) -> None:
        if not isinstance(sys.exc_info()[1], OSError):
            super().handleError(record)


class LogFile(logging.FileHandler):
    """Log messages to a new file; if it cannot be written any more, such as on a full disk, that is logged once."""

    def __init__(self, path: Path) -> None:
        # As on stderr: names of files, and messages of users' errors, may have bytes that are no UTF-8.
        super().__init__(path, mode="w", encoding="utf-8", errors="backslashreplace")

    def handleError(self, record: logging.LogRecord) -> None:
        """Stop writing the file, and log the error."""
        error = sys.exc_info()[1]
        if not isinstance(error, OSError):
            super().handleError(record)
            return
        root = logging.getLogger("libgz")
        if self in root.handlers:
            root.removeHandler(self)
            root.error("log file %s cannot be written any more: %s", self.baseFilename, error.strerror)


class _ConsoleFormatter(logging.Formatter):
    def format(self, record: logging.LogRecord) -> str:
        return PREFIXES.get(record.levelno, "") + visible(super().format(record))


def set_up_messages(level: int, logfile: str | None) -> None:
    """Send errors, warnings, and messages up to `level` (-1 to 9) to stderr, and all messages to `logfile`.

    Raises:
        ParameterError: the log file cannot be written.
    """
    root = logging.getLogger("libgz")
    root.setLevel(logging.DEBUG)
    root.propagate = False
    console = _Console(sys.stderr)
    console.setFormatter(_ConsoleFormatter("%(message)s"))
    console.setLevel(logging.WARNING if level < 1 else logging.INFO if level == 1 else logging.DEBUG)
    root.handlers[:] = [console]
    if logfile is None:
        return
    try:
        file = LogFile(Path(logfile).expanduser())
    except OSError as error:
        raise ParameterError(f"cannot write log file {logfile!r}: {error.strerror}") from None
    file.setFormatter(_ConsoleFormatter("%(filename)s:%(lineno)d %(message)s"))
    root.addHandler(file)
