"""Noise of sensors: its figures, its seeds."""

import math
import statistics

import numpy as np
import pytest
from sensor_worlds import box, get, model, noise, ray, sensor, world_of

import libgz
from libgz.base.errors import NotFoundError
from libgz.classic import sensors
from libgz.classic.sensors.noise import GaussianNoiseModel


def test_noise_has_its_mean_deviation_and_bias():
    rate = f"<x>{noise(mean=1.0, stddev=0.1)}</x><y>{noise(bias=(2.0, 0.0))}</y>"
    content = f"<imu><angular_velocity>{rate}</angular_velocity></imu>"
    with world_of(model("m", sensor("imu", content))) as world:
        one, got = get("s"), []
        for _ in range(1000):
            world.step(1)
            got.append(tuple(one.AngularVelocity()))
        x, y, z = zip(*got, strict=True)
        assert statistics.mean(x) == pytest.approx(1.0, abs=3 * 0.1 / math.sqrt(1000))
        assert statistics.stdev(x) == pytest.approx(0.1, rel=0.1)
        assert set(map(abs, y)) == {2.0}
        assert len(set(y)) == 1
        assert set(z) == {0.0}
        assert tuple(one.AngularVelocity(noiseFree=True)) == (0.0, 0.0, 0.0)
        kind = sensors.SensorNoiseType.IMU_ANGVEL_X_NOISE_RADIANS_PER_S
        assert one.Noise(kind).GetStdDev() == 0.1
        one.Noise(kind).SetCustomNoiseCallback(lambda value: value + 7.0)
        world.step(1)
        assert one.AngularVelocity().x == 7.0
        with pytest.raises(NotFoundError, match="has no noise"):
            one.Noise(sensors.RAY_NOISE)


def test_noise_of_sdf_1_4_is_on_all_axes_and_quantized_noise_is_rounded():
    old = (
        "<imu><noise><type>gaussian</type><rate><mean>3</mean><stddev>0</stddev></rate>"
        "<accel><mean>1</mean><stddev>0</stddev></accel></noise></imu>"
    )
    with world_of(model("m", sensor("imu", old)), "1.4") as world:
        world.step(1)
        assert tuple(get("s").AngularVelocity()) == (3.0, 3.0, 3.0)
        assert tuple(get("s").LinearAcceleration()) == pytest.approx((1, 1, 10.8))
    rounded = noise("gaussian_quantized", 0.26, precision=0.5)
    content = f"<altimeter><vertical_position>{rounded}</vertical_position></altimeter>"
    with world_of(model("m", sensor("altimeter", content))) as world:
        world.step(1)
        assert get("s").Altitude() == 0.5


def test_two_runs_with_one_seed_are_equal_and_sensors_have_noise_of_their_own():
    content = ray(50, (-0.5, 0.5), (0.1, 10), noise="<noise><type>gaussian</type><stddev>0.1</stddev></noise>")
    scene = model("m", sensor("ray", content, "a") + sensor("ray", content, "b")) + box("b", "3 0 0 0 0 0", "1 9 9")

    def run(seed):
        text = f"<sdf version='1.6'><world name='default'>{scene}</world></sdf>"
        with libgz.World.from_string(text, seed=seed) as world:
            world.step(5)
            return get("a").Ranges(), get("b").Ranges()

    first, again, other = run(1), run(1), run(2)
    assert first == again
    assert first != other
    assert first[0] != first[1]
    angles = np.linspace(-0.5, 0.5, 50)
    assert np.std(np.array(first[0]) - 2.5 / np.cos(angles)) == pytest.approx(0.1, rel=0.35)


def test_custom_noise_is_what_a_plugin_sets():
    content = ray(3, (-0.5, 0.5), (0.1, 10), noise="<noise><type>custom</type></noise>")
    with world_of(model("m", sensor("ray", content)) + box("b", "3 0 0 0 0 0", "1 9 9")) as world:
        world.step(1)
        kind = sensors.SensorNoiseType.RAY_NOISE
        assert get("s").Range(1) == pytest.approx(2.5)
        assert get("s").Noise(kind).GetNoiseType() == get("s").Noise(kind).CUSTOM
        get("s").Noise(kind).SetCustomNoiseCallback(lambda value: 0.5 * value)
        world.step(1)
        assert get("s").Range(1) == pytest.approx(1.25)


def test_a_standard_deviation_of_minus_zero_is_zero():
    model = GaussianNoiseModel(0.5, -0.0, 0.0, -0.0)
    assert model.Apply(1.0) == 1.5
