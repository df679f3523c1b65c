"""States of SDF worlds: what happens after `set_state` is equal to the bit to what happened after `get_state`."""

from __future__ import annotations

import hashlib
import logging
import subprocess
import sys
from pathlib import Path

import pytest
from classic_runs import Run, first_difference, opened

from libgz import World
from libgz.base.encoding import FORMAT
from libgz.base.errors import ClosedError, GazeboError, ParameterError, StateError
from libgz.classic import msgs
from libgz.classic.common import PoseAnimation
from libgz.classic.math import PID, Color, Pose3d, Rand, Vector3d
from libgz.classic.rendering import Visual, get_scene
from libgz.classic.sensors import get_sensor
from libgz.classic.server import attach
from libgz.classic.transport import Node, TopicManager
from libgz.classic.transport.publisher import queue_message
from libgz.simulation.event import owner
from libgz.simulation.state import decode, encode

EXAMPLES = Path(__file__).parents[2] / "examples" / "plugins"
WORLDS = sorted(path for path in EXAMPLES.glob("*/*.world") if path.parent.name != "hello_world")
MANY = [  # worlds, those of ready plugins as trials
    pytest.param(path, id=path.stem, marks=[pytest.mark.trial] if path.parent.name == "ready" else [])
    for path in WORLDS
]
STEPS = 60

GROUND = """<model name='ground'><static>1</static><link name='l'><collision name='c'><geometry><plane/></geometry>
</collision></link></model>"""
NOISE = """<noise type='gaussian'><mean>0.1</mean><stddev>0.2</stddev><bias_mean>1</bias_mean>
<bias_stddev>1</bias_stddev></noise>"""
IMU = f"""<sensor name='imu' type='imu'><always_on>1</always_on><update_rate>130</update_rate><imu>
<angular_velocity><x>{NOISE}</x></angular_velocity>
<linear_acceleration><z>{NOISE}</z></linear_acceleration></imu></sensor>"""
SENSORS = f"""{IMU}
<sensor name='ray' type='ray'><always_on>1</always_on><update_rate>40</update_rate><ray><scan><horizontal>
<samples>20</samples><min_angle>-1</min_angle><max_angle>1</max_angle></horizontal></scan>
<range><min>0.05</min><max>5</max></range>{NOISE}</ray></sensor>
<sensor name='bump' type='contact'><always_on>1</always_on><update_rate>30</update_rate>
<contact><collision>c</collision></contact></sensor>
<sensor name='gps' type='gps'><always_on>1</always_on><gps><position_sensing><horizontal>{NOISE}</horizontal>
</position_sensing></gps></sensor>
<sensor name='alt' type='altimeter'><always_on>1</always_on><altimeter><vertical_position>{NOISE}</vertical_position>
</altimeter></sensor>
<sensor name='sonar' type='sonar'><always_on>1</always_on><sonar><min>0.1</min><max>3</max><radius>0.3</radius></sonar>
</sensor>"""


def box(name, pose, inside="", link="", plugin=""):
    return f"""<model name='{name}'><pose>{pose}</pose><link name='l'>
<collision name='c'><geometry><box><size>.4 .4 .4</size></box></geometry></collision>
<visual name='v'><geometry><box><size>.4 .4 .4</size></box></geometry></visual>{link}</link>{inside}{plugin}</model>"""


ARM = """<link name='arm'><pose>.3 0 0 0 0 0</pose>
<collision name='c'><geometry><box><size>.2 .1 .1</size></box></geometry></collision></link>
<joint name='hinge' type='revolute'><parent>l</parent><child>arm</child><axis><xyz>0 1 0</xyz>
<dynamics><damping>0.1</damping></dynamics></axis></joint>"""
BATTERY = "<battery name='main'><voltage>12</voltage></battery>"
TEXT = f"""<sdf version='1.6'><world name='default'>{GROUND}
<light name='sun' type='directional'/>
{box("one", "0 0 1 0.1 0.2 0", link=SENSORS)}
{box("two", "0.1 0.1 1.8 0 0.3 0.1", link=BATTERY)}
{box("three", "2 0 0.3 0 0 0", inside=ARM)}
{box("four", "-2 0 0.2 0 0 0", inside=box("inner", "0 1 0 0 0 0"))}
</world></sdf>"""
NEW = f"<sdf version='1.6'>{box('new', '0 0 3 0 0 0', link=IMU)}</sdf>"


@pytest.fixture
def run():
    with World.from_string(TEXT) as world:
        made = Run(world)
        made.watch()
        yield made


def repeats(run, between, steps=STEPS):
    """Save; run; do something else; restore; run again: both runs are equal to the bit."""
    state = run.world.get_state()
    assert run.world.get_state() == state
    first = run.steps(steps)
    between()
    run.world.set_state(state)
    assert run.world.get_state() == state
    assert first_difference(first, run.steps(steps)) is None


@pytest.mark.parametrize("path", MANY)
def test_a_restored_world_runs_on_to_the_bit(path):
    Rand.Seed(5)
    run = opened(path)
    with run.world:
        run.watch()
        run.steps(STEPS, every=50)
        repeats(run, lambda: None)


def test_the_harness_sees_a_difference(run):
    """One force of a micronewton is enough, so that the tests here can fail."""
    run.steps(20)
    state = run.world.get_state()
    first = run.steps(20)
    run.world.set_state(state)
    run.view.ModelByName("two").GetLink("l").AddForce((1e-6, 0.0, 0.0))
    assert first_difference(first, run.steps(20)) == 0


def test_models_that_went_return_and_those_that_came_go(run):
    run.steps(50)
    run.view.InsertModelString(NEW.replace("'new'", "'before'"))
    run.steps(10)
    one, ground = run.view.ModelByName("one"), run.view.ModelByName("ground")

    def edit():
        run.view.RemoveModel("one")
        run.view.RemoveModel("sun")
        run.steps(3)
        run.view.RemoveModel("before")
        run.view.InsertModelString(NEW)
        run.steps(20)

    repeats(run, edit)
    names = [model.GetName() for model in run.view.Models()]
    assert names == ["ground", "one", "two", "three", "four", "before"]
    assert run.view.ModelByName("ground") is ground  # what stayed has its views
    assert run.view.ModelByName("one") is not one
    with pytest.raises(ClosedError, match="was closed"):
        one.GetLink("l").AddForce((1.0, 0.0, 0.0))


def test_nested_models_and_links_made_at_run_time_return(run):
    run.steps(5)
    link = run.view.ModelByName("two").CreateLink("extra")
    link.SetLinearVel((0.1, 0.0, 0.0))

    def edit():
        run.view.RemoveModel("four::inner")
        run.view.ModelByName("two").CreateLink("another")
        run.steps(5)

    repeats(run, edit)
    assert run.view.ModelByName("two").GetLink("another") is None
    assert run.view.ModelByName("two").GetLink("extra") is not None
    assert run.view.ModelByName("four::inner") is not None


def test_joints_made_and_removed_around_a_state(run):
    two, three = (run.view.ModelByName(name) for name in ("two", "three"))
    run.steps(30)
    two.CreateJoint("grip", "fixed", three.GetLink("l"), two.GetLink("l"))
    run.steps(10)

    def edit():
        two.CreateJoint("late", "ball", None, two.GetLink("l"))
        run.steps(10)

    repeats(run, edit)
    assert two.GetJoint("late") is None

    def remove():
        two.RemoveJoint("grip")
        run.steps(10)

    repeats(run, remove)
    assert two.GetJoint("grip") is not None


def test_a_joint_that_returns_is_the_object_that_plugins_hold(run):
    three = run.view.ModelByName("three")
    hinge, ends = three.GetJoint("hinge"), (three.GetLink("l"), three.GetLink("arm"))
    run.steps(10)
    with_hinge = run.world.get_state()
    three.RemoveJoint("hinge")
    another = three.CreateJoint("hinge", "revolute", *ends)  # the same name is another joint
    with_another = run.world.get_state()
    run.world.set_state(with_hinge)
    assert three.GetJoint("hinge") is hinge
    hinge.SetPosition(0, 0.2)
    assert hinge.Position() == pytest.approx(0.2)
    run.world.set_state(with_another)
    assert three.GetJoint("hinge") is another
    assert run.world.get_state() == with_another
    run.world.set_state(with_hinge)
    assert run.world.get_state() == with_hinge

    def edit():
        three.RemoveJoint("hinge")
        run.steps(5)

    repeats(run, edit, 20)


def test_a_joint_returns_to_a_link_that_was_made_in_a_later_model(run):
    two, three = (run.view.ModelByName(name) for name in ("two", "three"))
    two.CreateJoint("grip", "fixed", three.CreateLink("late"), two.GetLink("l"))
    run.steps(5)
    repeats(run, lambda: run.view.RemoveModel("one"), 20)


def test_a_name_that_a_state_took_back_is_free_again(run):
    state = run.world.get_state()
    one = run.view.ModelByName("one")
    one.SetName("other")
    run.world.set_state(state)
    run.view.RemoveModel(one)
    run.view.InsertModelString(f"<sdf version='1.6'>{box('one', '0 0 3 0 0 0')}</sdf>")
    run.steps(2)
    assert run.view.ModelByName("one") is not None


def test_names_of_models_that_were_removed_are_in_no_state(run):
    inner = run.view.ModelByName("four::inner")
    inner.SetName("other")
    run.view.RemoveModel(inner)
    run.steps(5)
    state = run.world.get_state()
    run.view.RemoveModel("four")
    run.steps(5)
    run.world.set_state(state)
    assert run.world.get_state() == state


def test_an_axis_and_an_anchor_set_since_are_undone(run):
    hinge = run.view.ModelByName("three").GetJoint("hinge")
    run.steps(20)

    def edit():
        hinge.SetAxis(0, (1.0, 0.0, 0.0))
        hinge.SetAnchor(0, (2.2, 0.1, 0.2))
        hinge.SetParam("fmax", 0, 3.0)
        hinge.SetDamping(0, 2.0)
        run.steps(10)

    repeats(run, edit)
    assert run.view.ModelByName("three").GetJoint("hinge") is hinge


def test_controllers_batteries_animations_and_settings(run):
    view = run.view
    three, two = view.ModelByName("three"), view.ModelByName("two")
    controller = three.GetJointController()
    controller.SetPositionPID("three::hinge", PID(5.0, 1.0, 0.2, 10.0, -10.0))
    controller.SetPositionTarget("three::hinge", 0.4)
    battery = two.GetLink("l").Battery("main")
    load = battery.AddConsumer()
    battery.SetPowerLoad(load, 3.0)
    animation, ended = PoseAnimation("up", 0.3, False), []
    for time in (0.0, 0.3):
        animation.CreateKeyFrame(time).Translation(Vector3d(-2.0, 0.0, 1.0 + time))
    view.ModelByName("four").SetAnimation(animation, lambda: ended.append(view.SimTime().Double()))
    run.steps(40)

    def edit():
        controller.Reset()
        controller.SetForce("three::hinge", 2.0)
        view.ModelByName("two").GetJointController().SetForce("nothing", 1.0)
        battery.RemoveConsumer(load)
        view.SetGravity((0.0, 0.0, 1.0))
        view.SetMagneticField((1.0, 2.0, 3.0))
        view.Physics().SetParam("iters", 7)
        view.Physics().SetParam("island_threads", 3)
        two.GetLink("l").GetInertial().SetMass(7.0)
        two.GetLink("l").GetCollision("c").SetCollideMode("none")
        two.SetScale((2.0, 2.0, 2.0))
        view.LightByName("sun").SetDiffuseColor((1.0, 0.0, 0.0, 1.0))
        run.steps(5)

    repeats(run, edit, 300)
    assert len(ended) == 2  # the callback of its end was called in both runs
    assert ended[0] == ended[1]
    assert battery.PowerLoad(load) == 3.0
    assert controller.GetPositions()
    assert view.Physics().GetParam("island_threads") == 0
    assert tuple(view.MagneticField()) != (1.0, 2.0, 3.0)
    assert two.GetLink("l").GetInertial().Mass() != 7.0


def test_sensors_made_removed_and_changed_since(run):
    from libgz.classic.sensors import SensorManager

    run.steps(20)
    manager = SensorManager.Instance()

    def edit():
        manager.RemoveSensor("one::l::alt")
        ray = manager.GetSensor("one::l::ray")
        ray.SetUpdateRate(5.0)
        ray.SetPose(Pose3d(0.1, 0.0, 0.5, 0.0, 0.0, 1.0))
        manager.GetSensor("one::l::imu").SetActive(False)
        manager.GetSensor("one::l::gps").all_noises[0].SetStdDev(3.0)
        run.steps(10)

    repeats(run, edit)


def test_bodies_asleep_stay_asleep_in_both_runs():
    text = f"<sdf version='1.6'><world name='default'>{GROUND}{box('b', '0 0 0.2 0 0 0')}</world></sdf>"
    with World.from_string(text) as world:
        run = Run(world)
        world.step(1500)
        link = run.view.ModelByName("b").GetLink("l")
        assert not link.GetEnabled()
        repeats(run, lambda: link.SetEnabled(True))
        assert world.get_state()


def test_another_process_continues_to_the_bit(run, tmp_path):
    world_file, state_file = tmp_path / "a.world", tmp_path / "state"
    world_file.write_text(TEXT)
    run.steps(60)
    run.view.InsertModelString(NEW)
    run.view.RemoveModel("two")
    run.steps(10)
    run.view.ModelByName("three").CreateJoint("hold", "fixed", None, run.view.ModelByName("three").GetLink("l"))
    run.listen()
    state = run.world.get_state()
    state_file.write_bytes(state)
    wanted = hashlib.blake2b(b"".join(run.steps(STEPS))).hexdigest()
    code = f"""if True:
        import hashlib, sys
        sys.path.insert(0, {str(Path(__file__).parents[1])!r})
        from classic_runs import opened
        run = opened({str(world_file)!r})
        run.watch()
        state = open({str(state_file)!r}, "rb").read()
        run.world.set_state(state)
        assert run.world.get_state() == state
        run.listen()
        print(hashlib.blake2b(b"".join(run.steps({STEPS}))).hexdigest())
        run.world.close()"""
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert found.stdout.strip() == wanted, found.stderr


def test_a_state_of_another_world_is_refused(run):
    with (
        World.from_string(TEXT.replace("0 0 1 0.1", "0 0 1 0.3")) as other,
        pytest.raises(StateError, match="another world"),
    ):
        other.set_state(run.world.get_state())


def replaced(value, old, new):
    """A decoded state with another value in place of those that are equal to `old`."""
    if isinstance(value, bytes) and value.startswith(FORMAT):
        return encode(replaced(decode(value), old, new))
    if isinstance(value, dict):
        return {key: replaced(one, old, new) for key, one in value.items()}
    if hasattr(value, "_fields"):
        return type(value)(*(replaced(one, old, new) for one in value))
    if isinstance(value, (tuple, list)):
        return type(value)(replaced(one, old, new) for one in value)
    return new if type(value) is type(old) and value == old else value


@pytest.mark.parametrize(
    ("old", "new"),
    [("revolute", "bent"), ("hinge", 7), (b"", "x"), ("one", ("a",)), (False, "x"), (0, "x"), (0.0, "x"), (None, {})],
)
def test_a_damaged_state_leaves_the_world_unchanged(run, old, new):
    run.steps(2)
    state = run.world.get_state()
    run.steps(2)
    run.view.RemoveModel("four")
    run.steps(2)
    now = run.world.get_state()
    damaged = replaced(state, old, new)
    assert damaged != state
    with pytest.raises(GazeboError):
        run.world.set_state(damaged)
    assert run.world.get_state() == now
    run.world.set_state(state)
    assert run.world.get_state() == state


@pytest.mark.parametrize(
    ("joined", "message"),
    [(lambda pair: [max(pair)] * 2, "with itself"), (lambda _: [None, None], "fit each other")],
    ids=["itself", "nothing"],
)
def test_a_joint_of_a_body_with_itself_or_of_none_is_refused(run, joined, message):
    digest, names, parts = decode(run.world.get_state())
    saved = decode(parts)
    objects = decode(saved["engine"]["objects"])
    for _, pair, _ in objects["joints"]:
        pair[:] = joined(pair)
    saved["engine"]["objects"] = encode(objects)
    now = run.world.get_state()
    with pytest.raises(StateError, match=message):
        run.world.set_state(encode([digest, names, encode(saved)]))
    assert run.world.get_state() == now


# Plugins --------------------------------------------------------------------------------------------------------------

COUNTER = """
from libgz.classic import *
from libgz.classic.event import Events
loads = []
class Counter(ModelPlugin):
    {declares}
    def Load(self, model, sdf):
        loads.append(model.GetName())
        self.count, self.resets, self.model = 0, 0, model
        self.c = Events.ConnectWorldUpdateBegin(self.OnUpdate)
    def OnUpdate(self):
        self.count += 1
        self.model.GetLinks()[0].AddForce((0.01 * (self.count % 7), 0, 0))
    def Reset(self):
        self.count = 0
        self.resets += 1
GZ_REGISTER_MODEL_PLUGIN(Counter)
"""
PLUGIN = "<plugin name='p' filename='libcounter.so'/>"


@pytest.fixture
def with_plugin(tmp_path, monkeypatch):
    """Makes a run of a world with the counter, and returns the plugins of its two models."""
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", str(tmp_path))
    worlds = []

    def make(declares):
        (tmp_path / "counter.py").write_text(COUNTER.format(declares=declares))
        models = "".join(box(name, f"{x} 0 .5 0 0 0", plugin=PLUGIN) for x, name in enumerate("ab"))
        worlds.append(World.from_string(f"<sdf version='1.6'><world name='default'>{GROUND}{models}</world></sdf>"))
        run = Run(worlds[0])
        server = attach(worlds[0])
        return run, lambda name: server.plugins.of_model(run.view.ModelByName(name))[0].plugin

    yield make
    for world in worlds:
        world.close()


def test_plugins_that_stay_are_not_reloaded_and_get_their_state(with_plugin):
    run, plugin = with_plugin("STATE = ('count',)")
    run.steps(10)
    before = plugin("a")
    repeats(run, lambda: run.view.RemoveModel("b"))
    assert plugin("a") is before
    assert sys.modules[type(before).__module__].loads == ["a", "b", "b"]
    assert plugin("b").count == plugin("a").count == 10 + STEPS


def test_a_plugin_without_a_declared_state_is_named_once(with_plugin, caplog):
    run, _ = with_plugin("pass")
    assert "does not declare its state" not in caplog.text
    for _ in range(2):
        run.world.get_state()
    assert caplog.text.count("class Counter does not declare its state") == 1


def test_a_plugin_that_cannot_declare_its_state_is_named_with_the_reason(with_plugin, caplog):
    run, _ = with_plugin("not_kept = 'its variables are those of C++'")
    run.world.get_state()
    assert "its variables are those of C++" in caplog.text
    assert "does not declare its state" not in caplog.text


PUSHED = """
    def Load(self, model, sdf):
        self.count, self.resets, self.model = 0, 0, model
        self.c = Events.ConnectWorldUpdateBegin(self.OnUpdate)
        model.GetJointController().SetPositionPID("a::hinge", PID(1, 2, 3))
        model.SetGravityMode(False)
        model.SetAutoDisable(False)
        model.GetWorld().InsertModelString(NEW)
    STATE = ("count",)
    def OnUpdate(self):
        self.count += 1
"""


def test_what_a_plugin_does_that_a_state_loads_again_is_undone(tmp_path, monkeypatch):
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", str(tmp_path))
    text = COUNTER.format(declares="").split("    def Load")[0] + PUSHED + "GZ_REGISTER_MODEL_PLUGIN(Counter)\n"
    (tmp_path / "counter.py").write_text(f"from libgz.classic.math import PID\nNEW = {NEW!r}\n{text}")
    model = box("a", "0 0 1 0 0 0", inside=ARM, plugin=PLUGIN)
    with World.from_string(f"<sdf version='1.6'><world name='default'>{GROUND}{model}</world></sdf>") as world:
        run = Run(world)
        view, server = run.view.ModelByName("a"), attach(world)
        controller = view.GetJointController()
        controller.SetPositionTarget("a::hinge", 0.5)
        controller.SetPositionPID("a::hinge", PID(5, 4, 3))
        view.SetGravityMode(True)
        run.steps(20)
        state = world.get_state()
        (loaded,) = server.plugins.of_model(view)
        loaded.drop()
        run.steps(20)
        run.view.RemoveModel("new")
        world.set_state(state)
        assert world.get_state() == state
        (again,) = server.plugins.of_model(run.view.ModelByName("a"))
        assert (again.plugin.count, world.model("a").GetId()) == (20, "a")
        assert len(world.models) == 3


def test_a_reset_calls_reset_and_loads_the_plugins_of_models_that_return(with_plugin):
    run, plugin = with_plugin("STATE = ('count',)")
    run.steps(10)
    before = plugin("a")
    run.view.RemoveModel("b")
    run.world.reset()
    assert plugin("a") is before
    assert (before.count, before.resets) == (0, 1)
    assert sys.modules[type(before).__module__].loads == ["a", "b", "b"]


# Resets ---------------------------------------------------------------------------------------------------------------


def fresh_and_reset(open_world, edit=lambda run: None):
    """The digests of the first steps of a fresh world, and of those of one after a reset."""
    records = []
    for again in (False, True):
        Rand.Seed(5)
        run = open_world()
        with run.world:
            run.watch()
            if again:
                run.steps(STEPS + 7)
                edit(run)
                run.world.reset()
                run.activate()
            records.append(run.steps(STEPS))
    return records


@pytest.mark.parametrize("path", MANY)
def test_a_reset_world_is_as_a_fresh_one_to_the_bit(path):
    assert first_difference(*fresh_and_reset(lambda: opened(path))) is None


def test_a_reset_undoes_inserts_deletes_and_settings(caplog):
    def edit(run):
        run.view.InsertModelString(NEW)
        run.view.RemoveModel("two")
        run.view.SetGravity((0.0, 0.0, 0.0))
        run.view.ModelByName("three").CreateJoint("j", "fixed", None, run.view.ModelByName("three").GetLink("l"))

    assert first_difference(*fresh_and_reset(lambda: Run(World.from_string(TEXT)), edit)) is None
    assert not [record for record in caplog.records if record.levelno >= logging.ERROR]


def test_reset_of_time_and_of_entities_keep_their_meaning(run):
    run.steps(40)
    two = run.view.ModelByName("two")
    pose = tuple(two.WorldPose().Pos())
    run.view.ResetTime()
    assert (run.world.GetSimTime(), tuple(two.WorldPose().Pos())) == (0.0, pose)
    run.steps(10)
    run.view.InsertModelString(NEW)
    run.view.ResetEntities()
    assert tuple(two.WorldPose().Pos()) == (0.1, 0.1, 1.8)
    assert run.world.GetSimTime() > 0.0
    assert run.view.ModelByName("new") is not None


def test_commands_to_a_clone_move_only_the_clone():
    with World.from_file(EXAMPLES / "diff_drive" / "diff_drive.world") as world:
        world.step(100)
        state = world.get_state()
        expected = []
        for _ in range(STEPS):
            world.step()
            expected.append(world.engine.states.tobytes())
        world.set_state(state)
        with world.clone() as silent, world.clone() as driven:
            assert driven.get_state() == silent.get_state() == state
            node = Node()
            node.Init(driven.topic_space)
            publisher = node.Advertise(msgs.Pose, "~/pioneer2dx/vel_cmd")
            moved, turn = [], msgs.Pose()
            msgs.Set(turn, Pose3d(0.0, 0.0, 0.0, 0.0, 0.0, 0.8))
            for number in range(STEPS):
                if number % 10 == 0:
                    publisher.Publish(turn)
                for each in (driven, world, silent):
                    each.step()
                assert world.engine.states.tobytes() == expected[number]
                assert silent.engine.states.tobytes() == expected[number]
                moved.append(driven.engine.states.tobytes())
            assert moved[0] == expected[0]
            assert moved[-1] != expected[-1]
        world.step()  # the clones' end leaves its topics


def test_plugins_of_a_clone_find_its_topics_by_the_name_of_the_world():
    with World.from_file(EXAMPLES / "diff_drive" / "diff_drive.world") as world, world.clone() as clone:
        assert clone.name == world.name
        topics = TopicManager.Instance().topics
        for space in (world.topic_space, clone.topic_space):
            assert len(topics[f"/gazebo/{space}/pioneer2dx/vel_cmd"].live_subscribers()) == 1
        plugin = next(attach(clone).plugins.running())
        token = owner.set(plugin)
        try:
            node = Node()
            node.Init(world.name)
            assert node.GetTopicNamespace() == clone.topic_space
            assert node.DecodeTopicName(f"/gazebo/{world.name}/a") == f"/gazebo/{clone.topic_space}/a"
            assert node.EncodeTopicName(f"/gazebo/{clone.topic_space}/a") == "~/a"
        finally:
            owner.reset(token)


def test_messages_that_wait_end_with_their_world():
    for _ in range(2):
        with World.from_string(TEXT) as world:
            topics = attach(world).topics
            assert topics.save() == []
            topic = f"/gazebo/{world.topic_space}/request"
            queue_message(topic, msgs.Request(id=1, request="nothing"))
            assert topics.save()


def test_a_removed_link_gets_no_space_of_its_own(run):
    state = run.world.get_state()
    link = run.view.ModelByName("three").GetLink("arm")
    run.view.RemoveModel("three")
    with pytest.raises(ClosedError, match="arm"):
        link.SetSelfCollide(True)
    later = run.world.get_state()
    run.world.set_state(state)
    run.world.set_state(later)
    assert run.world.get_state() == later


def test_groups_lines_and_shapes_of_visuals(run):
    blue = (0.0, 0.0, 1.0, 1.0)
    before = run.world.get_state()
    scene = get_scene("default")
    assert run.world.get_state() == before  # a scene that nothing changed is no part of the state
    model = scene.GetVisual("one")
    model.SetTransparency(0.25)
    model.SetVisible(False)
    model.SetMaterial("Gazebo/Red")
    line = model.CreateDynamicLine()
    line.AddPoint((0, 0, 0), Color(*blue))
    line.AddPoint((0, 0, 1))
    arrow = Visual("arrow", scene)
    arrow.AttachMesh("unit_box")
    arrow.SetPosition((1, 2, 3))
    state = run.world.get_state()

    model.SetTransparency(0.75)
    model.SetVisible(True)
    model.SetMaterial("Gazebo/Green")
    line.SetPoint(1, (5, 5, 5))
    line.AddPoint((1, 1, 1))
    model.CreateDynamicLine()
    scene.GetVisual("two").SetTransparency(0.5)
    arrow.Fini()
    Visual("later", scene).AttachMesh("unit_sphere")
    run.world.set_state(state)
    assert run.world.get_state() == state
    assert (model.Transparency(), model.Visible(), model.GetMaterialName()) == (0.25, False, "Gazebo/Red")
    assert scene.lines == [line]
    assert (line.PointCount(), line.Point(1)) == (2, Vector3d(0, 0, 1))
    assert scene.GetVisual("two").Transparency() == 0.0
    assert scene.GetVisual("later") is None
    assert scene.GetVisual("arrow").Position() == Vector3d(1, 2, 3)

    run.world.DeleteModel("one")
    run.world.set_state(state)  # the model is built again, and its visual is a new one
    assert run.world.get_state() == state
    assert scene.GetVisual("one") is not model
    assert scene.GetVisual("one").Transparency() == 0.25
    assert [line.PointCount() for line in scene.lines] == [2]

    run.world.set_state(before)
    assert run.world.get_state() == before
    assert (scene.GetVisual("one").Transparency(), scene.GetVisual("one").Visible()) == (0.0, True)
    assert scene.GetVisual("arrow") is None
    assert scene.lines == []


def test_what_seldom_changes_is_read_after_each_change(run):
    """A state keeps what it has read until a change of it is counted: these are easy to forget."""
    three, light = run.view.ModelByName("three"), run.view.LightByName("sun")
    hinge, sensors = three.GetJoint("hinge"), run.view.server.sensors.sensors
    imu = next(sensor for sensor in sensors.values() if sensor.Type() == "imu")
    manager = run.view.Physics().GetContactManager()
    edits = (
        lambda: hinge.SetEffortLimit(0, 0.5),
        lambda: hinge.SetVelocityLimit(0, 2.0),
        lambda: hinge.SetUpperLimit(0, 0.7),
        lambda: hinge.SetProvideFeedback(True),
        lambda: three.SetName("third"),
        lambda: hinge.SetName("elbow"),
        lambda: light.SetCastShadows(not light.CastShadows()),
        lambda: imu.Noise(next(iter(imu.noises))).Apply(1.0),
        lambda: imu.SetUpdateRate(11.0),
        lambda: manager.CreateFilter("f", ["one::l::c"]),
        lambda: run.view.Physics().SetParam("island_threads", 3),
        lambda: run.view.server.presets.CreateProfile("another"),
        lambda: three.SetInitialRelativePose(Pose3d(1.0, 2.0, 3.0, 0.0, 0.0, 0.0)),
        lambda: run.steps(3),
    )
    run.steps(20)
    start = run.world.get_state()
    states = [start]
    for edit in edits:
        edit()
        states.append(run.world.get_state())
        assert run.world.get_state() == states[-1]
    assert len(set(states)) == len(states)
    for state in reversed(states):
        run.world.set_state(state)
        assert run.world.get_state() == state
    assert (three.GetName(), hinge.GetName()) == ("three", "hinge")


@pytest.mark.parametrize("name", ["ros_diff_drive", "without_effect"])
def test_ready_plugins_declare_their_state(name, caplog):
    with World.from_file(EXAMPLES / "ready" / f"{name}.world") as world:
        world.step(1)
        world.get_state()
    assert "does not declare its state" not in caplog.text


def test_contacts_of_a_removed_model_end_with_it():
    sensor = """<sensor name='bump' type='contact'><always_on>1</always_on><update_rate>10</update_rate>
<contact><collision>c</collision></contact></sensor>"""
    low, high = box("low", "0 0 0.2 0 0 0", link=sensor), box("high", "0 0 0.6 0 0 0")

    def touching(run):
        run.steps(120, every=120)
        message = get_sensor("bump").Contacts()
        return {name for contact in message.contact for name in (contact.collision1, contact.collision2)}

    with World.from_string(f"<sdf version='1.6'><world name='default'>{GROUND}{low}{high}</world></sdf>") as world:
        run = Run(world)
        run.steps(30)
        before = world.get_state()
        run.view.RemoveModel("high")
        run.steps(1)
        then = world.get_state()
        assert touching(run) == {"ground::l::c", "low::l::c"}
        world.set_state(then)
        assert touching(run) == {"ground::l::c", "low::l::c"}
        world.set_state(before)
        assert "high::l::c" in touching(run)


CHAIN = """<model name='chain'><pose>0 5 2 0 0 0</pose>
<link name='a'/><link name='b'><pose>0.3 0 0 0 0.2 0.1</pose></link><link name='c'><pose>0.6 0 0 0 0.1 0</pose></link>
<link name='d'><pose>0.9 0 0 0 0 0</pose></link><link name='e'><pose>0.9 0.4 0 0 0 0</pose></link>
<joint name='thread' type='screw'><parent>a</parent><child>b</child><axis><xyz>1 0 0</xyz></axis>
<thread_pitch>10</thread_pitch></joint>
<joint name='hinge' type='revolute'><parent>b</parent><child>c</child><axis><xyz>0 1 0.1</xyz></axis>
<sensor name='wrench' type='force_torque'><always_on>1</always_on></sensor></joint>
<joint name='first' type='revolute'><parent>c</parent><child>d</child><axis><xyz>0 0 1</xyz></axis></joint>
<joint name='second' type='revolute'><parent>c</parent><child>e</child><axis><xyz>0 0 1</xyz></axis></joint>
<joint name='gears' type='gearbox'><parent>d</parent><child>e</child><axis><xyz>0 0 1</xyz></axis>
<axis2><xyz>0 0 1</xyz></axis2><gearbox_ratio>2</gearbox_ratio>
<gearbox_reference_body>c</gearbox_reference_body></joint></model>"""


def rejoined(chain):
    chain.GetJoint("gears").Detach()
    chain.GetJoint("thread").Detach()
    chain.GetJoint("thread").Attach(chain.GetLink("a"), chain.GetLink("b"))


def removed(chain):
    chain.RemoveJoint("hinge")
    chain.RemoveJoint("gears")
    chain.CreateJoint("hinge", "ball", chain.GetLink("a"), chain.GetLink("c"))


def joined_with_itself(chain):
    with pytest.raises(ParameterError, match="cannot join body"):
        chain.GetJoint("hinge").Attach(chain.GetLink("a"), chain.GetLink("a"))


def spaces(chain):
    for name in ("d", "a", "c"):
        chain.GetLink(name).SetSelfCollide(True)
    chain.GetLink("d").SetSelfCollide(False)


def renamed(chain):
    chain.SetName("other")


def linked(chain):
    box = chain.GetWorld().ModelByName("box")
    box.CreateLink("new")  # another order than that of the models
    chain.CreateLink("new").SetLinearVel((0.1, 0.0, 0.0))


CHANGES = (rejoined, removed, joined_with_itself, spaces, renamed, linked)


@pytest.mark.parametrize("change", CHANGES, ids=lambda change: change.__name__)
def test_changes_of_joints_and_links_are_in_a_state_and_undone_by_one(change):
    text = f"<sdf version='1.6'><world name='default'>{GROUND}{CHAIN}{box('box', '2 0 1 0 0.1 0')}</world></sdf>"
    with World.from_string(text) as world:
        run = Run(world)
        run.activate()
        run.steps(5)
        repeats(run, lambda: change(run.view.ModelByName("chain")), steps=10)
        change(run.view.ModelByName("chain"))
        run.steps(3)
        changed = world.get_state()
        with world.clone() as clone:
            assert clone.get_state() == changed
        world.reset()
        world.set_state(changed)
        assert world.get_state() == changed


ROPE = """
from libgz.classic import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.event import Events


class Rope(ModelPlugin):
    STATE = ("count",)
    ends = False

    def Load(self, model, sdf):
        self.count = 0
        self.joint = model.CreateJoint("rope", "revolute", None, model.GetLink("l"))
        self.c = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def OnUpdate(self):
        self.count += 1
        self.joint.SetForce(0, 0.5)
        if type(self).ends:
            raise RuntimeError("at an end")


GZ_REGISTER_MODEL_PLUGIN(Rope)
"""


@pytest.mark.parametrize("at_run_time", [False, True])
def test_a_plugin_that_made_a_joint_and_ended_is_loaded_again(tmp_path, at_run_time):
    path = tmp_path / "rope.py"
    path.write_text(ROPE)
    plugin = f"<plugin name='r' filename='{path}'/>"
    text = f"<sdf version='1.6'><world name='default'>{box('a', '0 0 1 0 0 0', plugin='' if at_run_time else plugin)}"
    with World.from_string(f"{text}{box('b', '3 0 1 0 0 0')}</world></sdf>") as world:
        run = Run(world)
        view = run.view.ModelByName("a")
        if at_run_time:
            attach(world).plugins.load_for_model(view, str(path), "r", None)
        run.steps(10)
        state = world.get_state()
        first = run.steps(20)
        (loaded,) = attach(world).plugins.of_model(view)
        loaded.plugin_class.ends = True
        run.steps(2)
        assert len(world.errors) == 1
        loaded.plugin_class.ends = False
        world.set_state(state)
        assert world.get_state() == state
        assert run.steps(20) == first
        with world.clone() as clone:
            assert clone.get_state() == world.get_state()
        assert len(world.errors) == 1


def test_renamed_models_and_lights_are_found_by_their_new_names(run):
    one, inner = run.view.ModelByName("one"), run.view.ModelByName("four::inner")
    assert run.view.ModelByName("inner") is inner
    one.SetName("other")
    assert run.view.ModelByName("other") is one
    assert run.view.ModelByName("one") is None
    run.view.ModelByName("four").SetName("five")
    assert run.view.ModelByName("five::inner") is inner
    run.steps(2)
    state = run.world.get_state()
    one.SetName("third")
    run.world.set_state(state)
    assert run.view.ModelByName("other") is one
