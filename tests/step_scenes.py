"""Scenes whose motion is recorded: `python tests/step_scenes.py` writes tests/ode/recorded.json anew.

A key names what the last bits depend on: ODE's version, the machine and the variants of libm's functions. Under a known
key a scene must repeat its digest; everywhere its first steps must come near the recorded values.
"""

from __future__ import annotations

import ctypes
import hashlib
import json
import math
import platform
import re
import tempfile
from pathlib import Path

import numpy as np
from engine_parts import box, busy_world, cylinder, dressed_box, dressed_ground, ground, solid, use_classic
from sdf_worlds import GROUND, Loader, collision, friction, inertial, joint, link, model, two_links, world

import libgz
from libgz.base.files import installed_worlds
from libgz.ode.lib import ode
from libgz.ode.types import dParamFMax, dParamHiStop, dParamLoStop, dParamVel
from libgz.physics.engine import Engine
from libgz.physics.space import Space

RECORDED = Path(__file__).with_name("ode") / "recorded.json"
EARLY = 10  # steps after which values are compared; later ones of tumbling bodies depend on the last bits
TOLERANCE = 1e-6  # [m], [m/s], [rad/s]


def key():
    """What the last bits of a motion depend on; glibc chooses variants of its functions by the processor."""
    libm = ctypes.CDLL("libm.so.6")
    values = []
    for name in ("sin", "cos", "tan", "acos", "asin", "atan", "exp", "log", "sqrt"):
        function = getattr(libm, name)
        function.argtypes, function.restype = [ctypes.c_double], ctypes.c_double
        values += [function(x) for x in np.linspace(0.001, 0.999, 111).tolist()]
    libm.atan2.argtypes, libm.atan2.restype = [ctypes.c_double] * 2, ctypes.c_double
    values += [libm.atan2(math.sin(x), x) for x in np.linspace(-3, 3, 111).tolist()]
    probe = hashlib.sha256(np.array(values).tobytes()).hexdigest()[:16]
    assert ode().path  # which loads it
    [path] = set(re.findall(r"/\S*/libode\S*", Path("/proc/self/maps").read_text()))
    library = hashlib.sha256(Path(path).read_bytes()).hexdigest()[:16]
    return f"{Path(path).name} {library}, {platform.machine()}, libm {probe}"


def moved(engine, step, steps):
    """States after the first steps, and a digest of states, joints, contacts and rays after all."""
    engine.record_contacts = True
    digest, early = hashlib.sha256(), None
    for i in range(steps):
        step()
        if i + 1 == EARLY:
            early = engine.states.copy()
        if i % 10 == 9:
            digest.update(engine.states.tobytes())
            digest.update(engine.contacts.tobytes())
            digest.update(engine.tables.bodies.motion.tobytes() if engine.record_motion else b"")
    for one in engine.joints.values():
        digest.update(repr(one.GetAngle() if hasattr(one, "GetAngle") else None).encode())
    angles = [math.tau * i / 60 for i in range(60)]  # numpy's sines differ from processor to processor
    rays = np.array([(0, 0, 0, math.cos(angle), math.sin(angle), -0.2, 20.0) for angle in angles])
    rays[:, 3:6] /= np.linalg.norm(rays[:, 3:6], axis=1)[:, None]
    ranges, rows = np.empty(60), np.empty(60, dtype=np.int64)
    engine.scan(np.array([-2.0, 0.1, 1.0, 1, 0, 0, 0]), rays, 0, ranges, rows)
    digest.update(ranges.tobytes() + rows.tobytes())
    return early, digest.hexdigest()[:32]


MOTOR = {dParamLoStop: -0.5, dParamHiStop: 0.5, dParamVel: 1.0, dParamFMax: 2.0}


# Scenes of an engine ---------------------------------------------------------------------------------------------


def pile(solver):
    def run(_):
        engine = busy_world()
        engine.solver = solver
        return moved(engine, engine.step, 400)

    return run


def classic_pile(cone):
    def run(_):
        engine = Engine(step_time=0.001, solver="quick", seed=3)
        use_classic(engine)
        engine.cone = cone
        dressed_ground(engine, mu=0.8, BOUNCE=0.3, BOUNCE_VEL=0.1)
        for i in range(6):
            spin = {
                "fdir1": (1, 0.3, 0) if i % 2 else (0, 0, 0),
                "SLIP1": 0.01 * i,
                "MIN_DEPTH": 1e-4 * i,
                "BOUNCE": 0.1 * i,
                "BOUNCE_VEL": 0.1,
            }
            place = (0.4 * i, 0.1 * i, 0.6 + 1.1 * i)
            geom = dressed_box(engine, place, mu=0.2 * i, mu2=0.5, MAX_CONTACTS=4 + i, **spin)
            geom.body.SetAngularVel((i, 1, 0))
        return moved(engine, engine.step, 1500)

    return run


def tracks(_):
    engine = Engine(step_time=0.001, solver="quick", seed=3)
    use_classic(engine)
    dressed_ground(engine, mu=0.8, fdir1=(0, 1, 0), TRACK=1, TRACK_SPEED=0.1)
    for i in range(4):
        speed = {"fdir1": (0.1 * i, 1, 0), "TRACK": i % 3, "TRACK_SPEED": 0.2 * i, "PIVOT": 0.3}
        geom = dressed_box(engine, (0.3 * i, 1.2 * i, 0.6 + 1.1 * i), mu=0.9, mu2=0.3, **speed)
        geom.body.SetAngularVel((i, 1, 0))
    return moved(engine, engine.step, 1500)


def crowd(_):
    """Solids with limits, torsion, ghosts and cylinders among them, and records of motion."""
    engine = Engine(step_time=0.001, solver="quick", seed=3)
    use_classic(engine)
    engine.cone = engine.record_motion = True
    dressed_ground(engine, mu=0.8, TORSION=0.5)
    for i in range(40):
        place = (0.4 * (i % 7), 0.3 * (i // 7), 0.6 + 1.1 * (i // 7))
        torsion = {"PATCH_RADIUS": 0.1 * (i % 3), "BY_PATCH": i % 2, "RADIUS": 0.5, "TORSION": 0.4}
        limits = {"MAX_CONTACTS": 3 + i % 5, "GHOST": i % 5 == 4, "MIN_DEPTH": 1e-4 * i, "MAX_VEL": 0.01 * (i % 4)}
        geom = dressed_box(engine, place, mu=0.1 * (i % 9), **limits, **torsion)
        geom.body.SetAngularVel((i, 1, 0))
    libgz.CylinderGeom(libgz.Body(engine, dummy=True), Space(engine), 0.3, 1.0).SetRelativePosition((0.5, 0.5, 0.5))
    libgz.CylinderGeom(libgz.Body(engine), Space(engine), 0.3, 1.0).SetRelativePosition((0.5, 0.5, 1.6))
    return moved(engine, engine.step, 120)


def relief(_):
    """Solids on a height field and on a mesh."""
    engine = Engine(step_time=0.005, solver="quick", seed=2)
    base, space = libgz.Body(engine, dummy=True), Space(engine)
    libgz.HeightfieldGeom(base, space, [[0, 1, 0, 0.5], [1, 2, 1, 0], [0, 0, 3, 0], [0.2, 0, 1, 0]], 4.0, 4.0)
    makers = (box(0.3, 0.2, 0.4), cylinder, lambda b, s: libgz.SphereGeom(b, s, 0.2))
    for i in range(9):
        solid(engine, makers[i % 3], position=(0.4 * (i % 3) - 0.5, 0.4 * (i // 3) - 0.5, 3.0 + 0.3 * i), friction=0.6)
    return moved(engine, engine.step, 300)


def closing(_):
    """Bodies that are closed between contacts and motion."""
    engine = Engine(step_time=0.01)
    bodies = [solid(engine, box(0.3, 0.3, 0.3), position=(0.1 * i, 0, 0.25 * i)) for i in range(12)]
    libgz.BoxGeom(libgz.Body(engine, dummy=True), Space(engine), 9, 9, 0.2)
    count = iter(range(1000))

    def step():
        k = next(count)
        engine.collide()
        if k % 4 == 1 and len(bodies) > 3:
            bodies.pop(k % len(bodies)).close()
        engine.solve()

    return moved(engine, step, 60)


def joints(solver):
    """All joints of an engine, with stops, motors and springs."""

    def run(_):
        engine = Engine(step_time=0.005, solver=solver)
        ground(engine)
        kinds = (libgz.HingeJoint, libgz.SliderJoint, libgz.BallJoint, libgz.UniversalJoint, libgz.Hinge2Joint)
        for i, kind in enumerate(kinds):
            low, high = (solid(engine, box(0.3, 0.3, 0.3), position=(2 * i, 0, z)) for z in (1.0, 1.6))
            one = kind(engine)
            one.Attach(low, high)
            if kind is not libgz.SliderJoint:
                one.SetAnchor((2 * i, 0, 1.3))
            if kind in (libgz.HingeJoint, libgz.SliderJoint):
                one.SetAxis((0, 1, 0) if kind is libgz.HingeJoint else (0, 0, 1))
                for which, value in MOTOR.items():
                    one.SetParam(which, value)
                one.set_spring(20.0, 0.1, 0.3)
            elif kind is not libgz.BallJoint:
                one.SetAxes((0, 0, 1), (0, 1, 0))
            high.SetLinearVel((0.2, 0.1, 0))
        return moved(engine, engine.step, 400)

    return run


# Worlds in SDF ---------------------------------------------------------------------------------------------------


def sdf(*parts, steps=400, step=0.001, drive=None, **options):
    """A world of such parts."""

    def run(folder):
        loader = Loader(folder)
        physics = f"<max_step_size>{step}</max_step_size>"
        made = loader(world(*parts, physics=physics, **options))
        made.engine.seed = 1
        if drive is not None:
            drive(made)
        found = moved(made.engine, made.step, steps)
        loader.close()
        return found

    return run


def block(name, size, place, mass=1.0, surface="", turn="0 0 0"):
    x, y, z = size
    moments = tuple(mass / 12.0 * (a * a + b * b) for a, b in ((y, z), (x, z), (x, y)))
    geometry = f"<box><size>{x} {y} {z}</size></box>"
    where = " ".join(map(str, place)) + f" {turn}"
    awake = "<allow_auto_disable>0</allow_auto_disable>"
    return model(name, awake, link("link", inertial(mass, moments), collision(geometry, surface)), pose=where)


def stack(count, size=0.5):
    return "".join(block(f"b{i}", (size,) * 3, (0, 0, size / 2 + size * i)) for i in range(count))


def spin(*models):
    """Turn the joints of models."""

    def drive(made):
        for one in map(made.model, models):
            if one.sdf_joints["j"].dof in (1, 2):
                one.sdf_joints["j"].set_velocity(3.0)

    return drive


LIMIT = "<limit><lower>-0.4</lower><upper>0.6</upper><effort>3</effort></limit>"
DAMPED = f"{LIMIT}<dynamics><damping>.1</damping></dynamics>"
KINDS = {
    "revolute": joint("j", "revolute", "a", "b", "0 1 0", inside=DAMPED),
    "prismatic": joint("j", "prismatic", "a", "b", "0 0 1", inside=DAMPED),
    "ball": joint("j", "ball", "a", "b", ""),
    "fixed": joint("j", "fixed", "a", "b", ""),
    "screw": joint("j", "screw", "a", "b", "0 0 1", "<thread_pitch>8</thread_pitch>"),
    "universal": joint("j", "universal", "a", "b", "1 0 0", "<axis2><xyz>0 1 0</xyz></axis2>", pose="0.3 0.2 0 0 0 0"),
    "revolute2": joint("j", "revolute2", "a", "b", "0 0 1", "<axis2><xyz>0 1 0</xyz></axis2>"),
}


def of_kind(text):
    """A joint between two links that falls on the ground, and one between a link and the world."""
    shape = collision("<box><size>.3 .3 .3</size></box>")
    fall = model("m", link("a", inertial(2.0), shape), link("b", inertial(1.0), shape, pose="1 0 0 0 0 0"), text)
    fall = fall.replace("<pose>0 0 0 0 0 0</pose>", "<pose>0 0 0.5 0.2 0.1 0</pose>", 1)
    held = model("h", link("b", inertial(1.0), shape, pose="5 0 2 0 0 0"), text.replace("<parent>a<", "<parent>world<"))
    return sdf(GROUND, fall, held, drive=spin("m", "h"))


BOUNCY = "<friction><ode><mu>.5</mu><slip1>.01</slip1><fdir1>1 0 0</fdir1></ode></friction>"
TUMBLING = [
    model(f"b{i}", link("l", collision(shape, BOUNCY)), pose=f"{0.3 * i} 0 {1 + i} {0.1 * i} 0 0")
    for i, shape in enumerate(("box", "sphere", "cylinder", "box"))
]
LEANING = (
    block("slippery", (0.4, 0.4, 0.2), (0, 3, 0.101), surface=friction(0.01)),
    *(
        block(f"w{i}", (0.4, 0.2, 0.2), (3 + 0.42 * (i % 3) + 0.2 * (i // 3), 0, 0.1 + 0.2 * (i // 3)))
        for i in range(5)
    ),
    block("leaning", (0.3, 0.3, 0.3), (6, 0, 0.17), turn="0.1 0.05 0"),
)


def push(made):
    for one in list(made.engine.bodies.values()):
        one.SetLinearVel((0.09, 0, 0))


def legacy(name):
    """A world of the package; its robots stand, or drive as they are told in it."""

    def run(_):
        with libgz.World.from_file(installed_worlds() / f"{name}.world", seed=5) as made:
            return moved(made.engine, made.step, 100)

    return run


def driven(_):
    robot = "<model:Pioneer2AT><id>r</id></model:Pioneer2AT>"
    text = f"<gz:world xmlns:gz='g' xmlns:model='m'><model:GroundPlane/>{robot}</gz:world>"
    with libgz.World.from_string(text, seed=5) as made:
        made.interface("position", "r").command(vx=0.3, vyaw=0.4)
        return moved(made.engine, made.step, 300)


WORLDS = sorted(path.stem for path in installed_worlds().glob("*.world"))
SCENES = {
    "pile, world": pile("world"),
    "pile, quick": pile("quick"),
    "classic pile, pyramid": classic_pile(False),
    "classic pile, cone": classic_pile(True),
    "tracks": tracks,
    "crowd": crowd,
    "relief": relief,
    "closing": closing,
    "joints, world": joints("world"),
    "joints, quick": joints("quick"),
    "tumbling": sdf(GROUND, *TUMBLING, steps=1500),
    "resting stack": sdf(GROUND, stack(14, 0.3), step=0.02, steps=100),
    "leaning and resting": sdf(GROUND, *LEANING, stack(5), step=0.02, steps=100),
    "sliding to rest": sdf(GROUND, *LEANING, drive=push),
    "weightless": sdf(two_links(KINDS["revolute"]), gravity="0 0 0", drive=spin("m"), steps=1500),
    **{f"{kind} joint": of_kind(text) for kind, text in KINDS.items()},
    "driven": driven,
    **{f"{name}.world": legacy(name) for name in WORLDS},
}


def run_scene(name, folder):
    """Values after the first steps and the digest of all of a scene."""
    early, digest = SCENES[name](Path(folder))
    return np.nan_to_num(early[:8, [0, 1, 2, 10, 11, 12, 13, 14, 15]]).round(9).tolist(), digest


def main():
    known = json.loads(RECORDED.read_text())["digests"] if RECORDED.exists() else {}
    values, digests = {}, {}
    for name in SCENES:
        with tempfile.TemporaryDirectory() as folder:
            values[name], digests[name] = run_scene(name, folder)
    lines = [f"  {json.dumps(name)}: {json.dumps(rows)}" for name, rows in values.items()]
    known[key()] = digests
    shown = ",\n".join(lines)
    RECORDED.write_text(f'{{\n"values": {{\n{shown}\n}},\n"digests": {json.dumps(known, indent=1)}\n}}\n')


if __name__ == "__main__":
    main()
