"""Threads: every call is safe while another thread steps, and no thread waits without end."""

import inspect
import logging
import subprocess
import sys
import textwrap
import threading
import time
import traceback

import pytest

import libgz
from libgz.base.errors import ClosedError
from libgz.base.geometry import GzPose, GzQuatern, GzVector
from libgz.physics import lock as lock_module
from libgz.physics.lock import WorldLock, exclusive
from libgz.transport import semaphores
from libgz.transport.control import Request

LEGACY = (
    "<gz:world xmlns:gz='g' xmlns:model='m'><model:GroundPlane/>"
    "<model:Pioneer2AT><id>one</id></model:Pioneer2AT><model:Pioneer2AT><id>two</id><xyz>3 0 0</xyz></model:Pioneer2AT>"
    "</gz:world>"
)
BOX = (
    "<model name='{}'><pose>{} 0 0.5 0 0 0</pose><link name='link'><collision name='c'><geometry>"
    "<box><size>1 1 1</size></box></geometry></collision></link></model>"
)
CLASSIC = f"<sdf version='1.6'><world name='default'>{BOX.format('one', 0)}{BOX.format('two', 3)}</world></sdf>"

# Each line runs again and again in a thread of its own, while two threads step. ODE aborts the process at a race.
# What a reset would take away in between is one change.
CALLS = """
one.SetPose(GzPose(GzVector(0, 0, 1), GzQuatern(1, 0, 0, 0)))
world.SetModelPose(two, GzPose(GzVector(3, 0, 1), GzQuatern(1, 0, 0, 0)))
one.GetBody().AddForce(1, 0, 0); one.GetBody().SetLinearVel((0, 0, 0.1))
with world.lock: world.InsertModel("<model:SimpleSolid><id>new</id></model:SimpleSolid>"); world.DeleteModel("new")
with world.lock: h = libgz.HingeJoint(world); h.Attach(one.GetBody(), two.GetBody()); h.SetAnchor((1,0,0)); h.close()
with world.lock: libgz.BoxGeom(two.GetBody(), two.modelSpaceId, 0.1, 0.1, 0.1).close()
world.Reset(); world.engine.gravity = (0, 0, -9.8)
world.set_state(world.get_state())
one.GetPose(); one.joints; world.model("two"); two.GetBody().GetLinearVel(); world.engine.states.sum()
"""
SOLID = "<model:SimpleSolid><id>new</id><xyz>0 5 3</xyz></model:SimpleSolid>"
PROGRAM = """
import sys, threading, time
import libgz
from libgz import GzPose, GzQuatern, GzVector, World

SOLID = {solid!r}
world = World.from_string({text!r})
one, two = world.model("one"), world.model("two")
end, failed, counts = threading.Event(), [], {{}}

def again(line):
    code, counts[line] = compile(line, line, "exec"), 0
    try:
        while not end.is_set():
            exec(code, globals())
            counts[line] += 1
    except BaseException as error:
        failed.append((line, error))

lines = {lines!r}
threads = [threading.Thread(target=again, args=(line,)) for line in [*lines, "world.Step()", "world.step(2)"]]
for thread in threads: thread.start()
while min(counts.values(), default=0) < 20 and not failed and time.process_time() < 60: time.sleep(0.05)
end.set()
for thread in threads: thread.join()
world.close()
print(failed, min(counts.values()))
"""


@pytest.mark.parametrize("text", [LEGACY, CLASSIC], ids=["legacy", "classic"])
def test_calls_from_other_threads_are_safe(text):
    program = PROGRAM.format(text=text, solid=SOLID, lines=CALLS.strip().splitlines())
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stdout.split()[0]) == (0, "[]"), done.stdout + done.stderr[-2000:]
    assert int(done.stdout.split()[-1]) >= 20, done.stdout


def test_a_call_waits_for_the_end_of_the_step(monkeypatch):
    """And then acts before the next one, however fast the world is stepped."""
    with libgz.World.from_string(LEGACY) as world:
        entered, waited = threading.Event(), []
        model = world.model("one")

        def update(step):
            first, end = not entered.is_set(), time.monotonic() + 20
            entered.set()
            while first and not world.lock.waiting and time.monotonic() < end:
                time.sleep(0.01)
            waited.append(bool(world.lock.waiting))

        monkeypatch.setattr(model, "Update", update)
        thread = threading.Thread(
            target=lambda: (entered.wait(), model.SetPose(GzPose(GzVector(9, 9, 9), GzQuatern(1, 0, 0, 0))))
        )
        thread.start()
        world.step(3)
        assert waited == [True, False, False]
        assert model.GetPose().pos.x == pytest.approx(9, abs=0.1)
        thread.join()


def test_threads_have_the_world_between_the_steps_of_one_call():
    with libgz.World.from_string(LEGACY) as world:
        seen, begun = [], threading.Event()

        def change():
            begun.wait(20)
            for _ in range(3):
                world.engine.gravity = (0, 0, -9.8)
                seen.append(world.iterations)

        thread = threading.Thread(target=change)
        world.model("one").Update = lambda step: (begun.set(), thread.is_alive() and time.sleep(0.005))
        thread.start()
        world.step(30)
        thread.join()
        assert 0 < seen[0] <= seen[1] <= seen[2] < 30
        assert world.lock.holder == 0


def test_native_steps_end_when_a_thread_waits(monkeypatch):
    monkeypatch.setattr("libgz.ode.step.LONGEST", 60.0)
    with libgz.World.from_string(LEGACY.replace("Pioneer2AT", "SimpleSolid")) as world:
        world.step(2)
        seen = []

        def look():
            while world.iterations < 100:
                time.sleep(0.001)
            with world.lock:
                seen.append(world.iterations)

        thread = threading.Thread(target=look)
        thread.start()
        world.step(100)
        while not seen:
            made = world.step_on(100_000_000)
            assert made < 100_000_000
        thread.join()
        assert 100 <= seen[0] < 1_000_000


def test_several_changes_are_one():
    with libgz.World.from_string(LEGACY) as world:
        end, seen = threading.Event(), set()

        def stepper():
            while not end.is_set():
                world.Step()
                seen.add(world.engine.gravity)

        thread = threading.Thread(target=stepper)
        thread.start()
        for _ in range(20):
            with world.lock:
                before = world.iterations
                world.engine.gravity = (0, 0, -1)
                time.sleep(0.001)
                world.engine.gravity = (0, 0, -9.8)
                assert world.iterations == before
        end.set()
        thread.join()
        assert seen <= {(0.0, 0.0, -9.8)}


def test_close_waits_for_the_step_of_another_thread():
    world = libgz.World.from_string(LEGACY)
    failed = []

    def stepper():
        try:
            while True:
                world.Step()
        except ClosedError as error:
            failed.append(error)

    thread = threading.Thread(target=stepper)
    thread.start()
    time.sleep(0.05)
    world.close()
    thread.join(10)
    assert "the world is closed" in str(failed[0])


def test_a_callback_that_waits_for_a_waiting_thread_is_reported(monkeypatch, tmp_path, caplog):
    monkeypatch.setattr(lock_module, "LONG", 0.3)
    path = tmp_path / "net.py"
    path.write_text(
        textwrap.dedent("""
        import contextlib, threading
        from libgz import GZ_REGISTER_PLUGIN, Body, GazeboError, GzPose, GzVector, GzQuatern, Model

        class Net(Model):
            def Load(self, file, node):
                self.AddBody(Body(self.world), True)
            def Update(self, step):
                thread = threading.Thread(target=self.work, name="network")
                thread.start()
                thread.join(1.5)
            def work(self):
                with contextlib.suppress(GazeboError):  # the world may be closed first
                    self.SetPose(GzPose(GzVector(1, 2, 3), GzQuatern(1, 0, 0, 0)))

        GZ_REGISTER_PLUGIN("Net", Net)
        """)
    )
    text = f"<model:Net><id>net1</id><plugin>{path}</plugin></model:Net>"
    text = f"<gz:world xmlns:gz='g' xmlns:model='m'>{text}</gz:world>"
    with caplog.at_level(logging.ERROR, "libgz"), libgz.World.from_string(text) as world:
        world.Step()
    (line,) = [record.getMessage() for record in caplog.records if "has waited" in record.getMessage()]
    assert line.startswith("thread 'network' has waited")
    assert f" for the world, in {path}:14; " in line
    assert f"holds it, in Update of model 'net1' ({path}:11): if that waits for thread 'network'" in line


@pytest.mark.parametrize("method", ["Load", "Init", "Fini"])
def test_a_method_of_a_model_that_waits_for_a_waiting_thread_is_reported(monkeypatch, tmp_path, caplog, method):
    monkeypatch.setattr(lock_module, "LONG", 0.1)
    wait = "thread = threading.Thread(target=self.Work); thread.start(); thread.join(0.5)"
    lines = {name: wait if name == method else "pass" for name in ("Load", "Init", "Fini")}
    path = tmp_path / "net.py"
    path.write_text(
        "import contextlib, threading\nfrom libgz import GZ_REGISTER_PLUGIN, Body, GazeboError, Model\n"
        "class Net(Model):\n"
        "    def Work(self):\n"
        "        with contextlib.suppress(GazeboError):  # the world may be closed first\n"
        "            self.bodies[0].SetLinearVel((0, 0, 1))\n"
        f"    def Load(self, file, node):\n        self.AddBody(Body(self.world), True); {lines['Load']}\n"
        f"    def Init(self, file, node):\n        {lines['Init']}\n"
        f"    def Fini(self):\n        {lines['Fini']}\n"
        "GZ_REGISTER_PLUGIN('Net', Net)\n"
    )
    text = f"<model:Net><id>net1</id><plugin>{path}</plugin></model:Net>"
    with caplog.at_level(logging.ERROR, "libgz"):
        libgz.World.from_string(f"<gz:world xmlns:gz='g' xmlns:model='m'>{text}</gz:world>").close()
    (line,) = [record.getMessage() for record in caplog.records if "has waited" in record.getMessage()]
    assert f"holds it, in {method} of model 'net1' ({path}:" in line


class Counter:
    """A part of a world, with its lock."""

    def __init__(self):
        self.engine, self.lock = self, WorldLock()

    @exclusive
    def hold(self, first, second=2, *, third=3, fourth):
        """Which thread holds the lock, and the arguments."""
        return self.lock.holder, first, second, third, fourth

    @exclusive
    def place(self, first, second=2):
        """Which thread holds the lock, and the arguments."""
        return self.lock.holder, (lambda: first)(), second

    @exclusive
    def fail(self):
        raise ValueError("no")


def test_an_exclusive_method_holds_the_lock_and_keeps_its_parameters():
    part, me = Counter(), threading.get_ident()
    assert part.hold(1, fourth=4) == (me, 1, 2, 3, 4)
    assert part.hold(second=5, first=6, fourth=7, third=8) == (me, 6, 5, 8, 7)
    with part.lock:
        assert part.hold(1, fourth=4) == (me, 1, 2, 3, 4)
        assert part.lock.holder == me
    assert part.lock.holder == 0
    assert str(inspect.signature(part.hold)) == "(first, second=2, *, third=3, fourth)"
    with pytest.raises(TypeError, match="missing 1 required keyword-only argument: 'fourth'"):
        part.hold(1)
    assert part.place(1) == (me, 1, 2)
    assert part.place(second=3, first=4) == (me, 4, 3)
    with part.lock:
        assert part.place(1, second=5) == (me, 1, 5)
    with pytest.raises(TypeError, match="missing 1 required positional argument: 'first'"):
        part.place()


def test_an_exclusive_method_that_raises_releases_the_lock():
    part = Counter()
    with pytest.raises(ValueError, match="no") as caught:
        part.fail()
    assert part.lock.holder == 0
    lines = [entry.line for entry in traceback.extract_tb(caught.value.__traceback__)]
    assert lines[1:] == ["return method({passed})", 'raise ValueError("no")']


def test_the_lock_names_its_holder():
    lock = WorldLock()
    assert (lock.holder, lock.owned()) == (0, False)
    with lock:
        assert (lock.holder, lock.owned()) == (threading.get_ident(), True)


def test_worlds_in_threads_are_independent():
    """A world whose step does not end does not keep another one from stepping."""
    with libgz.World.from_string(LEGACY) as slow, libgz.World.from_string(LEGACY) as quick:
        release = threading.Event()
        slow.model("one").Update = lambda step: release.wait(20)
        thread = threading.Thread(target=slow.Step)
        thread.start()
        quick.step(10)
        release.set()
        thread.join()
        assert (slow.iterations, quick.iterations) == (1, 10)


class Counted:
    """A lock or an event that is waited for: no wait may be long, for a signal may come just before it."""

    def __init__(self, after):
        self.after, self.waits = after, []

    def wait(self, seconds):
        self.waits.append(seconds)
        return len(self.waits) > self.after

    def acquire(self, block=True, timeout=-1):
        return self.wait(timeout)


def test_no_wait_is_long(monkeypatch):
    lock = WorldLock()
    monkeypatch.setattr(lock_module, "LONG", 1e-4)
    lock._lock, reports = Counted(5), []
    lock.report = reports.append
    lock.wait()
    request = Request("save", "-", b"")
    request._answered = Counted(3)
    request.wait()
    assert 0.0 < max(lock._lock.waits + request._answered.waits) <= 0.1
    assert (len(lock._lock.waits), len(request._answered.waits), len(reports) <= 1) == (6, 4, True)


def test_a_wait_for_a_server_is_in_parts(wire, monkeypatch):
    with libgz.World.from_string(LEGACY, server_id=wire) as world, libgz.Client(wire, 0) as client:
        client.wait()
        limits, real = [], semaphores._libc.semtimedop

        def wait(handle, operation, count, limit):
            limits.append(limit._obj.sec + limit._obj.nsec * 1e-9)
            if len(limits) == 3:
                world.Step()
            return real(handle, operation, count, limit)

        monkeypatch.setattr(semaphores._libc, "semtimedop", wait)
        assert client.wait()
        assert (len(limits), max(limits) <= 0.1) == (3, True)
        assert not client.wait(0.15)
        assert not client.wait(0.0)


MANY = f"<sdf version='1.6'><world name='default'>{''.join(BOX.format(f'b{i}', i) for i in range(100))}</world></sdf>"


def run(text):
    """The end of a program whose thread steps a world."""
    program = f"""
import os, sys, threading, time
import libgz
world = libgz.World.from_string({MANY!r})

def step():
    while True:
        world.step(50)

threading.Thread(target=step, daemon=True).start()
while not world.lock.holder:
    time.sleep(0.001)
""" + textwrap.dedent(text)
    return subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)


def test_a_process_may_end_while_a_thread_of_it_steps():
    for _ in range(3):
        ended = run("")
        assert (ended.returncode, ended.stderr) == (0, "")


def test_a_process_forked_in_a_step_ends_and_says_why_it_cannot_step():
    """A lock that is held by a thread that was not forked would be waited for without end; ODE is amid its work."""
    ended = run("""
        child = os.fork()
        if child == 0:
            try:
                world.step()
            except libgz.GazeboError as error:
                print(error, file=sys.stderr)
            sys.exit()
        sys.stderr.write(str(os.waitpid(child, 0)[1]))
        """)
    assert ended.returncode == 0, ended.stderr
    assert ended.stderr.startswith("this process was forked while another thread stepped")
    assert ended.stderr.endswith("\n0")
