"""Plugins of Gazebo classic: found, loaded in order, called under guard, and let go."""

import logging
import textwrap

import pytest

import libgz
from libgz.base.errors import ParameterError
from libgz.classic import physics
from libgz.classic.event import Events

BOX = """
<model name='{name}'><pose>{pose}</pose>
  <link name='link'><collision name='c'><geometry><box><size>1 1 1</size></box></geometry></collision></link>
  {inside}
</model>
"""


@pytest.fixture(autouse=True)
def own_places(monkeypatch, tmp_path):
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", str(tmp_path))
    monkeypatch.delenv("GAZEBO_MODEL_PATH", raising=False)


@pytest.fixture
def plugin(tmp_path):
    """Writes a plugin file; its lines may use `received`, a list that the test reads."""

    def write(name, text):
        (tmp_path / f"{name}.py").write_text("from libgz.classic import *\n" + textwrap.dedent(text))

    return write


@pytest.fixture
def run(tmp_path):
    """Loads a world whose `<world>` holds these elements."""
    worlds = []

    def load(*inside, version="1.6"):
        path = tmp_path / f"w{len(worlds)}.world"
        path.write_text(f"<sdf version='{version}'><world name='default'>{''.join(inside)}</world></sdf>")
        worlds.append(libgz.World.from_file(path))
        return worlds[-1]

    yield load
    for world in worlds:
        world.close()


def element(name, filename=None, inside=""):
    return f"<plugin name='{name}' filename='{filename or f'lib{name}.so'}'>{inside}</plugin>"


def test_world_and_model_plugins_load_in_the_order_of_the_file(plugin, run, capsys):
    for name, kind in (("w1", "World"), ("w2", "World"), ("m1", "Model"), ("m2", "Model")):
        plugin(
            name,
            f"""
            class P({kind}Plugin):
                def __init__(self):
                    print("{name} made")
                def Load(self, thing, sdf):
                    print("{name} Load", thing.GetName(), sdf.Get(str, "word"))
                def Init(self):
                    print("{name} Init")
            GZ_REGISTER_{kind.upper()}_PLUGIN(P)
            """,
        )
    nested = BOX.format(name="inner", pose="0 0 2 0 0 0", inside=element("m2"))
    run(
        BOX.format(name="box", pose="0 0 1 0 0 0", inside=element("m1", inside="<word>hi</word>") + nested),
        element("w1"),
        element("w2"),
    )
    assert capsys.readouterr().out.splitlines() == [
        "w1 made", "w1 Load default ", "w1 Init", "w2 made", "w2 Load default ", "w2 Init",
        "m1 made", "m1 Load box hi", "m1 Init", "m2 made", "m2 Load inner ", "m2 Init",
    ]  # fmt: skip


def test_a_plugin_is_found_under_its_old_name_and_beside_the_world(plugin, run, monkeypatch, capsys):
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", "/nowhere")
    text = (
        "class P(WorldPlugin):\n    def Load(self, world, sdf):\n        print(self.GetHandle(), self.GetFilename())\n"
    )
    plugin("thing", text + "GZ_REGISTER_WORLD_PLUGIN(P)")
    run(element("a", "libthing.so"), element("b", "thing.py"), element("c", "libthing.py"))
    assert capsys.readouterr().out.splitlines() == ["a libthing.so", "b thing.py", "c libthing.py"]


def test_a_missing_plugin_is_reported_with_all_places_and_the_world_runs(run, caplog):
    world = run(element("gone"))
    world.step(3)
    assert "Failed to load plugin libgone.so: libgone.so: cannot open shared object file" in caplog.text
    assert "GAZEBO_PLUGIN_PATH" in caplog.text
    assert "the current directory" in caplog.text


def test_files_that_are_no_plugins_are_not_suggested(run, caplog):
    run(element("a", "lib_boxes1.so"))
    assert "did you mean '" in caplog.text
    assert "'_" not in caplog.text


def test_a_plugin_of_the_wrong_kind_is_reported_with_classics_message(plugin, run, caplog):
    plugin("m", "class P(ModelPlugin): pass\nGZ_REGISTER_MODEL_PLUGIN(P)")
    run(element("m"))
    words = "World[default] is attempting to load a plugin, but detected an incorrect plugin type."
    assert f"{words} Plugin filename[libm.so] name[m]" in caplog.text


def test_a_file_without_a_plugin_or_with_two_is_reported(plugin, run, caplog):
    plugin("none", "x = 1")
    plugin("two", "class P(WorldPlugin): pass\nGZ_REGISTER_WORLD_PLUGIN(P)\nGZ_REGISTER_WORLD_PLUGIN(P)")
    plugin("broken", "import no_such_module")
    run(element("none"), element("two"), element("broken"))
    assert "registers nothing" in caplog.text
    assert "it registers 2 classes; one file has one plugin" in caplog.text
    assert "No module named 'no_such_module'" in caplog.text


def test_a_macro_takes_only_classes_of_its_kind(plugin, run, caplog):
    plugin("odd", "class P(ModelPlugin): pass\nGZ_REGISTER_WORLD_PLUGIN(P)")
    run(element("odd"))
    assert "it needs a class that is derived from WorldPlugin" in caplog.text


STAGES = {
    "the constructor": "def __init__(self): 1 / 0",
    "the Load function": "def Load(self, world, sdf): 1 / 0",
    "the Init function": "def Init(self): 1 / 0",
    "a callback of event WorldUpdateBegin": "def OnUpdate(self): 1 / 0",
    "the Reset function": "def Reset(self): 1 / 0",
}


@pytest.mark.parametrize("stage", STAGES)
def test_a_plugin_that_raises_is_named_and_stopped_and_the_world_runs_on(stage, plugin, run, caplog):
    plugin(
        "bad",
        f"""
        class Base(WorldPlugin):
            def Load(self, world, sdf):
                pass
            def OnUpdate(self):
                pass
        class P(Base):
            {STAGES[stage]}
        class Q(P):
            def Init(self):
                super().Init()
                self.connection = event.Events.ConnectWorldUpdateBegin(self.OnUpdate)
        GZ_REGISTER_WORLD_PLUGIN(Q)
        """,
    )
    plugin(
        "good",
        """
        class P(WorldPlugin):
            def Load(self, world, sdf):
                self.world, self.count = world, 0
                self.connection = event.Events.ConnectWorldUpdateBegin(self.OnUpdate)
            def OnUpdate(self, info):
                self.count += 1
        GZ_REGISTER_WORLD_PLUGIN(P)
        """,
    )
    world = run(element("bad"), element("good"))
    world.step(3)
    world.Reset()
    world.step(2)
    words = f"Exception occured in {stage} of plugin with name[bad] and filename[libbad.so]. This plugin will not run."
    assert caplog.text.count(words) == 1
    assert "ZeroDivisionError" in caplog.text
    server = world.companions[0]
    assert server.plugins.of_world["good"].plugin.count == 5
    assert world.events["WorldUpdateBegin"].ConnectionCount() == 1


def test_a_load_with_wrong_parameters_is_shown_the_right_ones(plugin, run, caplog):
    plugin("bad", "class P(WorldPlugin):\n    def Load(self, world): pass\nGZ_REGISTER_WORLD_PLUGIN(P)")
    run(element("bad"))
    assert "it is called as WorldPlugin declares it: Load(self, world, sdf)" in caplog.text
    assert "classic/loading.py" not in caplog.text


def test_connections_end_when_they_are_dropped(plugin, run, caplog):
    world = run(BOX.format(name="box", pose="0 0 1 0 0 0", inside=""))
    calls = []
    kept = Events.ConnectWorldUpdateBegin(lambda info: calls.append(info.simTime.Double()))
    world.step(2)
    assert calls == pytest.approx([0.001, 0.002])
    del kept
    world.step()
    assert len(calls) == 2
    caplog.set_level(logging.WARNING)
    Events.ConnectWorldUpdateBegin(lambda: None)
    assert "Deleting a connection right after creation" in caplog.text


def test_events_have_classics_order_and_arguments(plugin, run):
    world = run(BOX.format(name="box", pose="0 0 10 0 0 0", inside=""))
    received = []
    view = physics.get_world()
    box = view.ModelByName("box")
    kept = [
        Events.ConnectWorldUpdateBegin(lambda info: received.append(("begin", info.worldName, view.Iterations()))),
        Events.ConnectBeforePhysicsUpdate(lambda info: received.append(("before", box.WorldPose().Pos().Z()))),
        Events.ConnectWorldUpdateEnd(lambda: received.append(("end", box.WorldPose().Pos().Z() < 10.0))),
        Events.ConnectPause(lambda on: received.append(("pause", on))),
        Events.ConnectWorldReset(lambda: received.append(("reset", view.SimTime().Double()))),
        Events.ConnectTimeReset(lambda: received.append(("time", view.SimTime().Double()))),
    ]
    world.step()
    assert received == [("begin", "default", 1), ("before", pytest.approx(10.0, abs=1e-9)), ("end", True)]
    received.clear()
    view.SetPaused(True)
    world.step(3)
    view.SetPaused(False)
    view.Reset()
    assert received == [("pause", True), ("pause", False), ("time", 0.0), ("reset", 0.0)]
    assert box.WorldPose().Pos().Z() == pytest.approx(10.0, abs=1e-12)
    del kept


def test_plugins_receive_events_of_their_own_world_only(plugin, run):
    plugin(
        "count",
        """
        class P(WorldPlugin):
            def Load(self, world, sdf):
                self.count = 0
                self.connection = event.Events.ConnectWorldUpdateBegin(self.OnUpdate)
            def OnUpdate(self):
                self.count += 1
        GZ_REGISTER_WORLD_PLUGIN(P)
        """,
    )
    one, two = run(element("count")), run(element("count"))
    one.step(3)
    two.step(1)
    assert [w.companions[0].plugins.of_world["count"].plugin.count for w in (one, two)] == [3, 1]


def test_world_plugins_are_loaded_and_removed_at_run_time(plugin, run):
    plugin(
        "late",
        """
        class P(WorldPlugin):
            ticks = 0
            def Load(self, world, sdf):
                self.connection = event.Events.ConnectWorldUpdateBegin(self.OnUpdate)
            def OnUpdate(self):
                P.ticks += 1
        GZ_REGISTER_WORLD_PLUGIN(P)
        """,
    )
    world = run(BOX.format(name="box", pose="0 0 1 0 0 0", inside=""))
    view = physics.get_world()
    view.LoadPlugin("liblate.so", "late")
    kind = type(world.companions[0].plugins.of_world["late"].plugin)
    world.step(2)
    view.RemovePlugin("late")
    world.step(2)
    assert kind.ticks == 2


def test_models_are_inserted_and_removed_with_their_plugins(plugin, run):
    plugin(
        "spin",
        """
        class P(ModelPlugin):
            alive = 0
            def Load(self, model, sdf):
                P.alive += 1
                self.connection = event.Events.ConnectWorldUpdateBegin(self.OnUpdate)
                self.model = model
            def OnUpdate(self):
                self.model.SetAngularVel((0, 0, 1))
        GZ_REGISTER_MODEL_PLUGIN(P)
        """,
    )
    world = run(BOX.format(name="box", pose="0 0 1 0 0 0", inside=""))
    view = physics.get_world()
    text = BOX.format(name="new", pose="0 0 5 0 0 0", inside=element("spin"))
    view.InsertModelString(f"<sdf version='1.6'>{text}</sdf>")
    world.step()
    new = view.ModelByName("new")
    assert new.WorldAngularVel().Z() == pytest.approx(1.0)
    assert view.ModelCount() == 2
    assert new.GetPluginCount() == 1
    view.RemoveModel("new")
    world.step()
    assert view.ModelCount() == 1
    assert world.events["WorldUpdateBegin"].ConnectionCount() == 0


def test_load_param_logs_the_value(plugin, run, caplog, capsys):
    plugin(
        "params",
        """
        class P(WorldPlugin):
            def Load(self, world, sdf):
                for name, default in (("flag", False), ("number", 1), ("pi", 0.0), ("text", ""), ("absent", 7)):
                    print(self.LoadParam(sdf, name, default))
        GZ_REGISTER_WORLD_PLUGIN(P)
        """,
    )
    caplog.set_level(logging.INFO, "libgz.classic.console")
    inside = "<flag>true</flag><number>42</number><pi>3.14</pi><text>words</text>"
    run(element("params", inside=inside))
    assert capsys.readouterr().out.split() == ["True", "42", "3.14", "words", "7"]
    assert "params Plugin <number> set to <42>" in caplog.text
    assert "params Plugin missing <absent>, defaults to <7>" in caplog.text


def test_a_topic_callback_that_raises_stops_its_plugin(plugin, run, caplog):
    plugin(
        "listener",
        """
        class P(WorldPlugin):
            def Load(self, world, sdf):
                self.node = transport.Node()
                self.node.Init(world.Name())
                self.sub = self.node.Subscribe("~/words", self.OnWords)
                self.pub = self.node.Advertise(msgs.GzString, "~/words")
                self.connection = event.Events.ConnectWorldUpdateBegin(self.OnUpdate)
            def OnUpdate(self):
                self.pub.Publish(msgs.GzString(data="hi"))
            def OnWords(self, message):
                raise RuntimeError(message.data)
        GZ_REGISTER_WORLD_PLUGIN(P)
        """,
    )
    world = run(element("listener"))
    world.step(3)
    words = "Exception occured in the callback P.OnWords of topic /gazebo/default/words of plugin with name[listener]"
    assert caplog.text.count(words) == 1
    assert "RuntimeError: hi" in caplog.text
    assert world.events["WorldUpdateBegin"].ConnectionCount() == 0


def test_batteries_follow_their_update_function_and_are_reset(run):
    inside = "<model name='m'><link name='l'><battery name='cell'><voltage>12</voltage></battery></link></model>"
    world = run(inside)
    view = physics.get_world()
    cell = view.ModelByName("m").GetLink("l").Battery("cell")
    load = cell.AddConsumer()
    cell.SetPowerLoad(load, 24.0)
    cell.SetUpdateFunc(lambda b: b.Voltage() - 0.001 * sum(b.PowerLoads().values()))
    world.step(10)
    assert cell.Voltage() == pytest.approx(12.0 - 10 * 0.024)
    view.Reset()
    assert cell.Voltage() == 12.0


def test_a_model_can_be_made_static(run):
    world = run(BOX.format(name="box", pose="0 0 5 0 0 0", inside=""))
    box = physics.get_world().ModelByName("box")
    world.step(50)
    box.SetStatic(True)
    assert box.IsStatic()
    held = box.WorldPose().Pos().Z()
    world.step(50)
    assert box.WorldPose().Pos().Z() == pytest.approx(held, abs=1e-12)
    state = world.get_state()
    box.SetStatic(False)
    assert not box.IsStatic()
    world.set_state(state)
    assert box.IsStatic()
    box.SetStatic(False)
    world.step(50)
    assert box.WorldPose().Pos().Z() < held - 0.001


def test_what_raises_at_the_end_of_an_animation_or_in_a_battery_stops_its_plugin_only(plugin, run, caplog):
    plugin(
        "ends",
        """
        class P(ModelPlugin):
            def Load(self, model, sdf):
                animation = common.PoseAnimation("a", 0.002, False)
                for time in (0.0, 0.002):
                    animation.CreateKeyFrame(time)
                model.SetAnimation(animation, lambda: 1 / 0)
        GZ_REGISTER_MODEL_PLUGIN(P)
        """,
    )
    plugin(
        "rules",
        """
        class P(ModelPlugin):
            def Load(self, model, sdf):
                model.GetLink().Battery("b").SetUpdateFunc(lambda battery: float("nan"))
        GZ_REGISTER_MODEL_PLUGIN(P)
        """,
    )
    inside = element("ends") + element("rules")
    box = BOX.format(name="box", pose="0 0 1 0 0 0", inside=inside)
    world = run(box.replace("<collision", "<battery name='b'><voltage>5</voltage></battery><collision"))
    world.step(5)
    words = "Exception occured in {} of plugin with name[{}] and filename[lib{}.so]. This plugin will not run."
    assert caplog.text.count(words.format("the end of the animation of box", "ends", "ends")) == 1
    assert caplog.text.count(words.format("the rule of battery 'b'", "rules", "rules")) == 1
    assert physics.get_world().ModelByName("box").GetLink().Battery("b").Voltage() == 5.0


def test_animations_keep_time_when_others_begin(run):
    from libgz.classic.common import PoseAnimation

    world = run(*(BOX.format(name=name, pose=f"0 {y} 9 0 0 0", inside="") for name, y in (("a", 0), ("b", 5))))
    view = physics.get_world()

    def start(name):
        animation = PoseAnimation(name, 1.0, False)
        for time in (0.0, 1.0):
            animation.CreateKeyFrame(time).Translation((time, 5.0 * (name == "b"), 9.0))
        view.ModelByName(name).SetAnimation(animation)

    start("a")
    kept = Events.ConnectWorldUpdateBegin(lambda: start("b"))
    world.step(500)
    assert view.ModelByName("a").WorldPose().Pos().X() == pytest.approx(0.5, abs=1e-4)
    del kept


# The <physics> elements (name, default, step), and what Gazebo 11.1 answered.
@pytest.mark.parametrize(
    ("given", "profiles", "current", "step"),
    [
        ("zz 0 0.002,aa 1 0.003,mid 0 0.001", ["aa", "mid", "zz"], "aa", 0.003),
        ("zz 0 0.002,aa 0 0.003, 0 0.001", ["aa", "default_physics", "zz"], "zz", 0.002),
        (" 0 0.001, 0 0.004", ["default_physics"], "default_physics", 0.004),
        ("x 0 0.002,y 0 0.007,x 0 0.004", ["x", "y"], "x", 0.004),
        ("x 0 0.002,y 1 0.007,x 0 0.004", ["x", "y"], "y", 0.007),
        ("x 0 0.002,x 1 0.007,x 0 0.004", ["x"], "x", 0.004),
    ],
)
def test_of_profiles_of_one_name_the_last_is_taken(run, given, profiles, current, step):
    text = "<physics {name} default='{default}' type='ode'><max_step_size>{step}</max_step_size></physics>"
    parts = [part.split(" ") for part in given.split(",")]
    world = run(*(text.format(name=f"name='{n}'" if n else "", default=d, step=s) for n, d, s in parts))
    presets = physics.get_world().PresetMgr()
    assert (presets.AllProfiles(), presets.CurrentProfile(), world.engine.step_time) == (profiles, current, step)
    presets.RemoveProfile(current)
    assert (current in presets.AllProfiles(), presets.CurrentProfile(), world.engine.step_time) == (False, "", step)


def test_a_profile_applies_all_of_its_element(run):
    cone = "<ode><solver><type>quick</type><friction_model>cone_model</friction_model></solver></ode>"
    world = run(
        "<physics name='plain' type='ode'/>",
        f"<physics name='cone' type='ode'><max_step_size>0.005</max_step_size>{cone}</physics>",
        BOX.format(name="box", pose="0 0 1 0 0 0", inside=""),
    )
    view = physics.get_world()
    presets = view.PresetMgr()
    assert (presets.AllProfiles(), presets.CurrentProfile()) == (["cone", "plain"], "plain")
    presets.SetProfileParam("cone", "iters", 77)
    presets.CurrentProfile("cone")
    assert (world.engine.step_time, world.engine.cone, world.engine.iterations) == (0.005, True, 77)
    presets.CurrentProfile("plain")
    assert (world.engine.step_time, world.engine.cone, world.engine.iterations) == (0.001, False, 50)
    presets.SetCurrentProfileParam("friction_model", "cone_model")
    assert world.engine.cone
    with pytest.raises(ParameterError, match="allowed are pyramid_model and cone_model"):
        view.Physics().SetParam("friction_model", "cube_model")
    assert set(presets._profile(presets.CreateProfile("now"))) == set(presets._profile("cone"))
