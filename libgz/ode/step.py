"""One physics step and one ray scan: the functions of the C files beside, by ctypes."""

from __future__ import annotations

import contextlib
import ctypes
import functools
import threading
from collections.abc import Callable, Iterable, Sequence
from ctypes import c_double, c_int64, c_void_p
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import LibraryError
from libgz.base.geometry import GzPose
from libgz.base.records import JobRecord, TableRecord, check_sizes
from libgz.ode.context import CONTACT, Publication, RayScan, StepContext
from libgz.ode.lib import ode
from libgz.ode.parts import Parts

__all__ = ["LONGEST", "Step", "address_of", "library_path"]


LIBRARY = Path(__file__).with_name("_step.so")
LONGEST = 0.01  # [s] of real time without Python, if there is more than one step; then signals are noticed
_ALLOCATORS = tuple(f"d{verb}{what}Handler" for what in ("Alloc", "Realloc", "Free") for verb in ("Get", "Set"))
_loading = threading.Lock()
_NO_TURN = (1.0, 0.0, 0.0, 0.0)
# ODE's classes of joints by their number; those without a name have no rows.
_JOINTS = (
    *("", "Ball", "Hinge", "Slider", "Contact", "Universal", "Hinge2", "Fixed", "", "AMotor", "LMotor", "Plane2D"),
    *("PR", "PU", "Piston", "DBall", "DHinge", "Transmission"),
)


def library_path() -> Path:
    """Where the step was built.

    Raises:
        LibraryError: it was not built.
    """
    if not LIBRARY.exists():
        raise LibraryError(
            "the step was not built: install a C compiler (apt-get install gcc libc6-dev) and then libgz again"
        )
    return LIBRARY


class Step:
    """The step of one engine. The interpreter lock is released while it runs.

    Raises:
        LibraryError: it was not built, or from another version of the sources.
    """

    _library: ctypes.CDLL | None = None

    def __init__(self, context: StepContext) -> None:
        self._shared = self._bind()
        self._context = context
        self._buffer, self._size = ctypes.create_string_buffer(0), c_int64(0)  # of the last state
        self._address = ctypes.addressof(context)
        if not self._shared.gz_open(self._address):
            raise LibraryError("there is no memory for the step of another world")
        # Functions that are looked up by item have no argument types: they take ctypes objects unchecked.
        self._step = functools.partial(self._shared["gz_step"], c_void_p(self._address))
        self._publish = functools.partial(self._shared["gz_publish"], c_void_p(self._address))
        self._get_state = self._shared["gz_get_state"]
        self._get_state.restype = c_int64
        self._scan = self._shared["gz_scan"]
        self._scan.restype = None
        self.release = functools.partial(_release, self._shared, context)

    @classmethod
    def _bind(cls) -> ctypes.CDLL:
        """Load the shared object and pass it ODE's addresses, once."""
        with _loading:
            if cls._library is None:
                cls._library = cls._load(library_path())
            return cls._library

    @staticmethod
    def _load(path: Path) -> ctypes.CDLL:
        library = ctypes.CDLL(str(path))
        library.gz_step_needs.restype = ctypes.POINTER(ctypes.c_char_p)
        library.gz_step_context_size.restype = ctypes.c_size_t
        library.gz_step_bind.argtypes = [c_void_p]
        library.gz_collide.argtypes = [c_void_p]
        library.gz_solve.argtypes = [c_void_p]
        library.gz_open.argtypes = [c_void_p]
        library.gz_close.argtypes, library.gz_close.restype = [c_void_p], None
        library.gz_read.argtypes = [c_void_p]
        library.gz_overlap.argtypes = [c_void_p, c_void_p, c_void_p]
        library.gz_overlap.restype = c_double
        library.gz_parts_size.restype = ctypes.c_size_t
        library.gz_set_state.argtypes = [c_void_p, ctypes.c_char_p, c_int64]
        library.gz_frames.argtypes = [c_int64, c_void_p, c_void_p, c_double, c_void_p]
        library.gz_place.argtypes, library.gz_place.restype = [c_void_p, c_void_p, c_int64, c_void_p], None
        for move in (library.gz_turn_bodies, library.gz_carry_bodies):
            move.argtypes, move.restype = [c_void_p, c_void_p, c_int64, c_void_p, ctypes.c_int], c_int64
        library.gz_read_body.argtypes, library.gz_read_body.restype = [c_void_p, c_int64], None
        library.gz_set_contacts.restype = None
        library.gz_set_contacts.argtypes = [c_void_p, ctypes.c_char_p, c_int64]
        sizes = library.gz_step_context_size(), library.gz_parts_size()
        if sizes != (ctypes.sizeof(StepContext), ctypes.sizeof(Parts)):
            raise LibraryError(f"{path} was built from other versions of its sources; install libgz again")
        check_sizes(library)
        names = []
        for name in library.gz_step_needs():
            if name is None:
                break
            names.append(name.decode())
        addresses = (c_void_p * len(names))(*(ode().address(name) for name in names))
        library.gz_step_bind(addresses)
        library.gz_use_blocks.argtypes = [c_void_p]
        library.gz_calls_made.argtypes, library.gz_calls_made.restype = [c_void_p], c_int64
        _bind_joints(library)
        library.gz_use_blocks((c_void_p * len(_ALLOCATORS))(*(ode().address(name) for name in _ALLOCATORS)))
        return library

    def step(self) -> int:
        """Both halves. Returns 1, 0 when ODE ran out of memory, or STEP_NEEDS_RECOVERY."""
        done: int = self._step()
        return done

    @property
    def calls_made(self) -> int:
        """How many of the calls into which ODE divides steps have memory."""
        return int(self._shared.gz_calls_made(self._address))

    def collide(self) -> None:
        """The first half: find contacts and make joints of them."""
        self._shared.gz_collide(self._address)

    def solve(self) -> int:
        """The second half: move everything, empty the contact group, copy all states out; returns what `step` does."""
        return int(self._shared.gz_solve(self._address))

    def contacts(self) -> NDArray[np.void]:
        """A copy of the contact points recorded in this step, as `CONTACT`; without forces until `solve`."""
        count = self._context.record_count
        if not count:
            return np.empty(0, dtype=CONTACT)
        records = (ctypes.c_char * (count * CONTACT.itemsize)).from_address(self._context.records)
        return np.frombuffer(bytearray(records), dtype=CONTACT)

    def set_contacts(self, contacts: bytes) -> None:
        """Replace the contact points recorded in the last step by others, as `CONTACT`."""
        self._shared.gz_set_contacts(self._address, contacts, len(contacts) // CONTACT.itemsize)

    def get_state(self, parts: Parts) -> bytes:
        """The memory of ODE that decides what comes next: bodies, joints, and the order of geoms."""
        where, buffer = ctypes.byref(parts), self._buffer
        size: int = self._get_state(where, buffer, self._size)
        if size > len(buffer):
            self._buffer, self._size = ctypes.create_string_buffer(size), c_int64(size)
            self._get_state(where, self._buffer, self._size)
            buffer = self._buffer
        return buffer.raw if size == len(buffer) else ctypes.string_at(buffer, size)

    def set_state(self, parts: Parts, state: bytes) -> bool:
        """Put it back; false, and nothing has changed, if a geom is not where the state has it."""
        return bool(self._shared.gz_set_state(ctypes.addressof(parts), state, len(state)))

    def read(self) -> None:
        """Copy all states out."""
        self._shared.gz_read(self._address)

    def frames(
        self, positions: NDArray[np.float64], turns: NDArray[np.float64], most: float
    ) -> NDArray[np.float64] | None:
        """Positions [m], shape (n, 3), and rotations, shape (n, 4), as rows of 7 whose rotations have the length 1.

        None if a coordinate is beyond +-`most` [m], or the length of a rotation far from 1.
        """
        positions, turns = (np.ascontiguousarray(array, dtype=np.float64) for array in (positions, turns))
        turns, frames = turns.reshape(len(positions), 4), np.empty((len(positions), 7))
        found = self._shared.gz_frames(len(frames), address_of(positions), address_of(turns), most, address_of(frames))
        return frames if found else None

    def place(self, geoms: Sequence[int], rows: Sequence[int], frames: NDArray[np.float64]) -> None:
        """Put geoms without bodies at such frames, each at that of a row."""
        count = len(geoms)
        self._shared.gz_place((c_void_p * count)(*geoms), (c_int64 * count)(*rows), count, address_of(frames))

    def read_body(self, row: int) -> None:
        """Copy the state of one body to its row."""
        self._shared.gz_read_body(self._address, row)

    def turn_bodies(
        self,
        tables: TableRecord,
        rows: Sequence[int],
        point: Iterable[float],
        rotation: Iterable[float],
        slide: Iterable[float],
        still: bool,
    ) -> int:
        """Turn bodies about a point [m] by a rotation, and slide them [m].

        Args:
            tables: where they are.
            rows: of them.
            still: whether they are at rest then.

        Returns:
            How many were moved: the pose of the next one is one that Python refuses, or needs a larger range.
        """
        motion = (*point, *_NO_TURN, 0.0, 0.0, 0.0, *rotation, *slide)
        return self._move(self._shared.gz_turn_bodies, tables, rows, motion, still)

    def carry_bodies(self, tables: TableRecord, rows: Sequence[int], before: GzPose, after: GzPose, still: bool) -> int:
        """Move bodies with a frame, from one global pose of it to another [m]; the rest is as of `turn_bodies`."""
        motion = (*before.pos, *before.rot, *after.pos, *after.rot, 0.0, 0.0, 0.0)
        return self._move(self._shared.gz_carry_bodies, tables, rows, motion, still)

    @staticmethod
    def _move(function: Any, tables: TableRecord, rows: Sequence[int], motion: Sequence[float], still: bool) -> int:
        count = len(rows)
        return int(function(ctypes.byref(tables), (c_int64 * count)(*rows), count, (c_double * 17)(*motion), still))

    def publish(self, publication: Publication) -> None:
        """Copy header and states to a mapped file, with its counter odd meanwhile; the tables stay as they are."""
        self._publish(ctypes.byref(publication))

    def overlap(self, geom1: int, geom2: int) -> float:
        """The depth of the deepest contact point of two geoms [m], whatever their bodies; -1 without any."""
        return float(self._shared.gz_overlap(self._address, geom1, geom2))

    def updates(self) -> tuple[Callable[..., int], Callable[[JobRecord], Callable[[], object]]]:
        """The function that does rows, see `libgz.base.records`; and one that prepares a call for a job of them."""
        run, work = self._shared["gz_updates_run"], self._shared["gz_updates_work"]
        run.argtypes, run.restype, work.restype = [c_void_p, c_int64, c_int64], c_int64, None

        def prepare(job: JobRecord) -> Callable[[], object]:
            return functools.partial(work, ctypes.byref(job))

        return run, prepare

    def interrupter(self, wanted: c_int64) -> Callable[[], object]:
        """A function that sets the number to 1 for which steps end, and wakes what waits for the next one."""
        return functools.partial(self._shared["gz_interrupt"], ctypes.byref(wanted))

    def scanner(self, scan: RayScan) -> Callable[[], object]:
        """A prepared scan that can be run again and again, see gz_scan in rays.c; it keeps the arrays alive."""
        frame, rays, ranges, rows = (
            array.ctypes.data_as(c_void_p) for array in (scan.frame, scan.rays, scan.ranges, scan.rows)
        )
        count, owner = c_int64(len(scan.rays)), c_int64(scan.owner)
        return functools.partial(self._scan, c_void_p(self._address), frame, rays, count, owner, ranges, rows)


def address_of(array: NDArray[Any]) -> int:
    """Where the numbers of a contiguous array are: `ctypes.data` takes three times as long."""
    if array.size and array.flags.writeable:
        return ctypes.addressof(ctypes.c_char.from_buffer(array.data))
    return int(array.ctypes.data)


def _bind_joints(library: ctypes.CDLL) -> None:
    """Pass it the functions by which ODE's joints count and write their rows, as far as this ODE exports them."""
    counting, writing = (c_void_p * len(_JOINTS))(), (c_void_p * len(_JOINTS))()
    for number, name in enumerate(_JOINTS):
        scope = f"_ZN{len(name) + 7}dxJoint{name}8getInfo"
        with contextlib.suppress(AttributeError):
            if name:
                counting[number] = ode().address(f"{scope}1EPN7dxJoint5Info1E")
                writing[number] = ode().address(f"{scope}2EddiPdS0_iS0_S0_Pi")
    library.gz_tree_bind(counting, writing, ctypes.c_size_t(len(_JOINTS)))


def _release(library: ctypes.CDLL, context: StepContext) -> None:
    """Free the memory of the step."""
    library.gz_close(ctypes.addressof(context))
