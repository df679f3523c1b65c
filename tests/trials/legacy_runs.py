"""Runs of worlds for trials; as a program, one run in a process of its own, whose figures it prints as JSON.

python legacy_runs.py long HOURS SEED         ten robots with lasers, and a camera
python legacy_runs.py digest WORLD STEPS SEED   a digest of all states
python legacy_runs.py loads COUNT SEED        loads and closes
python legacy_runs.py inserts COUNT SEED      inserts and deletes
python legacy_runs.py sdf COUNT SEED          inserts and deletes in a world of Gazebo classic
"""

from __future__ import annotations

import ctypes
import functools
import gc
import hashlib
import json
import logging
import os
import random
import statistics
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import libgz
from libgz.base.files import installed_worlds

HEAD = "<gz:world xmlns:gz='g' xmlns:model='m' xmlns:param='p'><model:GroundPlane/>"
STEP, HOUR = 0.02, 3600.0  # [s]
MINUTE = 3000  # steps
STABLE = ("position", "power", "sonar", "laser", "fiducial", "gripper", "truth", "ptz", "actarray", "joint", "gps")
BASES = {"Pioneer2AT": (0.0, "0.1 0 0.311"), "Pioneer2DX": (0.24, "0.1 0 0.01")}  # height; place of a laser


def resident() -> int:
    """Resident memory of this process [bytes]."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def descriptors() -> int:
    """How many files this process has open."""
    return len(list(Path("/proc/self/fd").iterdir()))


def growth(samples: list[int], warm: int) -> float:
    """Growth of memory after the first `warm` samples, as a share."""
    return max(samples[warm:]) / samples[warm] - 1.0


def trend(samples: list[int], warm: int) -> float:
    """Growth of memory from the first to the last third of the samples after the first `warm`, as a share.

    Medians, for the memory that an allocator keeps free goes up and down by some MB.
    """
    kept = samples[warm:]
    third = max(1, len(kept) // 3)
    return statistics.median(kept[-third:]) / statistics.median(kept[:third]) - 1.0


def command(world: libgz.World, rng: random.Random) -> None:
    """Command every robot of a world to do something else."""
    for (kind, _), interface in sorted(world.gz_server.interfaces.items()):
        if kind == "position":
            interface.command(vx=rng.uniform(-0.4, 0.6), vyaw=rng.uniform(-0.6, 0.6))
        elif kind == "gripper":
            interface.command(rng.randrange(1, 9))
        elif kind == "ptz":
            interface.command(pan=rng.uniform(-1.0, 1.0), tilt=rng.uniform(-0.4, 0.4))


# Long run --------------------------------------------------------------------------------------------------------


def ten_robots(rng: random.Random) -> str:
    """A world of ten robots with lasers, some solids, and a camera."""
    text = HEAD
    for i in range(10):
        base = list(BASES)[i % 2]
        z, mount = BASES[base]
        laser = f"<model:SickLMS200><id>laser{i}</id><xyz>{mount}</xyz></model:SickLMS200>"
        eye = "<model:MonoCam><id>eye</id><xyz>0 0 0.4</xyz><imageSize>64 48</imageSize><updateRate>1</updateRate>"
        text += f"<model:{base}><id>r{i}</id><xyz>{3 * (i % 5)} {3 * (i // 5)} {z}</xyz>"
        text += f"<rpy>0 0 {rng.uniform(0, 360):.1f}</rpy>{laser}{'' if i else eye + '</model:MonoCam>'}</model:{base}>"
        text += f"<model:SimpleSolid><xyz>{3 * (i % 5) + 1.5} {3 * (i // 5)} 0</xyz><mass>30</mass></model:SimpleSolid>"
    return text + "</gz:world>"


def long_run(hours: float, seed: int) -> dict[str, object]:
    """Simulate hours with ten robots; figures of memory and ticks."""
    rng = random.Random(seed)
    steps = round(hours * HOUR / STEP)
    slices = max(24, round(hours))  # of which memory is measured
    ticks: dict[str, int] = {}

    def count(name: str, owner: object, method: str) -> None:
        original = getattr(owner, method)
        ticks[name] = 0

        def counted(*arguments: object) -> object:
            ticks[name] += 1
            return original(*arguments)

        setattr(owner, method, counted)

    with libgz.World.from_string(ten_robots(rng)) as world:
        for i in range(10):
            count(f"r{i}", world.model(f"r{i}").position, "exchange")
            count(f"laser{i}", world.model(f"laser{i}").rays, "Update")
        count("eye", world.model("eye").camera.eye, "Start")
        memory, done = [], 0
        for k in range(slices):
            target = steps * (k + 1) // slices
            while done < target:
                some = min(MINUTE - done % MINUTE, target - done)
                world.step(some)
                done += some
                if done % MINUTE == 0:
                    command(world, rng)
            memory.append(resident())
        sim_time, iterations = world.GetSimTime(), world.iterations
        stopped = [i for i in range(10) if world.interface("laser", f"laser{i}").data.time < sim_time - 0.2]
    warm = min(slices // 3, max(1, round(slices / hours)))  # the first hour, or a third of a shorter run
    return {
        "steps": steps, "iterations": iterations, "sim_time": sim_time, "ticks": ticks, "stopped": stopped,
        "growth": growth(memory, warm), "resident": memory[-1],
    }  # fmt: skip


# Digests ---------------------------------------------------------------------------------------------------------


def digest(path: Path, steps: int, seed: int) -> str:
    """A digest of the states and interfaces of a world, under random commands, every ten steps."""
    rng, found = random.Random(seed), hashlib.sha256()
    with libgz.World.from_file(path, seed=seed) as world:
        for _ in range(steps // 10):
            if rng.random() < 0.1:
                command(world, rng)
            world.step(10)
            found.update(world.engine.states.tobytes())
            for (kind, _), interface in sorted(world.gz_server.interfaces.items()):
                if kind in STABLE:
                    data = interface.data
                    found.update(bytes(data)[ctypes.sizeof(type(data.head)) :])
    return found.hexdigest()


# Loads, inserts --------------------------------------------------------------------------------------------------


def loads(count: int, seed: int) -> dict[str, object]:
    """Load, step and close legacy worlds that are installed with libgz, served and unserved."""
    rng = random.Random(seed)
    worlds = sorted(path for path in installed_worlds().glob("*.world"))
    for served in (True, False):  # what is loaded once per process
        for path in worlds:
            load(path, rng, served)
    gc.collect()
    memory, files, threads = [], descriptors(), threading.active_count()
    for k in range(count):
        load(worlds[k % len(worlds)], rng, rng.random() < 0.5)
        if k % max(1, count // 20) == 0:
            gc.collect()
            memory.append(resident())
    memory.append(resident())
    return {
        "growth": trend(memory, len(memory) // 4), "files": descriptors() - files, "resident": memory[-1],
        "threads": threading.active_count() - threads,
    }  # fmt: skip


def load(path: Path, rng: random.Random, served: bool) -> None:
    """One load and close."""
    options = {"server_id": int(os.environ["TRIAL_SERVER"])} if served else {}
    with libgz.World.from_file(path, **options) as world:
        world.step(rng.randrange(4))


NewModel = Callable[[str, random.Random, str], str]  # name, random numbers, place -> XML
KINDS = (
    "SimpleSolid", "Pioneer2AT", "Pioneer2DX", "SickLMS200", "SegwayRMP", "GarminGPS", "TruthWidget", "SonyVID30",
    "Shrimp", "Roomba",
)  # fmt: skip


LEGACY = f"{HEAD}<model:Pioneer2AT><id>stays</id></model:Pioneer2AT></gz:world>"
SDF_SENSORS = (
    "<sensor name='s' type='imu'><always_on>1</always_on></sensor>",
    "<sensor name='s' type='ray'><always_on>1</always_on><ray><scan><horizontal><samples>30</samples><min_angle>-1"
    "</min_angle><max_angle>1</max_angle></horizontal></scan><range><min>0.1</min><max>8</max></range></ray></sensor>",
    "<sensor name='s' type='contact'><contact><collision>c</collision></contact></sensor>",
    "",
)
SDF = """<sdf version='1.6'><world name='default'><model name='ground'><static>1</static><link name='l'>
    <collision name='c'><geometry><plane><normal>0 0 1</normal></plane></geometry></collision></link></model>
    </world></sdf>"""


def legacy_model(name: str, rng: random.Random, place: str) -> str:
    """A model of any kind."""
    kind = rng.choice(KINDS)
    laser = f"<model:SickLMS200><id>{name}laser</id><xyz>0 0 0.3</xyz></model:SickLMS200>"
    inside = laser if kind.startswith("Pioneer") else ""
    return f"<model:{kind}><id>{name}</id><xyz>{place}</xyz>{inside}</model:{kind}>"


def sdf_model(name: str, rng: random.Random, place: str) -> str:
    """Two links, a joint, and a sensor of any kind."""
    shape = "<geometry><box><size>0.3 0.3 0.3</size></box></geometry>"
    look = f"<collision name='c'>{shape}</collision><visual name='v'>{shape}</visual>"
    return f"""<sdf version='1.6'><model name='{name}'><pose>{place} 0 0 0</pose>
        <link name='a'>{look}{rng.choice(SDF_SENSORS)}</link><link name='b'><pose>0 0 0.4 0 0 0</pose>{look}</link>
        <joint name='j' type='revolute'><parent>a</parent><child>b</child><axis><xyz>0 0 1</xyz></axis></joint>
        </model></sdf>"""


def inserts(count: int, seed: int, text: str = LEGACY, new: NewModel = legacy_model) -> dict[str, object]:
    """Insert and delete models of new names in a running world; a legacy one is served."""
    rng = random.Random(seed)
    served = int(os.environ["TRIAL_SERVER"]) if text is LEGACY else None
    with libgz.World.from_string(text, server_id=served) as world:
        insert = world.InsertModel
        if text is SDF:
            world.attach_era()
            insert = world.facade.InsertModelString
        engine = world.engine
        tables = [len(found) for found in (engine.bodies, engine.geoms, engine.joints, engine.ray_bundles)]
        memory, alive, files = [], [], descriptors()
        for k in range(count):
            place = f"{rng.uniform(-20, 20):.2f} {rng.uniform(-20, 20):.2f} 0.3"
            insert(new(f"new{k}", rng, place))
            alive.append(f"new{k}")
            world.step(rng.randrange(3))
            if len(alive) > 5:
                world.DeleteModel(alive.pop(rng.randrange(len(alive))))
            if k % max(1, count // 20) == 0:
                gc.collect()
                memory.append(resident())
        for name in alive:
            world.DeleteModel(name)
        world.step()
        gc.collect()
        memory.append(resident())
        after = [len(found) for found in (engine.bodies, engine.geoms, engine.joints, engine.ray_bundles)]
        left = descriptors() - files
    return {
        "growth": trend(memory, len(memory) // 4),
        "tables": [tables, after],
        "files": left,
        "resident": memory[-1],
    }


def main(what: str, *words: str) -> None:
    """Run one of them."""
    logging.disable(logging.INFO)
    begin = time.monotonic()
    found: dict[str, object]
    if what == "long":
        found = long_run(float(words[0]), int(words[1]))
    elif what == "digest":
        found = {"digest": digest(Path(words[0]), int(words[1]), int(words[2]))}
    else:
        sdf = functools.partial(inserts, text=SDF, new=sdf_model)
        found = {"loads": loads, "inserts": inserts, "sdf": sdf}[what](int(words[0]), int(words[1]))
    print(json.dumps({**found, "seconds": time.monotonic() - begin}))


if __name__ == "__main__":
    main(*sys.argv[1:])
