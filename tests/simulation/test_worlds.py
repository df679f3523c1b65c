"""Worlds that step beside each other: the same to the bit as alone, with any number of threads; errors; leaks."""

import gc
import hashlib
import multiprocessing
import os
import signal
import threading
import time
import weakref

import pytest

import libgz
from libgz.base.errors import ClosedError, GazeboError, ParameterError, StrictError
from libgz.rendering.render_thread import RenderThread

ROBOTS = (
    "<gz:world xmlns:gz='g' xmlns:model='m'><model:GroundPlane/><model:Pioneer2AT><id>one</id>"
    "<model:SickLMS200><id>laser</id></model:SickLMS200></model:Pioneer2AT>"
    "<model:SimpleSolid><id>box</id><xyz>1.2 0 0.3</xyz></model:SimpleSolid></gz:world>"
)
BOX = (
    "<model name='box{0}'><pose>{1} 0 {2} 0 0 0.1</pose><link name='link'><collision name='c'><geometry>"
    "<box><size>0.5 0.5 0.5</size></box></geometry></collision></link></model>"
)
GROUND = (
    "<model name='ground'><static>true</static><link name='link'><collision name='c'><geometry>{}</geometry>"
    "</collision></link></model>"
)
PLANE = "<plane><normal>0 0 1</normal></plane>"
SDF = "<sdf version='1.6'><world name='default'>{}</world></sdf>"
HEAP = SDF.format(  # more contacts than are solved exactly: the quick solver iterates, with random numbers
    GROUND.format(PLANE) + "".join(BOX.format(i, 0.2 * (i % 4), 0.3 + 0.51 * (i // 4)) for i in range(12))
)
MESH = SDF.format(
    GROUND.format("<mesh><uri>file://{folder}/ground.stl</uri></mesh>") + BOX.format(0, 0, 0.4) + BOX.format(1, 0.3, 1)
)
STEPS = 60


def stl(path):
    """A flat square of two triangles."""
    corners = ((-5, -5, 0), (5, -5, 0), (5, 5, 0), (-5, 5, 0))
    facets = "".join(
        "facet normal 0 0 1 outer loop " + "".join(f"vertex {x} {y} {z} " for x, y, z in three) + "endloop endfacet "
        for three in ((corners[0], corners[1], corners[2]), (corners[0], corners[2], corners[3]))
    )
    path.write_text(f"solid s {facets}endsolid s\n")


def start(kind, seed, folder):
    """A world, which differs by its seed."""
    texts = {"robots": ROBOTS, "heap": HEAP, "mesh": MESH.replace("{folder}", str(folder))}
    world = libgz.World.from_string(texts[kind], seed=seed)
    if kind == "robots":
        world.interface("position", "one").command(vx=0.1 * seed, vyaw=0.2)
    else:
        world.model("box0").GetBody().SetLinearVel((0.2 * seed, 0, 0))
    return world


def digest(world):
    return hashlib.sha256(world.get_state()).hexdigest()


def test_worlds_move_as_alone_with_any_number_of_threads(tmp_path):
    stl(tmp_path / "ground.stl")
    kinds = [(kind, seed) for seed in range(1, 4) for kind in ("robots", "heap", "mesh")]
    expected = []
    for kind, seed in kinds:
        with start(kind, seed, tmp_path) as world:
            world.step(STEPS)
            expected.append(digest(world))
    assert len(set(expected)) == len(kinds)
    for threads in (1, 2, 5):
        with libgz.Worlds((start(kind, seed, tmp_path) for kind, seed in kinds), threads) as worlds:
            assert worlds.threads == threads
            worlds.step(STEPS // 2)
            worlds.step(STEPS - STEPS // 2)
            assert [digest(world) for world in worlds] == expected


CAMERA = (
    "<gz:world xmlns:gz='g' xmlns:model='m'><model:LightSource/><model:GroundPlane/>"
    "<model:Pioneer2AT><id>r</id><xyz>2 {} 0</xyz></model:Pioneer2AT>"
    "<model:MonoCam><id>c</id><xyz>0 0 0.5</xyz><imageSize>32 24</imageSize></model:MonoCam></gz:world>"
)


def with_camera(y):
    world = libgz.World.from_string(CAMERA.format(y))
    world.interface("position", "r").command(vx=0.5, vyaw=1.0)
    return world


@pytest.mark.parametrize("natively", [True, False])
def test_images_are_rendered_beside_other_worlds_and_are_the_same(natively, monkeypatch):
    places, expected = (-0.3, 0.0, 0.3), []
    for y in places:
        with with_camera(y) as world:
            world.step(40)
            expected.append(world.interface("camera", "c").image.tobytes())
    assert len(set(expected)) == len(places)
    start, begun = RenderThread.start, []
    all_begun = threading.Barrier(len(places))

    def start_together(self, *arguments):
        """Begin an image that is not complete before those of all other worlds were begun."""
        start(self, *arguments)
        begun.append(self.context.submit(all_begun.wait, 20.0))
        return begun[-1]

    monkeypatch.setattr(RenderThread, "start", start_together)
    with libgz.Worlds(map(with_camera, places)) as worlds:
        for world in worlds:
            world.rows.enabled = natively
        worlds.step(40)
        assert [world.interface("camera", "c").image.tobytes() for world in worlds] == expected
    assert len(begun) >= 3 * len(places)
    assert all(one.exception() is None for one in begun)


def test_callbacks_run_in_the_calling_thread():
    called = []
    with libgz.Worlds(libgz.World.from_string(HEAP) for _ in range(3)) as worlds:
        kept = worlds[1].events["WorldUpdateBegin"].Connect(lambda: called.append(threading.get_ident()))
        worlds.step(20)
        assert kept.connected
        assert called == [threading.get_ident()] * 20
        assert [world.iterations for world in worlds] == [20, 20, 20]


def test_worlds_step_in_one_thread_at_a_time():
    began, said = threading.Event(), []

    def other(worlds):
        with pytest.raises(GazeboError, match="for another thread of the program") as raised:
            worlds.step()
        said.append(raised.value)

    def inside():
        if not began.is_set():
            began.set()
            thread = threading.Thread(target=other, args=(worlds,))
            thread.start()
            thread.join()
            for use in (worlds.step, worlds.close):
                with pytest.raises(GazeboError, match="what a step calls cannot step or close"):
                    use()
                said.append(use)

    with libgz.Worlds((libgz.World.from_string(HEAP) for _ in range(3)), threads=2) as worlds:
        kept = worlds[1].events["WorldUpdateBegin"].Connect(inside)
        worlds.step(5)
        assert len(said) == 3
        assert kept.connected
        assert [world.iterations for world in worlds] == [5, 5, 5]


def test_closing_worlds_waits_for_a_step_in_another_thread():
    began = threading.Event()
    worlds = libgz.Worlds((libgz.World.from_string(HEAP) for _ in range(3)), threads=2)
    kept = worlds[0].events["WorldUpdateBegin"].Connect(began.set)
    made = []

    def step():
        worlds.step(50)
        made.append(kept.connected)

    thread = threading.Thread(target=step)
    thread.start()
    assert began.wait(60)
    worlds.close()
    thread.join()
    assert made


def test_a_world_that_fails_ends_and_the_others_step_on():
    def fail():
        raise ValueError("no")

    with libgz.Worlds(libgz.World.from_string(HEAP, strict=number == 1) for number in range(3)) as worlds:
        kept = worlds[1].events["WorldUpdateBegin"].Connect(fail)
        with pytest.raises(GazeboError, match=r"^world 1 of 3: ") as raised:
            worlds.step(20)
        assert not kept.connected
        assert isinstance(raised.value.__cause__, StrictError)
        assert [world.iterations for world in worlds] == [20, 1, 20]


def test_a_world_that_diverges_is_recovered_beside_others(caplog):
    def run(*, diverge):
        with libgz.Worlds((libgz.World.from_string(HEAP) for _ in range(3)), threads=3) as worlds:
            worlds.step(5)
            if diverge:
                worlds[1].model("box11").GetBody().SetAngularVel((0, 1e9, 0))
            worlds.step(20)
            assert [world.iterations for world in worlds] == [25, 25, 25]
            assert len({world.GetSimTime() for world in worlds}) == 1  # the step that went wrong was made once
            return digest(worlds[0]), digest(worlds[2])

    undisturbed = run(diverge=False)
    assert "diverged" not in caplog.text
    assert run(diverge=True) == undisturbed
    assert "body box11::link diverged; its velocity was reset" in caplog.text


def test_an_interrupt_leaves_worlds_that_step():
    def interrupt():
        signal.raise_signal(signal.SIGINT)

    with libgz.Worlds((libgz.World.from_string(HEAP) for _ in range(4)), threads=2) as worlds:
        kept = worlds[0].events["WorldUpdateBegin"].Connect(interrupt)
        with pytest.raises(KeyboardInterrupt):
            worlds.step(20)
        kept.Disconnect()
        assert not any(world.lock.owned() for world in worlds)
        before = worlds[3].iterations
        worlds.step(2)
        assert worlds[3].iterations == before + 2


def test_an_interrupt_while_native_code_steps_ends_it():
    def interrupt():
        while worlds[0].iterations < 50:
            time.sleep(0.001)
        os.kill(os.getpid(), signal.SIGINT)

    with libgz.Worlds((libgz.World.from_string(HEAP) for _ in range(4)), threads=2) as worlds:
        thread = threading.Thread(target=interrupt)
        thread.start()
        with pytest.raises(KeyboardInterrupt):
            worlds.step(10**9)
        thread.join()
        before = worlds[3].iterations
        worlds.step(2)
        assert worlds[3].iterations == before + 2


def test_wrong_worlds_are_refused():
    with libgz.World.from_string(HEAP) as one, libgz.World.from_string(HEAP) as two:
        for given, threads, message in (
            ([], None, "there is no world"),
            ([one, one], None, "world 1 is there twice"),
            ([one], 0, "threads is 0; allowed are 1 to 256"),
        ):
            with pytest.raises(ParameterError, match=message):
                libgz.Worlds(given, threads)
        worlds = libgz.Worlds([one, two])
        assert len(worlds) == 2
        assert list(worlds) == [one, two]
        with one.clone() as copy, pytest.raises(ParameterError, match="world 1 is one of other Worlds"):
            libgz.Worlds([copy, two])
        two.close()
        with pytest.raises(ClosedError, match="world 1 of 2 is closed"):
            worlds.step()
        assert one.iterations == 0
        worlds.close()
        worlds.close()
        with pytest.raises(ClosedError, match="world 0 of 1 is closed"):
            libgz.Worlds([one])


def test_nothing_is_left_of_closed_worlds():
    def run():
        with libgz.Worlds((libgz.World.from_string(HEAP) for _ in range(3)), threads=3) as worlds:
            worlds.step(3)
            assert sum(thread.name.startswith("libgz crew") for thread in threading.enumerate()) == 2
            return [weakref.ref(world) for world in worlds]

    before = threading.active_count()
    left = [found for _ in range(5) for found in run()]
    gc.collect()
    assert threading.active_count() == before
    assert [found() for found in left] == [None] * len(left)


def step_in_child(worlds):
    worlds.step(10)
    raise SystemExit(0 if [world.iterations for world in worlds] == [15] * len(worlds) else 1)


def test_a_forked_process_has_threads_of_its_own():
    with libgz.Worlds((libgz.World.from_string(HEAP) for _ in range(3)), threads=2) as worlds:
        worlds.step(5)
        child = multiprocessing.get_context("fork").Process(target=step_in_child, args=(worlds,))
        child.start()
        child.join(60)
        assert child.exitcode == 0
        worlds.step(1)
        assert worlds[0].iterations == 6
