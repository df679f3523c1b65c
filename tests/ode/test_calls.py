"""The calls into which ODE divides a step."""

import ctypes
from contextlib import contextmanager

import pytest
from engine_parts import box, solid, unsolvable

from libgz.ode.lib import ode
from libgz.physics.engine import Engine


def steps(engine, count):
    for _ in range(count):
        engine.step()


@contextmanager
def counted_blocks():
    """Counts what ODE allocates meanwhile and has not freed."""
    get = ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_size_t)
    drop = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_size_t)
    shared = ctypes.CDLL(ode().path)
    shared.dGetAllocHandler.restype = shared.dGetFreeHandler.restype = ctypes.c_void_p
    other_get, other_drop = get(shared.dGetAllocHandler()), drop(shared.dGetFreeHandler())
    blocks = set()

    @get
    def get_block(size):
        block = other_get(size)
        blocks.add(block)
        return block

    @drop
    def drop_block(block, size):
        blocks.discard(block)
        other_drop(block, size)

    shared.dSetAllocHandler(get_block)
    shared.dSetFreeHandler(drop_block)
    try:
        yield blocks
    finally:
        shared.dSetAllocHandler(other_get)
        shared.dSetFreeHandler(other_drop)


def test_ode_keeps_nothing_of_abandoned_steps():
    engine, _ = unsolvable()
    steps(engine, 2)
    with counted_blocks() as blocks:
        steps(engine, 50)
    assert engine.abandoned
    assert not blocks


def test_calls_of_abandoned_steps_are_used_again():
    engine, _ = unsolvable()
    steps(engine, 2)
    before = engine.native.calls_made
    steps(engine, 50)
    assert engine.abandoned
    assert 0 < before == engine.native.calls_made


@pytest.mark.parametrize("solver", ["world", "quick"])
def test_a_step_after_an_abandoned_one_is_the_same(solver):
    def run(*, abandon):
        engine = Engine(solver=solver)
        bodies = [solid(engine, box(0.1, 0.1, 0.1), position=(0, 0, 1 + 0.09 * i)) for i in range(5)]
        broken, _ = unsolvable()
        for _ in range(20):
            if abandon:
                broken.step()
            engine.step()
        assert broken.abandoned is abandon
        return [tuple(body.GetPosition()) for body in bodies]

    assert run(abandon=True) == run(abandon=False)
