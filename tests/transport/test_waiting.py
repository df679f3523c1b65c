"""Waiting for a server's posts."""

import math
import os
import signal
import threading
import time

import pytest
from served import serve

import libgz
from libgz.interfaces.sim import Sim
from libgz.transport.semaphores import SemaphoreSet
from libgz.transport.server import Server


def test_post_is_a_flag_for_each_client(server):
    one, two = (SemaphoreSet.attach(server.server_id) for _ in range(2))
    for _ in range(10):
        server.post()
    assert one.wait(0, 1.0)
    assert not one.wait(0, 0.0)  # ten posts wake once
    assert two.wait(1, 1.0)  # each client has its own flag
    assert not two.wait(1, 0.05)


def test_wait_sleeps_until_the_post(server):
    waiting = SemaphoreSet.attach(server.server_id)
    threading.Timer(0.1, server.post).start()
    begin = time.monotonic()
    assert waiting.wait(5, 10.0)
    assert 0.05 < time.monotonic() - begin < 5.0


def test_a_wait_ends_with_an_error_when_the_server_ends(wire):
    server = Server(wire)
    server.start()
    serve(server, Sim, "default")
    client = libgz.Client(wire)
    threading.Timer(0.1, server.stop).start()
    with pytest.raises(libgz.ServerGoneError, match=f"server {wire} ended"):
        client.wait(timeout=10.0)
    client.disconnect()


def test_signals_do_not_end_a_wait(server):
    waiting = SemaphoreSet.attach(server.server_id)
    seen = []
    before = signal.signal(signal.SIGUSR1, lambda *_: seen.append(1))
    try:
        threading.Timer(0.05, os.kill, (os.getpid(), signal.SIGUSR1)).start()
        threading.Timer(0.2, server.post).start()
        assert waiting.wait(2, 10.0)
    finally:
        signal.signal(signal.SIGUSR1, before)
    assert seen


@pytest.mark.parametrize("timeout", [-1, math.nan])
def test_timeouts_are_checked(server, timeout):
    with pytest.raises(libgz.ParameterError, match="timeout"):
        SemaphoreSet.attach(server.server_id).wait(0, timeout)
