"""The reference of the benchmarks: a world as reference.c steps it, a plain C program with the same calls of ODE."""

from __future__ import annotations

import ctypes
import math
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

import libgz
from libgz.base.law import Operation
from libgz.base.records import CastRecord, Kind, LawRecord, LinkRecord, OperationRecord, RateRecord
from libgz.ode.lib import ode
from libgz.physics.engine import Engine
from libgz.physics.geom import Geom

__all__ = ["Reference", "Spent", "scene_of"]

SOURCE = Path(__file__).with_name("reference.c")
HINGE, SLIDER = 2, 3
SURFACE = slice(0, 4)  # columns of stiffness, damping, friction and bounce
STOPS, MOTOR = (libgz.dParamLoStop, libgz.dParamHiStop), (libgz.dParamVel, libgz.dParamFMax)
WRITTEN = {
    "d": "d",
    "f": "i",
    "i": "i",
    "I": "i",
}  # type of a field -> what reference.c writes there


class Spent(NamedTuple):
    """Real time and processor time of one step [s]."""

    wall: float
    cpu: float


# The scene -------------------------------------------------------------------------------------------------------


def scene_of(world: libgz.World, *, sensors: bool = True) -> str:
    """A world as it is now, for reference.c.

    Args:
        world: of geoms, joints and sensors that reference.c knows.
        sensors: whether its rays, and what it writes to interfaces, are part of it.
    """
    world.engine.sort_geoms()
    return "\n".join([*_engine(world.engine), *_rows(world, sensors), "end\n"])


def _numbers(*values: ArrayLike) -> str:
    return " ".join(repr(float(number)) for value in values for number in np.asarray(value, dtype=float).ravel())


def _shape(geom: Geom) -> tuple[str, tuple[float, ...]]:
    """Its kind and dimensions."""
    if isinstance(geom, libgz.PlaneGeom):
        return "plane", (*geom.normal, geom.altitude)
    if isinstance(geom, libgz.BoxGeom):
        return "box", (*geom.size, 0.0)
    if isinstance(geom, libgz.SphereGeom):
        return "sphere", (geom.radius, 0.0, 0.0, 0.0)
    if isinstance(geom, libgz.CylinderGeom):
        return "cylinder", (geom.radius, geom.length, 0.0, 0.0)
    raise SystemExit(f"reference.c has no {type(geom).__name__}")


def _engine(engine: Engine) -> Iterator[str]:
    lib, mass, bodies = ode(), (ctypes.c_double * 17)(), list(engine.bodies.values())
    places = {body: place for place, body in enumerate(bodies)}
    spaces = list(engine.spaces)
    yield f"world {_numbers(engine.step_time, engine.gravity)}"
    yield from ("space" for _ in spaces)
    for body in bodies:
        lib.dBodyGetMass(body.id, ctypes.addressof(mass))
        pose, switches = body.GetCoMPose(), (body.GetGravityMode(), lib.dBodyGetFiniteRotationMode(body.id))
        velocities = body.GetLinearVel(), body.GetAngularRate()
        yield f"body {_numbers(pose.pos, pose.rot, *velocities, mass[0], mass[5:])} {switches[0]} {switches[1]}"
    for row, geom in engine.geoms.items():
        if geom.id and geom.space in engine.spaces:
            kind, dimensions = _shape(geom)
            pose = geom.GetPose() if geom.body.dummy else geom.GetRelativePose()
            place = [p - c for p, c in zip(pose.pos, geom.body.com, strict=True)]
            numbers = _numbers(dimensions, place, geom._turned(pose.rot), engine.tables.geoms.surface[row, SURFACE])
            yield f"geom {kind} {spaces.index(geom.space)} {places.get(geom.body, -1)} {numbers}"
    for joint in engine.attached:
        one, two = (places.get(body, -1) for body in joint.bodies)
        yield f"joint {int(joint.kind)} {one} {two} {_numbers(joint.GetAnchor(), *_axis(joint))} {_parameters(joint)}"


def _axis(joint: Any) -> tuple[Any, float]:
    """The axis, and where it is now: reference.c counts from there."""
    if joint.kind == HINGE:
        return joint.GetAxis(), joint.GetAngle()
    if joint.kind == SLIDER:
        return joint.GetSliderAxis(), joint.GetSliderPos()
    return (0.0, 0.0, 1.0), 0.0


def _parameters(joint: Any) -> str:
    if joint.kind not in (HINGE, SLIDER):
        return "0"
    _, at = _axis(joint)
    found = [(number, joint.GetParam(number) - at) for number in STOPS if math.isfinite(joint.GetParam(number))]
    found += [(number, joint.GetParam(number)) for number in MOTOR]
    return f"{len(found)} " + " ".join(f"{int(number)} {float(value)!r}" for number, value in found)


# What is done beside physics --------------------------------------------------------------------------------------


def _rows(world: libgz.World, sensors: bool) -> Iterator[str]:
    """The rows of a step: sensors and servos, and what is written to interfaces."""
    handles = {body.id: place for place, body in enumerate(world.engine.bodies.values())}
    joints = {joint.id: (place, joint) for place, joint in enumerate(world.engine.attached)}
    end, inside = 0, False
    for model in world.models:
        for target, servo in zip(getattr(model, "targets", ()), getattr(model, "servos", ()), strict=True):
            place, joint = joints[servo.axis.joint.id]
            yield f"servo {place} {_numbers(target, servo.gain, servo.damping, joint.GetAngle())}"
    for place, row in enumerate(world.rows._rows):
        if inside and place >= end:
            yield "due 0"
            inside = False
        if row.kind == Kind.DUE:
            period = RateRecord.from_address(row.part).period
            yield f"due {max(1, round(period / world.engine.step_time))}"
            end, inside = row.jump, True
        elif row.kind == Kind.ADVANCE:
            yield "advance"
        elif sensors and row.kind == Kind.CAST:
            cast = CastRecord.from_address(row.part)
            rays = (ctypes.c_double * (7 * cast.count)).from_address(cast.rays)
            yield f"cast {handles[cast.handle]} {cast.count} {_numbers(rays)}"
        elif sensors and row.kind == Kind.LAW and (law := LawRecord.from_address(row.part)).link:
            yield _written(law)
        elif sensors and row.kind == Kind.POST:
            yield "post"


def _written(law: LawRecord) -> str:
    """What a law writes to an interface under its lock, as zeros: the program does none of the arithmetic."""
    link = LinkRecord.from_address(law.link)
    operations = (OperationRecord * law.count).from_address(law.operations)
    stores = [(one, chr(one.type)) for one in operations if one.code == Operation.STORE and chr(one.type) in WRITTEN]
    words = [f"write {max(link.size, 8)} {int(link.descriptor >= 0)} {len(stores)}"]
    words += [f"{WRITTEN[kind]} {one.two or 0} {one.count} {one.strides[1]} 0.0" for one, kind in stores]
    return " ".join(words)


# The program -----------------------------------------------------------------------------------------------------


class Reference:
    """A process of reference.c with a scene. As a context manager, it ends the process.

    Args:
        scene: of `scene_of`.

    Attributes:
        position: of its first body after the last run [m].
    """

    _folder: tempfile.TemporaryDirectory[str] | None = None

    def __init__(self, scene: str) -> None:
        self._process = subprocess.Popen([self._built()], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.position: tuple[float, ...] = ()
        self._send(scene)

    @classmethod
    def _built(cls) -> str:
        """The compiled program."""
        if cls._folder is None:
            compiler = shutil.which("cc") or shutil.which("gcc")
            if compiler is None:
                raise SystemExit("no C compiler here: the reference cannot be built")
            cls._folder = tempfile.TemporaryDirectory(prefix="reference")
            library = ode().path if "/" in ode().path else f"-l:{ode().path}"
            command = [compiler, "-O2", str(SOURCE), "-o", f"{cls._folder.name}/reference", library, "-lm"]
            subprocess.run(command, check=True)
        return f"{cls._folder.name}/reference"

    def _send(self, text: str) -> None:
        if self._process.stdin is None:
            raise SystemExit("the reference has no input")
        self._process.stdin.write(text)
        self._process.stdin.flush()

    def run(self, steps: int) -> Spent:
        """Run steps; the time of each."""
        self._send(f"{steps}\n")
        line = self._process.stdout.readline() if self._process.stdout else ""
        if not line:
            raise SystemExit(f"the reference ended with {self._process.wait()}")
        wall, cpu, *position = map(float, line.split())
        self.position = tuple(position)
        return Spent(wall / steps, cpu / steps)

    def close(self) -> None:
        """End the process."""
        self._process.communicate()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
