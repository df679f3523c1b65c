"""Wireless transmitters and receivers: the formula of Gazebo's model, what is heard, messages, wrong values."""

import math

import pytest
from sensor_worlds import box, get, model, sensor, world_of

from libgz.base.geometry import GzPose, GzVector
from libgz.classic import msgs, transport

WIFI = "<essid>osrf</essid><frequency>2442</frequency><power>14.5</power><gain>2.6</gain>"
FAR = "<essid>far</essid><frequency>5000</frequency>"
MEAN = 6.0 * math.sqrt(2.0 / math.pi)  # [dB] of the absolute value of a normal distribution


def transmitter(name="tx", content=WIFI, pose="0 0 1 0 0 0", more="", link=""):
    antenna = f"<transceiver>{content}</transceiver>"
    return model(name, link + sensor("wireless_transmitter", antenna, name=name, rate=1, more=more), pose)


def receiver(pose="4 0 1 0 0 0", content=""):
    return model("rx", sensor("wireless_receiver", f"<transceiver>{content}</transceiver>", name="rx", rate=100), pose)


def without_fading(distance, exponent=6.0):
    wave = 299792458.0 / 2442e6
    return 14.5 + 2.6 + 2.5 + 20.0 * math.log10(wave / 4.0 / math.pi) - 10.0 * exponent * math.log10(distance)


def levels(found, distance, count=2000):
    at = GzPose(GzVector(distance, 0.0, 1.0))
    return [found.SignalStrength(at, 2.5) for _ in range(count)]


@pytest.mark.parametrize("distance", [0.0, 0.5, 4.0, 9.0])
def test_the_signal_falls_with_distance_and_fades(distance):
    with world_of(transmitter()) as core:
        core.step(1)
        found = levels(get("tx"), distance)
    most = without_fading(max(1.0, distance))
    assert max(found) == pytest.approx(most, abs=0.05)
    assert max(found) <= most
    assert sum(found) / len(found) == pytest.approx(most - MEAN, abs=0.4)  # five standard errors


def test_a_collision_between_both_ends_doubles_the_loss_with_distance():
    with world_of(transmitter() + box("wall", "2 0 1 0 0 0")) as core:
        core.step(1)
        assert max(levels(get("tx"), 4.0)) == pytest.approx(without_fading(4.0, 12.0), abs=0.05)


def test_a_receiver_lists_the_transmitters_in_its_band_and_reach():
    heard = []
    far = transmitter("far", FAR, "0 5 1 0 0 0") + transmitter("weak", WIFI, "400 0 1 0 0 0")
    with world_of(transmitter() + far + receiver()) as core:
        node = transport.Node()
        node.Init("default")
        kept = node.Subscribe("~/rx/link/rx/transceiver", heard.append)
        core.run(0.105)
        kept.Unsubscribe()
        found = get("rx")
        assert (found.MinFreqFiltered(), found.MaxFreqFiltered(), found.Sensitivity()) == (2412.0, 2484.0, -90.0)
        assert (found.Gain(), found.Power(), get("tx").ESSID(), get("tx").Freq()) == (2.5, 14.5, "osrf", 2442.0)
    assert len(heard) == 10
    assert isinstance(heard[0], msgs.WirelessNodes)
    assert {(node.essid, node.frequency) for message in heard for node in message.node} == {("osrf", 2442.0)}
    strengths = [message.node[0].signal_level for message in heard]
    assert all(-90.0 <= level <= without_fading(4.0) for level in strengths)
    assert len({*strengths}) == len(strengths)


def test_nothing_is_published_where_nothing_is_heard():
    heard = []
    with world_of(transmitter(pose="400 0 1 0 0 0") + receiver()) as core:
        node = transport.Node()
        node.Init("default")
        kept = node.Subscribe("~/rx/link/rx/transceiver", heard.append)
        core.run(0.05)
        kept.Unsubscribe()
    assert not heard


def test_viewers_get_the_signal_around_a_visualized_transmitter():
    heard = []
    with world_of(transmitter(more="<visualize>1</visualize>")) as core:
        node = transport.Node()
        node.Init("default")
        kept = node.Subscribe("~/tx/link/tx/transceiver", heard.append)
        core.run(1.01)
        kept.Unsubscribe()
    points = {(point.x, point.y) for point in heard[0].particle}
    assert len(points) == 317  # within 10 m, one each metre
    assert {(-10.0, 0.0), (0.0, 0.0), (6.0, 8.0)} <= points
    assert (8.0, 8.0) not in points


def test_runs_and_resets_repeat_the_fading():
    def strengths(core):
        core.step(1)
        return levels(get("tx"), 4.0, 3)

    with world_of(transmitter()) as core:
        first = strengths(core)
        core.Reset()
        assert strengths(core) == first
        state = core.get_state()
        later = strengths(core)
        core.set_state(state)
        assert strengths(core) == later


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("<gain>-1</gain>", "<gain>: is -1 dBi; it must be at least 0 dBi"),
        ("<frequency>0</frequency>", "<frequency>: is 0 MHz; it must be above 0"),
    ],
)
def test_wrong_values_are_replaced_with_a_warning(content, message, caplog):
    with world_of(transmitter(content=content)) as core:
        core.step(1)
    assert message in caplog.text
