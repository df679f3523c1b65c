"""Off-screen OpenGL contexts: rows of a table, tried in order or chosen by name."""

from __future__ import annotations

import ctypes
import logging
import os
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from ctypes import c_char_p, c_int, c_uint, c_void_p
from typing import ClassVar, ParamSpec, TypeVar

from libgz.base.errors import ClosedError, LibraryError
from libgz.rendering.chain import advice
from libgz.rendering.choice import check_choice, chosen
from libgz.rendering.gl import GL, Constant

__all__ = ["CONTEXTS", "Context", "EGLContext", "OSMesaContext", "open_context"]

log = logging.getLogger("libgz.rendering")

P = ParamSpec("P")
T = TypeVar("T")


class Context:
    """A context, and the one thread that may use it.

    All GL work goes through `run` or `submit`. `close` is idempotent.

    Raises:
        LibraryError: this kind of context does not work here; the message says why.
    """

    name: ClassVar[str]

    def __init__(self) -> None:
        self._worker: ThreadPoolExecutor | None = ThreadPoolExecutor(1, thread_name_prefix=f"libgz-{self.name}")
        self.gl: GL
        try:
            self.run(self._start)
        except BaseException:
            self.close()
            raise

    def _start(self) -> None:
        self.create()
        self.gl = GL(self.address_of)
        texts = (self.gl.glGetString(Constant.RENDERER), self.gl.glGetString(Constant.VERSION))
        self.description = ", OpenGL ".join(bytes(text or b"?").decode() for text in texts)

    def create(self) -> None:
        """Make the context, current in the calling thread."""
        raise NotImplementedError

    def destroy(self) -> None:
        """Undo `create`, also a partial one."""
        raise NotImplementedError

    def address_of(self, name: bytes) -> int | None:
        """Address of a GL function."""
        raise NotImplementedError

    def submit(self, work: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Queue a call for the context's thread.

        Raises:
            ClosedError: the context was closed.
        """
        if self._worker is None:
            raise ClosedError(f"the {self.name} context was closed")
        return self._worker.submit(work, *args, **kwargs)

    def run(self, work: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """Call a function in the context's thread, and wait for its result."""
        return self.submit(work, *args, **kwargs).result()

    @property
    def closed(self) -> bool:
        """Whether `close` was called."""
        return self._worker is None

    def close(self) -> None:
        """Release the context and end its thread. Can be called twice."""
        worker, self._worker = self._worker, None
        if worker is not None:
            worker.submit(self.destroy).result()
            worker.shutdown()


class OSMesaContext(Context):
    """Mesa that renders into memory, without a window system. Mesa 25.1 dropped it."""

    name = "osmesa"

    _RGBA = 0x1908

    def create(self) -> None:  # noqa: D102
        self._handle: int | None = None
        self._lib = _library("libOSMesa.so.8", self)
        lib = self._lib
        lib.OSMesaCreateContextExt.restype = c_void_p
        lib.OSMesaCreateContextExt.argtypes = [c_uint, c_int, c_int, c_int, c_void_p]
        lib.OSMesaMakeCurrent.argtypes = [c_void_p, c_void_p, c_uint, c_int, c_int]
        lib.OSMesaDestroyContext.argtypes = [c_void_p]
        lib.OSMesaGetProcAddress.restype = c_void_p
        lib.OSMesaGetProcAddress.argtypes = [c_char_p]
        self._handle = lib.OSMesaCreateContextExt(self._RGBA, 0, 0, 0, None)
        if not self._handle:
            raise LibraryError("OSMesa could not make a context")
        self._pixel = (ctypes.c_ubyte * 64)()  # required, but unused: images are rendered into framebuffer objects
        if not lib.OSMesaMakeCurrent(self._handle, self._pixel, Constant.UNSIGNED_BYTE, 4, 4):
            raise LibraryError("OSMesa could not make its context current")

    def destroy(self) -> None:  # noqa: D102
        if getattr(self, "_handle", None):
            self._lib.OSMesaMakeCurrent(None, None, 0, 0, 0)
            self._lib.OSMesaDestroyContext(self._handle)
            self._handle = None

    def address_of(self, name: bytes) -> int | None:  # noqa: D102
        return self._lib.OSMesaGetProcAddress(name)  # type: ignore[no-any-return]


class EGLContext(Context):
    """EGL on Mesa's surfaceless platform: no window system, and a graphics card if Mesa supports it."""

    name = "egl"

    _SURFACELESS_MESA, _OPENGL_API = 0x31DD, 0x30A2
    _NONE, _SURFACE_TYPE, _RENDERABLE_TYPE, _OPENGL_BIT = 0x3038, 0x3033, 0x3040, 0x0008

    def create(self) -> None:  # noqa: D102
        self._display: int | None = None
        self._handle: int | None = None
        lib = self._lib = _library("libEGL.so.1", self)
        lib.eglGetProcAddress.restype = c_void_p
        lib.eglGetProcAddress.argtypes = [c_char_p]
        address = self.address_of(b"eglGetPlatformDisplayEXT")
        if not address:
            raise LibraryError(f"this EGL has no platforms (eglGetPlatformDisplayEXT); {advice(self.name)}")
        get_display = ctypes.CFUNCTYPE(c_void_p, c_uint, c_void_p, c_void_p)(address)
        lib.eglInitialize.argtypes = [c_void_p, c_void_p, c_void_p]
        lib.eglChooseConfig.argtypes = [c_void_p, c_void_p, c_void_p, c_int, c_void_p]
        lib.eglCreateContext.restype = c_void_p
        lib.eglCreateContext.argtypes = [c_void_p, c_void_p, c_void_p, c_void_p]
        lib.eglMakeCurrent.argtypes = [c_void_p] * 4
        lib.eglDestroyContext.argtypes = [c_void_p, c_void_p]
        self._display = get_display(self._SURFACELESS_MESA, None, None)
        if not self._display or not lib.eglInitialize(self._display, None, None):
            raise self._error("has no surfaceless platform")
        wanted = (c_int * 5)(self._SURFACE_TYPE, 0, self._RENDERABLE_TYPE, self._OPENGL_BIT, self._NONE)
        config, found = c_void_p(), c_int()
        if not lib.eglChooseConfig(self._display, wanted, ctypes.byref(config), 1, ctypes.byref(found)) or not found:
            raise self._error("offers no configuration with OpenGL")
        if not lib.eglBindAPI(self._OPENGL_API):
            raise self._error("has no OpenGL")
        self._handle = lib.eglCreateContext(self._display, config, None, None)
        if not self._handle or not lib.eglMakeCurrent(self._display, None, None, self._handle):
            raise self._error("could not make a context")

    def _error(self, what: str) -> LibraryError:
        return LibraryError(f"EGL {what} (EGL error {self._lib.eglGetError():#06x}); {advice(self.name)}")

    def destroy(self) -> None:  # noqa: D102
        # The display is shared by the whole process, so it is not terminated.
        if getattr(self, "_handle", None):
            self._lib.eglMakeCurrent(self._display, None, None, None)
            self._lib.eglDestroyContext(self._display, self._handle)
            self._lib.eglReleaseThread()
            self._handle = None

    def address_of(self, name: bytes) -> int | None:  # noqa: D102
        return self._lib.eglGetProcAddress(name)  # type: ignore[no-any-return]


def _library(name: str, context: Context) -> ctypes.CDLL:
    try:
        return ctypes.CDLL(name)
    except OSError as error:
        raise LibraryError(f"{name} cannot be loaded ({error}); {advice(context.name)}") from None


CONTEXTS: dict[str, type[Context]] = {kind.name: kind for kind in (OSMesaContext, EGLContext)}
_rendering: int | None = None  # the process in which Mesa has started threads


def open_context(choice: str | None = None) -> Context | None:
    """A new context: the chosen kind, or for ``"auto"`` the first that works; None for ``"none"``.

    Raises:
        LibraryError: it does not work here, or none does.
        ParameterError: the choice is unknown.
    """
    global _rendering
    choice = chosen() if choice is None else check_choice(choice, "the choice of OpenGL")
    if choice == "none":
        return None
    if _rendering not in (None, os.getpid()):
        raise LibraryError(
            "OpenGL was used before this process was forked, so it would wait here without end: start processes with "
            "'spawn' or 'forkserver', or set LP_NUM_THREADS=0 in the environment before the first camera"
        )
    if os.environ.get("LP_NUM_THREADS") != "0":
        _rendering = os.getpid()
    if choice != "auto":
        return CONTEXTS[choice]()
    reasons = []
    for name, kind in CONTEXTS.items():
        try:
            context = kind()
        except LibraryError as error:
            log.info("%s does not render: %s", name, error)
            reasons.append(f"{name}: {error}")
            continue
        log.info("rendering with %s: %s", name, context.description)
        return context
    raise LibraryError(
        f"no OpenGL works here, which the world's cameras need ({'; '.join(reasons)}); --gl none disables rendering, "
        "and so does LIBGZ_GL=none in the environment"
    )
