"""Adds the native step to what setup.cfg says.

It needs neither Python's headers nor ODE's: it is a plain shared object that ctypes loads. Where there is no C compiler
the package installs without it, and the step runs in Python.
"""

from setuptools import Extension, setup

setup(
    ext_modules=[
        Extension(
            "libgz.ode._step",
            ["libgz/ode/step.c"],
            # No fused multiply-add: the native step and the Python one must give the same bits.
            extra_compile_args=["-O2", "-std=c99", "-ffp-contract=off"],
            optional=True,
        )
    ]
)
