"""libgz cxx: compile C++ plugins: libgz cxx build MyRobot.cc -o MyRobot.so."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from libgz.apps.console import say
from libgz.base.errors import ParameterError
from libgz.classic_cxx.recognition import is_classic
from libgz.cxx.build import STANDARD, CompileError, build, check

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    builder = actions.add_parser("build", help="compile and link a plugin", description="Compile and link a plugin.")
    checker = actions.add_parser(
        "check",
        help="compile only, and explain what is missing",
        description="Compile only, and explain what is missing.",
    )
    for command in (builder, checker):
        command.add_argument("sources", nargs="+", type=Path, metavar="FILE.cc", help="the C++ sources of one plugin")
        command.add_argument(
            "--std", default=STANDARD, metavar="S", help=f"the language's standard (default {STANDARD})"
        )
        command.add_argument("-I", dest="include", action="append", default=[], metavar="DIR", help="where headers are")
        command.add_argument(
            "-D", dest="define", action="append", default=[], metavar="NAME[=V]", help="define a macro"
        )
    builder.add_argument(
        "-o", dest="output", type=Path, metavar="FILE.so", help="the plugin (default: beside the first source)"
    )
    builder.add_argument("--debug", action="store_true", help="without optimization, and with symbols for gdb")
    builder.add_argument("-L", dest="folders", action="append", default=[], metavar="DIR", help="where libraries are")
    builder.add_argument("-l", dest="libraries", action="append", default=[], metavar="NAME", help="link a library")


def run(options: argparse.Namespace) -> int:
    """Build or check; 1 if there are errors, which are printed with file and line.

    Raises:
        LibraryError: there is no compiler.
        ParameterError: a file cannot be read or written.
        PluginError: the plugin that was built cannot be loaded.
    """
    flags = [f"-I{folder}" for folder in options.include] + [f"-D{name}" for name in options.define]
    if is_classic(options.sources):
        return _classic(options, flags)
    if options.action == "check":
        errors = check(options.sources, standard=options.std, options=flags)
        if not errors:
            say(f"{', '.join(map(str, options.sources))}: no errors")
        return _report(errors)
    output: Path = options.output or options.sources[0].with_suffix(".so")
    if output.suffix != ".so":
        raise ParameterError(f"a plugin's name ends with .so, and {str(output)!r} does not")
    libraries = _libraries(options)
    errors = build(
        options.sources, output, debug=options.debug, standard=options.std, options=flags, libraries=libraries
    )
    if not errors:
        from libgz.cxx.plugin import load  # which loads all that worlds need

        names = ", ".join(name for name, _ in load(output).registered)
        say(f"{output}: {names}")
    return _report(errors)


def _classic(options: argparse.Namespace, flags: list[str]) -> int:
    """The same for a plugin of Gazebo classic; the library that it needs is built first."""
    from libgz.classic_cxx import build as classic

    standard = None if options.std == STANDARD else options.std
    if options.action == "check":
        errors = classic.check(options.sources, standard=standard, options=flags, progress=_progress)
        if not errors:
            say(f"{', '.join(map(str, options.sources))}: no errors")
        return _report(errors)
    output: Path = options.output or classic.default_output(options.sources[0])
    libraries = _libraries(options)
    errors = classic.build(
        options.sources,
        output,
        debug=options.debug,
        standard=standard,
        options=flags,
        libraries=libraries,
        progress=_progress,
    )
    if not errors:
        from libgz.classic_cxx.plugin import load  # which loads all that worlds need

        (kind, _), *_ = load(output).registered
        say(f"{output}: a {kind}Plugin")
    return _report(errors)


def _libraries(options: argparse.Namespace) -> list[str]:
    """The linker's options; what is in these folders is found there when the plugin is loaded, as after cmake."""
    words = [f"-L{folder}" for folder in options.folders] + [f"-l{name}" for name in options.libraries]
    for folder in options.folders:
        words += ["-Xlinker", "-rpath", "-Xlinker", str(Path(folder).absolute())]
    return words


def _progress(line: str) -> None:
    say(line, file=sys.stderr, flush=True)


def _report(errors: list[CompileError]) -> int:
    for error in errors:
        say(error, file=sys.stdout)
    return 1 if errors else 0
