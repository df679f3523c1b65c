"""Models that join a running world and leave it, by call and through a factory's letter-box."""

import gc

import pytest

import libgz
from libgz.interfaces.position import Position

HEAD = "<gz:world xmlns:gz='g' xmlns:model='m'>"
GROUND = "<model:GroundPlane/>"
ROBOT = "<model:Pioneer2AT><id>{0}</id><xyz>{1} 0 0</xyz>{2}</model:Pioneer2AT>"
FACTORY = "<model:Factory><id>f</id></model:Factory>"


@pytest.fixture
def world():
    with libgz.World.from_string(f"{HEAD}{GROUND}{FACTORY}{ROBOT.format('r', 0, '')}</gz:world>") as running:
        running.step(5)
        yield running


def census(world):
    """Everything there is in a world."""
    engine = world.engine
    return (
        [model.GetId() for model in world.models],
        sorted(world.gz_server.interfaces),
        len(engine.bodies),
        len(engine.joints),
        len(engine.geoms),
        len(engine.spaces),
    )


# By call ---------------------------------------------------------------------------------------------------------


def test_a_model_is_inserted_and_takes_part(world):
    (robot,) = world.InsertModel(ROBOT.format("r2", 3, ""))
    assert robot is world.model("r2")
    world.interface("position", "r2").command(vx=0.3)
    world.step(200)
    assert robot.GetPose().pos.x == pytest.approx(3 + 0.3 * 4, abs=0.15)
    assert world.interface("power", "r2").data.levels[0] < 12.4


def test_inserted_models_bring_their_children(world):
    laser = "<model:SickLMS200><id>l2</id><xyz>0.1 0 0.3</xyz></model:SickLMS200>"
    added = world.InsertModel(ROBOT.format("r2", 3, laser))
    assert [model.GetId() for model in added[:1]] == ["r2"]
    world.step(20)
    assert len(world.interface("laser", "l2").ranges) == 181


def test_a_deleted_model_leaves_nothing_behind(world):
    before = census(world)
    laser = "<model:SickLMS200><id>l2</id><xyz>0.1 0 0.3</xyz></model:SickLMS200>"
    for _ in range(3):
        world.InsertModel(ROBOT.format("r2", 3, laser))
        world.step(10)
        world.DeleteModel("r2")
        world.step(10)
        assert census(world) == before
    assert world.model("r").failed is None


def test_a_child_is_deleted_without_its_parent(world):
    laser = "<model:SickLMS200><id>l2</id><xyz>0.1 0 0.3</xyz></model:SickLMS200>"
    world.InsertModel(ROBOT.format("r2", 3, laser))
    world.DeleteModel("l2")
    assert world.model("r2").children == []
    world.step(10)
    assert ("laser", "l2") not in world.gz_server.interfaces
    world.ResetModelPoses()


def test_the_others_do_not_notice_a_deletion():
    text = f"{HEAD}{GROUND}{{}}{ROBOT.format('r', 0, '')}</gz:world>"
    ends = []
    for extra in ("", ROBOT.format("x", 50, "")):
        with libgz.World.from_string(text.format(extra)) as world:
            world.interface("position", "r").command(vx=0.3, vyaw=0.2)
            world.step(50)
            if extra:
                world.DeleteModel("x")
            world.step(100)
            ends.append(tuple(world.model("r").GetPose().pos))
    assert ends[0] == pytest.approx(ends[1], abs=1e-9)


def test_deletion_during_a_step_happens_after_it(world):
    seen = []

    class Assassin(libgz.Model):
        def Load(self, file, node):
            self.AddBody(libgz.Body(self.world, dummy=True), True)

        def Update(self, step):
            self.world.DeleteModel("r")
            self.world.DeleteModel(self)
            seen.append(self.world.model("r").GetPose().pos.z)
            with pytest.raises(libgz.GazeboError, match=r"use World\.after_step"):
                self.world.InsertModel(GROUND)

    world.factory.RegisterModel("test", "Assassin", Assassin)
    world.InsertModel("<model:Assassin/>")
    world.step(3)
    assert len(seen) == 1
    assert census(world)[0] == ["GroundPlane", "f"]


def test_an_unknown_model_is_not_deleted(world):
    with pytest.raises(libgz.NotFoundError, match=r"no model 'rr'.*did you mean 'r'"):
        world.DeleteModel("rr")


def test_a_model_may_delete_itself_twice(world):
    robot = world.model("r")
    world.DeleteModel(robot)
    world.DeleteModel(robot)
    world.step(2)


BAD = {
    "not well-formed": ("<model:Pioneer2AT><id>x</id>", "mismatch|end tag|EndTag"),
    "no model": ("<id>x</id>", "no <model:...> element|is not used"),
    "nothing": ("", "no <model:...> element"),
    "unknown": ("<model:Pionier2AT/>", "unknown model class.*did you mean 'Pioneer2AT'"),
    "a bad number": ("<model:SimpleSolid><mass>-1</mass></model:SimpleSolid>", "mass .kg. must be above 0"),
    "not a number": ("<model:SimpleSolid><xyz>nan 0 0</xyz></model:SimpleSolid>", "'nan' is not allowed"),
    "infinite": ("<model:SimpleSolid><xyz>inf 0 0</xyz></model:SimpleSolid>", "infinite numbers are not allowed"),
    "a bad child": (
        ROBOT.format("x", 3, "<model:SimpleSolid><size>-1 0 0</size></model:SimpleSolid>"),
        "size .m. must be above 0 each",
    ),
    "a missing plugin": ("<model:Ghost><plugin>Ghost.so</plugin></model:Ghost>", "Ghost"),
    "a later format": ("<sdf version='1.6' xmlns:model='m'/>", "SDF world"),
    "deep": ("<model:SimpleSolid>" + "<a>" * 600, "depth|Excessive"),
    "far": ("<model:SimpleSolid><xyz>1e300 0 0</xyz></model:SimpleSolid>", "numbers above 1e.30"),
    "large": ("<model:SimpleSolid><size>1e200 1 1</size></model:SimpleSolid>", "at most 1e.30"),
    "heavy": ("<model:SimpleSolid><mass>1e300</mass></model:SimpleSolid>", "mass must be finite, and at most 1e.30"),
}


@pytest.mark.parametrize("name", BAD)
def test_of_a_bad_text_nothing_stays(world, name):
    text, message = BAD[name]
    before = census(world)
    with pytest.raises(libgz.GazeboError, match=message):
        world.InsertModel(text)
    assert census(world) == before
    world.step(5)


def test_of_a_failed_init_nothing_stays(world):
    class Half(libgz.Model):
        def Load(self, file, node):
            self.AddBody(libgz.Body(self.world, dummy=True), True)

        def Init(self, file, node):
            self.position = Position()
            self.position.create(self.world.gz_server, self.GetId(), "Half", self.GetIntId())
            raise ValueError("half-way")

    world.factory.RegisterModel("test", "Half", Half)
    before = census(world)
    with pytest.raises(libgz.PluginError, match="half-way"):
        world.InsertModel("<model:Half><id>h</id></model:Half>")
    assert census(world) == before
    gc.collect()
    world.step(5)


# Through the letter-box ------------------------------------------------------------------------------------------


def test_a_client_adds_and_removes_a_model(world):
    box = world.interface("factory", "f")
    box.create_model(ROBOT.format("r2", 3, ""))
    assert box.busy
    world.step(3)
    assert not box.busy
    assert world.interface("position", "r2").data.head.model_type == b"Pioneer2AT"
    box.delete_model("r2")
    world.step(3)
    assert [model.GetId() for model in world.models] == ["GroundPlane", "f", "r"]


@pytest.mark.parametrize(
    "text",
    [
        "<model:SimpleSolid><id>s</id></model:SimpleSolid>",
        "\n <model:SimpleSolid><id>s</id></model:SimpleSolid>\n",
        "<?xml version='1.0'?><model:SimpleSolid><id>s</id></model:SimpleSolid>",
        f"<?xml version='1.0'?>{HEAD}<model:SimpleSolid><id>s</id></model:SimpleSolid></gz:world>",
        "<model:SimpleSolid xmlns:model='m'><id>s</id></model:SimpleSolid>",
    ],
)
def test_texts_with_and_without_a_root_are_taken(world, text):
    world.interface("factory", "f").create_model(text)
    world.step(3)
    assert world.model("s")


def test_a_paused_world_takes_models_too(world):
    world.sim.data.pause = 1
    world.interface("factory", "f").create_model("<model:SimpleSolid><id>s</id></model:SimpleSolid>")
    world.step(3)
    assert world.model("s")


def test_models_of_a_factory_are_not_saved(tmp_path):
    path = tmp_path / "w.world"
    path.write_text(f"{HEAD}{FACTORY}</gz:world>")
    with libgz.World.from_file(path) as world:
        world.InsertModel("<model:SimpleSolid><id>s</id></model:SimpleSolid>")
        assert world.Save() == 0
    assert "SimpleSolid" not in path.read_text()


@pytest.mark.parametrize("name", BAD)
def test_a_bad_text_is_one_warning(world, caplog, name):
    text, _ = BAD[name]
    before = census(world)
    world.interface("factory", "f").create_model(text or " ")
    world.step(5)
    told = [record for record in caplog.records if "request failed" in record.getMessage()]
    assert [record.levelname for record in told] == ["WARNING"]
    assert census(world) == before


def test_hostile_letters_are_survived(world, caplog):
    box = world.interface("factory", "f")
    before = census(world)
    for content in (
        b"x" * 4096,
        b"\xff" * 100 + b"\0",
        b"<" * 4095 + b"\0",
        b"<delete></delete>\0",
        b"<delete>..</delete>\0",
    ):
        box.string[: len(content)] = list(content)
        world.step(5)
        assert not box.busy
    assert caplog.text.count("request failed") == 5
    assert "no terminating zero within 4096 bytes" in caplog.text
    assert census(world) == before


def test_huge_and_tiny_models_do_not_end_the_world(world):
    for text in (
        "<model:SimpleSolid><xyz>9e7 0 0</xyz></model:SimpleSolid>",
        "<model:SimpleSolid><xyz>0 0 9</xyz><size>1e7 1e7 1e7</size></model:SimpleSolid>",
        "<model:SimpleSolid><xyz>0 0 5</xyz><mass>9e8</mass></model:SimpleSolid>",
        "<model:SimpleSolid><xyz>0 0 3</xyz><mass>1e-300</mass></model:SimpleSolid>",
    ):
        count = len(world.models)
        world.interface("factory", "f").create_model(text)
        world.step(50)
        assert len(world.models) == count + 1


def test_half_a_letter_is_not_taken(world, caplog):
    box = world.interface("factory", "f")
    text = b"<model:SimpleSolid><id>s</id></model:SimpleSolid>\0"
    box.string[:20] = list(text[:20])
    world.step(1)
    box.string[20 : len(text)] = list(text[20:])
    world.step(3)
    assert world.model("s")
    assert "request failed" not in caplog.text


def test_over_the_wire(gazebo, tmp_path):
    path = tmp_path / "w.world"
    path.write_text(f"{HEAD}{GROUND}{FACTORY}</gz:world>")
    server = gazebo(path, "--rate", "10")
    with libgz.Client(server.id) as client:
        box = client.factory("f")
        for turn in range(2):
            box.create_model(ROBOT.format("new", turn, ""))
            for _ in range(100):
                if ("position", "new") in client.interfaces():
                    break
                assert client.wait(timeout=5.0)
            robot = client.position("new")
            robot.command(vx=0.2)
            before = robot.time
            for _ in range(30):
                assert client.wait(timeout=5.0)
            assert robot.time > before
            robot.close()
            box.delete_model("new")
            for _ in range(100):
                if ("position", "new") not in client.interfaces():
                    break
                assert client.wait(timeout=5.0)
            assert ("position", "new") not in client.interfaces()
    assert server.stop()[0] == 0


def test_failed_requests_do_not_fill_the_log(world, caplog):
    factory = world.model("f")
    for _ in range(250):
        factory.obey(b"no XML\0")
    assert [message.partition("failed: ")[2] for message in caplog.messages] == [
        "the text is not XML: it does not begin with '<'",
        "the text is not XML: it does not begin with '<' (100 times so far)",
    ]
    caplog.clear()
    for number in range(250):
        factory.obey(f"<delete>nobody{number}</delete>\0".encode())
    assert len(caplog.messages) == 21  # 19 names, and the first and hundredth of the others
    assert caplog.messages[-1].endswith("(100 times so far)")
