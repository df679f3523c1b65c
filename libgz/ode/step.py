"""One physics step and one ray scan, in two forms that give the same numbers: native (step.c) and pure Python.

`choose_step` returns the native one if it was built. The environment variable LIBGZ_STEP forces a choice:
``native`` (an error if it was not built), ``python``, or ``auto``.
"""

from __future__ import annotations

import os

from libgz.errors import LibraryError, ParameterError
from libgz.ode.context import Step, StepContext
from libgz.ode.native_step import NativeStep, native_path
from libgz.ode.python_step import PythonStep
from libgz.ode.tables import Tables

__all__ = ["choose_step"]

_CHOICES = ("auto", "native", "python")


def choose_step(context: StepContext, tables: Tables) -> Step:
    """The form of the step to use, by LIBGZ_STEP and by what was built.

    Raises:
        ParameterError: LIBGZ_STEP has an unknown value.
        LibraryError: LIBGZ_STEP is ``native`` and the native step was not built.
    """
    choice = os.environ.get("LIBGZ_STEP", "auto") or "auto"
    if choice not in _CHOICES:
        raise ParameterError(f"LIBGZ_STEP is {choice!r}; allowed are {', '.join(_CHOICES)}")
    path = native_path()
    if choice == "python" or (choice == "auto" and path is None):
        return PythonStep(context, tables)
    if path is None:
        raise LibraryError("LIBGZ_STEP=native, but the native step was not built: a C compiler is needed")
    return NativeStep(context, path)
