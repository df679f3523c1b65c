"""States with numbers that no world has, set in a process of its own: `python state_attacks.py VALUE [EACH]`.

Every word of ODE's memory, or each so many, becomes the value, one at a time; what is taken must be able to go on.
"""

from __future__ import annotations

import logging
import math
import struct
import sys

import libgz
from libgz.base.errors import StateError

WORLD = """<sdf version='1.6'><world name='default'>
<model name='ground'><static>1</static><link name='l'><collision name='c'><geometry><plane/></geometry></collision>
</link></model>
<model name='m'><pose>0 0 0.5 0 0 0</pose><link name='a'><collision name='c'><geometry><box><size>1 1 1</size></box>
</geometry></collision></link>
{links}
</model></world></sdf>"""
LINK = """<link name='{0}'><pose>{1} 0 1 0 0 0</pose><collision name='c'><pose>0.1 0 0 0 0 0</pose>
<geometry>{2}</geometry></collision></link>
<joint name='{0}' type='{3}'><parent>a</parent><child>{0}</child>{4}</joint>"""
AXIS = "<axis><xyz>0 0 1</xyz><limit><lower>-1</lower><upper>1</upper></limit></axis>"
KINDS = {
    "revolute": AXIS,
    "prismatic": AXIS,
    "universal": AXIS + AXIS.replace("axis>", "axis2>").replace("0 0 1", "0 1 0"),
    "ball": "",
    "fixed": "",
    "screw": f"<thread_pitch>2</thread_pitch>{AXIS}",
}
SHAPES = (
    "<sphere><radius>.2</radius></sphere>",
    "<cylinder><radius>.2</radius><length>.4</length></cylinder>",
    "<box><size>.2 .3 .4</size></box>",
)
WORDS = {
    "large": struct.pack("d", -1e308),
    "nan": struct.pack("d", math.nan),
    "infinite": struct.pack("d", math.inf),
    "far": struct.pack("d", 3e9),
    "zero": bytes(8),
    "ones": b"\xff" * 8,
    "counts": struct.pack("2i", 2**30, 2**30),
}


def world() -> libgz.World:
    """A world with all shapes and kinds of joints."""
    links = "".join(
        LINK.format(kind, 2 + i, SHAPES[i % len(SHAPES)], kind, axes) for i, (kind, axes) in enumerate(KINDS.items())
    )
    return libgz.World.from_string(WORLD.format(links=links))


def main(name: str, each: str = "1") -> None:
    """Attack the words; print how many values were taken, and how many refused."""
    logging.disable(logging.CRITICAL)
    found = {True: 0, False: 0}
    with world() as made:
        engine = made.engine
        for _ in range(20):
            made.step()
        state = engine.get_state()
        memory, word = state["memory"], WORDS[name]
        for at in range(0, len(memory), 8 * int(each)):
            if memory[at : at + 8] == word:
                continue
            try:
                engine.set_state({**state, "memory": memory[:at] + word + memory[at + 8 :]})
                found[True] += 1
                for _ in range(3):
                    engine.step()
            except StateError:
                found[False] += 1
            engine.set_state(state)
    print(found[True], found[False])


if __name__ == "__main__":
    main(*sys.argv[1:])
