"""Models that fail while a state is taken or set: the world stays whole, and says why."""

import pytest

import libgz
from libgz.base.errors import GazeboError

CODE = """
from libgz import Body, Model, SphereGeom, GZ_REGISTER_PLUGIN
class Odd(Model):
    STATE = ("count",)
    calls, where, what = [], "", None
    def reached(self, place):
        Odd.calls.append(place)
        if place == Odd.where:
            Odd.what()
    def __init__(self, *values):
        super().__init__(*values)
        self.count = 0
        self.reached("constructor")
    def Load(self, file, node):
        self.AddBody(Body(self.world), True)
        SphereGeom(self.GetBody(), self.modelSpaceId, 0.2).SetMass(1.0)
        self.reached("Load")
    def Init(self, file, node):
        self.reached("Init")
    def Update(self, step):
        self.count += 1
        self.reached("Update")
    def Fini(self):
        self.reached("Fini")
    def SaveState(self):
        self.reached("SaveState")
        return self.count
    def LoadState(self, state):
        self.reached("LoadState")
GZ_REGISTER_PLUGIN("Odd", Odd)
"""
HEAD = "<gz:world xmlns:gz='g' xmlns:model='m'><model:GroundPlane><id>ground</id></model:GroundPlane>"
SOLID = "<model:SimpleSolid><id>{0}</id><xyz>{1} 1 1</xyz></model:SimpleSolid>"


class Unforeseen(BaseException):
    """What a model may raise that is no Exception, like CancelledError of asyncio."""


def raises(error):
    def function():
        raise error

    return function


@pytest.fixture
def world(tmp_path):
    (tmp_path / "Odd.py").write_text(CODE)
    model = f"<model:Odd><id>odd</id><xyz>0 0 1</xyz><plugin>{tmp_path / 'Odd.py'}</plugin></model:Odd>"
    with libgz.World.from_string(
        f"{HEAD}{SOLID.format('first', 1)}{model}{SOLID.format('last', 2)}</gz:world>"
    ) as world:
        world.step(5)
        yield world
        kind = type(world.model("odd"))
        kind.where = ""


ERRORS = [ValueError("odd"), SystemExit(5), KeyboardInterrupt(), GazeboError("odd"), Unforeseen("odd")]


@pytest.mark.parametrize("error", ERRORS, ids=lambda error: type(error).__name__)
@pytest.mark.parametrize("where", ["SaveState", "LoadState"])
def test_what_these_raise_is_an_error_and_changes_nothing(world, where, error):
    kind = type(world.model("odd"))
    state = world.get_state()
    world.step(5)
    later = world.get_state()
    for _ in range(2):  # the second time, this is a state that could be set
        kind.where, kind.what = where, raises(error)
        with pytest.raises(GazeboError, match="odd"):
            world.get_state() if where == "SaveState" else world.set_state(state)
        kind.where = ""
        assert world.get_state() == later
        world.set_state(state)
        assert world.get_state() == state
        world.step(5)
        assert world.get_state() == later


@pytest.mark.parametrize("error", ERRORS[::2], ids=lambda error: type(error).__name__)
@pytest.mark.parametrize("where", ["constructor", "Load", "Init"])
def test_a_model_that_cannot_be_built_again_refuses_the_state(world, where, error):
    kind = type(world.model("odd"))
    state = world.get_state()
    for _ in range(2):
        world.DeleteModel("odd")
        world.step(5)
        later = world.get_state()
        kind.where, kind.what = where, raises(error)
        with pytest.raises(GazeboError):
            world.set_state(state)
        kind.where = ""
        assert world.get_state() == later
        world.set_state(state)
        assert world.get_state() == state


@pytest.mark.parametrize("where", ["constructor", "Load", "Init", "Update", "Fini", "SaveState", "LoadState"])
@pytest.mark.parametrize("call", ["get_state", "set_state", "clone", "close"])
def test_calls_within_callbacks_are_errors(world, where, call):
    kind = type(world.model("odd"))
    world.keep_rewind(1.0, 0.0)
    state = world.get_state()
    world.step(5)
    later, refused = world.get_state(), []
    values = {"set_state": (state,), "rewind": (0.01,), "keep_rewind": (1.0,), "reseed": (3,)}

    def attack():
        kind.where = ""
        with pytest.raises(GazeboError, match=r"in a callback|while plugins load"):
            getattr(world, call)(*values.get(call, ()))
        refused.append(call)

    kind.where, kind.what = where, attack
    if where == "Update":
        world.Step()
    elif where == "SaveState":
        world.get_state()
    else:
        world.set_state(state)
        world.DeleteModel("odd")
        world.set_state(state)
    assert refused
    kind.where = ""
    world.set_state(state)
    world.step(5)
    assert world.get_state() == later
