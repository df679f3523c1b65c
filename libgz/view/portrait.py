"""Portraits of models, for a catalogue: a process of its own, which loads no plugins and takes little memory and time.

It reads requests from its standard input, a line of JSON each with the ``text`` of a model, legacy or SDF, and answers
each on its standard output: the length of a JPEG in a line, then its bytes; a length of 0 where there is no portrait.
"""

from __future__ import annotations

import io
import json
import logging
import os
import resource
import sys
from typing import BinaryIO

from libgz.base.errors import GazeboError
from libgz.base.trust import distrust
from libgz.front import World
from libgz.rendering.framing import visible_points

__all__ = ["SIZE", "main", "portrait"]

log = logging.getLogger("libgz.view")

SIZE = 256, 192  # [px]
OVERSAMPLING = 2
MEMORY = 4 << 30  # [byte] of address space
QUALITY = 85
SETTINGS = (
    "<gz:world xmlns:gz='gz' xmlns:model='model' xmlns:param='param'>"
    "<param:Global><gravity>0 0 0</gravity><skyColor>0.87 0.89 0.92</skyColor>"
    "</param:Global><model:LightSource><id>sun</id><xyz>-6 9 16</xyz></model:LightSource>"
)
SCENE = (
    "<sdf version='1.6'><world name='portrait'><gravity>0 0 0</gravity><scene><ambient>0.3 0.3 0.3 1</ambient>"
    "<background>0.87 0.89 0.92 1</background><grid>false</grid></scene><light name='portrait_sun' type='directional'>"
    "<direction>0.6 0.1 -0.9</direction><diffuse>0.7 0.7 0.7 1</diffuse><cast_shadows>true</cast_shadows></light>"
)


def portrait(text: str) -> bytes:
    """A portrait of a model as JPEG.

    Args:
        text: a `<model:...>` element, or the `<include>` or `<model>` of an SDF world.

    Raises:
        GazeboError: the model does not load, or nothing renders here.
    """
    from PIL import Image

    legacy = text.lstrip().startswith("<model:")
    source = f"{SETTINGS}{text}</gz:world>" if legacy else f"{SCENE}{text}</world></sdf>"
    width, height = SIZE
    with World.from_string(source) as world:
        bodies = [body for entity in world.entities for body in entity.bodies]
        if not len(visible_points(bodies)):
            raise GazeboError("nothing of the model is visible")
        image = Image.fromarray(world.image(OVERSAMPLING * width, OVERSAMPLING * height))
    file = io.BytesIO()
    image.resize(SIZE, Image.Resampling.LANCZOS).save(file, "jpeg", quality=QUALITY)
    return file.getvalue()


def main(requests: BinaryIO, answers: BinaryIO) -> None:
    """Answer requests until there are no more."""
    for line in requests:
        try:
            image = portrait(str(json.loads(line)["text"]))
        except GazeboError as error:
            log.info("there is no portrait: %s", error)
            image = b""
        answers.write(b"%d\n" % len(image) + image)
        answers.flush()


if __name__ == "__main__":
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    distrust()
    own = os.dup(1)
    os.dup2(2, 1)  # what a library prints is no answer
    with os.fdopen(own, "wb") as out:
        main(sys.stdin.buffer, out)
