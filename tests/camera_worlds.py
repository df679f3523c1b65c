"""Worlds with cameras, for tests: a world without gravity, a lamp, a solid, a robot with a camera."""

import libgz

HEAD = "<gz:world xmlns:gz='g' xmlns:model='m' xmlns:param='p'><param:Global><gravity>0 0 0</gravity>{}</param:Global>"
LIGHT = "<model:LightSource><xyz>-5 3 8</xyz></model:LightSource>"
ROBOT_WITH_CAMERA = (
    "<model:Pioneer2AT><id>r</id><xyz>0 0 0</xyz>"
    "<model:SonyVID30><id>c</id><xyz>0.1 0 0.34</xyz>{}</model:SonyVID30></model:Pioneer2AT>"
)


def world_of(body, settings="", **options):
    return libgz.World.from_string(f"{HEAD.format(settings)}{body}</gz:world>", **options)


def solid(xyz, size, more=""):
    place = f"<xyz>{xyz}</xyz><size>{size}</size>"
    return f"<model:SimpleSolid><id>s</id>{place}<color>1 0 0</color>{more}</model:SimpleSolid>"
