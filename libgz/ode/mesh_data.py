"""ODE's data of triangle meshes, whose search trees take seconds to build where meshes are large."""

from __future__ import annotations

import threading

import numpy as np
from numpy.typing import NDArray

from libgz.base.waiting import wait_for
from libgz.ode.lib import ode

__all__ = ["LARGE", "new_mesh_data"]

LARGE = 20_000  # triangles, whose tree takes about 20 ms


def new_mesh_data(vertices: NDArray[np.float64], triangles: NDArray[np.uint32]) -> int:
    """ODE's handle of a mesh, which the caller destroys; ODE keeps the addresses of both arrays.

    A signal's handler that raises an exception ends the wait for a large mesh at once.

    Args:
        vertices: shape (n, 4); the fourth column is padding [m].
        triangles: numbers of their corners, shape (m, 3).
    """
    if len(triangles) < LARGE:
        data = ode().dGeomTriMeshDataCreate()
        ode().dGeomTriMeshDataBuildSimple(data, *_arguments(vertices, triangles))
        return int(data)
    return _Build(vertices, triangles).wait()


def _arguments(vertices: NDArray[np.float64], triangles: NDArray[np.uint32]) -> tuple[int, int, int, int]:
    return vertices.ctypes.data, len(vertices), triangles.ctypes.data, triangles.size


class _Build:
    """The building of a tree in a thread: Python runs no signal handlers in a thread that is in a native function."""

    def __init__(self, vertices: NDArray[np.float64], triangles: NDArray[np.uint32]) -> None:
        self._data = ode().dGeomTriMeshDataCreate()
        self._lock = threading.Lock()
        self._built = threading.Event()
        self._abandoned = False
        # A daemon, for nobody waits for it after an interrupt. It keeps the arrays until ODE has read them.
        self._thread = threading.Thread(target=self._run, args=(vertices, triangles), name="libgz mesh", daemon=True)

    def wait(self) -> int:
        """The handle, as soon as the tree is built."""
        try:
            self._thread.start()
            wait_for(self._built)
        except BaseException:
            with self._lock:
                self._abandoned = True
                if self._built.is_set():
                    self._destroy()
            raise
        return int(self._data)

    def _run(self, vertices: NDArray[np.float64], triangles: NDArray[np.uint32]) -> None:
        ode().without_lock("dGeomTriMeshDataBuildSimple")(self._data, *_arguments(vertices, triangles))
        with self._lock:
            self._built.set()
            if self._abandoned:
                self._destroy()

    def _destroy(self) -> None:
        ode().dGeomTriMeshDataDestroy(self._data)
