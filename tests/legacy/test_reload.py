"""Models of worldfiles whose plugin is edited while the world runs."""

import textwrap

import pytest

import libgz
from libgz.base.errors import NotFoundError, PluginError

PLUGIN = """
import libgz

class Cart(libgz.Model):
    STATE = ("driven",)
    def Load(self, file, node):
        body = libgz.Body(self.world)
        libgz.BoxGeom(body, self.modelSpaceId, {size}, 0.2, 0.2).SetMass(2.0)
        self.AddBody(body, True)
        self.driven = 0.0
        {load}
    def Init(self, file, node):
        self.position = libgz.Position()
        self.position.create(self.world.gz_server, self.GetId(), "Cart", self.GetIntId())
        {init}
    def Update(self, step):
        self.driven += step * {speed}
        if self.position.lock():
            self.position.data.pos[0] = self.driven
            self.position.unlock()
    def Fini(self):
        self.position.destroy()

libgz.GZ_REGISTER_PLUGIN("Cart", Cart)
"""
WORLD = """<gz:world xmlns:gz='g' xmlns:model='m'>
<model:GroundPlane><id>ground</id></model:GroundPlane>
<model:Cart><id>cart1</id><xyz>0 0 0.1</xyz><plugin>cart.py</plugin>
  <model:TruthWidget><id>truth1</id><xyz>0 0 0.2</xyz></model:TruthWidget>
  <model:SimpleSolid><id>box1</id><xyz>0 0 0.2</xyz><shape>box</shape><size>0.1 0.1 0.1</size></model:SimpleSolid>
</model:Cart>
<model:Cart><id>cart2</id><xyz>3 0 0.1</xyz></model:Cart>
</gz:world>"""


def write(folder, *, size=0.4, speed=1.0, load="pass", init="pass"):
    (folder / "cart.py").write_text(textwrap.dedent(PLUGIN).format(size=size, speed=speed, load=load, init=init))


@pytest.fixture
def world(tmp_path):
    write(tmp_path)
    (tmp_path / "w.world").write_text(WORLD)
    with libgz.World.from_file(tmp_path / "w.world") as made:
        made.step(10)
        made.SetModelPose(made.model("cart1"), libgz.GzPose(libgz.GzVector(7.0, 1.0, 0.1)))
        made.model("cart1").GetBody().SetLinearVel((0.5, 0.0, 0.0))
        yield made


@pytest.mark.parametrize("name", ["cart1", "Cart", "cart.py", "cart"])
def test_models_are_built_again_in_place(world, tmp_path, name):
    order = [model.GetId() for model in world.models]
    old, data = world.model("cart1"), world.interface("position", "cart1").data
    step = world.engine.step_time
    write(tmp_path, speed=100.0)
    assert world.reload_plugin(name) == ["model cart1 (Cart)", "model cart2 (Cart)"]
    new = world.model("cart1")
    assert new is not old
    assert [model.GetId() for model in world.models] == order
    assert (new.GetPose().pos.x, new.GetPose().pos.y) == (7.0, 1.0)
    assert new.GetBody().GetLinearVel().x == 0.5
    assert world.model("truth1").parent is new
    world.step()
    assert new.driven == pytest.approx(10 * step + 100 * step)
    assert data.pos[0] == new.driven  # the memory that clients have mapped
    assert world.interface("position", "cart1").data.head.model_id == new.GetIntId()
    assert len(world.model("box1").GetBody().joints) == 1
    world.step(20)
    for name in ("truth1", "box1"):
        at, cart = world.model(name).GetPose().pos, new.GetPose().pos
        assert (at.x - cart.x, at.y - cart.y, at.z - cart.z) == pytest.approx((0.0, 0.0, 0.2), abs=0.01)


@pytest.mark.parametrize(
    ("edit", "words"),
    [
        ({"load": "1 / 0"}, ['cart.py", line 11, in Load', "ZeroDivisionError", "w.world:3: <model:Cart>"]),
        ({"init": "1 / 0"}, ["line 15, in Init", "ZeroDivisionError"]),
        ({"load": "return -1"}, ["returned -1"]),
        ({"speed": "("}, ["cart.py", "SyntaxError"]),
    ],
)
def test_an_edit_that_fails_keeps_the_model(world, tmp_path, edit, words):
    old, bodies = world.model("cart1"), len(world.engine.bodies)
    step = world.engine.step_time
    write(tmp_path, **edit)
    with pytest.raises(PluginError) as raised:
        world.reload_plugin("cart1")
    assert all(word in str(raised.value) for word in words), raised.value
    assert world.model("cart1") is old
    assert world.model("truth1").parent is old
    assert len(world.engine.bodies) == bodies
    world.step()
    assert world.interface("position", "cart1").data.pos[0] == pytest.approx(11 * step)
    assert world.interface("position", "cart1").data.head.model_id == old.GetIntId()
    write(tmp_path)
    assert len(world.reload_plugin("cart1")) == 2


def test_another_shape_and_a_reset(world, tmp_path):
    world.keep_rewind(1.0)
    write(tmp_path, size=1.5, load="second = libgz.Body(self.world, 'second'); self.AddBody(second)")
    world.reload_plugin("cart1")
    assert world.model("cart1").GetPose().pos.x == 7.0
    world.step(5)
    world.Reset()
    cart = world.model("cart1")
    assert (cart.GetPose().pos.x, cart.driven, len(cart.bodies), world.GetSimTime()) == (0.0, 0.0, 2, 0.0)
    world.step(5)
    state = world.get_state()
    world.step()
    world.set_state(state)


def test_a_class_that_is_not_there_any_more(world, tmp_path):
    write(tmp_path)
    path = tmp_path / "cart.py"
    path.write_text(path.read_text().replace('PLUGIN("Cart"', 'PLUGIN("Wagon"'))
    with pytest.raises(PluginError, match="does not register 'Cart' any more; it has Wagon"):
        world.reload_plugin("cart1")


def test_built_in_models_have_no_plugin(world):
    with pytest.raises(NotFoundError, match="it has cart1, cart2"):
        world.reload_plugin("ground")


def test_a_model_that_has_failed_runs_again(world, tmp_path):
    write(tmp_path, speed="'a'")
    world.reload_plugin("cart1")
    world.step()
    assert world.model("cart1").error is not None
    write(tmp_path)
    world.reload_plugin("cart1")
    world.step()
    assert world.model("cart1").error is None
    assert world.model("cart1").driven > 0.0
