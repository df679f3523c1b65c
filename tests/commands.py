"""The commands, run in this process, or in one of their own where signals, streams or exit codes are what is tested."""

import contextlib
import importlib
import io
import logging
import os
import signal
import subprocess
import sys
from unittest.mock import patch

from libgz.rendering import choice

__all__ = ["command_line", "kept_logging", "run_command", "run_libgz", "spawn_command"]


def command_line(name, *arguments):
    """The words that start a command in a process of its own."""
    return [sys.executable, "-m", f"libgz.apps.{name}", *map(str, arguments)]


def spawn_command(name, *arguments, timeout=60, **options):
    """The finished process of a command, with its output as text."""
    return subprocess.run(command_line(name, *arguments), capture_output=True, text=True, timeout=timeout, **options)


def run_command(name, *arguments, env=None, cwd=".", timeout=60):
    """The same without a process, which costs a hundredth: a command leaves no trace in this one."""
    main = importlib.import_module(f"libgz.apps.{name}").main
    out, err = (io.TextIOWrapper(io.BytesIO(), "utf-8", write_through=True) for _ in range(2))
    with contextlib.ExitStack() as stack:
        enter = stack.enter_context
        enter(contextlib.chdir(cwd))
        enter(patch.dict(os.environ, os.environ if env is None else env, clear=True))
        enter(patch.object(choice, "_preferred", None))
        enter(kept_logging())
        enter(_kept_signals(timeout))
        enter(contextlib.redirect_stdout(out))
        enter(contextlib.redirect_stderr(err))
        try:
            code = main([str(word) for word in arguments])
        except SystemExit as end:
            code = end.code or 0
    return subprocess.CompletedProcess([name, *arguments], code, _text(out), _text(err))


def run_libgz(*arguments, **options):
    """What ``libgz ...`` prints and returns."""
    return run_command("libgz", *arguments, **options)


def _text(stream):
    return stream.buffer.getvalue().decode()


@contextlib.contextmanager
def kept_logging():
    """Restore the library's logger, which commands change."""
    logger = logging.getLogger("libgz")
    level, propagate, handlers = logger.level, logger.propagate, logger.handlers[:]
    try:
        yield
    finally:
        for handler in logger.handlers:
            if handler not in handlers:
                handler.close()
        logger.setLevel(level)
        logger.propagate, logger.handlers[:] = propagate, handlers


@contextlib.contextmanager
def _kept_signals(timeout):
    """Restore the handlers of signals that commands handle; after `timeout` [s] the command is ended."""

    def give_up(_number, _frame):
        raise AssertionError(f"the command did not end within {timeout} s")

    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGALRM)
    before = {number: signal.getsignal(number) for number in numbers}
    signal.signal(signal.SIGALRM, give_up)
    signal.alarm(timeout)
    try:
        yield
    finally:
        signal.alarm(0)
        for number, handler in before.items():
            signal.signal(number, handler)
