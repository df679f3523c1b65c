"""Plugins that fail while a state is taken or set, or the world is reset: the world stays whole, and says why."""

import sys
import threading

import pytest
from topics import send

from libgz import World
from libgz.base.errors import GazeboError, PluginError, StateError, StrictError
from libgz.classic import msgs

CONTROL = """
calls, where, what = [], "", None
def reached(place):
    calls.append(place)
    if place == where:
        what()
"""
PLUGIN = """
from libgz.classic import *
from libgz.classic.event import Events
import {control} as control
class Odd({kind}Plugin):
    STATE = ("count",)
    def __init__(self):
        super().__init__()
        self.count, self.resets = 0, 0
        control.reached("constructor " + self.GetHandle())
    def Load(self, holder, sdf):
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)
        self.node = transport.Node()
        self.node.Init("default")
        self.subscriber = self.node.Subscribe("~/order", self.OnMessage)
        control.reached("Load " + self.GetHandle())
    def Init(self):
        control.reached("Init " + self.GetHandle())
    def OnUpdate(self):
        self.count += 1
        control.reached("OnUpdate " + self.GetHandle())
    def OnMessage(self, message):
        control.reached("OnMessage " + self.GetHandle())
    def Reset(self):
        self.count, self.resets = 0, self.resets + 1
        control.reached("Reset " + self.GetHandle())
    def SaveState(self):
        control.reached("SaveState")
        return -self.count
    def LoadState(self, state):
        control.reached("LoadState")
        if state != -self.count:
            raise ValueError("another count")
GZ_REGISTER_{upper}_PLUGIN(Odd)
"""
BOX = """<model name='{0}'><pose>{1} 0 1 0 0.1 0</pose><link name='l'><collision name='c'><geometry><sphere>
<radius>1</radius></sphere></geometry></collision></link><plugin name='{0}1' filename='libodd_model.so'/>
<plugin name='{0}2' filename='libodd_model.so'/></model>"""
TEXT = f"""<sdf version='1.6'><world name='default'><plugin name='w1' filename='libodd_world.so'/>
<plugin name='w2' filename='libodd_world.so'/>{BOX.format("a", 0)}{BOX.format("b", 3)}</world></sdf>"""


class Unforeseen(BaseException):
    """What a plugin may raise that is no Exception, like CancelledError of asyncio."""


def raises(error):
    def function():
        raise error

    return function


@pytest.fixture
def control(tmp_path, monkeypatch):
    """A module that the plugins of `world` call in all their methods."""
    name = f"control_{tmp_path.name}"
    (tmp_path / f"{name}.py").write_text(CONTROL)
    for kind in ("Model", "World"):
        text = PLUGIN.format(control=name, kind=kind, upper=kind.upper())
        (tmp_path / f"odd_{kind.lower()}.py").write_text(text)
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", str(tmp_path))
    monkeypatch.syspath_prepend(str(tmp_path))
    yield __import__(name)
    del sys.modules[name]


@pytest.fixture
def world(control):
    with World.from_string(TEXT) as world:
        world.step(5)
        yield world
        control.where = ""


def server(world):
    return world.facade.server


def plugin(world, model, number=0):
    return server(world).plugins.of_model(world.facade.ModelByName(model))[number].plugin


ERRORS = [ValueError("odd"), SystemExit(5), KeyboardInterrupt(), GazeboError("odd"), Unforeseen("odd")]


@pytest.mark.parametrize("error", ERRORS[::2], ids=lambda error: type(error).__name__)
@pytest.mark.parametrize("where", ["SaveState", "LoadState"])
def test_what_these_raise_is_an_error_and_changes_nothing(world, control, where, error):
    state = world.get_state()
    world.step(5)
    later = world.get_state()
    for _ in range(2):  # the second time, this is a state that could be set
        control.where, control.what = where, raises(error)
        with pytest.raises(PluginError):
            world.get_state() if where == "SaveState" else world.set_state(state)
        control.where = ""
        assert world.get_state() == later
        world.set_state(state)
        assert world.get_state() == state
        world.step(5)
        assert world.get_state() == later
    assert world.errors == []


def remove_world_plugin(world):
    server(world).plugins.remove_from_world("w1")


def remove_model(world):
    world.DeleteModel("a")


@pytest.mark.parametrize(
    ("where", "error"), [*zip(["constructor", "Load", "Init", "Load"], ERRORS[1:], strict=True)], ids=repr
)
@pytest.mark.parametrize("remove", [remove_world_plugin, remove_model])
def test_a_plugin_that_cannot_be_loaded_again_refuses_the_state(world, control, remove, where, error):
    state = world.get_state()
    for again in range(2):
        remove(world)
        world.step(5)
        later, noted = world.get_state(), len(world.errors)
        removed = "w1" if remove is remove_world_plugin else "a1"
        control.where, control.what = f"{where} {removed}", raises(error)
        name = "World plugin 'w1'" if remove is remove_world_plugin else "Model plugin 'a1' of a"
        with pytest.raises(StateError, match=f"^{name} of the state cannot be loaded again: the .* failed with"):
            world.set_state(state)
        assert len(world.errors) == noted + 1, again
        control.where = ""
        assert world.get_state() == later
        world.set_state(state)
        assert world.get_state() == state


def test_a_plugin_whose_file_is_gone_refuses_the_state(world, tmp_path, control):
    state = world.get_state()
    remove_world_plugin(world)
    later = world.get_state()
    (tmp_path / "odd_world.py").rename(tmp_path / "away.py")
    for _ in range(2):
        with pytest.raises(StateError, match="World plugin 'w1' of the state cannot be loaded again"):
            world.set_state(state)
        assert world.get_state() == later
    assert len(world.errors) == 1


@pytest.mark.parametrize("error", ERRORS[:2], ids=lambda error: type(error).__name__)
def test_what_a_reset_raises_stops_that_plugin_only(world, control, error):
    with World.from_string(TEXT) as fresh:
        start = fresh.engine.states.tobytes()
    control.where, control.what = "Reset a1", raises(error)
    world.Reset()
    assert [plugin(world, "b").resets, plugin(world, "a", 1).resets, plugin(world, "a")] == [1, 1, None]
    assert world.engine.states.tobytes() == start
    (problem,) = world.errors
    assert "the Reset function failed" in str(problem)
    control.calls.clear()
    world.step(1)
    assert "OnUpdate a1" not in control.calls
    assert "OnUpdate a2" in control.calls


def test_a_strict_world_ends_at_a_failing_reset(control):
    with World.from_string(TEXT, strict=True) as world:
        control.where, control.what = "Reset a1", raises(ValueError("odd"))
        world.Reset()
        with pytest.raises(StrictError, match="Reset function failed"):
            world.Step()


@pytest.mark.parametrize(
    "change",
    [
        remove_world_plugin,
        remove_model,
        lambda world: world.DeleteModel("b"),
        lambda world: server(world).plugins.of_model(world.facade.ModelByName("a"))[0].drop(),
        lambda world: (
            server(world).plugins.remove_from_world("late"),
            remove_world_plugin(world),
            remove_model(world),
        ),
        lambda world: world.Reset(),
    ],
)
def test_callbacks_are_called_in_the_same_order(world, control, change):
    server(world).plugins.load_for_world("libodd_world.so", "late", None)
    order = order_of_calls(world, control)
    assert len(order) == 14
    state = world.get_state()
    change(world)
    world.set_state(state)
    assert world.get_state() == state
    assert order_of_calls(world, control) == order


def order_of_calls(world, control):
    """The callbacks of an event, and of a topic."""
    publisher = send("~/order", msgs.Int(data=1))
    control.calls.clear()
    world.step(1)
    publisher.Fini()
    return [call for call in control.calls if call.startswith("On")]


def test_a_reloaded_plugin_keeps_its_place_in_the_order(world, control):
    order = order_of_calls(world, control)
    world.reload_plugin("a1")
    assert order_of_calls(world, control) == order


CALLS = {
    "get_state": lambda world, state: world.get_state(),
    "set_state": lambda world, state: world.set_state(state),
    "rewind": lambda world, state: world.rewind(0.001),
    "clone": lambda world, state: world.clone(),
    "keep_rewind": lambda world, state: world.keep_rewind(1.0),
    "reseed": lambda world, state: world.reseed(3),
    "step": lambda world, state: world.Step(),
    "close": lambda world, state: world.close(),
}


@pytest.mark.parametrize("call", CALLS)
def test_calls_within_callbacks_are_errors(world, control, call):
    world.keep_rewind(1.0, 0.0)
    state = world.get_state()
    world.step(5)
    later, refused = world.get_state(), []

    def attack():
        control.where = ""
        with pytest.raises(GazeboError, match=r"in a callback|while plugins load") as caught:
            CALLS[call](world, state)
        refused.append(caught)

    actions = {
        "OnUpdate a1": world.Step,
        "Reset a1": world.Reset,
        "SaveState": world.get_state,
        "LoadState": lambda: world.set_state(state),
        "Load new": lambda: server(world).plugins.load_for_world("libodd_world.so", "new", None),
        "Init newer": lambda: server(world).plugins.load_for_world("libodd_world.so", "newer", None),
    }
    for where, act in actions.items():
        control.where, control.what = where, attack
        act()
        world.set_state(state)
        world.step(5)
        assert world.get_state() == later, where
    assert len(refused) == len(actions)
    assert world.errors == []


@pytest.mark.parametrize("strict", [False, True])
def test_a_state_that_cannot_be_kept_for_rewinding_is_reported_and_left_out(control, strict):
    with World.from_string(TEXT, strict=strict) as world:
        world.keep_rewind(1.0, 0.002)
        world.step(4)
        control.where, control.what = "SaveState", raises(ValueError("odd"))
        control.calls.clear()
        if strict:
            with pytest.raises(StrictError, match=r"(?s)cannot be kept for rewinding: .*ValueError: odd"):
                world.step(4)
        else:
            world.step(8)
            assert control.calls.count("SaveState") == 4  # the first plugin, at each interval
            (problem,) = world.errors
            assert problem.message.startswith("the state of sim time 0.006 s cannot be kept for rewinding: ")
            control.where = ""
            world.step(4)
            assert world.rewind(0.003) == pytest.approx(0.004)
        control.where = ""


@pytest.mark.parametrize("seconds", [0.0, 1.0])
def test_a_refused_keep_rewind_leaves_the_kept_states(world, control, seconds):
    world.keep_rewind(1.0, 0.0)
    world.step(5)
    refused = []

    def attack():
        with pytest.raises(GazeboError, match="in a callback") as caught:
            world.keep_rewind(seconds)
        refused.append(caught)

    control.where, control.what = "OnUpdate a1", attack
    world.step(2)
    assert (len(refused), world.iterations) == (2, 12)
    assert world.rewind(0.005) == pytest.approx(0.007)


@pytest.mark.parametrize("where", ["Reset a1", "LoadState", "SaveState", "OnUpdate a1"])
def test_a_reset_that_asks_for_a_reset_ends(world, control, where):
    world.step(5)
    state = world.get_state()
    asked = []

    def attack():
        asked.append(1)
        world.Reset()

    control.where, control.what = where, attack
    if where == "Reset a1":
        world.Reset()
        assert [str(problem).count("would never end") > 0 for problem in world.errors] == [True]
    elif where == "LoadState":
        world.set_state(state)
    elif where == "SaveState":
        assert world.get_state() == state  # the reset came after it
        assert world.iterations == 0
    else:
        world.Step()
    assert 0 < len(asked) < 100  # six plugins ask; so they do in each of the resets that follow
    control.where = ""
    world.set_state(state)
    assert world.get_state() == state


EVERYWHERE = """
from libgz.classic import *
from libgz.classic.event import Events
import {control} as control
NAMES = ("WorldUpdateBegin", "BeforePhysicsUpdate", "WorldUpdateEnd", "WorldReset", "TimeReset")
NAMES += ("AddEntity", "DeleteEntity")
class Everywhere(ModelPlugin):
    STATE = ()
    def Load(self, model, sdf):
        self.connections = [getattr(Events, "Connect" + n)(lambda *_, n=n: control.reached(n)) for n in NAMES]
        self.connections.append(sensors.get_sensor("s").ConnectUpdated(lambda *_: control.reached("sensor")))
        self.node = transport.Node()
        self.node.Init("default")
        self.subscriber = self.node.Subscribe("~/x", lambda _: control.reached("topic"))
GZ_REGISTER_MODEL_PLUGIN(Everywhere)
"""


ONE = """<sdf version='1.6'><world name='default'><model name='box'><pose>0 0 1 0 0 0</pose><link name='l'><inertial>
<mass>1</mass></inertial><sensor name='s' type='imu'><always_on>1</always_on><update_rate>1000</update_rate></sensor>
</link><plugin name='p' filename='libeverywhere.so'/></model></world></sdf>"""
OTHER = "<sdf version='1.6'><model name='other'><link name='l'/></model></sdf>"
PLACES = {
    "WorldUpdateBegin": World.Step,
    "BeforePhysicsUpdate": World.Step,
    "WorldUpdateEnd": World.Step,
    "sensor": World.Step,
    "topic": lambda world: (send("~/x", msgs.Int(data=1)), world.Step()),
    "WorldReset": World.Reset,
    "TimeReset": lambda world: world.facade.ResetTime(),
    "AddEntity": lambda world: (world.facade.InsertModelString(OTHER), world.Step()),
    "DeleteEntity": lambda world: world.DeleteModel("other"),
}


def test_all_calls_in_all_callbacks_are_refused_and_change_nothing(control, tmp_path):
    (tmp_path / "everywhere.py").write_text(EVERYWHERE.format(control=control.__name__))
    states = []
    for attacked in (False, True):
        with World.from_string(ONE) as world:
            world.keep_rewind(1.0, 0.0)
            world.step(3)
            state, refused = world.get_state(), []
            states.append([])
            for place, act in PLACES.items():
                control.where = place if attacked else ""

                def attack(world=world, state=state, refused=refused):
                    control.where = ""
                    for name, call in CALLS.items():
                        with pytest.raises(GazeboError, match=r"in a callback|while plugins load"):
                            call(world, state)
                        refused.append(name)

                control.what = attack
                act(world)
                states[-1].append(world.get_state())
            assert len(refused) == attacked * len(PLACES) * len(CALLS)
            assert world.errors == []
            world.set_state(state)
            assert world.get_state() == state
    assert states[0] == states[1]


def test_all_calls_in_a_thread_of_a_plugin_wait_for_the_step(world, control):
    world.keep_rewind(1.0, 0.0)
    state, failures = world.get_state(), []

    def use():
        try:
            for _ in range(3):
                world.set_state(world.get_state())
                world.keep_rewind(1.0, 0.0)
                world.rewind(0.0)
                world.Reset()
                world.reseed(3)
                with world.clone() as clone:
                    clone.step(2)
                world.reload_plugin("a1")
                world.Step()
                world.set_state(state)
        except BaseException as error:  # noqa: BLE001 - it is the result
            failures.append(error)

    user = threading.Thread(target=use, daemon=True)
    user.start()
    while user.is_alive():
        world.Step()
    assert failures == []
    world.set_state(state)
    assert world.get_state() == state
    assert world.errors == []
