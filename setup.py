"""Adds the native step, and the native conversion of images, to setup.cfg.

They need neither Python's headers nor ODE's: they are plain shared objects that ctypes loads. Where there is no C
compiler the package installs without them; the step runs in Python, and Mesa converts the images.
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
        ),
        Extension(
            "libgz.rendering._pixels",
            ["libgz/rendering/pixels.c"],
            extra_compile_args=["-O3", "-std=c99"],
            optional=True,
        ),
    ]
)
