"""Finding and loading the Python files that worlds name as plugins."""

from __future__ import annotations

import contextvars
import importlib.util
import inspect
import logging
import re
import sys
import traceback
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import FunctionType
from typing import Any

from libgz.base.errors import USER_ERRORS, PluginError, nearest, pass_interrupt
from libgz.base.files import exists, expand, is_file, is_folder, read_file
from libgz.base.trust import check_trusted

__all__ = [
    "Plugin",
    "called",
    "collect",
    "edition",
    "load_plugin",
    "own_place",
    "own_traceback",
    "reload_plugin",
    "search",
]

log = logging.getLogger("libgz.simulation")

CPP_SUFFIXES = (".cc", ".cpp", ".cxx", ".c", ".hh", ".hpp", ".h")

# Packages that plugins of the C++ API, and of its users' wrappers, might be expected to import.
FOREIGN = ("gazebo", "gz", "ignition", "pygazebo", "sdformat")

_loading: contextvars.ContextVar[Plugin | None] = contextvars.ContextVar("loading", default=None)
_loaded: dict[Path, Plugin] = {}


@dataclass(eq=False, repr=False)
class Plugin:
    """A plugin file and what it registered, in order: (name, class)."""

    path: Path
    registered: list[tuple[str, Any]] = field(default_factory=list)
    module: Any = None
    edited: tuple[int, int] = (0, 0)  # time [ns] and size of the file that was run
    neighbours: dict[str, tuple[int, int]] = field(default_factory=dict)  # the same of modules beside it, by name


def collect(name: str, kind: Any) -> bool:
    """Record a registration of the plugin file that is being loaded; false if none is."""
    plugin = _loading.get()
    if plugin is None:
        return False
    plugin.registered.append((name, kind))
    return True


def _file_names(name: str, ends: tuple[str, ...] = (".py", "/__init__.py")) -> list[str]:
    """The files that a plugin's name may mean, best first: for Python, X.so and libX.so are both X.py."""
    stem = name.removesuffix(".so").removesuffix(".py")
    stems = [stem, stem.removeprefix("lib"), f"lib{stem}"]
    return list(dict.fromkeys(f"{s}{end}" for end in ends for s in stems if s))


def _matches(folder: Path, names: list[str]) -> Iterator[Path]:
    """Files in a folder that have one of the names; the case may differ, as old files often differ in it."""
    for name in names:
        if is_file(folder / name):
            yield folder / name
    wanted = {name.lower() for name in names if "/" not in name}
    with_other_case = sorted(folder.iterdir()) if is_folder(folder) else []
    yield from (path for path in with_other_case if path.name.lower() in wanted and is_file(path))


def search(
    name: str, places: list[tuple[str, Path]], tried: list[str], compiled: Callable[[Path], bool] | None = None
) -> Path | None:
    """The file of a plugin in the first of several (why, directory) that has it; an absolute name means itself.

    Every place without it is added to `tried`, a line each.

    Args:
        name: as the world gives it.
        places: where to look.
        tried: out: why each place has none.
        compiled: whether a shared object can be loaded; it then comes before a Python file. None: none can.
    """
    if name[0] in "/~":
        path = expand(name)
        places, name = [("the absolute path", path.parent)], path.name
    names = _file_names(name)
    shared = _file_names(name, (".so",)) if compiled is not None and not name.endswith(".py") else []
    for why, folder in places:
        found = next(_matches(folder, names), None)
        library = next((path for path in _matches(folder, shared) if compiled is not None and compiled(path)), None)
        if library is not None:
            if found is not None:
                log.info("plugin %r: %s is used, not %s beside it", name, library.name, found.relative_to(folder))
            return library.resolve()
        if found is not None:
            return found.resolve()
        link = next((folder / one for one in (name, *shared, *names) if _dangles(folder / one)), None)
        if link is not None:
            tried.append(f"  {link} ({why}): this link leads to {link.readlink()}, where there is no file")
        elif not exists(folder):
            tried.append(f"  {folder}/ ({why}): there is no such directory")
        elif name.endswith(".so") and is_file(folder / Path(name).name):
            what = "this file is no C++ plugin of libgz, so build its source with `libgz cxx build`, or"
            what = what if compiled is not None else "a compiled plugin cannot be loaded;"
            tried.append(f"  {folder / Path(name).name} ({why}): {what} port it to Python as {names[0]}")
        else:
            tried.append(f"  {folder}/ ({why}): {_absent(folder, names, compiled is not None)}")
    return None


def _dangles(path: Path) -> bool:
    """Whether a path is a symbolic link that leads to nothing."""
    try:
        return path.is_symlink() and not exists(path)
    except (OSError, ValueError):
        return False


def _absent(folder: Path, names: list[str], builds: bool) -> str:
    """Why a folder has no plugin of one of the names: there is only its C++ source, or a similar name, or nothing."""
    stems = {Path(name).stem.lower() for name in names if "/" not in name}
    files = sorted(path.name for path in folder.iterdir())
    source = next((f for f in files if Path(f).stem.lower() in stems and Path(f).suffix.lower() in CPP_SUFFIXES), None)
    if source is not None:
        port = Path(source).with_suffix(".py")
        if builds:
            return (
                f"{source} is C++ source: build it, `libgz cxx build {folder / source}`, or port it to Python as "
                f"{port} beside it (docs/cxx.md)"
            )
        return (
            f"{source} is C++ source, which cannot be loaded; port it to Python as {port} beside it (docs/plugins.md)"
        )
    near = nearest(names[0], [f for f in files if f.endswith(".py") and not f.startswith("_")])
    return f"has no {names[0]}{near}"


def load_plugin(path: Path) -> Plugin:
    """Run a plugin file and collect what it registers. A file is run once per process, and again after it was edited.

    Each file is a module of its own, whatever classes it defines: two files may both define a class of one name.
    Plugins that are loaded stay what they are when their file is edited; what is loaded later is new.

    Raises:
        PluginError: the file fails, or registers nothing; the message holds its own traceback.
        UntrustedError: files are not trusted.
    """
    check_trusted(f"plugin {path}")
    path = path.resolve()
    edited = edition(path)
    if path in _loaded and _loaded[path].edited == edited:
        return _loaded[path]
    plugin = Plugin(path, edited=edited)
    name = f"libgz_plugin_{path.parent.name if path.stem == '__init__' else path.stem}_{zlib.crc32(bytes(path)):08x}"
    folder = [str(path.parent)] if path.stem == "__init__" else None
    spec = importlib.util.spec_from_file_location(name, path, submodule_search_locations=folder)
    if spec is None or not isinstance(spec.loader, SourceFileLoader):
        raise PluginError(f"error loading plugin: {path} is not a Python file")
    plugin.module = importlib.util.module_from_spec(spec)
    before = sys.modules.get(name)
    sys.modules[name] = plugin.module
    if str(path.parent) not in sys.path:
        sys.path.append(str(path.parent))  # a plugin may import its neighbours, at any time
    token = _loading.set(plugin)
    try:
        # Not by exec_module: its cache of compiled files misses an edit within the same second.
        code = spec.loader.source_to_code(read_file(path), str(path))
        exec(code, plugin.module.__dict__)
        initialised = getattr(plugin.module, "gazebo_plugin_init", int)()
    except USER_ERRORS as error:
        pass_interrupt(error)
        del sys.modules[name]
        if before is not None:  # what it defined may still run
            sys.modules[name] = before
        raise PluginError(f"error loading plugin: {path}\n{own_traceback(error, path)}{import_hint(error)}") from error
    finally:
        _loading.reset(token)
    if initialised:
        raise PluginError(f"plugin init failed: gazebo_plugin_init() of {path} returned {initialised}")
    if not plugin.registered:
        raise PluginError(
            f'plugin {path} registers nothing; it must end with a line like GZ_REGISTER_PLUGIN("MyModel", MyModel), or '
            "GZ_REGISTER_WORLD_PLUGIN(MyPlugin) in worlds of Gazebo classic"
        )
    _loaded[path] = plugin
    plugin.neighbours = {one: edition(Path(str(sys.modules[one].__file__))) for one in _neighbours(plugin)}
    return plugin


def reload_plugin(path: Path) -> Plugin:
    """Run a plugin file again, edited or not; with it the modules beside it that it imports, if one was edited.

    Raises:
        PluginError: the file fails, or registers nothing; what `load_plugin` returned before stays valid.
    """
    path = path.resolve()
    before = _loaded.pop(path, None)
    aside = _edited_neighbours(before) if before is not None else {}
    for name in aside:
        del sys.modules[name]
    try:
        return load_plugin(path)
    except PluginError:
        sys.modules.update(aside)
        if before is not None:
            _loaded[path] = before
        raise


def _neighbours(plugin: Plugin) -> list[str]:
    """The names of imported modules that lie beside a plugin's file, and of those in packages beside it."""
    folder, own = plugin.path.parent, plugin.module.__name__
    found = []
    for name, module in list(sys.modules.items()):
        top = name.partition(".")[0]
        if top == own and name != own:  # the plugin is a package
            found.append(name)
        elif not top.startswith("libgz") and top != "__main__":
            file = getattr(sys.modules.get(top), "__file__", None)
            place = Path(file) if isinstance(file, str) else Path()
            place = place.parent if place.stem == "__init__" else place
            if place.parent == folder and isinstance(getattr(module, "__file__", None), str):
                found.append(name)
    return found


def _edited_neighbours(plugin: Plugin) -> dict[str, Any]:
    """All modules beside a plugin, if one of them was edited: they may import each other."""
    known = {name: sys.modules[name] for name in plugin.neighbours if name in sys.modules}
    for name, module in known.items():
        file = Path(str(module.__file__))
        if not is_file(file) or edition(file) != plugin.neighbours[name]:
            return known
    return {}


def called(path: Path, name: str) -> bool:
    """Whether a name means a plugin file: its path, or its name with or without its suffix or `lib` and `.so`."""
    stem = path.parent.name if path.stem == "__init__" else path.stem
    plain = stem.removeprefix("lib")
    names = {str(path), path.name, stem, f"{stem}.so", f"{stem}.py", plain, f"{plain}.py", f"lib{plain}.so"}
    return name in names or (name.startswith((".", "~", "/")) and expand(name).resolve() == path)


def import_hint(error: BaseException) -> str:
    """A line that names the right import, for the names of the C++ libraries and for those of the other era."""
    if not isinstance(error, ImportError):
        return ""
    wanted = re.match(r"cannot import name '(\w+)' from 'libgz'", str(error))
    package = (error.name or "").partition(".")[0]
    if package in FOREIGN or (wanted is not None and (wanted[1].endswith("Plugin") or "GZ_REGISTER" in wanted[1])):
        return (
            "\nthe classes of Gazebo 1 to 11 are in libgz.classic: `from libgz.classic import *` and, for example, "
            "`from libgz.classic import physics`; those of Gazebo 0.x in libgz: `from libgz import *`. "
            "docs/plugins.md shows how to write plugins"
        )
    return ""


def edition(path: Path) -> tuple[int, int]:
    """Time [ns] and size of a plugin file, by which another build of it shows.

    Raises:
        PluginError: it cannot be read.
    """
    try:
        status = path.stat()
    except OSError as error:
        raise PluginError(f"error loading plugin: {path}: {error.strerror}") from None
    return status.st_mtime_ns, status.st_size


def own_place(error: BaseException) -> str:
    """The end of a message about an error that user code caused, `` (file.py:12)``; empty for libgz's own models."""
    place, trace = "", error.__traceback__
    while trace is not None:
        module = str(trace.tb_frame.f_globals.get("__name__"))
        if module != "libgz" and not module.startswith("libgz."):
            place = f" ({trace.tb_frame.f_code.co_filename}:{trace.tb_lineno})"
        trace = trace.tb_next
    return place


def own_traceback(error: BaseException, path: Path | None = None, called: Callable[..., object] | None = None) -> str:
    """The traceback of an error in the user's own code: without the frames of libgz and importlib above it.

    An error of a plugin without such code is one in C++, and its message says all. Where the method `called` does not
    take what libgz gives it, the message has the parameters that it must have, and where it is.
    """
    frames = traceback.extract_tb(error.__traceback__)
    package = Path(__file__).parent.parent
    above = (str(package), str(package.resolve()), "<frozen importlib")
    own = [i for i, f in enumerate(frames) if f.filename == str(path) or not f.filename.startswith(above)]
    if not own and isinstance(error, TypeError) and (right := _right_call(called)):
        return "\n".join([*right, *traceback.format_exception_only(error)]).rstrip()
    first = own[0] if own else 0
    # The message of a syntax error names the place.
    alone = isinstance(error, SyntaxError) or (isinstance(error, PluginError) and not own)
    lines = ([] if alone else traceback.format_list(frames[first:])) + traceback.format_exception_only(error)
    return "".join(lines).rstrip()


def _right_call(method: Callable[..., object] | None) -> list[str]:
    """Where a user's method is, and how it must be declared: as in the class of libgz that it overrides."""
    if method is None:
        return []
    owner, name = type(getattr(method, "__self__", None)), getattr(method, "__name__", "")
    function = inspect.unwrap(getattr(method, "__func__", method))
    own = next((kind for kind in owner.__mro__ if name in vars(kind)), owner)
    if not isinstance(function, FunctionType) or own.__module__.startswith("libgz."):
        return []
    place = f'  File "{function.__code__.co_filename}", line {function.__code__.co_firstlineno}, in {name}'
    base = next((kind for kind in owner.__mro__ if kind.__module__.startswith("libgz.") and name in vars(kind)), None)
    if base is None:
        return [place]
    parameters = ", ".join(inspect.signature(vars(base)[name]).parameters)
    return [place, f"  it is called as {base.__name__} declares it: {name}({parameters})"]
