"""Plugins whose file is edited while the world runs."""

import textwrap

import pytest

import libgz
from libgz.base.errors import GazeboError, NotFoundError, PluginError
from libgz.classic.server import attach
from libgz.classic.world_plugins import system_plugins
from libgz.simulation.problems import Problem

BEGIN = "from libgz.classic import *\nfrom libgz.classic.event import Events\n"
WORLD_PLUGIN = """
    class Counter(WorldPlugin):
        STATE = ("steps",)
        def Load(self, world, sdf):
            self.world, self.steps, self.by = world, 0, {by}
            self.first = sdf.Get(int, "first")
            {load}
            self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)
        def OnUpdate(self):
            self.steps += self.by
    GZ_REGISTER_WORLD_PLUGIN(Counter)
"""


def write(folder, name, text, **values):
    path = folder / f"{name}.py"
    path.write_text(BEGIN + textwrap.dedent(text).format(**values))
    return path


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Returns a function that runs a world of some elements, with plugins in tmp_path."""
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", str(tmp_path))
    worlds = []

    def start(inside, **options):
        text = f"<sdf version='1.6'><world name='w'>{inside}</world></sdf>"
        worlds.append(libgz.World.from_string(text, **options))
        return worlds[-1]

    yield start
    for world in worlds:
        world.close()


def counter(world):
    return attach(world).plugins.of_world["count"].plugin


@pytest.fixture
def counting(run, tmp_path):
    write(tmp_path, "counter", WORLD_PLUGIN, by=1, load="")
    world = run("<plugin name='count' filename='libcounter.so'><first>7</first></plugin>")
    world.step(3)
    return world


@pytest.mark.parametrize("name", ["count", "libcounter.so", "counter", "counter.py"])
def test_an_edited_world_plugin_keeps_its_element_and_state(counting, tmp_path, name):
    old = counter(counting)
    write(tmp_path, "counter", WORLD_PLUGIN, by=10, load="")
    assert counting.reload_plugin(name) == ["World plugin count"]
    counting.step(2)
    new = counter(counting)
    assert (new.steps, new.first, new.GetHandle()) == (23, 7, "count")
    assert old.steps == 3  # its connection has ended


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("class Counter(WorldPlugin:\n", ["counter.py", "line 3", "SyntaxError"]),
        ("class Counter(WorldPlugin):\n    pass\n", ["registers nothing"]),
        ("class Counter(ModelPlugin):\n    pass\nGZ_REGISTER_MODEL_PLUGIN(Counter)\n", ["ModelPlugin", "WorldPlugin"]),
        (WORLD_PLUGIN.replace("{by}", "1").replace("{load}", "raise ValueError(41 + 1)"), ["line 9", "ValueError: 42"]),
        (WORLD_PLUGIN.replace("{by}", "1").replace("{load}", "world.SetGravity((0, 0, 5)); 1 / 0"), ["ZeroDivision"]),
        (WORLD_PLUGIN.replace("{by}", "1").replace("{load}", "world.InsertModelString('<sdf'); 1 / 0"), ["ZeroDiv"]),
    ],
)
def test_an_edit_that_fails_changes_nothing(counting, tmp_path, text, words):
    old = counter(counting)
    write(tmp_path, "counter", text)
    with pytest.raises(PluginError) as raised:
        counting.reload_plugin("count")
    assert all(word in str(raised.value) for word in words), raised.value
    counting.step(2)
    assert counter(counting) is old
    assert old.steps == 5
    assert not counting.errors
    assert counting.engine.gravity == pytest.approx((0.0, 0.0, -9.8))
    write(tmp_path, "counter", WORLD_PLUGIN, by=100, load="")
    counting.reload_plugin("count")
    counting.step()
    assert counter(counting).steps == 105


def test_an_edit_in_a_strict_world_that_fails_does_not_end_it(run, tmp_path):
    write(tmp_path, "counter", WORLD_PLUGIN, by=1, load="")
    world = run("<plugin name='count' filename='counter'/>", strict=True)
    write(tmp_path, "counter", WORLD_PLUGIN, by=1, load="1 / 0")
    with pytest.raises(PluginError):
        world.reload_plugin("count")
    world.step()


def test_a_new_attribute_of_the_state_keeps_what_load_gave_it(counting, tmp_path):
    text = WORLD_PLUGIN.replace('("steps",)', '("steps", "more")')
    write(tmp_path, "counter", text, by=1, load="self.more = 5")
    counting.reload_plugin("count")
    assert (counter(counting).steps, counter(counting).more) == (3, 5)


def test_a_plugin_that_has_failed_runs_again(run, tmp_path):
    write(tmp_path, "counter", WORLD_PLUGIN, by="'a'", load="")  # int + str, in the first step
    write(tmp_path, "late", "class Late(WorldPlugin):\n    pass\n")  # registers nothing
    world = run("<plugin name='count' filename='counter'/><plugin name='late' filename='late'/>")
    world.step()
    assert len(world.errors) == 2
    write(tmp_path, "counter", WORLD_PLUGIN, by=1, load="")
    write(tmp_path, "late", WORLD_PLUGIN, by=2, load="")
    assert world.reload_plugin("count") == ["World plugin count"]
    assert world.reload_plugin("late") == ["World plugin late"]
    world.step()
    found = attach(world).plugins.of_world
    assert (found["count"].plugin.steps, found["late"].plugin.steps) == (1, 2)


def test_a_plugin_that_still_fails_to_start_is_reported(run, tmp_path):
    write(tmp_path, "late", "1 / 0")
    world = run("<plugin name='late' filename='late'/>")
    for _ in range(1000):  # after so many no more are kept
        world.problems.add(Problem("a plugin", "it fails", "", "error"))
    with pytest.raises(PluginError, match="ZeroDivisionError"):
        world.reload_plugin("late")


def test_modules_beside_an_edited_plugin_are_loaded_again(run, tmp_path):
    (tmp_path / "helper_a1.py").write_text("from helper_b1 import BY\n")
    (tmp_path / "helper_b1.py").write_text("BY = 1\n")
    write(tmp_path, "counter", "from helper_a1 import BY\n" + textwrap.dedent(WORLD_PLUGIN), by="BY", load="")
    world = run("<plugin name='count' filename='counter'/>")
    (tmp_path / "helper_b1.py").write_text("BY = 1000\n")
    world.reload_plugin("count")
    world.step()
    assert counter(world).steps == 1000
    (tmp_path / "helper_b1.py").write_text("BY = None or 1 / 0\n")
    with pytest.raises(PluginError, match=r"helper_b1\.py"):
        world.reload_plugin("count")
    world.step()
    assert counter(world).steps == 2000


def test_no_such_plugin(counting):
    with pytest.raises(NotFoundError, match="it has count; did you mean 'count'"):
        counting.reload_plugin("coun")


def test_not_in_a_step(counting, tmp_path):
    failures = []

    def attempt():
        try:
            counting.reload_plugin("count")
        except GazeboError as error:
            failures.append(str(error))

    connection = counting.events["WorldUpdateBegin"].Connect(attempt)
    counting.step()
    assert "its step is under way" in failures[0]
    del connection


MODEL_PLUGIN = """
    class Push(ModelPlugin):
        def Load(self, model, sdf):
            self.model, self.node = model, transport.Node()
            self.node.Init()
            self.publisher = self.node.Advertise(msgs.Int, "~/{topic}")
            self.subscriber = self.node.Subscribe("~/go", self.OnMessage)
            self.got = 0
        def OnMessage(self, message):
            self.got += message.data
    GZ_REGISTER_MODEL_PLUGIN(Push)
"""


def test_model_plugins_of_one_file_are_replaced_with_their_topics(run, tmp_path):
    begin = "from libgz.classic import msgs, transport\n"
    model = "<model name='{}'><link name='l'/><plugin name='push' filename='libpush.so'/></model>"
    write(tmp_path, "push", begin + textwrap.dedent(MODEL_PLUGIN), topic="old")
    world = run(model.format("a") + model.format("b"))
    server = attach(world)
    olds = [server.plugins.of_model(server.world.ModelByName(name))[0].plugin for name in "ab"]
    write(tmp_path, "push", begin + textwrap.dedent(MODEL_PLUGIN), topic="new")
    assert world.reload_plugin("a::push") == ["Model plugin a::push"]
    assert world.reload_plugin("push") == ["Model plugin a::push", "Model plugin b::push"]
    from libgz.classic import msgs, transport

    node = transport.Node()
    node.Init("w")
    publisher = node.Advertise(msgs.Int, "~/go")
    publisher.Publish(msgs.Int(data=5))
    world.step()
    news = [server.plugins.of_model(server.world.ModelByName(name))[0].plugin for name in "ab"]
    assert [one.got for one in news] == [5, 5]
    assert [one.got for one in olds] == [0, 0]
    del olds
    import gc

    gc.collect()
    assert [t for t in transport.getAdvertisedTopics() if t in ("/gazebo/w/old", "/gazebo/w/new")] == ["/gazebo/w/new"]


SENSOR = """
    class Watch(SensorPlugin):
        def Load(self, sensor, sdf):
            self.sensor, self.number = sensor, {number}
            self.connection = sensor.ConnectUpdated(self.OnUpdate)
            self.seen = 0
        def OnUpdate(self):
            self.seen += {number}
    GZ_REGISTER_SENSOR_PLUGIN(Watch)
"""


def test_a_sensor_plugin(run, tmp_path):
    write(tmp_path, "watch", SENSOR, number=1)
    world = run(
        "<model name='m'><link name='l'><sensor name='s' type='imu'><always_on>1</always_on>"
        "<update_rate>0</update_rate><plugin name='watch' filename='watch'/></sensor></link></model>"
    )
    world.step(5)
    write(tmp_path, "watch", SENSOR, number=100)
    assert world.reload_plugin("watch") == ["Sensor plugin w::m::l::s::watch"]
    world.step(2)
    [(_, _, [loaded])] = list(attach(world).sensors.plugins_by_holder())
    assert loaded.plugin.seen == 200


def test_a_system_plugin(run, tmp_path):
    from libgz.classic.loading import new_plugin

    text = """
    class Sys(SystemPlugin):
        def Load(self, argc, argv):
            self.words, self.number = list(argv), {number}
    GZ_REGISTER_SYSTEM_PLUGIN(Sys)
    """
    path = write(tmp_path, "sys1", text, number=1)
    system_plugins.append(new_plugin("System", str(path), str(path), "System", None))
    try:
        system_plugins[0].load(2, ["gzserver", "x.world"])
        world = run("<light name='sun' type='point'/><plugin name='none' filename='none'/>")
        write(tmp_path, "sys1", text, number=2)
        assert world.reload_plugin("sys1") == [f"System plugin {path}"]
        plugin = system_plugins[0].plugin
        assert (plugin.words, plugin.number) == (["gzserver", "x.world"], 2)
    finally:
        system_plugins.clear()
