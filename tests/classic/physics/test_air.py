"""Wind and Atmosphere: their numbers, messages and states."""

import math

import pytest
from plugin_worlds import body

from libgz.base.errors import ParameterError
from libgz.classic import msgs, transport
from libgz.classic.math import Vector3d

WIND = "<wind><linear_velocity>1 2 0.5</linear_velocity></wind>"
AIR = (
    "<atmosphere type='adiabatic'><temperature>300</temperature><temperature_gradient>-0.005</temperature_gradient>"
    "<pressure>100000</pressure></atmosphere>"
)
WINDY = "<enable_wind>true</enable_wind>"


def test_the_standard_atmosphere(run):
    _, world = run("")
    air = world.Atmosphere()
    assert air.Type() == "adiabatic"
    assert world.AtmosphereEnabled()
    # U.S. Standard Atmosphere 1976: pressure and density at 0, 1000, 5000 and 11000 m
    for altitude, temperature, pressure, density in (
        (0.0, 288.15, 101325.0, 1.2250),
        (1000.0, 281.65, 89874.6, 1.1116),
        (5000.0, 255.65, 54019.9, 0.73612),
        (11000.0, 216.65, 22632.1, 0.36391),
    ):
        assert air.Temperature(altitude) == pytest.approx(temperature)
        world.SetGravity((0, 0, -9.80665))
        assert air.Pressure(altitude) == pytest.approx(pressure, rel=1e-4)
        assert air.MassDensity(altitude) == pytest.approx(density, rel=1e-4)
    assert air.Pressure(50_000.0) == air.MassDensity(50_000.0) == 0.0


def test_an_atmosphere_of_a_file(run):
    _, world = run(AIR)
    air = world.Atmosphere()
    values = [air.Param(key) for key in ("temperature", "temperature_gradient", "pressure")]
    assert values == [300.0, -0.005, 100000.0]
    power = air.MOLAR_MASS * 9.8 / (0.005 * air.IDEAL_GAS_CONSTANT_R)
    assert air.Pressure(100.0) == pytest.approx(1e5 * (1 - 0.5 / 300.0) ** power)
    ground = air.MOLAR_MASS * 1e5 / (air.IDEAL_GAS_CONSTANT_R * 300.0)
    assert air.MassDensity(100.0) == pytest.approx(ground * (1 - 0.5 / 300.0) ** (power - 1))
    air.SetTemperatureGradient(0.0)
    scale = air.IDEAL_GAS_CONSTANT_R * 300.0 / (air.MOLAR_MASS * 9.8)
    assert air.Pressure(100.0) == pytest.approx(1e5 * math.exp(-100.0 / scale))
    assert air.SetParam("temperature", 280.0)
    assert air.Temperature() == 280.0
    assert not air.SetParam("mass_density", 1.0)
    with pytest.raises(ParameterError, match="temprature"):
        air.Param("temprature")
    with pytest.raises(ParameterError, match="temperature"):
        air.SetTemperature(-1.0)


def test_wind_at_links(run):
    link = "<enable_wind>false</enable_wind>"
    core, world = run(
        WIND, body("a", inside=WINDY), body("b"), body("c", inside=WINDY, link=link), body("d", link=WINDY)
    )
    assert world.Wind().LinearVel() == Vector3d(1, 2, 0.5)
    links = {name: world.ModelByName(name).GetLink() for name in "abcd"}
    assert {name: link.WindMode() for name, link in links.items()} == {"a": True, "b": False, "c": False, "d": True}
    turned = links["a"]
    turned.SetWorldPose(_turned(turned))
    assert turned.WorldWindLinearVel() == Vector3d(1, 2, 0.5)
    relative = turned.RelativeWindLinearVel()
    assert (relative.X(), relative.Y(), relative.Z()) == pytest.approx((2, -1, 0.5))
    assert links["b"].WorldWindLinearVel() == Vector3d(0, 0, 0)
    world.ModelByName("b").SetWindMode(True)
    assert links["b"].WorldWindLinearVel() == Vector3d(1, 2, 0.5)
    state = core.get_state()
    world.SetWindEnabled(False)
    world.Wind().SetLinearVel((7, 0, 0))
    assert turned.WorldWindLinearVel() == Vector3d(0, 0, 0)
    world.ModelByName("b").SetWindMode(False)
    core.set_state(state)
    assert world.WindEnabled()
    assert links["b"].WorldWindLinearVel() == Vector3d(1, 2, 0.5)


def _turned(link):
    pose = link.WorldPose()
    pose.Rot().Euler(0, 0, math.pi / 2)
    return pose


def test_a_function_gives_the_wind_once_in_an_iteration(run):
    core, world = run(WIND, body("a", inside=WINDY), body("b", inside=WINDY))
    calls = []

    def gust(wind, entity):
        calls.append(entity.GetModel().GetName())
        return wind.LinearVel() * len(calls)

    world.Wind().SetLinearVelFunc(gust)
    a, b = (world.ModelByName(name).GetLink() for name in "ab")
    core.step(1)
    assert (b.WorldWindLinearVel().X(), a.WorldWindLinearVel().X()) == (2.0, 1.0)
    assert a.WorldWindLinearVel().X() == 1.0
    assert calls == ["a", "b"]
    core.step(1)
    assert a.WorldWindLinearVel().X() == 3.0
    world.Wind().SetLinearVelFunc(lambda wind, entity: "x")
    assert a.WorldWindLinearVel() == Vector3d(1, 2, 0.5)  # the function failed, which is reported


def test_messages_set_and_ask_for_the_air(run):
    core, world = run(WIND)
    answers = []
    node = transport.Node()
    node.Init("default")
    subscriber = node.Subscribe("~/response", answers.append)
    wind, air, request = (
        node.Advertise(kind, topic)
        for kind, topic in ((msgs.Wind, "~/wind"), (msgs.Atmosphere, "~/atmosphere"), (msgs.Request, "~/request"))
    )
    message = msgs.Wind(enable_wind=False)
    msgs.Set(message.linear_velocity, Vector3d(3, 0, 0))
    wind.Publish(message)
    air.Publish(msgs.Atmosphere(temperature=290.0, pressure=90000.0, enable_atmosphere=False))
    core.step(2)
    assert world.Wind().LinearVel() == Vector3d(3, 0, 0)
    assert not world.WindEnabled()
    assert not world.AtmosphereEnabled()
    request.Publish(msgs.Request(id=1, request="wind_info"))
    request.Publish(msgs.Request(id=2, request="atmosphere_info"))
    core.step(2)
    found = {answer.request: answer for answer in answers}
    message = msgs.Wind()
    message.ParseFromString(found["wind_info"].serialized_data)
    assert message.linear_velocity.x == 3.0
    message = msgs.Atmosphere()
    message.ParseFromString(found["atmosphere_info"].serialized_data)
    assert (message.temperature, message.pressure) == (290.0, 90000.0)
    assert message.mass_density == pytest.approx(world.Atmosphere().MassDensity())
    del subscriber


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<wind><linear_velocity>1 nan 0</linear_velocity></wind>", "<linear_velocity>: '1 nan 0' is read as '1 0 0'"),
        ("<atmosphere><temperature>-3</temperature></atmosphere>", "<temperature>: '-3' is out of range"),
    ],
)
def test_wrong_values_are_warnings_with_line(run, caplog, text, message):
    run(text)
    assert f"<string>:1: {message}" in caplog.text
