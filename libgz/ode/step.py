"""One physics step and one ray scan, in two forms that give the same numbers: native (step.c) and pure Python.

`choose_step` returns the native one if it was built. The environment variable LIBGZ_STEP forces a choice:
``native`` (an error if it was not built), ``python``, or ``auto``. The Python form is the reference for tests: it is
slower, and ODE ends the process where one of its assertions fails, which the native form survives. So a server uses it
only where LIBGZ_STEP asks for it.
"""

from __future__ import annotations

import logging
import os
from functools import lru_cache

from libgz.base.errors import LibraryError, ParameterError
from libgz.ode.context import Step, StepContext
from libgz.ode.native_step import NativeStep, native_path
from libgz.ode.tables import Tables

__all__ = ["SERVING_HELP", "check_serving", "choose_step"]

log = logging.getLogger("libgz.ode")

_CHOICES = ("auto", "native", "python")
_DRAWBACKS = "slow, and ends where one of ODE's assertions fails"
_REMEDY = "install a C compiler (apt-get install gcc libc6-dev) and then libgz again"
# For the help of commands that serve.
SERVING_HELP = (
    "Environment: LIBGZ_STEP=python serves although the native step was not built: the server is "
    "then slow, and ends where one of ODE's assertions fails. `libgz doctor` reports which form of the step is used."
)


def choose_step(context: StepContext, tables: Tables) -> Step:
    """The form of the step to use, by LIBGZ_STEP and by what was built.

    Raises:
        ParameterError: LIBGZ_STEP has an unknown value.
        LibraryError: LIBGZ_STEP is ``native`` and the native step was not built.
    """
    choice, path = _choice(), native_path()
    if choice == "python":
        return _python_step(context, tables)
    if path is not None:
        return NativeStep(context, path)
    if choice == "native":
        raise LibraryError("LIBGZ_STEP=native, but the native step was not built: a C compiler is needed")
    _warn_of_python()
    return _python_step(context, tables)


def _python_step(context: StepContext, tables: Tables) -> Step:
    from libgz.ode.python_step import PythonStep  # the native form does without it

    return PythonStep(context, tables)


def check_serving() -> None:
    """Check that the form of the step is one for servers; a warning if LIBGZ_STEP asks for the Python form.

    Raises:
        ParameterError: LIBGZ_STEP has an unknown value.
        LibraryError: the native step was not built, and LIBGZ_STEP does not ask for the Python form.
    """
    choice = _choice()
    if choice == "python":
        log.warning("LIBGZ_STEP=python: the server is %s", _DRAWBACKS)
    elif native_path() is None:
        raise LibraryError(
            f"the native step was not built, and without it a server is {_DRAWBACKS}: {_REMEDY}, "
            "or set LIBGZ_STEP=python to serve all the same"
        )


def _choice() -> str:
    choice = os.environ.get("LIBGZ_STEP", "auto") or "auto"
    if choice not in _CHOICES:
        raise ParameterError(f"LIBGZ_STEP is {choice!r}; allowed are {', '.join(_CHOICES)}")
    return choice


@lru_cache
def _warn_of_python() -> None:
    """Warn once in a process."""
    log.warning("the native step was not built: this process is %s; %s", _DRAWBACKS, _REMEDY)
