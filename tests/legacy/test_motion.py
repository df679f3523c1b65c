"""With all quirks, worlds move as the old server's did: its measured motion, in all nine digits that there are."""

import itertools

import pytest

import libgz
from libgz.base.geometry import GzQuaternToEuler
from libgz.simulation.rate import OldRate

GLOBAL = (
    "<param:Global><gravity>0 0 -9.8</gravity><stepTime>0.02</stepTime><legacyQuirks>true</legacyQuirks></param:Global>"
)
HEAD = f"<gz:world xmlns:gz='g' xmlns:model='m' xmlns:param='p'>{GLOBAL}<model:GroundPlane/>"
DIGITS = 2e-9  # [m], [rad], [V]


def world_of(body):
    return libgz.World.from_string(f"{HEAD}{body}</gz:world>")


def run_until(world, when):
    """Step up to a sim time [s]."""
    world.step(round(when / 0.02) - world.iterations)


# Sim time [s]; true x, y, z [m], yaw [rad]; odometric x, y [m], yaw [rad]; battery [V]; time of the interface [s].
DRIVE = (
    (
        2.0, 0.0, 0.0, 0.001319004, 0.0,
        0.0, 0.0, 0.0, 12.398888889, 1.92,
    ),
    (
        7.0, 1.493697183, 0.0, 0.001319004, 0.0,
        1.488, 0.0, 0.0, 12.396107540, 6.92,
    ),
    (
        12.0, 2.993697183, 0.0, 0.001319004, 0.0,
        2.988, 0.0, 0.0, 12.393326162, 11.92,
    ),
    (
        14.5, 3.002706495, -0.028347958, 0.001319004, 0.906796250,
        3.0, 0.0, 1.229998299, 12.391937066, 14.42,
    ),
    (
        17.0, 3.002833675, -0.028347962, 0.001319004, 1.940354262,
        3.0, 0.0, 2.479997951, 12.390547996, 16.92,
    ),
    (
        19.5, 2.564678977, 0.561788602, 0.001319004, 2.447387482,
        2.305855064, 0.196297177, 3.237998622, 12.389157268, 19.42,
    ),
    (
        22.0, 1.891051898, 0.921137916, 0.001319005, 3.018392576,
        1.652212213, -0.134421337, 3.987998504, 12.387766514, 21.92,
    ),
    (
        24.0, 1.884826087, 0.922500876, 0.001319004, 3.023923775,
        1.644287098, -0.143431951, 3.999998500, 12.386655373, 23.92,
    ),
)  # fmt: skip
COMMANDS = (
    (2.0, 0.3, 0.0),
    (12.0, 0.0, 0.5),
    (17.0, 0.3, 0.3),
    (22.0, 0.0, 0.0),
)  # [s], [m/s], [rad/s]


def test_a_pioneer2at_drives_straight_turns_and_arcs_as_it_did():
    with world_of("<model:Pioneer2AT><id>r</id></model:Pioneer2AT>") as world:
        position, robot = world.interface("position", "r"), world.model("r")
        commands = {when: speeds for when, *speeds in COMMANDS}
        for when, *expected in DRIVE:
            run_until(world, when)
            place, way = robot.GetPose(), robot.odometry.pose
            yaw = GzQuaternToEuler(place.rot).z
            found = [*place.pos, yaw, *way, robot.battery.level, position.time]
            assert found == pytest.approx(expected, abs=DIGITS), when
            if when in commands:
                position.command(vx=commands[when][0], vyaw=commands[when][1])


# Sim time [s], pan and tilt [rad] after a command at 1 s; the tick of 1.0 s comes at 1.04 s, by the sums of 0.02 s.
TURN = (
    (1.04, -0.000000000, 0.000000000),
    (1.06, 0.020000000, -0.011999800),
    (1.2, 0.148000000, -0.088799611),
    (1.5, 0.319776000, -0.191866801),
    (1.8, 0.407725312, -0.244636149),
    (2.1, 0.452755360, -0.271653760),
    (2.4, 0.475810744, -0.285486733),
    (2.7, 0.487615101, -0.292569208),
    (3, 0.493658932, -0.296195435),
    (3.3, 0.496753373, -0.298052063),
    (3.6, 0.498337727, -0.299002656),
    (3.9, 0.499148916, -0.299489360),
)


def test_a_camera_head_moves_as_it_did():
    body = "<model:Pioneer2AT><model:SonyVID30><id>c</id><xyz>0.10 0 0.34</xyz></model:SonyVID30></model:Pioneer2AT>"
    with world_of(body) as world:
        run_until(world, 1.0)
        world.interface("ptz", "c").command(pan=0.5, tilt=-0.3)
        camera = world.model("c")
        for when, pan, tilt in TURN:
            run_until(world, when)
            assert (camera.pan.GetAngle(), camera.tilt.GetAngle()) == pytest.approx((pan, tilt), abs=DIGITS), when


# Sim time [s], height of the box's and the ball's lowest point [m].
FALL = (
    (0.3, 0.029600000, 0.029600000),
    (0.4, 0.075590756, 0.074844888),
    (0.5, 0.123279200, 0.121600998),
    (0.6, 0.072967645, 0.070357107),
    (0.7, 0.000292015, 0.003303751),
    (0.8, -0.000002451, -0.000009742),
    (3.0, -0.000002450, -0.000009800),
)


def test_a_box_and_a_ball_fall_bounce_and_rest_as_they_did():
    def solid(shape, size):
        words = f"<id>{shape}</id><xyz>{4 * (shape == 'sphere')} 0 0.5</xyz><shape>{shape}</shape>"
        return f"<model:SimpleSolid>{words}<size>{size}</size><mass>1</mass></model:SimpleSolid>"

    with world_of(solid("box", "0.3 0.3 0.3") + solid("sphere", "0.3")) as world:
        for when, box, ball in FALL:
            run_until(world, when)
            assert world.model("box").GetPose().pos.z == pytest.approx(box, abs=DIGITS), when
            assert world.model("sphere").GetPose().pos.z == pytest.approx(ball, abs=DIGITS), when


def test_old_ticks_are_those_that_were_measured():
    def ticks(rate, until=4.0):
        now, found = 0.0, []
        while now < until:
            if rate.due(now):
                found.append(round(now, 6))
            now += 0.02
        return found

    head = ticks(OldRate(0.1, last=-0.1))
    assert head[:11] == [0.0, 0.1, 0.22, 0.32, 0.42, 0.52, 0.62, 0.72, 0.82, 0.92, 1.04]
    assert head[11:] == pytest.approx([1.14 + 0.1 * i for i in range(len(head) - 11)])
    robot = ticks(OldRate(1.0 / (10.0 + 1e-6), last=-1.0 / (10.0 + 1e-6), beyond=True))
    assert robot == pytest.approx([0.02 + 0.1 * i for i in range(40)])
    gps = ticks(OldRate(1.0, last=0.0, beyond=True), 12.0)
    assert {round(b - a, 6) for a, b in itertools.pairwise(gps)} <= {1.0, 1.02}
    rate = OldRate(0.1, last=0.0)
    assert rate.due(5.0)
    assert not rate.due(5.02)
    assert rate.due(0.0), "time was set back"
