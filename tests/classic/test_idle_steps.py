"""Steps in which sensors, plugins and topics have nothing to do are made without them, and nobody can tell."""

import resource
import threading
from collections import deque

from sensor_worlds import box, get, imu, model, ray, sensor, world_of

import libgz
from libgz.classic import physics, transport
from libgz.classic.server import attach
from libgz.classic.transport.received import Received
from libgz.classic.transport.topic import Incoming, Topic
from libgz.simulation.pacing import Pacer

SCENE = (
    model("m", imu(rate=100) + sensor("ray", ray(3, (-0.1, 0.1)), "laser", rate=33))
    + box("b", "2 0 1 0.3 0.2 0")
    + model("ground", "<collision name='c'><geometry><plane/></geometry></collision>", static=True)
)


def counted(world, monkeypatch):
    """A list that grows with each step in which the server is called."""
    server, calls = attach(world), []
    real = server.step
    monkeypatch.setattr(server, "step", lambda paused: (calls.append(world.iterations), real(paused)))
    return calls


def test_many_steps_of_one_call_are_single_steps(monkeypatch):
    with world_of(SCENE) as world:
        calls = counted(world, monkeypatch)
        world.step(1000)
        state, times = world.get_state(), [get(name).LastMeasurementTime() for name in ("s", "laser")]
    assert 100 <= len(calls) < 200  # the measurements, and what looks for bodies that fell
    with world_of(SCENE) as world:
        for _ in range(1000):
            world.Step()
        assert [get(name).LastMeasurementTime() for name in ("s", "laser")] == times
        assert world.get_state() == state


def test_whoever_wants_something_is_called_in_each_step(monkeypatch):
    with world_of(SCENE) as world:
        calls = counted(world, monkeypatch)
        begun = []
        connection = physics.get_world().core.events["WorldUpdateBegin"].Connect(lambda info: begun.append(info))
        world.step(20)
        assert len(begun) == len(calls) == 20
        connection.Disconnect()
        kept = attach(world).activity.joint_update.Connect(lambda: None)
        world.step(20)
        assert len(calls) == 40
        kept.Disconnect()
        physics.get_world().ModelByName("m").GetJointController()  # is a row of native code
        world.step(20)
        assert len(calls) < 50


def test_a_subscriber_hears_of_the_next_step():
    with world_of(SCENE) as world:
        world.step(5)
        node, heard = transport.Node(), []
        node.Init("default")
        kept = node.Subscribe("~/physics/contacts", heard.append)
        world.step(10)
        assert len(heard) >= 9
        kept.Unsubscribe()


def test_paced_steps_follow_each_other_without_python(monkeypatch):
    monkeypatch.setattr("libgz.simulation.pacing.LONGEST_RUN", 60.0)
    with world_of(SCENE) as world:
        world.step(11)  # then the IMU is due in 9 steps, at the earliest
        pacer = Pacer(1e-3 / 2e-4)  # a step is due each 0.2 ms
        while not pacer.sleep(world.GetSimTime()):
            pass
        begin = world.GetRealTime()
        assert world.step_on(5, pacer) == 5
        assert world.GetRealTime() - begin >= 4 * 2e-4


PHYSICS = "<physics type='ode'><max_step_size>0.001</max_step_size></physics>"
EMPTY = f"<sdf version='1.6'><world name='w'>{PHYSICS}</world></sdf>"


def started(world, speed):
    """A pacer whose first step is due."""
    pacer = Pacer(speed)
    while not pacer.sleep(world.GetSimTime()):
        pass
    return pacer


def test_steps_of_a_world_at_rest_share_a_wake_up(monkeypatch):
    monkeypatch.setattr("libgz.simulation.pacing.LONGEST_RUN", 60.0)
    with libgz.World.from_string(EMPTY) as world:
        world.step(256)  # until Python looks for bodies that fell
        pacer = started(world, 10.0)
        before = resource.getrusage(resource.RUSAGE_THREAD).ru_nvcsw
        assert world.step_on(250, pacer) == 250  # of 0.1 ms of real time
        assert resource.getrusage(resource.RUSAGE_THREAD).ru_nvcsw - before <= 15


def test_python_looks_at_a_paced_world_less_often():
    with libgz.World.from_string(EMPTY) as world:
        world.step(256)
        pacer = started(world, 1.0)
        made = []
        for _ in range(10):  # a busy machine may end some of them early
            made.append(world.step_on(1000, pacer))
            while not pacer.sleep(world.GetSimTime()):
                pass
        assert max(made) > 30


def waiting_world(monkeypatch):
    """A world, and a pacer by which its next step but one is due in a minute."""
    monkeypatch.setattr("libgz.simulation.pacing.LONGEST_RUN", 1e9)
    world = libgz.World.from_string(EMPTY)
    world.step(3)
    return world, started(world, 1e-3 / 60.0)


def test_whoever_wants_a_world_that_waits_for_its_next_step_has_it_at_once(monkeypatch):
    world, pacer = waiting_world(monkeypatch)
    with world:
        found, ended = [], threading.Event()

        def look():
            while not ended.is_set():
                with world.lock:
                    found.append(world.iterations)

        looker = threading.Thread(target=look)
        looker.start()
        assert world.step_on(10, pacer) == 1
        ended.set()
        looker.join()
        assert set(found) <= {3, 4}
        assert found[-1] == 4


def test_whoever_waited_before_steps_were_begun_is_not_kept_until_the_next_step(monkeypatch):
    world, pacer = waiting_world(monkeypatch)
    with world:
        world.lock.waiting[0] = 0.0  # its `interrupt` came before the steps
        assert world.step_on(10, pacer) == 1
        del world.lock.waiting[0]


def test_a_message_of_another_process_wakes_a_world_that_waits_for_its_next_step(monkeypatch):
    world, pacer = waiting_world(monkeypatch)
    manager, topic, ended = transport.TopicManager.Instance(), Topic("~/none"), threading.Event()
    monkeypatch.setattr(manager, "locks", {world.lock})
    monkeypatch.setattr(manager, "received", Received())
    with world:

        def send():
            while not ended.wait(1e-3):
                manager.receive(topic, Incoming(0, "t", b"", None), deque())

        sender = threading.Thread(target=send)
        sender.start()
        assert world.step_on(10, pacer) == 1
        ended.set()
        sender.join()
