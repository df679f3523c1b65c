"""Runs of legacy worlds that show whether a state is all there is: traces of all states and interface bytes.

As a program, it runs a world on from a state, in a process of its own, and prints the digest of the trace.

python state_runs.py WORLD STATE STEPS SEED
"""

from __future__ import annotations

import hashlib
import random
import sys
from pathlib import Path

import numpy as np

import libgz

PERIOD = 20  # steps between commands


def command(world, rng):
    """Command everything that takes commands, some of it wrongly."""
    for (kind, _), interface in sorted(world.gz_server.interfaces.items()):
        data = interface.data
        if kind == "position":
            interface.command(vx=rng.uniform(-0.4, 0.6), vyaw=rng.uniform(-0.6, 0.6))
            data.cmd_enable_motors = rng.random() < 0.9
        elif kind == "gripper":
            interface.command(rng.randrange(1, 9))
        elif kind == "ptz":
            interface.command(pan=rng.uniform(-1.0, 1.0), tilt=rng.uniform(-0.4, 0.4), zoom=rng.uniform(0.3, 1.0))
        elif kind == "joint":
            for joint in data.joints[: data.joint_count]:
                joint.cmd_angle, joint.cmd_angle2 = rng.uniform(-0.5, 0.5), rng.uniform(-0.2, 0.2)
        elif kind == "laser" and rng.random() < 0.3:
            data.cmd_min_angle, data.cmd_max_angle = -rng.uniform(0.5, 1.5), rng.uniform(0.5, 1.5)
            data.cmd_max_range, data.cmd_range_count = rng.uniform(4.0, 8.0), rng.randrange(20, 181)
            data.cmd_new_angle = data.cmd_new_length = 1
        elif kind == "guicam":
            data.display_rays = rng.random() < 0.5
            data.cmd_spot_state, data.cmd_spot_mode = rng.randrange(2), rng.randrange(3)
            data.cmd_spot_a[:], data.cmd_spot_b[:] = (10.0, 10.0), (rng.uniform(5, 15), rng.uniform(5, 15))
        elif kind == "truth" and rng.random() < 0.1:
            x, y = rng.uniform(-2, 2), rng.uniform(-2, 2)
            data.cmd_pos[:], data.cmd_rot[:], data.cmd_new = (x, y, 0.5), (1.0, 0.0, 0.0, 0.0), 1


def look(world):
    """Everything that can be seen of a world, as bytes by name: states, joints, clock, all bytes of interfaces."""
    engine = world.engine
    clock = (world.GetSimTime(), world.GetPauseTime(), world.iterations)
    found = {"clock": repr(clock).encode(), "models": repr([entity.GetId() for entity in world.entities]).encode()}
    found["states"] = b"".join(np.ascontiguousarray(engine.states[row]).tobytes() for row in engine.bodies)
    found["joints"] = b"".join(engine.tables.joints.state[row].tobytes() for row in engine.joints)
    for (kind, name), interface in sorted(world.gz_server.interfaces.items()):
        found[f"{kind}.{name}"] = interface.get_bytes()  # without real time
    return found


def run(world, steps, seed):
    """Step with commands; what is seen after each step, as short digests by name."""
    rng, trace = random.Random(seed), []
    for step in range(steps):
        if step % PERIOD == 0:
            command(world, rng)
        world.Step()
        trace.append({name: hashlib.blake2b(data, digest_size=8).hexdigest() for name, data in look(world).items()})
    return trace


def difference(one, other):
    """Where two traces differ first, or None."""
    for step, (a, b) in enumerate(zip(one, other, strict=True)):
        if a != b:
            names = sorted(name for name in a.keys() | b.keys() if a.get(name) != b.get(name))
            return f"step {step}: {', '.join(names[:6])}"
    return None


def digest(trace):
    """One digest of a trace."""
    return hashlib.blake2b(repr(trace).encode()).hexdigest()


def main(world, state, steps, seed):
    """Continue from a state, and print the digest."""
    with libgz.World.from_file(world) as found:
        found.set_state(Path(state).read_bytes())
        print(digest(run(found, int(steps), int(seed))))


if __name__ == "__main__":
    main(*sys.argv[1:])
