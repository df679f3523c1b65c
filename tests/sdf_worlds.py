"""Pieces of SDF for tests: worlds, models, joints."""

import libgz

GROUND = "<include><uri>model://ground_plane</uri></include>"
SHAPES = {
    "box": "<box><size>1 1 1</size></box>",
    "sphere": "<sphere><radius>0.5</radius></sphere>",
    "cylinder": "<cylinder><radius>0.5</radius><length>1</length></cylinder>",
}


def world(*parts, physics="", gravity="0 0 -9.8"):
    settings = f"<physics type='ode'>{physics}</physics><gravity>{gravity}</gravity>"
    return f"<world name='default'>{settings}{''.join(parts)}</world>"


def collision(shape="box", surface="", name="c", pose="0 0 0 0 0 0", more=""):
    geometry = SHAPES.get(shape, shape)
    surface = f"<surface>{surface}</surface>" if surface else ""
    return f"<collision name='{name}'>{more}<pose>{pose}</pose><geometry>{geometry}</geometry>{surface}</collision>"


def inertial(mass=1.0, moments=(1.0, 1.0, 1.0), pose="0 0 0 0 0 0"):
    inertia = "".join(f"<{key}>{value}</{key}>" for key, value in zip(("ixx", "iyy", "izz"), moments, strict=True))
    return f"<inertial><pose>{pose}</pose><mass>{mass}</mass><inertia>{inertia}</inertia></inertial>"


def link(name="link", *parts, pose="0 0 0 0 0 0"):
    return f"<link name='{name}'><pose>{pose}</pose>{''.join(parts)}</link>"


def model(name, *parts, pose="0 0 0 0 0 0"):
    return f"<model name='{name}'><pose>{pose}</pose>{''.join(parts)}</model>"


def joint(name, kind, parent, child, axis="0 0 1", more="", inside="", pose="0 0 0 0 0 0"):
    aim = f"<axis><xyz>{axis}</xyz>{inside}</axis>" if axis else ""
    ends = f"<parent>{parent}</parent><child>{child}</child><pose>{pose}</pose>"
    return f"<joint name='{name}' type='{kind}'>{ends}{aim}{more}</joint>"


def friction(mu, mu2=None, more=""):
    return f"<friction><ode><mu>{mu}</mu><mu2>{mu if mu2 is None else mu2}</mu2>{more}</ode></friction>"


def two_links(more=""):
    return model("m", link("a", inertial(2.0)), link("b", inertial(1.0), pose="1 0 0 0 0 0"), more)


def place(body):
    """Where a body is [m]."""
    return tuple(body.GetPosition())


class Loader:
    """Loads worlds from text, and closes them all in the end."""

    def __init__(self, folder):
        self.folder = folder
        self.worlds = []

    def __call__(self, body, version="1.6", **options):
        path = self.folder / f"w{len(self.worlds)}.world"
        path.write_text(f"<sdf version='{version}'>{body}</sdf>")
        self.worlds.append(libgz.World.from_file(path, **options))
        return self.worlds[-1]

    def close(self):
        for made in self.worlds:
            made.close()
