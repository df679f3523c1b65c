"""The cost of an iteration of gzserver, on SDF worlds: `python benchmarks/classic.py [SCENE...]`.

Each scene runs as the command, without pacing. With `LIBGZ_BENCH_GAZEBO=ROOT`, a root directory in which the real
Gazebo 11 is installed with its headers and g++, both take turns (as root, for chroot), and the last column is the
median of the ratios of each round.
"""

from __future__ import annotations

import argparse
import contextlib
import math
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from PIL import Image
from rounds import text_of

ROUNDS = 15
SECONDS = 1.0  # of CPU time that the many iterations take, about, on the slower side
FIRST = 200  # iterations that do not count: then everything is loaded, and has been used
TRIAL = 500  # iterations from which the number of the others is estimated
PLUGIN = Path(__file__).with_name("iterations.cc")

PHYSICS = (
    "<physics type='ode'><max_step_size>0.001</max_step_size><real_time_update_rate>0</real_time_update_rate></physics>"
)
GROUND = (
    "<model name='ground'><static>1</static><link name='l'><collision name='c'><geometry><plane><normal>0 0 1</normal>"
    "<size>100 100</size></plane></geometry></collision></link></model>"
)
SUN = "<light name='sun' type='directional'><direction>-0.5 0.1 -0.9</direction></light>"
INERTIA = "<inertial><mass>{0}</mass><inertia><ixx>{1}</ixx><iyy>{1}</iyy><izz>{1}</izz></inertia></inertial>"


def world(*parts: str) -> str:
    """An SDF world with a ground and a sun."""
    return f"<sdf version='1.6'><world name='default'>{PHYSICS}{GROUND}{SUN}{''.join(parts)}</world></sdf>"


def box(name: str, x: float, y: float, z: float, more: str = "", static: bool = False, size: str = ".5 .5 .5") -> str:
    """A box, with more in its link."""
    return (
        f"<model name='{name}'><pose>{x} {y} {z} 0 0 0</pose><static>{int(static)}</static><link name='link'>"
        f"{INERTIA.format(1, 0.04)}<collision name='c'><geometry><box><size>{size}</size></box></geometry></collision>"
        f"{more}</link></model>"
    )


def wheel(side: str, y: float) -> str:
    """A wheel and its joint."""
    return (
        f"<link name='{side}'><pose>0.1 {y} 0.1 1.5708 0 0</pose>{INERTIA.format(0.5, 0.002)}<collision name='c'>"
        "<geometry><cylinder><radius>0.1</radius><length>0.05</length></cylinder></geometry></collision></link>"
        f"<joint name='{side}_joint' type='revolute'><parent>chassis</parent><child>{side}</child><axis>"
        "<xyz>0 0 1</xyz></axis></joint>"
    )


def robot(name: str, x: float, y: float, more: str = "", in_chassis: str = "") -> str:
    """A robot with two wheels and a caster."""
    return (
        f"<model name='{name}'><pose>{x} {y} 0 0 0 0</pose><link name='chassis'><pose>0 0 0.15 0 0 0</pose>"
        f"{INERTIA.format(5, 0.1)}<collision name='c'><geometry><box><size>0.4 0.2 0.1</size></box></geometry>"
        "</collision><collision name='caster'><pose>-0.15 0 -0.1 0 0 0</pose><geometry><sphere><radius>0.05</radius>"
        "</sphere></geometry><surface><friction><ode><mu>0</mu><mu2>0</mu2></ode></friction></surface></collision>"
        f"{in_chassis}</link>{wheel('left', 0.15)}{wheel('right', -0.15)}{more}</model>"
    )


def drive(number: int) -> str:
    """The plugin that drives a robot."""
    return (
        "<plugin name='drive' filename='libDiffDrivePlugin.so'><left_joint>left_joint</left_joint><right_joint>"
        f"right_joint</right_joint><torque>5</torque><topic>~/robot{number}/vel_cmd</topic></plugin>"
    )


LASER = (
    "<sensor name='laser' type='ray'><pose>0.1 0 0.1 0 0 0</pose><always_on>1</always_on><update_rate>30</update_rate>"
    "<ray><scan><horizontal><samples>640</samples><resolution>1</resolution><min_angle>-2</min_angle><max_angle>2"
    "</max_angle></horizontal></scan><range><min>0.1</min><max>10</max></range></ray></sensor>"
)
IMU = "<sensor name='imu' type='imu'><always_on>1</always_on><update_rate>1000</update_rate></sensor>"
CONTACT = (
    "<sensor name='contact' type='contact'><always_on>1</always_on><update_rate>1000</update_rate>"
    "<contact><collision>c</collision></contact></sensor>"
)
RADIO = (
    "<sensor name='radio' type='wireless_{}'><always_on>1</always_on><update_rate>1</update_rate><transceiver>"
    "<gain>2.6</gain><power>14.5</power>{}</transceiver></sensor>"
)
SENDING = "<essid>net</essid><frequency>2442</frequency>"
HEARING = "<min_frequency>2412</min_frequency><max_frequency>2484</max_frequency><sensitivity>-90</sensitivity>"


def heightmap(folder: Path) -> str:
    """A hilly ground."""
    x, y = np.meshgrid(np.linspace(0, 4 * math.pi, 129), np.linspace(0, 4 * math.pi, 129))
    Image.fromarray((127 + 60 * np.sin(x) * np.cos(y)).astype(np.uint8)).save(folder / "hills.png")
    return (
        "<model name='hills'><static>1</static><link name='l'><collision name='c'><geometry><heightmap><uri>"
        "file://hills.png</uri><size>40 40 2</size></heightmap></geometry></collision></link></model>"
    )


BONES, RINGS, KEYS = 31, 4, 60  # of a skin: bones, squares of vertices along each, and keys of its animation


def actors(folder: Path, count: int) -> str:
    """Actors that play the animation of a skin where they stand: five limbs of bones, each of which nods."""
    (folder / "limbs.dae").write_text(limbs())
    skin = "<skin><filename>limbs.dae</filename></skin><animation name='nod'><filename>limbs.dae</filename></animation>"
    return "".join(
        f"<actor name='a{i}'><pose>{2 * i} 0 1 0 0 0</pose>{skin}<script><trajectory id='0' type='nod'><waypoint>"
        f"<time>0</time><pose>{2 * i} 0 1 0 0 0</pose></waypoint><waypoint><time>2</time><pose>{2 * i} 2 1 0 0 1</pose>"
        "</waypoint></trajectory></script></actor>"
        for i in range(count)
    )


def limbs() -> str:
    """The COLLADA file of that skin: a root with five chains of bones of 0.2 m."""

    def source(name: str, values: object) -> str:
        array = np.asarray(values, dtype=float)
        text, each = " ".join(f"{value:g}" for value in array.ravel()), array.size // len(array)
        return (
            f"<source id='{name}'><float_array id='{name}-a' count='{array.size}'>{text}</float_array>"
            f"<technique_common><accessor source='#{name}-a' count='{len(array)}' stride='{each}'/></technique_common>"
            "</source>"
        )

    def bone(number: int) -> str:
        children = range(1, 6) if number == 0 else range(number + 5, min(number + 6, BONES))
        angle = 72 * number if number < 6 else 0
        return (
            f"<node id='b{number}' name='b{number}' type='JOINT'><translate>{0.2 * (number > 5)} 0 0</translate>"
            f"<rotate>0 0 1 {angle}</rotate><rotate sid='turn'>0 1 0 0</rotate>{''.join(map(bone, children))}</node>"
        )

    binds, faces = [], []
    points: list[object] = []
    for number in range(BONES):
        angle, along = math.radians(72 * ((number - 1) % 5 + 1)) if number else 0.0, 0.2 * ((number - 1) // 5)
        turn = np.array([[math.cos(angle), -math.sin(angle), 0], [math.sin(angle), math.cos(angle), 0], [0, 0, 1]])
        bind = np.eye(4)
        bind[:3, :3], bind[:3, 3] = turn.T, (-along if number else 0.0, 0, 0)
        binds.append(bind)
        for ring in range(RINGS):
            corners = [(along + 0.2 * ring / (RINGS - 1), y, z) for y, z in ((-0.03, -0.03), (0.03, -0.03), (0, 0.03))]
            if ring:
                first = len(points)
                faces += [(first + i - 3, first + (i + 1) % 3 - 3, first + i) for i in range(3)]
                faces += [(first + (i + 1) % 3 - 3, first + (i + 1) % 3, first + i) for i in range(3)]
            points += [turn @ corner for corner in corners]
    times = np.linspace(0, 2, KEYS)
    animations = "".join(
        f"<animation>{source(f't{i}', times)}{source(f'v{i}', 20 * np.sin(math.pi * times + i))}<sampler id='s{i}'>"
        f"<input semantic='INPUT' source='#t{i}'/><input semantic='OUTPUT' source='#v{i}'/></sampler>"
        f"<channel source='#s{i}' target='b{i}/turn.ANGLE'/></animation>"
        for i in range(BONES)
    )
    each = 3 * RINGS
    return (
        "<?xml version='1.0'?><COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema' version='1.4.1'>"
        f"<library_geometries><geometry id='mesh'><mesh>{source('points', points)}<vertices id='all'>"
        f"<input semantic='POSITION' source='#points'/></vertices><triangles count='{len(faces)}'><input semantic="
        f"'VERTEX' source='#all' offset='0'/><p>{' '.join(map(str, np.ravel(faces)))}</p></triangles></mesh></geometry>"
        f"</library_geometries><library_controllers><controller id='ctl'><skin source='#mesh'>"
        f"<bind_shape_matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</bind_shape_matrix>{source('binds', binds)}"
        f"{source('weights', [1])}<source id='joints'><Name_array count='{BONES}'>"
        f"{' '.join(f'b{i}' for i in range(BONES))}</Name_array></source><joints><input semantic='JOINT' source="
        "'#joints'/><input semantic='INV_BIND_MATRIX' source='#binds'/></joints><vertex_weights count="
        f"'{len(points)}'><input semantic='JOINT' source='#joints' offset='0'/><input semantic='WEIGHT' source="
        f"'#weights' offset='1'/><vcount>{'1 ' * len(points)}</vcount><v>"
        f"{' '.join(f'{i // each} 0' for i in range(len(points)))}</v></vertex_weights></skin></controller>"
        f"</library_controllers><library_animations>{animations}</library_animations><library_visual_scenes>"
        f"<visual_scene id='scene'>{bone(0)}<node id='skin'><instance_controller url='#ctl'><skeleton>#b0</skeleton>"
        "</instance_controller></node></visual_scene></library_visual_scenes><scene><instance_visual_scene "
        "url='#scene'/></scene></COLLADA>"
    )


def tree(joints: int) -> str:
    """A fixed trunk with four limbs of revolute joints that are held by damping."""
    parts, limbs = [], 4
    parts.append(f"<link name='trunk'>{INERTIA.format(5, 0.1)}</link>")
    parts.append("<joint name='fix' type='fixed'><parent>world</parent><child>trunk</child></joint>")
    for limb in range(limbs):
        before = "trunk"
        for i in range(joints // limbs):
            name = f"l{limb}_{i}"
            parts.append(
                f"<link name='{name}'><pose>{0.3 + 0.2 * i} {limb * 0.3} 0 0 0 0</pose>{INERTIA.format(0.5, 0.002)}"
                "<collision name='c'><geometry><box><size>0.1 0.05 0.05</size></box></geometry></collision></link>"
                f"<joint name='j{name}' type='revolute'><pose>-0.1 0 0 0 0 0</pose><parent>{before}</parent><child>"
                f"{name}</child><axis><xyz>0 {i % 2} {1 - i % 2}</xyz><limit><lower>-1</lower><upper>1</upper></limit>"
                "<dynamics><damping>0.1</damping></dynamics></axis></joint>"
            )
            before = name
    return f"<model name='tree'><pose>0 0 2 0 0 0</pose>{''.join(parts)}</model>"


def scenes(folder: Path) -> Iterator[tuple[str, str]]:
    """(name, world) of all; files that worlds need are written into the folder."""
    yield "empty", world()
    for count in (1, 20):
        robots = (robot(f"r{i}", i % 5, i // 5, drive(i)) for i in range(count))
        yield f"{count} diff drives", world(*robots)
    yield "10 robots", world(*(robot(f"r{i}", i % 5, i // 5) for i in range(10)))
    yield "10 lasers", world(*(robot(f"r{i}", i % 5, i // 5, "", LASER) for i in range(10)))
    yield "20 imus", world(*(box(f"b{i}", i % 5, i // 5, 0.25, IMU) for i in range(20)))
    yield "20 contacts", world(*(box(f"b{i}", i % 5, i // 5, 0.25, CONTACT) for i in range(20)))
    yield "heightmap", world(heightmap(folder), *(box(f"b{i}", 2 * (i % 5), 2 * (i // 5), 3) for i in range(20)))
    yield "5 actors", world(actors(folder, 5))
    yield "231 static", world(*(box(f"b{i}", i % 20, i // 20, 0.25, static=True, size="2 2 .5") for i in range(231)))
    radios = [box("hear", 0, 0, 1, RADIO.format("receiver", HEARING), static=True)]
    radios += [box(f"s{i}", 3 * i + 3, i, 1, RADIO.format("transmitter", SENDING), static=True) for i in range(4)]
    yield "wireless", world(*radios)
    yield "24 joints", world(tree(24))
    yield "52 joints", world(tree(52))
    yield "100 boxes", world(*(box(f"b{i}", i % 10, i // 10, 0.25) for i in range(100)))
    yield "stack of 10", world(*(box(f"b{i}", 0, 0, 0.25 + 0.5 * i) for i in range(10)))


class Side:
    """A gzserver that runs worlds.

    Args:
        folder: where it finds them, as seen from outside.
        inside: the same, as it sees it itself.
    """

    def __init__(self, folder: Path, inside: Path) -> None:
        self.folder, self.inside = folder, inside
        self.env = {
            **os.environ,
            "GAZEBO_MODEL_DATABASE_URI": "",
            "GAZEBO_RESOURCE_PATH": f"{inside}:/usr/share/gazebo-11",
            "GAZEBO_MASTER_URI": "http://127.0.0.1:11399",
            "HOME": str(inside),
            "TMP": str(inside),
        }

    def seconds(self, name: str, count: int) -> float:
        """The CPU time of so many iterations [s]."""
        raise NotImplementedError

    def path(self, name: str) -> str:
        """Of a world, as the server sees it."""
        return str(self.inside / f"{name.replace(' ', '_')}.world")

    def microseconds(self, name: str, count: int) -> float:
        """What one of so many iterations takes [us]."""
        return self.seconds(name, count) / count * 1e6


class Libgz(Side):
    """libgz's gzserver: the difference of a long and a short run."""

    def seconds(self, name: str, count: int) -> float:
        """The CPU time of so many iterations [s]."""
        return self._whole(name, FIRST + count) - self._whole(name, FIRST)

    def _whole(self, name: str, iterations: int) -> float:
        command = [sys.executable, "-P", "-m", "libgz.apps.gzserver", "--iters", str(iterations), self.path(name)]
        quiet = subprocess.DEVNULL
        with subprocess.Popen(command, stdout=quiet, stderr=quiet, env=self.env) as process:
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode:
            raise RuntimeError(f"{' '.join(command)} ended with {process.returncode}")
        return usage.ru_utime + usage.ru_stime


class Gazebo(Side):
    """Gazebo's gzserver, which is ended by a plugin of ours: it does not end by itself in every root.

    Args:
        root: where it is installed.
        name: of the worlds' folder.
    """

    def __init__(self, root: Path, name: str) -> None:
        self.root = root
        inside = Path("/tmp") / name
        folder = root / inside.relative_to("/")
        folder.mkdir(parents=True)
        super().__init__(folder, inside)
        shutil.copy(PLUGIN, folder)
        build = "cd {0} && g++ -w -O1 -shared -fPIC {1} -o libiterations.so $(pkg-config --cflags --libs gazebo)"
        subprocess.run(["chroot", root, "bash", "-c", build.format(inside, PLUGIN.name)], check=True)

    def seconds(self, name: str, count: int) -> float:
        """The CPU time of so many iterations [s]."""
        command = ["chroot", self.root, "gzserver", "-s", self.inside / "libiterations.so", self.path(name)]
        env = {**self.env, "FIRST": str(FIRST), "COUNT": str(count)}
        ended = subprocess.run(command, capture_output=True, text=True, timeout=600, env=env, check=True)
        return float(ended.stdout.split()[-1])


@contextlib.contextmanager
def sides(root: str | None) -> Iterator[dict[str, Side]]:
    """libgz's gzserver, and Gazebo's if there is one; scenes are written for both."""
    with contextlib.ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        both: dict[str, Side] = {"libgz": Libgz(folder, folder)}
        if root:
            both["gazebo"] = Gazebo(Path(root), folder.name)
            stack.callback(shutil.rmtree, both["gazebo"].folder)
        for side in both.values():
            for name, text in scenes(side.folder):
                (side.folder / f"{name.replace(' ', '_')}.world").write_text(text)
        yield both


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene", nargs="*", help="names of scenes, in part")
    parser.add_argument("--rounds", type=int, default=ROUNDS)
    parser.add_argument("--count", type=int, default=0, help="of iterations; 0: as many as take a second")
    options = parser.parse_args()
    with sides(os.environ.get("LIBGZ_BENCH_GAZEBO")) as both:
        print(f"{'CPU time of an iteration [us]':<30}{''.join(f'{name:>12}' for name in both)}{'ratio':>10}")
        for name, _ in scenes(both["libgz"].folder):
            if options.scene and not any(word in name for word in options.scene):
                continue
            try:
                # The same iterations on both sides: bodies that land and come to rest cost less from then on.
                cost = max(max(one.seconds(name, TRIAL) for one in both.values()) / TRIAL, 2e-6)
                count = options.count or max(TRIAL, round(SECONDS / cost))
                rounds = [{s: one.microseconds(name, count) for s, one in both.items()} for _ in range(options.rounds)]
            except subprocess.CalledProcessError as error:  # Gazebo crashes on some
                print(f"{name:<30}{error}", flush=True)
                continue
            columns = "".join(f"{statistics.median(one[side] for one in rounds):12.1f}" for side in both)
            ratios = [one["libgz"] / one["gazebo"] for one in rounds] if len(both) > 1 else []
            ratio = f"{statistics.median(ratios):10.2f}   {text_of(ratios)}" if ratios else ""
            print(f"{name:<30}{columns}{ratio}", flush=True)


if __name__ == "__main__":
    main()
