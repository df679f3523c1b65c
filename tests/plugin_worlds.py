"""Pieces of SDF for tests of plugins: bodies, hinges, plugins; worlds made of them."""

from topics import send

import libgz
from libgz.classic import msgs, physics
from libgz.classic.math import Pose3d

HINGE = """<joint name='{name}' type='revolute'>
  <parent>world</parent><child>link</child><axis><xyz>0 0 1</xyz></axis>
</joint>"""
GROUND = "<include><uri>model://ground_plane</uri></include>"


def keep_to(folder, monkeypatch):
    """Only the plugins and models that come with libgz are found."""
    monkeypatch.setenv("HOME", str(folder / "home"))
    for variable in ("GAZEBO_PLUGIN_PATH", "GAZEBO_MODEL_PATH"):
        monkeypatch.delenv(variable, raising=False)


def worlds_of_elements():
    """Yields a function that makes a world of some elements, (engine's world, view); closes all worlds in the end."""
    worlds = []

    def load(*inside, version="1.6", **options):
        text = f"<sdf version='{version}'><world name='default'>{''.join(inside)}</world></sdf>"
        worlds.append(libgz.World.from_string(text, **options))
        return worlds[-1], physics.get_world()

    yield load
    for world in worlds:
        world.close()


def plugin(name, **elements):
    inside = "".join(f"<{key}>{value}</{key}>" for key, value in elements.items())
    return f"<plugin name='{name}' filename='lib{name.removeprefix('lib')}.so'>{inside}</plugin>"


def body(name, pose="0 0 0 0 0 0", mass=1.0, inside="", link="", gravity="true"):
    inertia = "<inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia>"
    return (
        f"<model name='{name}'><pose>{pose}</pose><link name='link'><gravity>{gravity}</gravity>"
        f"<inertial><mass>{mass}</mass>{inertia}</inertial>{link}</link>{inside}</model>"
    )


def collision(shape, pose="0 0 0 0 0 0", name="c"):
    return f"<collision name='{name}'><pose>{pose}</pose><geometry>{shape}</geometry></collision>"


def wheel(name, x, y):
    """A driven wheel of a base, whose joint has the wheel's name."""
    shape = "<cylinder><radius>0.1</radius><length>0.05</length></cylinder>"
    inertia = "<inertia><ixx>0.002</ixx><iyy>0.002</iyy><izz>0.003</izz></inertia>"
    return (
        f"<link name='{name}_wheel'><pose>{x} {y} 0.1 -1.5707963 0 0</pose>"
        f"<inertial><mass>0.5</mass>{inertia}</inertial>{collision(shape)}</link>"
        f"<joint name='{name}' type='revolute'><parent>base</parent><child>{name}_wheel</child>"
        "<axis><xyz>0 0 1</xyz></axis></joint>"
    )


def command(topic, speed, turn=0.0):
    message = msgs.Pose()
    msgs.Set(message, Pose3d(speed, 0.0, 0.0, 0.0, 0.0, turn))
    return send(topic, message)
