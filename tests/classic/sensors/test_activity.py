"""When sensors measure, and what becomes of them: pauses, resets, models that go, plugins."""

import logging

import pytest
from sensor_worlds import box, collision, get, imu, model, ray, sensor, world_of

from libgz.base.errors import NotFoundError
from libgz.classic import physics, sensors


def test_a_sensor_that_nobody_wants_does_not_measure():
    with world_of(model("m", imu(on=False))) as world:
        one = get("s")
        world.step(100)
        assert one.LastUpdateTime().Double() == 0.0
        assert not one.IsActive()
        kept = one.ConnectUpdated(lambda: None)
        world.step(1)
        assert one.LastUpdateTime().Double() == pytest.approx(0.101)
        assert one.IsActive()
        del kept
        world.step(100)
        assert one.LastUpdateTime().Double() == pytest.approx(0.101)
        assert not one.IsActive()
        one.SetActive(True)
        world.step(1)
        assert one.LastMeasurementTime().Double() == pytest.approx(0.202)


def test_a_paused_world_measures_only_by_force():
    with world_of(model("m", imu())) as world:
        world.step(10)
        world.paused = True
        count = []
        kept = get("s").ConnectUpdated(lambda: count.append(1))
        world.step(10)
        assert not count
        laser = get("s")
        laser.SetUpdateRate(1)
        laser.Update(True)
        assert laser.UpdateRate() == 1.0
        assert kept.connected


def test_a_listener_of_the_topic_wakes_a_sensor():
    from libgz.classic import transport

    scene = model("m", sensor("ray", ray(3, (-0.1, 0.1)), "laser", on=False, rate=10)) + box("b", "1 0 0 0 0 0")
    with world_of(scene) as world:
        scans = []
        node = transport.Node()
        node.Init("default")
        laser = get("laser")
        world.step(10)
        assert laser.Topic() == "~/m/link/laser/scan"
        assert not laser.IsActive()
        kept = node.Subscribe("~/m/link/laser/scan", scans.append)
        world.step(500)
        transport.TopicManager.Instance().ProcessNodes()
        assert laser.IsActive()
        assert len(scans) == 5
        scan = scans[0].scan
        assert scan.count == 3
        assert scan.ranges[1] == pytest.approx(0.5)
        assert scan.frame == "m::link"
        kept.Unsubscribe()
        world.step(200)
        assert not laser.IsActive()


def test_a_reset_puts_times_and_noise_back_and_sensors_live_on():
    noise = "<noise><type>gaussian</type><mean>0</mean><stddev>0.1</stddev></noise>"
    scene = model("m", sensor("ray", ray(20, (-0.1, 0.1), noise=noise), rate=50)) + box("b", "2 0 0 0 0 0")
    with world_of(scene) as world:
        laser = get("s")
        world.step(20)
        first = laser.Ranges()
        world.step(480)
        assert laser.Ranges() != first
        physics.get_world().Reset()
        assert laser.LastUpdateTime().Double() == 0.0
        world.step(20)
        assert laser.LastUpdateTime().Double() == pytest.approx(0.02)
        assert laser.Ranges() == first


def test_a_clock_that_is_set_back_stops_no_sensor():
    with world_of(model("m", imu(rate=100))) as world:
        world.step(500)
        physics.get_world().SetSimTime(0.1)
        world.step(20)
        assert get("s").LastUpdateTime().Double() == pytest.approx(0.12, abs=0.011)


def test_a_sensor_of_a_nested_model_goes_with_it():
    inner = "<model name='inner'><link name='link'>" + imu("deep") + "</link></model>"
    with world_of(model("outer", collision("<sphere><radius>1</radius></sphere>"), static=True, more=inner)) as world:
        assert get("deep").ScopedName() == "default::outer::inner::link::deep"
        assert get("outer::inner::link::deep") is get("deep")
        world.step(5)
        assert get("deep").LastUpdateTime().Double() == pytest.approx(0.005)
        physics.get_world().RemoveModel("outer")
        assert sensors.get_sensor("deep") is None
        world.step(5)


def test_the_manager_finds_makes_and_removes():
    with world_of(model("m", imu("same") + imu("own")) + model("n", imu("same"))) as world:
        manager = sensors.SensorManager.Instance()
        assert manager.GetSensor("same") is None
        assert manager.GetSensor("m::link::same") is not manager.GetSensor("default::n::link::same") is not None
        assert len(manager.GetSensors()) == 3
        assert manager.SensorsInitialized()
        element = manager.GetSensor("own").GetSDF().Clone()
        element.set_attribute("name", "made")
        assert manager.CreateSensor(element, "default", "n::link") == "default::n::link::made"
        world.step(1)
        assert get("made").LastUpdateTime().Double() == pytest.approx(0.001)
        manager.RemoveSensor("made")
        assert sensors.get_sensor("made") is None
        with pytest.raises(NotFoundError, match="Unable to remove sensor"):
            manager.RemoveSensor("made")
        with pytest.raises(NotFoundError, match="no link or joint 'x'"):
            manager.CreateSensor(element, "default", "x")
        link = physics.get_world().ModelByName("m").GetLink("link")
        assert link.GetSensorCount() == 2
        assert link.GetSensorName(0) == "default::m::link::same"


PLUGIN = """
from libgz.classic import GZ_REGISTER_SENSOR_PLUGIN, SensorPlugin


@GZ_REGISTER_SENSOR_PLUGIN
class Watch(SensorPlugin):
    def Load(self, sensor, sdf):
        self.sensor = sensor
        self.seen = sensor.seen = []
        self.kept = sensor.ConnectUpdated(self.OnUpdate)
        if sdf.Get(bool, "fail_in_load"):
            raise RuntimeError("not today")

    def OnUpdate(self):
        self.seen.append(self.sensor.LastMeasurementTime().Double())
        if len(self.seen) == 3:
            raise RuntimeError("enough")
"""


def test_a_sensor_plugin_that_raises_is_named_and_stopped(tmp_path, monkeypatch, caplog):
    (tmp_path / "watch.py").write_text(PLUGIN)
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", str(tmp_path))
    named = "<plugin name='{}' filename='libwatch.so'>{}</plugin>"
    good = imu("good", more=named.format("watcher", ""))
    bad = imu("bad", more=named.format("loser", "<fail_in_load>1</fail_in_load>"))
    missing = imu("missing", more="<plugin name='p' filename='libnowhere.so'/>")
    with caplog.at_level(logging.ERROR), world_of(model("m", good + bad + missing)) as world:
        world.step(10)
        assert len(get("good").seen) == 3
        assert get("good").LastUpdateTime().Double() == pytest.approx(0.01)
        assert get("bad").seen == []
        assert "name[watcher] and filename[libwatch.so]" in caplog.text
        assert "enough" in caplog.text
        assert "in the Load function of plugin with name[loser]" in caplog.text
        assert "not today" in caplog.text
        assert "Failed to load plugin libnowhere.so" in caplog.text
        assert get("missing").IsActive()


def test_a_plugin_gets_the_sensors_of_its_own_world(tmp_path, monkeypatch, caplog):
    text = """from libgz.classic import *
class P(ModelPlugin):
    def Load(self, model, sdf):
        self.found = [sensors.get_sensor(name) for name in ("s", "m::link::s")]
GZ_REGISTER_MODEL_PLUGIN(P)
"""
    (tmp_path / "finds.py").write_text(text)
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", str(tmp_path))
    content = model("m", imu(), more="<plugin name='p' filename='libfinds.so'/>")
    with world_of(content), world_of(content):
        for view in physics.worlds():
            (loaded,) = view.server.plugins.of_model(view.ModelByName("m"))
            (own,) = view.server.sensors.sensors.values()
            assert loaded.plugin.found == [own, own]
        assert "multiple sensors" not in caplog.text
        assert sensors.get_sensor("s") is None  # outside plugins there are two


def test_a_sensor_with_a_topic_publishes_on_its_own_one_too():
    from libgz.classic import transport

    scene = model("m", sensor("ray", "<topic>/scan</topic>" + ray(3, (-0.1, 0.1)), "laser", on=False, rate=10))
    with world_of(scene) as world:
        scans = []
        node = transport.Node()
        node.Init("default")
        assert get("laser").Topic() == "/scan"
        assert get("laser").topics() == ["/scan", "~/m/link/laser/scan"]
        for topic in get("laser").topics():
            kept = node.Subscribe(topic, scans.append)
            world.step(500)
            transport.TopicManager.Instance().ProcessNodes()
            assert len(scans) == 5
            scans.clear()
            kept.Unsubscribe()
            world.step(200)
            scans.clear()
