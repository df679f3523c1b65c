"""The memory of ODE's objects."""

import os
import subprocess
import sys
from itertools import pairwise

import libgz
from libgz.ode.lib import ode
from libgz.physics.engine import Engine

CACHE_LINE = 64


BESIDE = """
import libgz
from libgz.physics.engine import Engine

engine, kept = Engine(), []
for _ in range(200):
    print(libgz.Body(engine).id)
    kept.append(bytearray(5000))
"""


def test_bodies_lie_beside_each_other_whatever_is_allocated_meanwhile():
    # In a process of its own: where others were freed, their memory is used again in any order.
    done = subprocess.run([sys.executable, "-c", BESIDE], stdout=subprocess.PIPE, check=True, text=True)
    ids = [int(line) for line in done.stdout.split()]
    assert all(number % CACHE_LINE == 0 for number in ids)
    assert sum(0 < two - one < 4096 for one, two in pairwise(ids)) > 180


def test_blocks_are_used_again():
    Engine()  # with the first one the native step is loaded, whose blocks ODE uses from then on
    lib = ode()
    world = lib.dWorldCreate()
    first = [lib.dBodyCreate(world) for _ in range(50)]
    for body in first:
        lib.dBodyDestroy(body)
    assert {lib.dBodyCreate(world) for _ in range(50)} == set(first)
    lib.dWorldDestroy(world)


def test_large_blocks_are_freed_too():
    lib = ode()
    for _ in range(3):
        space = lib.dHashSpaceCreate(None)
        group = lib.dJointGroupCreate(100_000)
        lib.dJointGroupDestroy(group)
        lib.dSpaceDestroy(space)


def test_a_forked_child_allocates():
    engine = Engine()
    child = os.fork()
    if not child:
        os._exit(0 if libgz.Body(engine).id else 1)
    assert os.waitpid(child, 0)[1] == 0
