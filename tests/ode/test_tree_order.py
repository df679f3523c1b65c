"""The order in which the tree solver takes the bodies of an island, beside a plain search."""

import random
from pathlib import Path

import pytest
from c_programs import compile_c, needs_compiler, run

SOURCES = Path(__file__).parents[2] / "libgz" / "ode"
PROGRAM = r"""
#include "tree_island.c"
#include <stdio.h>
int main(void)
{
    island w = {0};
    long long bodies, joints, one, two, i;
    int tying;
    while (scanf("%lld %lld", &bodies, &joints) == 2) {
        free(w.bodies);
        free(w.joints);
        w.body_count = bodies;
        w.joint_count = joints;
        w.bodies = calloc((size_t)bodies + 1, sizeof *w.bodies);
        w.joints = calloc((size_t)joints + 1, sizeof *w.joints);
        for (i = 0; i < joints && scanf("%lld %lld %d", &one, &two, &tying) == 3; i++)
            w.joints[i] = (tree_joint){.body = {one, two}, .tying = tying, .side = -1};
        if (!grow_tree(&w))
            return 1;
        for (i = 0; i < w.order_count; i++)
            printf("%lld,%lld ", (long long)w.order[i], (long long)w.bodies[w.order[i]].parent);
        printf("\n");
    }
    return 0;
}
"""


@pytest.fixture(scope="module")
def ordered(tmp_path_factory):
    """A function that gives the (body, parent) of islands, each of (bodies, (one, two, tying) of its joints)."""
    folder = tmp_path_factory.mktemp("order")
    flags = ["-I", str(SOURCES), "-ffunction-sections", "-Wl,--gc-sections", "-lm"]
    program = compile_c(folder, PROGRAM, *flags)  # ODE's functions are left out with what calls them

    def find(islands):
        numbers = ((bodies, len(joints), *sum(joints, ())) for bodies, joints in islands)
        text = "\n".join(" ".join(map(str, row)) for row in numbers)
        lines = run(program, text=text).stdout.split("\n")[:-1]
        return [[tuple(map(int, pair.split(","))) for pair in line.split()] for line in lines]

    return find


def plain(bodies, joints):
    """What joints hold to the world, then whole trees, each from the body with most joints, the first of those."""
    links = [[] for _ in range(bodies)]  # the last joint comes first
    for one, two, tying in joints:
        for body, other in ((one, two), (two, one)):
            if tying and body >= 0:
                links[body].insert(0, other)
    order = []
    taken = {-1}

    def take(body, parent):
        if body not in taken:
            taken.add(body)
            order.append((body, parent))

    for one, two, tying in joints:
        if tying and -1 in (one, two):
            take(max(one, two), -1)
    at = 0
    while True:
        while at < len(order):
            body = order[at][0]
            for other in links[body]:
                take(other, body)
            at += 1
        left = [body for body in range(bodies) if body not in taken]
        if not left:
            return order
        take(max(left, key=lambda body: len(links[body])), -1)


def random_island(seed):
    """Bodies with joints between them, with the world, and contacts, which are no part of a tree."""
    generator = random.Random(seed)
    bodies = generator.randint(1, 12)
    pairs = [(one, two) for one in range(bodies) for two in range(-1, bodies) if one != two]
    joints = generator.choices(pairs, k=generator.randint(0, 2 * bodies)) if pairs else []
    return bodies, [(*pair, generator.randint(0, 2)) for pair in joints]


@needs_compiler
def test_bodies_are_taken_in_the_order_of_a_plain_search(ordered):
    chain = [(i, i + 1, 5) for i in range(9)]
    special = [(0, []), (1, []), (5, []), (10, chain), (10, [(3, -1, 6), *chain]), (4, [(0, 1, 5), (2, 3, 5)])]
    islands = special + [random_island(seed) for seed in range(300)]
    assert ordered(islands) == [plain(*island) for island in islands]
