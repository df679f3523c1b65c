"""Makes the native parts plain shared libraries: neither their names nor the wheel's tag has a Python ABI."""

from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.bdist_wheel import bdist_wheel
from setuptools.command.build_ext import build_ext
from setuptools.errors import BaseError, CCompilerError


class BuildLibraries(build_ext):
    """Names libraries without Python's suffix, and sources by patterns."""

    def finalize_options(self) -> None:
        """Find the sources, and the headers beside them, on which they depend."""
        super().finalize_options()
        for ext in self.extensions:
            ext.sources = sorted(str(path) for pattern in ext.sources for path in Path().glob(pattern))
            folders = {Path(source).parent for source in ext.sources}
            ext.depends = sorted(str(path) for folder in folders for path in folder.glob("*.h"))

    def get_ext_filename(self, fullname: str) -> str:
        """`libgz/ode/_step.so` for `libgz.ode._step`."""
        return str(Path(*fullname.split("."))) + ".so"

    def build_extensions(self) -> None:
        """Build them without the directories of the Python that builds, where they would look for libraries."""
        self.compiler.linker_so = [word for word in self.compiler.linker_so if not word.startswith("-Wl,-rpath")]
        super().build_extensions()

    def build_extension(self, ext: Extension) -> None:
        """Build one; a part that is needed fails with what to install."""
        try:
            super().build_extension(ext)
        except (BaseError, CCompilerError) as error:
            if ext.optional:
                raise
            remedy = "libgz needs a C compiler: apt-get install gcc libc6-dev"
            raise SystemExit(f"{remedy} ({ext.name}: {error})") from error


class AnyPythonWheel(bdist_wheel):
    """One wheel for all versions of Python on a platform."""

    def get_tag(self) -> tuple[str, str, str]:
        """Python and ABI tag of a wheel without extension modules, with the platform's tag."""
        return "py3", "none", super().get_tag()[2]


setup(cmdclass={"build_ext": BuildLibraries, "bdist_wheel": AnyPythonWheel})
