"""Observers: what other processes see of a world that a server runs."""

import contextlib
import ctypes
import errno
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import sdf_worlds as sdf

import libgz
from libgz.base.geometry import GzPose, GzQuatern, GzVector
from libgz.sdf.reader import SdfFile
from libgz.sdfworld.world import SdfWorld
from libgz.transport.directory import ServerDirectory
from libgz.transport.stale_files import remove_stale
from libgz.transport.tables import HEADER

WORLDS = Path(__file__).parents[2] / "worlds"
HEAD = "<gz:world xmlns:gz='g' xmlns:model='m' xmlns:param='p'>"
SPHERE = "<model:SimpleSolid><id>{0}</id><xyz>{1}</xyz><shape>sphere</shape></model:SimpleSolid>"


def legacy(body, **options):
    return libgz.World.from_string(f"{HEAD}{body}</gz:world>", **options)


def classic(*parts, **options):
    return libgz.World.from_string(f"<sdf version='1.6'>{sdf.world(*parts)}</sdf>", **options)


def lonely(name, pose="0 0 1 0 0 0", color=""):
    look = f"<visual name='v'>{color}<geometry><box><size>1 1 1</size></box></geometry></visual>"
    return sdf.model(name, sdf.link("link", sdf.inertial(), sdf.collision(), look), pose=pose)


def assert_same(world, observer):
    """What is observed is what the world has, to the bit."""
    state, bodies = observer.state(), {body.id: body for body in observer.bodies}
    assert (state.sim_time, state.pause_time) == (world.GetSimTime(), world.GetPauseTime())
    assert state.steps == world.iterations
    assert [entity.id for entity in observer.entities] == [entity.GetId() for entity in world.entities]
    for entity in world.entities:
        for body in entity.bodies:
            seen = bodies[body.number]
            pose, rate = body.GetPose(), body.GetAngularRate()
            row = state.bodies[seen.row]
            assert row[:7].tolist() == [*pose.pos, *pose.rot], body
            assert row[7:10].tolist() == [*body.GetCoMPose().pos]
            assert row[10:].tolist() == [*body.GetLinearVel(), *rate]
            assert (seen.name, seen.entity, seen.static) == (body.bodyName or "", entity.GetId(), body.dummy)
            assert [shape.id for shape in seen.shapes] == [geom.number for geom in body.geoms]
    rows = [joint.row for joint in observer.joints if joint.row >= 0]
    assert len(set(rows)) == len(rows)
    for row in rows:
        joint = world.engine.joints[row]
        assert state.joints[row].tolist() == [joint._value(column) for column in range(4)]


# States ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["pioneer2dx", "gripper", "map", "terrain", "factory"])
def test_states_of_legacy_worlds(wire, name):
    with libgz.World.from_file(WORLDS / f"{name}.world", server_id=wire) as world, libgz.Observer(wire) as observer:
        assert_same(world, observer)
        for _ in range(3):
            world.step(7)
            assert_same(world, observer)


def test_states_of_a_classic_world(wire):
    arm = sdf.two_links(sdf.joint("j", "revolute", "a", "b", pose="-0.5 0 0 0 0 0"))
    with classic(sdf.GROUND, arm, lonely("box"), server_id=wire) as world, libgz.Observer(wire) as observer:
        world.body("m", "b").SetAngularVel((0.0, 0.0, 3.0))
        world.step(100)
        assert_same(world, observer)
        (joint,) = observer.joints
        assert (joint.kind, joint.name, joint.entity) == ("revolute", "j", "m")
        assert joint.bodies == (world.body("m", "a").number, world.body("m", "b").number)
        assert joint.frame == world.body("m", "b").number
        assert [*joint.anchor] == pytest.approx([-0.5, 0, 0])
        assert [*joint.axes[0]] == pytest.approx([0, 0, 1])


def test_a_step_publishes(wire):
    hinge = sdf.two_links(sdf.joint("j", "revolute", "a", "b"))
    with classic(hinge, server_id=wire) as world, libgz.Observer(wire) as observer:
        world.body("m", "b").SetAngularVel((0.0, 0.0, 3.0))
        for _ in range(3):
            world.step(5)
            state = observer.state()
            before = world.engine.tables.joints.state.copy()
            world.engine.native.read()
            used = world.engine.tables.bodies.used
            assert (state.bodies[:used] == world.engine.states).all()
            assert (before[0] == world.engine.tables.joints.state[0]).all()
            assert (state.joints[0] == world.engine.tables.joints.state[0]).all()


def test_a_served_world_moves_like_another(wire):
    """Publishing reads stale rows of joints that count their turns, and must not count any."""
    hinge = sdf.two_links(sdf.joint("j", "revolute", "a", "b"))

    def run(**options):
        with classic(hinge, gravity, **options) as world:
            body, results = world.body("m", "b"), []
            world.paused = True
            for angle in (2.0, 4.0, 5.5, 1.0):
                body.SetPose(GzPose(body.GetPose().pos, GzQuatern(np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2))))
                world.step()
            world.paused = False
            for _ in range(50):
                world.step()
                results += [world.engine.states.copy(), world.engine.tables.joints.state.copy()]
            return results

    gravity = lonely("box")
    for one, other in zip(run(), run(server_id=wire), strict=True):
        assert (one == other).all()


def test_what_observers_show(wire):
    with libgz.World(wire) as world:
        world.Initialize()
        world.step(5)
        observer = libgz.Observer(wire)
        assert repr(observer) == f"<Observer of server {wire}, running, sim time {world.GetSimTime():.3f} s>"
    assert repr(observer) == f"<Observer of server {wire}, ended, sim time {world.GetSimTime():.3f} s>"
    observer.close()
    assert repr(observer) == f"<Observer of server {wire}, closed>"


def test_setters_are_seen_after_a_paused_step(wire):
    with legacy(SPHERE.format("a", "0 0 1"), server_id=wire) as world, libgz.Observer(wire) as observer:
        world.paused = True
        world.step()
        before = observer.state()
        assert before.paused
        world.SetModelPose(world.model("a"), GzPose(GzVector(4.0, 5.0, 6.0), GzQuatern(1.0, 0.0, 0.0, 0.0)))
        world.step()
        after = observer.wait(before, timeout=5.0)
        assert (after.number, after.steps) == (before.number + 1, before.steps)
        assert after.pause_time > before.pause_time
        assert [*observer.pose("a").pos] == [4.0, 5.0, 6.0]
        assert_same(world, observer)


def test_static_models_that_are_moved(wire):
    wall = "<model name='wall'><static>true</static>" + sdf.link("link", sdf.collision()) + "</model>"
    with classic(wall, lonely("box"), server_id=wire) as world, libgz.Observer(wire) as observer:
        revision = observer.revision
        world.SetModelPose(world.model("wall"), GzPose(GzVector(1.0, 2.0, 3.0), GzQuatern(1.0, 0.0, 0.0, 0.0)))
        world.step()
        assert [*observer.pose("wall").pos] == [1.0, 2.0, 3.0] == [*observer.pose("wall::link").pos]
        assert observer.revision == revision  # only the tables changed
        assert_same(world, observer)


def test_waiting(wire):
    with legacy("", server_id=wire) as world, libgz.Observer(wire) as observer:
        state = observer.state()
        with pytest.raises(libgz.InterfaceError, match=r"made no step within 0\.05 s"):
            observer.wait(state, timeout=0.05)
        world.step(3)
        assert observer.wait(state, timeout=5.0).steps == 3


FALLING = """
import sys
import libgz
text = "".join(f"<model:SimpleSolid><id>s{i}</id><xyz>{3 * (i % 16)} {3 * (i // 16)} 100</xyz></model:SimpleSolid>"
               for i in range(250))
world = libgz.World.from_string(f"<gz:world xmlns:gz='g' xmlns:model='m'>{text}</gz:world>", server_id=int(sys.argv[1]))
print("ready", flush=True)
while True:
    world.step(400)
    for model in world.models:
        for body in model.bodies:
            body.SetLinearVel((0.0, 0.0, 0.0))
"""


@contextlib.contextmanager
def started(script, *words):
    """A process that prints `ready` once it is; it is killed in the end."""
    command = [sys.executable, "-c", script, *map(str, words)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout.readline() == "ready\n"
            yield process
        finally:
            process.kill()


def test_states_are_never_torn(wire):
    """All bodies fall with one velocity at any moment. TORN_READS sets how many states are read."""
    reads = int(os.environ.get("TORN_READS", "20000"))
    with started(FALLING, wire), libgz.Observer(wire) as observer:
        rows = [body.row for body in observer.bodies]
        assert len(rows) == 250
        numbers, end = set(), time.monotonic() + 60.0
        while reads > 0 or (len(numbers) <= 100 and time.monotonic() < end):
            reads -= 1
            state = observer.state()
            speeds = state.bodies[rows, 12]
            assert speeds.min() == speeds.max(), state.number
            numbers.add(state.number)
        assert len(numbers) > 100
    assert list(remove_stale(wire))


# Scene -----------------------------------------------------------------------------------------------------------


def test_legacy_models_come_and_go(wire):
    with legacy(SPHERE.format("a", "0 0 1"), server_id=wire) as world, libgz.Observer(wire) as observer:
        first = observer.revision
        world.InsertModel(SPHERE.format("b", "3 0 1"))
        world.step()
        assert [entity.id for entity in observer.entities] == ["a", "b"]
        assert observer.revision > first
        assert_same(world, observer)
        world.DeleteModel("a")
        world.step()
        world.InsertModel("<model:Pioneer2AT><id>robot</id></model:Pioneer2AT>")
        world.step(10)
        assert_same(world, observer)
        robot = observer.entities[-1]
        assert (robot.kind, robot.type, robot.id) == ("model", "Pioneer2AT", "robot")
        assert {"type": "position", "id": "robot"} in robot.data["interfaces"]
        with pytest.raises(libgz.NotFoundError, match="no entity or body 'robt'; did you mean 'robot'"):
            observer.pose("robt")


def test_classic_models_come_and_go(wire):
    with classic(lonely("a"), server_id=wire) as world, libgz.Observer(wire) as observer:
        text = f"<sdf version='1.6'>{lonely('b', '5 0 1 0 0 0')}<light name='lamp' type='spot'/></sdf>"
        world.extension(SdfWorld).insert(SdfFile.from_string(text))
        world.step()
        assert [(entity.kind, entity.id) for entity in observer.entities] == [
            ("model", "a"),
            ("model", "b"),
            ("light", "lamp"),
        ]
        assert_same(world, observer)
        world.DeleteModel("a")
        world.DeleteModel("lamp")
        world.step(3)
        assert [entity.id for entity in observer.entities] == ["b"]
        assert_same(world, observer)


def test_tables_outgrow_their_file(wire):
    with legacy(SPHERE.format("a", "0 0 1"), server_id=wire) as world, libgz.Observer(wire) as observer:
        for count in (20, 1100):
            spheres = (SPHERE.format(f"s{count}x{i}", f"{3 * i} 0 1") for i in range(count))
            world.InsertModel("".join(spheres))
            world.step()
            assert len(observer.bodies) == len(world.models)
            assert_same(world, observer)


def test_changed_colours_are_seen(wire):
    with classic(lonely("a"), lonely("b", "5 0 1 0 0 0"), server_id=wire) as world, libgz.Observer(wire) as observer:
        revision = observer.revision
        geom = world.body("a").geoms[1]
        geom.SetDiffuseColor(libgz.GzColor(0.1, 0.2, 0.3, 1.0))
        end = time.monotonic() + 20.0
        while observer.revision == revision and time.monotonic() < end:
            world.step()
            time.sleep(0.01)
        assert observer.revision == revision + 1
        (seen,) = (shape for shape in observer.shapes if shape.id == geom.number)
        assert seen.data["material"]["diffuse"] == [0.1, 0.2, 0.3]
        assert seen.name == "v"
        assert not seen.collides
        assert_same(world, observer)


def test_meshes_and_rays_are_in_files(wire):
    with libgz.World.from_file(WORLDS / "terrain.world", server_id=wire) as world, libgz.Observer(wire) as observer:
        geoms = {geom.number: geom for geom in world.engine.geoms.values()}
        meshes = [shape for shape in observer.shapes if shape.kind == "mesh"]
        assert meshes
        for mesh in meshes:
            arrays, geom = observer.data(mesh.data["data"]), geoms[mesh.id]
            assert (arrays["vertices"] == geom.vertices.astype(np.float32)).all()
            assert (arrays["triangles"] == geom.triangles).all()
        texture = meshes[0].data["texture"]
        assert texture is None or Path(texture["file"]).is_file()
    robot = "<model:Pioneer2AT><id>r</id><model:SickLMS200><id>laser</id></model:SickLMS200></model:Pioneer2AT>"
    with legacy(robot, server_id=wire) as world, libgz.Observer(wire) as observer:
        (laser,) = (entity for entity in observer.entities if entity.id == "laser")
        (bundle,) = laser.data["sensors"]
        rays = observer.data(bundle["data"])["rays"]
        (own,) = (found for found in world.engine.ray_bundles if found.body is world.body("laser"))
        assert (rays == own.rays.astype(np.float32)).all()
        folder = Path(observer.path)
        world.DeleteModel("r")
        world.step()
        world.InsertModel(SPHERE.format("a", "0 0 1"))
        world.step()
        assert not list(folder.glob(".observer.data.*"))  # nothing refers to it any more
        with pytest.raises(libgz.NotFoundError, match="the scene has changed since"):
            observer.data(bundle["data"])


def test_sensors_of_classic_worlds(wire):
    camera = """<sensor name='eye' type='camera'><pose>0.1 0 0 0 0 0</pose><camera><horizontal_fov>1.2</horizontal_fov>
        <image><width>640</width><height>320</height></image><clip><near>0.2</near><far>30</far></clip></camera></sensor>"""
    ray = """<sensor name='laser' type='ray'><ray><scan><horizontal><samples>90</samples><min_angle>-1</min_angle>
        <max_angle>1</max_angle></horizontal></scan><range><min>0.1</min><max>9</max></range></ray></sensor>"""
    robot = sdf.model("m", sdf.link("link", sdf.inertial(), sdf.collision(), camera, ray))
    view = "<gui><camera name='c'><pose>1 2 3 0 0 0</pose></camera></gui>"
    scene = "<scene><ambient>0.5 0.5 0.5 1</ambient><background>0 0 1 1</background></scene>"
    with classic(robot, view, scene, server_id=wire), libgz.Observer(wire) as observer:
        eye, laser = observer.entities[0].data["sensors"]
        assert eye["cameras"][0] | {"pose": 0} == {"pose": 0, "fov": 1.2, "aspect": 2.0, "near": 0.2, "far": 30.0}
        assert eye["pose"][:3] == [0.1, 0, 0]
        assert laser["rays"][0]["horizontal"] == {"samples": 90, "min_angle": -1.0, "max_angle": 1.0}
        assert laser["rays"][0]["max"] == 9.0
        assert observer.scene["view"][:3] == [1, 2, 3]
        assert observer.scene["background"] == [0, 0, 1, 1]


def test_a_full_disk(wire, monkeypatch, caplog):
    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with legacy(SPHERE.format("a", "0 0 1"), server_id=wire) as world, libgz.Observer(wire) as observer:
        monkeypatch.setattr(ServerDirectory, "write_file", full)
        world.InsertModel(SPHERE.format("b", "3 0 1"))
        world.step(3)
        assert caplog.text.count("observers cannot see this world any more: No space left on device") == 1
        assert not observer.alive
        assert world.iterations == 3


def test_a_restored_state_is_seen(wire):
    wall = "<model name='wall'><static>true</static>" + sdf.link("link", sdf.collision()) + "</model>"
    with classic(wall, lonely("box"), server_id=wire) as world, libgz.Observer(wire) as observer:
        world.step(5)
        kept = world.get_state()
        world.SetModelPose(world.model("wall"), GzPose(GzVector(1.0, 2.0, 3.0), GzQuatern(1.0, 0.0, 0.0, 0.0)))
        world.step(50)
        world.set_state(kept)
        world.step()
        assert observer.state().steps == 6
        assert_same(world, observer)
        assert [*observer.pose("wall").pos] == [0.0, 0.0, 0.0]


# Servers and observers that come and go --------------------------------------------------------------------------


def test_no_server(wire):
    with pytest.raises(libgz.ServerGoneError, match=f"server {wire} is not running: there is no live server in "):
        libgz.Observer(wire)
    with pytest.raises(libgz.ParameterError, match="server id is -1"):
        libgz.Observer(-1)


def test_an_observer_that_is_there_first(wire):
    look = "import sys, libgz; print('ready', flush=True); o = libgz.Observer(int(sys.argv[1]), timeout=60.0); "
    with (
        started(look + "print(o.state().bodies.shape[1], len(o.entities))", wire) as observer,
        legacy(SPHERE.format("a", "0 0 1"), server_id=wire),
    ):
        assert observer.communicate(timeout=60.0)[0] == "16 1\n"


def test_a_server_that_ends_and_starts_again(wire):
    with legacy(SPHERE.format("a", "0 0 1"), server_id=wire) as world, libgz.Observer(wire) as observer:
        other = libgz.Observer(wire)
        assert observer.alive
        assert other.pose("a") == observer.pose("a")
        world.close()
        assert not observer.alive
        for action in (observer.state, lambda: observer.entities, lambda: observer.wait(timeout=1.0)):
            with pytest.raises(libgz.ServerGoneError, match=rf"server {wire} \(pid {os.getpid()}\) has ended"):
                action()
        with legacy(SPHERE.format("b", "0 0 1"), server_id=wire):
            assert not observer.alive  # of the former server
            observer.reconnect()
            assert [entity.id for entity in observer.entities] == ["b"]
        other.close()
        with pytest.raises(libgz.ClosedError, match="is closed"):
            other.state()


def test_a_killed_server(wire):
    with started(FALLING, wire) as server, libgz.Observer(wire) as observer:
        assert observer.alive
        assert observer.pid == server.pid
        server.kill()
        server.wait()
        assert not observer.alive
        with pytest.raises(libgz.ServerGoneError, match="has ended"):
            observer.wait(timeout=20.0)
        with pytest.raises(libgz.ServerGoneError, match="is not running"):
            observer.reconnect()
        with legacy("", server_id=wire) as world:  # which takes over the directory
            observer.reconnect()
            world.step()
            assert observer.state().steps == 1


def test_a_killed_observer(wire):
    look = "import sys, libgz; o = libgz.Observer(int(sys.argv[1])); print('ready', flush=True)\nwhile True: o.state()"
    with legacy(SPHERE.format("a", "0 0 1"), server_id=wire) as world:
        with started(look, wire) as observer:
            world.step(100)
            observer.send_signal(signal.SIGKILL)
            observer.wait()
        world.step(100)
        folder = Path(world.gz_server.path)
        with libgz.Observer(wire) as other:
            assert_same(world, other)
    assert not folder.exists()


def test_a_truncated_file(wire):
    with legacy(SPHERE.format("a", "0 0 1"), server_id=wire) as world, libgz.Observer(wire) as observer:
        tables = Path(observer.path, ".observer.tables")
        for size in (0, 100, HEADER.itemsize + 8):
            os.truncate(tables, size)
            world.step(2)
            assert_same(world, observer)
        tables.write_bytes(b"\xff" * tables.stat().st_size)
        world.step()
        assert_same(world, observer)


def test_a_forked_child_leaves_the_files_alone(wire):
    with legacy(SPHERE.format("a", "0 0 1"), server_id=wire) as world, libgz.Observer(wire) as observer:
        world.step(5)
        child = os.fork()
        if child == 0:
            world.step(100)
            world.close()
            os._exit(0)
        os.waitpid(child, 0)
        assert observer.state().steps == 5
        assert observer.alive
        world.step()
        assert_same(world, observer)


def test_files_are_hidden_and_private(wire):
    with legacy(SPHERE.format("a", "0 0 1"), server_id=wire) as world, libgz.Client(wire) as client:
        files = [path for path in Path(world.gz_server.path).iterdir() if "observer" in path.name]
        assert sorted(path.name for path in files) == [".observer.scene", ".observer.tables"]
        assert {path.stat().st_mode & 0o777 for path in files} == {0o600}
        assert [kind for kind, _ in client.interfaces()] == ["sim"]


def test_a_world_without_a_server_publishes_nothing():
    with legacy(SPHERE.format("a", "0 0 1")) as world:
        world.step()
        assert world.publication is None


def test_observers_load_neither_ode_nor_opengl(wire):
    script = """
import sys, libgz
o = libgz.Observer(int(sys.argv[1]))
o.pose("a")
parts = ("libgz.ode", "libgz.physics", "libgz.simulation", "OpenGL", "lxml")
loaded = [name for name in sys.modules if name.startswith(parts)]
print("ready" if not loaded else loaded, flush=True)
"""
    with legacy(SPHERE.format("a", "0 0 1"), server_id=wire), started(script, wire):
        pass


def test_the_documented_layout():
    text = (Path(__file__).parents[2] / "docs" / "observer.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\d+) \| (\w+) \| `(\w+)` \|", text, re.MULTILINE)
    names = {"S8": "bytes8", "u8": "uint64", "i8": "int64", "f8": "float64"}
    actual = [(str(offset), names[kind.str.lstrip("<>|=")], name) for name, (kind, offset) in HEADER.fields.items()]
    assert rows == actual
    assert ctypes.sizeof(ctypes.c_void_p) == 8
