"""States of legacy worlds: to the bit, in this process and others, with clients, after inserts and deletes."""

import os
import pickle
import subprocess
import sys
from collections import deque
from pathlib import Path

import numpy as np
import pytest
import state_runs
from state_runs import difference, look, run

import libgz
from libgz.base.errors import ClosedError, GazeboError, ParameterError, PluginError, StateError
from libgz.base.files import installed_worlds
from libgz.base.geometry import GzColor, GzPose, GzQuatern, GzVector
from libgz.legacy.world import LegacyWorld
from libgz.models.simplesolid import SimpleSolid
from libgz.physics.joint import HingeJoint

WORLDS = sorted(installed_worlds().glob("*.world"))
HEAD = "<gz:world xmlns:gz='g' xmlns:model='m' xmlns:param='p'>"
ROBOTS = (
    f"{HEAD}<model:GroundPlane><id>ground</id></model:GroundPlane>"
    "<model:Pioneer2AT><id>one</id><model:SickLMS200><id>laser</id><xyz>.1 0 .311</xyz></model:SickLMS200>"
    "</model:Pioneer2AT><model:SimpleSolid><id>box</id><xyz>1 0.2 1</xyz></model:SimpleSolid>"
    "<model:SegwayRMP><id>two</id><xyz>0 2 0</xyz></model:SegwayRMP>"
    "<model:Factory><id>factory</id></model:Factory></gz:world>"
)
BALL = "<model:SimpleSolid><id>{0}</id><shape>sphere</shape><xyz>{1} 0.4 2</xyz></model:SimpleSolid>"


@pytest.fixture
def world():
    with libgz.World.from_string(ROBOTS) as found:
        found.step(30)
        yield found


@pytest.mark.parametrize("path", WORLDS, ids=lambda path: path.stem)
def test_packaged_worlds_continue_and_reset_to_the_bit(path):
    with libgz.World.from_file(path) as world:
        start = world.get_state()
        first = run(world, 22, 1)
        state = world.get_state()
        assert world.get_state() == state
        seen = run(world, 22, 2)
        world.set_state(state)
        assert world.get_state() == state
        assert difference(seen, run(world, 22, 2)) is None
        world.Reset()
        assert world.get_state() == start
        assert difference(first, run(world, 22, 1)) is None


def test_another_process_continues_to_the_bit(tmp_path):
    path = tmp_path / "robots.world"
    path.write_text(ROBOTS)
    with libgz.World.from_file(path) as world:
        world.step(40)
        world.DeleteModel("box")
        world.InsertModel(BALL.format("ball", 0.1))
        run(world, 30, 1)
        kept = tmp_path / "state"
        kept.write_bytes(world.get_state())
        seen = state_runs.digest(run(world, 50, 2))
    command = [sys.executable, state_runs.__file__, str(path), str(kept), "50", "2"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.stdout.strip() == seen, done.stderr


def change_nothing(world):
    pass


def delete_first(world):
    world.DeleteModel("one")


def delete_ground(world):
    world.DeleteModel("ground")  # what comes after it is built again with it


def delete_child(world):
    world.DeleteModel("laser")


def insert(world):
    world.InsertModel(BALL.format("new", 0))


def replace(world):
    world.DeleteModel("box")
    world.InsertModel(BALL.format("box", 1))
    world.DeleteModel("two")


def join(world):
    hinge = HingeJoint(world, name="made")
    hinge.Attach(world.model("one").GetBody(), world.model("box").GetBody())
    hinge.SetAnchor((0.5, 0, 0.5))


BEFORE = change_nothing, delete_first, insert, replace
AFTER = change_nothing, delete_first, delete_child, insert, replace, join


@pytest.mark.parametrize(
    ("before", "after"),
    [  # each of them once, the other pairs as trials
        pytest.param(one, two, marks=[pytest.mark.trial] * (i != j % len(BEFORE)))
        for i, one in enumerate(BEFORE)
        for j, two in enumerate(AFTER)
    ],
)
def test_what_came_and_went(world, before, after):
    before(world)
    run(world, 25, 1)
    state = world.get_state()
    names = [entity.GetId() for entity in world.entities]
    seen = run(world, 45, 2)
    if not (before is delete_first and after in (delete_first, delete_child, join)) and not (
        before is replace and after is replace
    ):
        after(world)
        run(world, 5, 3)
    world.set_state(state)
    assert [entity.GetId() for entity in world.entities] == names
    assert world.get_state() == state
    assert difference(seen, run(world, 45, 2)) is None


def test_attachments_that_changed(world):
    first = world.get_state()
    seen = run(world, 45, 2)
    world.model("laser").Detach()
    run(world, 10, 3)
    world.set_state(first)
    assert difference(seen, run(world, 45, 2)) is None
    world.model("laser").Detach()
    box, two = world.model("box"), world.model("two")
    box.SetParent(two, two.GetBody())
    box.Attach()
    run(world, 20, 4)
    second = world.get_state()
    then = run(world, 45, 5)
    world.set_state(first)
    assert world.get_state() == first
    assert difference(seen, run(world, 45, 2)) is None
    world.set_state(second)
    assert world.get_state() == second
    assert difference(then, run(world, 45, 5)) is None
    with libgz.World.from_string(ROBOTS) as other:
        other.set_state(second)
        assert difference(then, run(other, 45, 5)) is None


def test_what_goes_is_closed_and_what_stays_is_the_same(world):
    one, ground = world.model("one"), world.model("ground")
    state = world.get_state()
    world.InsertModel(BALL.format("new", 0))
    new = world.body("new")
    world.set_state(state)
    assert world.model("one") is one
    with pytest.raises(ClosedError, match="closed"):
        new.GetPose()
    body = one.GetBody()
    world.DeleteModel("one")
    world.set_state(state)
    assert world.model("ground") is ground
    assert world.model("one") is not one
    with pytest.raises(ClosedError, match="closed"):
        body.GetPose()


def test_states_are_bytes_that_can_be_pickled_and_compared(world):
    state = world.get_state()
    assert isinstance(state, bytes)
    assert pickle.loads(pickle.dumps(state)) == state
    world.Step()
    assert world.get_state() != state


BODY_SETTERS = {
    "SetGravityMode": (False,),
    "SetFiniteRotationMode": (1,),
    "SetFiniteRotationAxis": (0.0, 1.0, 1.0),
    "SetForce": ((1.0, 2.0, 3.0),),
    "SetTorque": (0.1, 0.2, 0.3),
    "SetLinearVel": ((0.5, 0.0, 0.0),),
    "set_auto_disable": (True,),
    "set_damping": (0.1, 0.2),
    "set_kinematic": (True,),
}


@pytest.mark.parametrize("name", BODY_SETTERS)
def test_what_was_set_of_a_body_returns_in_a_world_without_it(world, name):
    before = world.get_state()
    getattr(world.body("box"), name)(*BODY_SETTERS[name])
    after = world.get_state()
    for state in (before, after):
        world.set_state(state)
        assert world.get_state() == state
    world.step(20)
    seen = world.engine.states.tobytes()
    world.set_state(after)
    world.step(20)
    assert world.engine.states.tobytes() == seen


def test_clients_stay_connected(wire):
    with libgz.World.from_string(ROBOTS, server_id=wire) as world, libgz.Client(wire, 0) as client:
        world.step(20)
        state = world.get_state()
        position, laser = client.position("one"), client.laser("laser")
        number, inode = position.data.head.model_id, os.fstat(position.descriptor).st_ino
        path = Path(client.path) / "position.one"
        for change in (delete_ground, insert, None):
            if change is None:
                world.Reset()
            else:
                world.set_state(state)
                change(world)
                world.step(3)
                world.set_state(state)
            assert path.stat().st_ino == inode
            assert not position.replaced
            assert position.data.head.model_id == number
            assert position.lock(1.0)
            position.unlock()
            position.command(vx=0.3)
            world.step(50)
            assert position.data.time == pytest.approx(world.GetSimTime(), abs=0.11)
            assert laser.data.time == pytest.approx(world.GetSimTime(), abs=0.11)
            assert position.data.pos[0] > 0.1
        world.set_state(state)
        world.DeleteModel("one")
        assert not path.exists()
        assert sorted(p.name for p in path.parent.glob(".*.new")) == []


def test_reset_is_a_fresh_load_and_the_button_returns_poses_only(wire):
    with libgz.World.from_string(ROBOTS, server_id=wire) as world:
        start = look(world)
        run(world, 60, 1)
        world.sim.data.reset = 1
        world.Step()
        assert world.GetSimTime() == pytest.approx(61 * 0.02)
        assert world.model("one").odometry.pose != [0, 0, 0]
        assert world.model("one").GetPose().pos.x == pytest.approx(0, abs=0.02)
        world.DeleteModel("two")
        world.InsertModel(BALL.format("new", 0))
        world.Reset()
        assert look(world) == start
        assert world.model("one").odometry.pose == [0, 0, 0]
        seen = run(world, 40, 2)
    with libgz.World.from_string(ROBOTS, server_id=wire) as fresh:
        assert difference(run(fresh, 40, 2), seen) is None


def test_reset_in_a_step_comes_after_it(world, monkeypatch):
    def update(step):
        times.append(world.GetSimTime())
        if len(times) == 2:
            world.Reset()
            with pytest.raises(GazeboError, match="its step is under way"):
                world.get_state()
            with pytest.raises(GazeboError, match="its step is under way"):
                world.set_state(b"")

    times = []
    world.Reset()
    monkeypatch.setattr(world.model("box"), "Update", update)
    world.step(4)
    assert times == pytest.approx([0, 0.02, 0, 0.02])


def test_clones_are_independent(world):
    run(world, 20, 1)
    world.InsertModel(BALL.format("new", 0))
    with world.clone() as clone:
        assert clone.server_id is None
        assert clone.get_state() == world.get_state()
        assert difference(run(world, 40, 2), run(clone, 40, 2)) is None
        clone.step(7)
        assert clone.GetSimTime() > world.GetSimTime()
        with clone.clone() as third:
            assert difference(run(clone, 20, 2), run(third, 20, 2)) is None


def test_paused_worlds_and_models_that_failed(world, tmp_path):
    plugin = tmp_path / "Fails.py"
    plugin.write_text(
        "from libgz import Body, BoxGeom, Model, GZ_REGISTER_PLUGIN\n"
        "class Fails(Model):\n"
        "    STATE = ('count',)\n"
        "    def Load(self, file, node):\n"
        "        self.AddBody(Body(self.world), True)\n"
        "        BoxGeom(self.GetBody(), self.modelSpaceId, 1, 1, 1).SetMass(1)\n"
        "        self.count = 0\n"
        "    def Update(self, step):\n"
        "        self.count += 1\n"
        "        if self.count == 10:\n"
        "            raise ValueError('ten')\n"
        "GZ_REGISTER_PLUGIN('Fails', Fails)\n"
    )
    (model,) = world.InsertModel(f"<model:Fails><plugin>{plugin}</plugin><xyz>5 5 1</xyz></model:Fails>")
    world.step(4)
    before = world.get_state()
    world.step(10)
    assert isinstance(model.error, ValueError)
    failed = world.get_state()
    world.paused = True
    world.step(3)
    paused = world.get_state()
    assert len({before, failed, paused}) == 3
    world.set_state(before)
    assert (model.error, model.count, world.paused) == (None, 4, False)
    world.step(10)
    assert (model.count, str(model.error)) == (10, "ten")
    assert world.get_state() == failed
    world.set_state(before)
    world.set_state(failed)
    assert "ValueError: ten" in str(model.error)
    world.step(3)
    assert model.count == 10
    world.set_state(paused)
    now = world.GetSimTime()
    world.step(2)
    assert (world.paused, world.GetSimTime()) == (True, now)
    assert world.get_state() != paused  # pause time grows


def test_random_numbers_continue(world):
    world.random.spawn(2)
    state = world.get_state()
    draws = [np.random.default_rng(child).random() for child in world.random.spawn(3)]
    world.set_state(state)
    assert [np.random.default_rng(child).random() for child in world.random.spawn(3)] == draws


def test_numbers_of_models_are_those_of_the_world(world):
    with libgz.World.from_string(ROBOTS) as other:
        assert [e.GetIntId() for e in world.entities] == [e.GetIntId() for e in other.entities] == [1, 2, 3, 4, 5, 6]


def test_what_does_not_fit_is_refused_with_a_reason(world):
    state = world.get_state()
    with (
        libgz.World.from_string(ROBOTS.replace("box", "crate")) as other,
        pytest.raises(StateError, match="its file has another text"),
    ):
        other.set_state(state)
    for damaged in (b"", b"libgz", state[:-20]):
        before = look(world)
        with pytest.raises(GazeboError):
            world.set_state(damaged)
        assert look(world) == before
    with pytest.raises(StateError, match="no state of this version"):
        world.set_state(b"something")
    world.close()
    with pytest.raises(ClosedError, match="the world is closed"):
        world.get_state()


def test_models_made_by_code_cannot_be_built_again(world):
    class Made(libgz.Model):
        STATE = ()

    made = Made(world)
    made.SetId("made")
    made.AddBody(libgz.Body(world), True)
    world.adopt(made)
    state = world.get_state()
    world.Step()
    world.set_state(state)
    assert world.model("made") is made
    world.DeleteModel("made")
    with pytest.raises(StateError, match="'made' cannot be built again: it was made by code"):
        world.set_state(state)


def test_models_without_a_declared_state_are_named_once(world, caplog, tmp_path):
    plugin = tmp_path / "Silent.py"
    plugin.write_text(
        "from libgz import Body, Model, GZ_REGISTER_PLUGIN\n"
        "class Silent(Model):\n"
        "    def Load(self, file, node):\n"
        "        self.AddBody(Body(self.world, dummy=True), True)\n"
        "GZ_REGISTER_PLUGIN('Silent', Silent)\n"
    )
    world.get_state()
    for _ in range(2):
        world.InsertModel(f"<model:Silent><plugin>{plugin}</plugin></model:Silent>")
    assert caplog.messages == []
    world.get_state()
    world.get_state()
    (message,) = caplog.messages
    assert message.startswith("model Silent declares no state")
    assert 'add STATE = ("name", ...)' in message


def test_a_state_that_is_not_plain_data_is_named(world):
    class Odd(libgz.Model):
        STATE = ("thing",)

    odd = Odd(world)
    odd.SetId("odd")
    odd.AddBody(libgz.Body(world), True)
    odd.thing = object()
    world.adopt(odd)
    with pytest.raises(ParameterError, match=r"'odd'.*Odd.*plain data"):
        world.get_state()


def test_rewind(world):
    with pytest.raises(StateError, match="call keep_rewind first"):
        world.rewind(1.0)
    world.keep_rewind(2.0, interval=0.2)
    run(world, 50, 1)
    moment = world.GetSimTime()
    state = world.get_state()
    seen = run(world, 30, 2)
    assert world.rewind(world.GetSimTime() - moment) == pytest.approx(moment, abs=0.021)
    world.set_state(state)
    assert difference(seen, run(world, 30, 2)) is None
    now = world.GetSimTime()
    assert now - 1.0 - 0.2 <= world.rewind(1.0) <= now - 1.0 + 1e-9
    world.step(200)
    with pytest.raises(StateError, match="before the oldest state that was kept"):
        world.rewind(3.0)
    assert world.rewind(1.9) == pytest.approx(world.GetSimTime())
    world.keep_rewind(10.0, interval=0.0, megabytes=len(state) * 5 / (1 << 20))
    world.step(20)
    world.rewind(0.06)
    with pytest.raises(StateError):
        world.rewind(0.2)
    world.keep_rewind(0.0)
    with pytest.raises(StateError):
        world.rewind(0.0)


def test_rewound_worlds_continue_to_the_bit(world):
    world.keep_rewind(5.0, interval=0.0)
    run(world, 40, 1)
    kept = world.get_state()
    seen = run(world, 40, 2)
    world.rewind(40 * world.engine.step_time)
    assert world.get_state() == kept
    assert difference(seen, run(world, 40, 2)) is None


def test_errors_in_a_models_own_code_name_the_model(world, tmp_path):
    plugin = tmp_path / "Wrong.py"
    plugin.write_text(
        "from libgz import Body, Model, GZ_REGISTER_PLUGIN\n"
        "class Wrong(Model):\n"
        "    STATE = ('later',)\n"
        "    def Load(self, file, node):\n"
        "        self.AddBody(Body(self.world, dummy=True), True)\n"
        "    def Update(self, step):\n"
        "        self.later = 1\n"
        "    def LoadState(self, state):\n"
        "        raise ValueError('no')\n"
        "    def SaveState(self):\n"
        "        return 1\n"
        "GZ_REGISTER_PLUGIN('Wrong', Wrong)\n"
    )
    text = f"<model:Wrong><id>w</id><plugin>{plugin}</plugin></model:Wrong>"
    with libgz.World.from_string(f"{HEAD}{text}</gz:world>") as wrong:  # it starts all the same
        with pytest.raises(PluginError, match=r"model 'w' \(Wrong\): its state cannot be saved"):
            wrong.Reset()
        wrong.Step()
        state = wrong.get_state()
        with pytest.raises(PluginError, match=r"model 'w' \(Wrong\): its state cannot be set"):
            wrong.set_state(state)


def test_the_time_of_day_of_a_sky():
    """A camera that comes before its sky in the file shows the restored one in its first image."""
    text = (
        "<gz:world xmlns:gz='g' xmlns:model='m'><model:SkyDome><id>sky</id><timeLapse>true</timeLapse></model:SkyDome>"
        "</gz:world>"
    )
    with libgz.World.from_string(text) as world:
        dome = world.model("sky").dome
        world.step(10)
        state, share = world.get_state(), dome.day_share
        world.step(1000)
        assert dome.day_share != share
        world.set_state(state)
        assert dome.day_share == share


def made(world, name, **values):
    """A model made by code, whose class declares these values; `loaded` counts calls of its LoadState."""

    class Made(libgz.Model):
        STATE = tuple(values)
        loaded = 0

        def SaveState(self):
            return None

        def LoadState(self, state):
            self.loaded += 1

    model = Made(world)
    vars(model).update(values)
    model.SetId(name)
    model.AddBody(libgz.Body(world, dummy=True), True)
    world.adopt(model)
    return model


@pytest.mark.parametrize(
    ("before", "after"), [(0.0, -0.0), (1, True), (True, 1.0), (2**70, 2.0**70), ("", b""), ((), []), ((0.0,), (-0.0,))]
)
def test_values_that_are_only_equal_are_distinguished(world, before, after):
    class Plain(libgz.Model):
        STATE = ("value", "last")

    model = Plain(world)
    model.value, model.last = before, 3
    model.AddBody(libgz.Body(world, dummy=True), True)
    world.adopt(model)
    state = world.get_state()
    model.value = after
    changed = world.get_state()
    assert changed != state
    world.set_state(state)
    assert repr(model.value) == repr(before)
    assert world.get_state() == state
    world.set_state(changed)
    assert repr(model.value) == repr(after)


def test_values_of_classes_that_alternate_reach_their_models(world):
    models = [made(world, f"m{i}", value=float(i)) if i % 3 else made(world, f"m{i}", other=i) for i in range(7)]
    state = world.get_state()
    for model in models:
        vars(model).update(value=-1.0, other=-1)
    world.set_state(state)
    assert [model.value if i % 3 else model.other for i, model in enumerate(models)] == list(range(7))


def test_load_state_is_called_though_the_state_is_the_present_one(world):
    model = made(world, "made", value=1)
    world.set_state(world.get_state())
    assert model.loaded == 1


def test_classes_that_declare_other_values_since_are_refused(world, tmp_path):
    plugin = tmp_path / "Changes.py"
    text = (
        "from libgz import Body, Model, GZ_REGISTER_PLUGIN\n"
        "class Changes(Model):\n"
        "    STATE = ('a', 'b')\n"
        "    a = b = 0\n"
        "    def Load(self, file, node):\n"
        "        self.AddBody(Body(self.world, dummy=True), True)\n"
        "GZ_REGISTER_PLUGIN('Changes', Changes)\n"
    )
    source = f"{HEAD}<model:Changes><id>c</id><plugin>{plugin}</plugin></model:Changes></gz:world>"
    states = []
    for declared in ("('a', 'b')", "('b', 'a')"):
        plugin.write_text(text.replace("('a', 'b')", declared))
        with libgz.World.from_string(source) as other:
            states.append(other.get_state())
            if len(states) > 1:
                with pytest.raises(StateError, match="their classes declare another STATE"):
                    other.set_state(states[0])


def test_a_body_that_was_added_before_the_one_that_holds_a_model(world):
    laser, one = world.model("laser"), world.model("one")
    state = world.get_state()
    one.bodies.insert(0, libgz.Body(world, dummy=True))
    assert one.bodies.index(laser.parentBody) == 1
    assert world.get_state() != state
    one.bodies.pop(0).close()
    assert world.get_state() == state


STRUCTS = [
    GzVector(1.0, -0.0, 3.0),
    GzQuatern(0.0, 1.0, 0.0, 0.0),
    GzColor(0.1, 0.2, 0.3, 0.4),
    GzPose(GzVector(1.0, 2.0, 3.0), GzQuatern(0.5, 0.5, 0.5, 0.5)),
    [GzVector(), (GzVector(1.0, 2.0, 3.0), {"at": GzPose()})],
    ("\0GzVector", 1.0, 2.0),  # what a state has of a vector begins like this
    ("\0tuple",),
    deque([GzVector(1.0, 2.0, 3.0)], maxlen=2),
]


def test_vectors_return_in_place_of_anything(world):
    model = made(world, "made", value=None)
    for value in STRUCTS:
        model.value = value
        state = world.get_state()
        for before in (None, 0, [], (), {}, GzVector(), "text"):
            model.value = before
            world.set_state(state)
            assert (type(model.value), repr(model.value)) == (type(value), repr(value))
            assert world.get_state() == state


def test_a_state_that_is_set_again_keeps_nothing_of_what_was_changed_meanwhile(world, monkeypatch):
    model = made(world, "made", value=None)
    monkeypatch.setattr(type(model), "__module__", "libgz.models.made")  # as if no code of users had a part in it
    values = [[1.0], {1.0}, np.ones(1), {"a": [1.0]}, GzVector(1.0, 2.0, 3.0)]
    model.value = list(values)
    state, kept = world.get_state(), repr(values)
    for _ in range(3):
        model.value = None
        world.set_state(state)
        assert repr(model.value) == kept
        numbers, unique, array, table, vector = model.value
        numbers.append(2.0)
        unique.add(2.0)
        array[0] = vector.x = 2.0
        table["a"].clear()


def test_arrays_of_every_size_return_as_they_were(world):
    shapes = [((), "f8"), ((0, 3), "i4"), ((5,), "?"), ((160, 80, 3), "u1"), ((300, 4), "c16"), ((5000,), ">f4")]
    shapes += [((40, 60, 3), "u1"), ((700,), "U3")]
    arrays = [np.arange(np.prod(shape, dtype=int)).reshape(shape).astype(kind) for shape, kind in shapes]
    arrays += [arrays[3][::2], np.asfortranarray(arrays[4])]
    models = [made(world, f"m{i}", value=array) for i, array in enumerate(arrays)]
    state = world.get_state()
    for model in models:
        vars(model).update(value=None)
    world.set_state(state)
    for model, array in zip(models, arrays, strict=True):
        assert model.value.dtype == array.dtype
        assert np.array_equal(model.value, array)
        model.value[...] = 0  # it can be written
    assert world.get_state() != state


def test_a_truncated_state_is_refused_wherever_it_ends(world):
    made(world, "made", value=np.zeros(10_000))
    state = world.get_state()
    before = world.get_state()
    for end in [*range(0, 200, 7), *range(200, len(state), len(state) // 50)]:
        with pytest.raises(StateError):
            world.set_state(state[:end])
    with pytest.raises(StateError):
        world.set_state(state + b"more")
    assert world.get_state() == before


def test_a_state_of_an_older_version_is_refused_with_its_version(world):
    state = world.get_state()
    with pytest.raises(StateError, match="this state has format 8; this version of libgz has format 9"):
        world.set_state(state.replace(b"libgz state 9\n", b"libgz state 8\n"))


def test_what_is_assigned_to_parts_is_in_the_next_state(world):
    body = world.model("box").GetBody()
    geom = body.geoms[0]
    for thing, name, value in (
        (body, "in_wind", True),
        (body, "diverged", True),
        (geom, "scale", (2.0, 1.0, 1.0)),
        (geom.appearance, "visible", False),
        (geom.appearance, "retro", 0.5),
    ):
        state, before = world.get_state(), getattr(thing, name)
        assert world.get_state() == state
        setattr(thing, name, value)
        assert world.get_state() != state, name
        world.set_state(state)
        assert getattr(thing, name) == before
        assert world.get_state() == state


def test_to_set_the_seed_begins_new_random_numbers():
    """A state has the seed: a generator that is made after it must be the same with and without it."""
    with libgz.World.from_string(f"{HEAD}</gz:world>") as world:
        world.random.spawn(1)
        world.seed = 5
        state = world.get_state()
        first = world.random.spawn(1)[0].generate_state(2).tolist()
        world.set_state(state)
        assert world.random.spawn(1)[0].generate_state(2).tolist() == first
        with pytest.raises(ParameterError, match="seed is -1"):
            world.seed = -1
    with libgz.World() as other:
        other.seed = 5
        assert other.engine.seed == 5


def test_to_look_at_a_world_does_not_change_its_state():
    with libgz.World.from_string(f"{HEAD}</gz:world>") as world:
        state = world.get_state()
        names = [name for name in dir(type(world)) if isinstance(getattr(type(world), name), property)]
        assert "sdf" in names
        for name in names:
            getattr(world, name)
        assert world.get_state() == state
        with world.clone() as clone:
            assert clone.get_state() == state


def test_rays_that_a_model_fixed_to_its_parent_end_with_it():
    sonars = "<model:Pioneer2Sonars><id>sonars</id></model:Pioneer2Sonars>"
    robot = f"<model:Pioneer2DX><id>robot</id><xyz>0 0 0.24</xyz>{sonars}</model:Pioneer2DX>"
    with libgz.World.from_string(f"{HEAD}{robot}</gz:world>") as world:
        bundles = len(world.engine.ray_bundles)
        state = world.get_state()
        rays = world.model("sonars").sonars.rays
        world.DeleteModel("sonars")
        assert rays not in world.engine.ray_bundles
        assert len(world.engine.ray_bundles) == bundles - 1
        world.set_state(state)
        assert len(world.engine.ray_bundles) == bundles
        assert world.get_state() == state


class Jointed(SimpleSolid):
    """A model that makes a joint in Load and one in Init, and attaches neither."""

    STATE = ()

    def Load(self, file, node):
        super().Load(file, node)
        self.made = [HingeJoint(self.world, name="loaded")]

    def Init(self, file, node):
        super().Init(file, node)
        self.made.append(HingeJoint(self.world, name="started"))


def test_detached_joints_of_a_model_end_with_it():
    with libgz.World.from_string(f"{HEAD}</gz:world>") as world:
        world.extension(LegacyWorld).factory.RegisterModel("Jointed", "Jointed", Jointed)
        world.InsertModel("<model:Jointed><id>one</id></model:Jointed>")
        later = HingeJoint(world, name="later")
        made = world.model("one").made
        world.DeleteModel("one")
        assert [joint.closed for joint in made] == [True, True]
        assert list(world.engine.joints.values()) == [later]


def test_a_model_with_detached_joints_comes_back_to_the_bit():
    with libgz.World.from_string(f"{HEAD}</gz:world>") as world:
        world.extension(LegacyWorld).factory.RegisterModel("Jointed", "Jointed", Jointed)
        start = world.get_state()
        world.InsertModel("<model:Jointed><id>one</id></model:Jointed>")
        world.step(3)
        state = world.get_state()
        for leave in (lambda: world.DeleteModel("one"), world.reset):
            leave()
            assert not world.engine.joints
            world.set_state(state)
            assert [joint.name for joint in world.engine.joints.values()] == ["loaded", "started"]
            assert world.get_state() == state
        world.reset()
        assert world.get_state() == start
