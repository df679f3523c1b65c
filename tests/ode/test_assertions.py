"""ODE ends the process where an assertion fails: no argument from outside reaches one.

`assertions.tsv` has a row for each declared function: what ODE 0.16.2 asserts of its arguments besides handles of the
right class, the modules of libgz that call it ("native" is the C code of libgz/ode), and the check that stands before.
Handles are those that ODE returned to the object that owns them; a closed object raises ClosedError (test_closed.py).
"""

import contextlib
import math
import re
from pathlib import Path

import numpy as np
import pytest
from engine_parts import box, solid
from forked import note, run_trials

import libgz
from libgz.base.errors import GazeboError
from libgz.base.geometry import GzPose, GzQuatern, GzVector
from libgz.ode.prototypes import PROTOTYPES
from libgz.physics.couplings import LineJoint, PistonJoint, TieJoint
from libgz.physics.engine import Engine
from libgz.physics.geoms import HeightfieldGeom, PlaneGeom, RayGeom, TriMeshGeom
from libgz.physics.rays import RayProximity

ROOT = Path(__file__).parents[2]
ROWS = [line.split("\t") for line in (ROOT / "tests/ode/assertions.tsv").read_text().splitlines()[1:]]
CONDITIONS = {row[0]: row[1:] for row in ROWS if row[1] != "-"}
WORDS = re.compile(r"\bd[A-Z]\w+")
DECLARATIONS = ("libgz.ode.prototypes", "libgz.cxx.ode_header")
BY_PLUGINS = "compiled plugins alone call it: they are code"
NUMBERS = (0.0, -0.0, -1.0, 1.0, 1e-320, 1e-160, 1e9, 1e10, 1e155, 1e200, -1e308, 1e308, math.inf, -math.inf, math.nan)
VECTORS = [(n, 0.0, 0.0) for n in NUMBERS] + [(n, n, n) for n in NUMBERS] + [(1.0, n, -n) for n in NUMBERS]


def declared():
    return set(re.findall(r"^\w+ (\w+)\(", PROTOTYPES, re.MULTILINE))


def test_each_declared_function_has_one_row():
    assert sorted(row[0] for row in ROWS) == sorted(declared())


def test_functions_with_conditions_are_called_where_their_rows_say():
    callers = {name: set() for name in CONDITIONS}
    for path in [*ROOT.glob("libgz/**/*.py"), *ROOT.glob("models/*.py"), *ROOT.glob("libgz/ode/*.c")]:
        module = ".".join(path.relative_to(ROOT).with_suffix("").parts)
        if module in DECLARATIONS:
            continue
        for name in set(WORDS.findall(path.read_text())) & set(CONDITIONS):
            callers[name].add("native" if path.suffix == ".c" else module)
    listed = {name: set() if where == "-" else set(where.split()) for name, (_, where, _) in CONDITIONS.items()}
    assert callers == listed
    assert all(check == BY_PLUGINS for _, where, check in CONDITIONS.values() if where == "-")


def each(call, *choices):
    """Call with all combinations of a few choices; libgz's errors are what is allowed to come."""
    if not choices:
        with contextlib.suppress(GazeboError):
            call()
        return
    for choice in choices[0]:
        each(lambda *rest, first=choice: call(first, *rest), *choices[1:])


def two_bodies():
    engine = Engine()
    return engine, *(solid(engine, box(1, 1, 1), position=(2.0 * i, 0, 5)) for i in range(2))


def attack_steps():
    engine, *_ = two_bodies()
    each(lambda seconds: (setattr(engine, "step_time", seconds), engine.step()), NUMBERS)
    engine.step_time = 0.001
    each(lambda n: setattr(engine, "gravity", (0, 0, n)) or engine.step(), NUMBERS)
    each(lambda n: engine.set_quick_step(5, n), NUMBERS)
    each(lambda n: engine.set_constraints(n, n, n), NUMBERS)
    engine.step()


def attack_poses():
    engine, body, _ = two_bodies()
    each(lambda v: body.SetRotation((1.0, *v)), VECTORS)
    each(lambda v: body.SetRotation((0.0, *v)), VECTORS)
    each(lambda v: (body.SetPosition(v), engine.step()), VECTORS)
    for setter in (body.SetLinearVel, body.SetAngularVel):
        each(lambda v, setter=setter: (setter(v), engine.step()), VECTORS)
    each(lambda v: (body.SetForce(v), engine.step()), VECTORS)
    for setter in (body.SetTorque, body.AddForce, body.AddTorque, body.AddRelForce, body.AddRelTorque):
        each(lambda v, setter=setter: (setter(*v), engine.step()), VECTORS)
    body.SetFiniteRotationMode(1)
    each(lambda v: body.SetFiniteRotationAxis(*v), VECTORS)
    each(body.set_damping, NUMBERS, NUMBERS)
    engine.step()


def attack_masses():
    _, body, _ = two_bodies()
    pose = GzPose(GzVector(0, 0, 0), GzQuatern(1, 0, 0, 0))
    each(lambda n, v: body.SetMassMatrix(libgz.physics.mass.given_mass(n, (*v, 0, 0, 0), pose)), NUMBERS, VECTORS)
    each(
        lambda v: body.SetMassMatrix(
            libgz.physics.mass.given_mass(1.0, (1, 1, 1, 0, 0, 0), GzPose(GzVector(*v), GzQuatern(1, 0, 0, 0)))
        ),
        VECTORS,
    )
    for geom in body.geoms:
        each(geom.SetMass, NUMBERS)


def attack_shapes():
    engine, body, _ = two_bodies()
    space = body.geoms[0].space
    for kind, count in ((libgz.BoxGeom, 3), (libgz.SphereGeom, 1), (libgz.CylinderGeom, 2), (libgz.CapsuleGeom, 2)):
        each(lambda v, kind=kind, count=count: kind(body, space, *v[:count]).close(), VECTORS)
    ball, tube = libgz.SphereGeom(body, space, 1), libgz.CylinderGeom(body, space, 1, 1)
    each(ball.resize, NUMBERS)
    each(tube.resize, NUMBERS, NUMBERS)
    each(lambda v: body.geoms[0].resize(*v), VECTORS)
    each(lambda n, v: PlaneGeom(body, space, n, v).close(), NUMBERS, VECTORS)
    each(lambda v: ball.SetRelativePose(GzPose(GzVector(*v), GzQuatern(1, 0, 0, 0))), VECTORS)
    each(lambda v: ball.SetRelativePose(GzPose(GzVector(0, 0, 0), GzQuatern(0, *v))), VECTORS)
    engine.step()


def attack_surfaces_of_triangles_and_heights():
    engine, body, _ = two_bodies()
    space = body.geoms[0].space
    each(lambda v: TriMeshGeom(body, space, [(0, 0, 0), (1, 0, 0), v], [(0, 1, 2)]), VECTORS)
    each(lambda n: TriMeshGeom(body, space, np.zeros((4, 3)), [(0, 1, n)]), (-1, 4, 2**31, 2**40))
    each(lambda n, h: HeightfieldGeom(body, space, [[0, h], [0, 0]], n, 1.0, n), NUMBERS, NUMBERS)
    each(lambda shape: HeightfieldGeom(body, space, np.zeros(shape), 1, 1), [(1, 2), (2, 1), (0, 0), (2,)])
    engine.step()


def attack_rays():
    engine, body, _ = two_bodies()
    bundle, ray = RayProximity(engine_of(engine), body, 1), RayGeom(body)
    each(lambda a, b: (bundle.SetRay(0, a, b), bundle.Update()), VECTORS, VECTORS)
    each(lambda a, b: (ray.Set(a, b), ray.Cast()), VECTORS, VECTORS)
    each(lambda n: (ray.SetLength(n), ray.Cast()), NUMBERS)
    for direction in VECTORS:
        rays = np.array([[0.0, 0.0, 0.0, *direction, 1.0]])
        engine.scan(np.array([0, 0, 0, 1.0, 0, 0, 0]), rays, 0, np.empty(1), np.empty(1, dtype=np.int64))
        engine.scan(np.array([*direction, 1.0, 0, 0, 0]), np.ones((1, 7)), 0, np.empty(1), np.empty(1, dtype=np.int64))


def attack_places():
    engine, *_ = two_bodies()
    each(engine.geoms_near, VECTORS, VECTORS)


class engine_of:
    """What has an engine, as a World has."""

    def __init__(self, engine):
        self.engine = engine


def attack_joints():
    for kind in (
        *(libgz.HingeJoint, libgz.SliderJoint, libgz.BallJoint, libgz.UniversalJoint, libgz.Hinge2Joint),
        *(libgz.FixedJoint, PistonJoint, LineJoint, TieJoint),
    ):
        engine, one, two = two_bodies()
        other = solid(Engine(), box(1, 1, 1))
        dummy = libgz.Body(engine, "dummy", dummy=True)
        joint = kind(engine)
        note(kind.__name__)
        attack_joint(joint)
        choices = (None, one, two, dummy, other)
        for first in choices:
            for second in choices:
                each(joint.Attach, [first], [second])
                attack_joint(joint)
                engine.step()
        one.close()
        attack_joint(joint)
        engine.step()


def attack_joint(joint):
    for name in ("SetAxis", "SetAxis1", "SetAxis2", "SetAnchor"):
        if hasattr(joint, name):
            each(lambda v, name=name: getattr(joint, name)(v), VECTORS[::3])
    if hasattr(joint, "SetAxes"):
        each(joint.SetAxes, VECTORS[::7], VECTORS[::5])
    each(joint.SetParam, (*range(-1, 20), *range(256, 276), 512, 1 << 40), (0.0, math.inf, -math.inf, math.nan, 1e308))
    each(joint.GetParam, (*range(-1, 20), *range(256, 276), 512, 1 << 40))
    if hasattr(joint, "SetAxis2"):
        each(lambda n: joint.SetTorque(n, n), NUMBERS)
    elif hasattr(joint, "SetTorque"):
        each(joint.SetTorque, NUMBERS)
    elif hasattr(joint, "SetSliderForce"):
        each(joint.SetSliderForce, NUMBERS)
    if isinstance(joint, LineJoint):
        each(lambda n: joint.place(GzVector(0, 0, 0), GzVector(1, 0, 0), n), NUMBERS)
    for name in ("GetAxis", "GetAxis1", "GetAxis2", "GetAnchor", "GetAnchor2", "GetAngle", "reset_turns"):
        if hasattr(joint, name):
            each(getattr(joint, name))


ATTACKS = [value for name, value in sorted(globals().items()) if name.startswith("attack_") and name != "attack_joint"]


@pytest.mark.parametrize("attack", ATTACKS, ids=lambda attack: attack.__name__)
def test_no_argument_ends_the_process(attack):
    def trial(_number):
        attack()
        return ""

    assert list(run_trials(trial, range(1), 1)) == []
