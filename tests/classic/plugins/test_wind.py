"""WindPlugin: rise, sine, noise and force by their formulas."""

import math

import numpy as np
import pytest
from plugin_worlds import body, plugin

NO_GRAVITY = "<gravity>0 0 0</gravity>"
WINDY = "<enable_wind>true</enable_wind>"


def wind(velocity="3 4 0"):
    return f"<wind><linear_velocity>{velocity}</linear_velocity></wind>"


def horizontal(magnitude="", direction=""):
    return {"horizontal": f"<magnitude>{magnitude}</magnitude><direction>{direction}</direction>"}


RISE = "<time_for_rise>{}</time_for_rise>"


def test_speed_and_direction_rise(run):
    parts = {**horizontal(RISE.format(0.5), RISE.format(0.25)), "vertical": RISE.format(0.2)}
    core, world = run(NO_GRAVITY, wind("3 4 2"), body("a", inside=WINDY), plugin("WindPlugin", **parts))
    link = world.ModelByName("a").GetLink()
    speed = direction = up = 0.0
    for _ in range(300):
        core.step(1)
        speed += 0.001 / 0.5 * (5.0 - speed)
        direction += 0.001 / 0.25 * (math.degrees(math.atan2(4.0, 3.0)) - direction)
        up += 0.001 / 0.2 * (2.0 - up)
        found = link.WorldWindLinearVel()
        assert math.hypot(found.X(), found.Y()) == pytest.approx(speed)
        assert math.degrees(math.atan2(found.Y(), found.X())) == pytest.approx(direction)
        assert found.Z() == pytest.approx(up)


def test_the_force_is_that_of_the_relative_wind(run):
    factor = 2.0
    rises = {**horizontal(RISE.format(0.001), RISE.format(0.001)), "vertical": RISE.format(0.001)}
    parts = {**rises, "force_approximation_scaling_factor": factor}
    core, world = run(
        NO_GRAVITY,
        wind("3 4 5"),
        body("a", mass=7.0, inside=WINDY, pose="0 0 0 0 0 1"),
        body("b"),
        plugin("WindPlugin", **parts),
    )
    velocity = np.zeros(3)
    for _ in range(500):
        core.step(1)
        velocity += 0.001 * factor * ((3.0, 4.0, 5.0) - velocity)
        found = world.ModelByName("a").WorldLinearVel()
        np.testing.assert_allclose((found.X(), found.Y(), found.Z()), velocity, rtol=1e-9)
    assert velocity[0] == pytest.approx(3.0 * (1.0 - math.exp(-factor * 0.5)), rel=2e-3)
    assert world.ModelByName("b").WorldLinearVel().Length() == 0.0


def test_without_a_factor_there_is_no_force(run, caplog):
    core, world = run(NO_GRAVITY, wind(), body("a", inside=WINDY), plugin("WindPlugin", **horizontal()))
    core.step(100)
    assert world.ModelByName("a").WorldLinearVel().Length() == 0.0
    assert "no force without a <force_approximation_scaling_factor>" in caplog.text


def test_a_link_falls_in_the_wind_as_in_gazebo(run):
    """Where Gazebo 11.1 has it after 1 s: 9.8 m/s^2, drag 1/s, wind 3 0 2 of which the vertical part rises for 1 s."""
    parts = {**horizontal(RISE.format(0.001), RISE.format(0.001)), "force_approximation_scaling_factor": 1}
    core, world = run(wind("3 0 2"), body("a", inside=WINDY, pose="0 0 50 0 0 0"), plugin("WindPlugin", **parts))
    core.step(1000)
    place = world.ModelByName("a").WorldPose().Pos()
    assert (place.X(), place.Y(), place.Z()) == pytest.approx((1.105, 0.0, 46.5984), abs=2e-3)


def test_the_wind_varies_as_a_sine(run):
    sine = "<sin><{}>{}</{}><period>0.2</period></sin>"
    parts = horizontal(
        RISE.format(0.001) + sine.format("amplitude_percent", 0.5, "amplitude_percent"),
        RISE.format(0.001) + sine.format("amplitude", 30, "amplitude"),
    )
    core, world = run(NO_GRAVITY, wind("2 0 0"), body("a", inside=WINDY), plugin("WindPlugin", **parts))
    link = world.ModelByName("a").GetLink()
    for _ in range(200):
        core.step(1)
        wave = math.sin(2.0 * math.pi * core.GetSimTime() / 0.2)
        found = link.WorldWindLinearVel()
        assert math.hypot(found.X(), found.Y()) == pytest.approx(2.0 * (1.0 + 0.5 * wave))
        assert math.degrees(math.atan2(found.Y(), found.X())) == pytest.approx(30.0 * wave, abs=1e-6)


def test_noise_has_its_spread_and_is_in_the_state(run):
    noise = "<noise type='gaussian'><mean>0</mean><stddev>{}</stddev></noise>"
    parts = {
        **horizontal(RISE.format(0.001) + noise.format(0.1), RISE.format(0.001)),
        "vertical": RISE.format(0.001) + noise.format(0.3),
    }
    core, world = run(NO_GRAVITY, wind("2 0 2"), body("a", inside=WINDY), plugin("WindPlugin", **parts))
    link = world.ModelByName("a").GetLink()

    def rows(count):
        found = []
        for _ in range(count):
            core.step(1)
            velocity = link.WorldWindLinearVel()
            found.append((velocity.X(), velocity.Y(), velocity.Z()))
        return np.array(found)

    rows(10)
    state = core.get_state()
    first = rows(2000)
    np.testing.assert_allclose(first.mean(axis=0), (2.0, 0.0, 2.0), atol=0.03)
    np.testing.assert_allclose(first.std(axis=0), (0.1, 0.0, 0.3), rtol=0.08, atol=1e-12)
    core.set_state(state)
    np.testing.assert_array_equal(rows(100), first[:100])
    core.Reset()
    after = rows(50)
    core.Reset()
    np.testing.assert_array_equal(rows(50), after)


def test_wrong_parameters_are_reported(run, caplog):
    run(plugin("WindPlugin", **horizontal(RISE.format(0))))
    assert "<time_for_rise> is 0; it must be positive" in caplog.text
    run(plugin("WindPlugin", force_approximation_scaling_factor=-1))
    assert "<force_approximation_scaling_factor> is -1" in caplog.text
