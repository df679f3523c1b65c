"""Pieces of SDF for tests of sensors: worlds, models, sensors."""

import libgz
from libgz.classic import sensors

G = 9.8


def world_of(content, version="1.6", gravity="0 0 -9.8"):
    holder = f"<gravity>{gravity}</gravity>"
    inside, outside = (holder, "") if version != "1.6" else ("", holder)
    holder = f"{outside}<physics type='ode'>{inside}</physics>"
    return libgz.World.from_string(f"<sdf version='{version}'><world name='default'>{holder}{content}</world></sdf>")


def model(name, link, pose="0 0 0 0 0 0", static=True, more=""):
    return (
        f"<model name='{name}'><static>{str(static).lower()}</static><pose>{pose}</pose>"
        f"<link name='link'>{link}</link>{more}</model>"
    )


def collision(shape, surface="", name="collision", pose="0 0 0 0 0 0"):
    return (
        f"<collision name='{name}'><pose>{pose}</pose><geometry>{shape}</geometry>"
        f"<surface>{surface}</surface></collision>"
    )


def box(name, pose, size="1 1 1", static=True):
    return model(name, collision(f"<box><size>{size}</size></box>"), pose, static)


GROUND = model("ground", collision("<plane><normal>0 0 1</normal></plane>"))


def sensor(kind, content, name="s", rate=0, on=True, pose="0 0 0 0 0 0", more=""):
    return (
        f"<sensor name='{name}' type='{kind}'><always_on>{int(on)}</always_on><update_rate>{rate}</update_rate>"
        f"<pose>{pose}</pose>{content}{more}</sensor>"
    )


def ray(samples=1, angles=(0, 0), reach=(0, 10), vertical=None, noise="", resolution=1):
    def row(tag, count, low, high, step=1):
        return (
            f"<{tag}><samples>{count}</samples><resolution>{step}</resolution>"
            f"<min_angle>{low!r}</min_angle><max_angle>{high!r}</max_angle></{tag}>"
        )

    rows = row("horizontal", samples, *angles, resolution)
    if vertical:
        rows += row("vertical", *vertical)
    return f"<ray><scan>{rows}</scan><range><min>{reach[0]}</min><max>{reach[1]}</max></range>{noise}</ray>"


def get(name):
    found = sensors.get_sensor(name)
    assert found is not None
    return found


def imu(name="s", **options):
    return sensor("imu", "<imu/>", name, **options)


def noise(kind="gaussian", mean=0.0, stddev=0.0, bias=(0.0, 0.0), precision=0.0):
    return (
        f"<noise type='{kind}'><mean>{mean}</mean><stddev>{stddev}</stddev><bias_mean>{bias[0]}</bias_mean>"
        f"<bias_stddev>{bias[1]}</bias_stddev><precision>{precision}</precision></noise>"
    )
