"""Finding, loading and failing plugins."""

import logging
import math
import re
import textwrap

import pytest

import libgz
from libgz.base.errors import PluginError, WorldFileError
from libgz.clib.prefixes import installed_prefixes, note_prefix
from libgz.legacy.plugin_search import find_plugin

WORLD = """<gz:world xmlns:gz='g' xmlns:model='m'>
<model:{model}><id>m1</id><plugin>{plugin}</plugin></model:{model}>
</gz:world>"""

PLUGIN = """
    from libgz import *
    import libgz
    class {name}(libgz.Model):
        def Load(self, file, node):
            self.AddBody(libgz.Body(self.world, dummy=True), True)
            {load}
        def Init(self, file, node):
            {init}
        def Update(self, step):
            {update}
    libgz.GZ_REGISTER_PLUGIN("{name}", {name})
"""


def write(folder, name, *, load="pass", init="pass", update="pass", file=None):
    path = folder / f"{file or name}.py"
    text = textwrap.dedent(PLUGIN).replace("from libgz import *\n", "")
    path.write_text(text.format(name=name, load=load, init=init, update=update))
    return path


def run(folder, model, plugin, **options):
    path = folder / "w.world"
    path.write_text(WORLD.format(model=model, plugin=plugin))
    return libgz.World.from_file(path, **options)


@pytest.fixture(autouse=True)
def no_gazebopath(monkeypatch):
    monkeypatch.delenv("GAZEBOPATH", raising=False)


def test_search_order(tmp_path, monkeypatch):
    first, second, home = (tmp_path / name for name in ("first", "second", "home"))
    for folder in (first, second, home):
        folder.mkdir()
    world = str(home / "w.world")
    write(home, "Thing")
    assert find_plugin("Thing.so", world) == home / "Thing.py"
    write(second, "Thing")
    monkeypatch.setenv("GAZEBOPATH", f"{first}:{second}")
    assert find_plugin("Thing.so", world) == second / "Thing.py"
    write(first, "Thing")
    assert find_plugin("libThing.so", world) == first / "Thing.py"
    assert find_plugin(str(home / "Thing.so"), world) == home / "Thing.py"
    monkeypatch.setenv("HOME", str(home))
    assert find_plugin("~/Thing.so", world) == home / "Thing.py"


def test_packages_and_other_cases_are_found(tmp_path):
    (tmp_path / "Robot").mkdir()
    (tmp_path / "Robot" / "__init__.py").write_text("")
    write(tmp_path, "Immovable", file="ImmovableObject")
    world = str(tmp_path / "w.world")
    assert find_plugin("Robot.so", world) == tmp_path / "Robot" / "__init__.py"
    assert find_plugin("immovableObject.so", world) == tmp_path / "ImmovableObject.py"


def test_a_miss_lists_every_place(tmp_path, monkeypatch):
    monkeypatch.setenv("GAZEBOPATH", "/no/such/place")
    (tmp_path / "gone.so").write_bytes(b"\x7fELF")
    with pytest.raises(WorldFileError) as caught:
        run(tmp_path, "Gone", "gone.so")
    text = str(caught.value)
    assert "w.world:2: <model:Gone>: plugin 'gone.so' was not found; tried" in text
    assert "/no/such/place/ (GAZEBOPATH): there is no such directory" in text
    assert (
        "gone.so (the worldfile's directory): this file is no C++ plugin of libgz, so build its source with "
        "`libgz cxx build`, or port it to Python as gone.py" in text
    )
    assert "gazebo/plugins/ (the installed plugins)" in text
    assert "(the installed models): has no gone.py" in text


def test_two_files_may_define_one_class_name(tmp_path):
    red = write(tmp_path, "HMT", file="red")
    blue = write(tmp_path, "HMT", file="blue")
    red.write_text(red.read_text().replace('PLUGIN("HMT"', 'PLUGIN("HMT_RED"'))
    blue.write_text(blue.read_text().replace('PLUGIN("HMT"', 'PLUGIN("HMT_BLUE"'))
    path = tmp_path / "w.world"
    path.write_text(
        "<gz:world xmlns:gz='g' xmlns:model='m'><model:HMT_RED><plugin>red.so</plugin></model:HMT_RED>"
        "<model:HMT_BLUE><plugin>blue.so</plugin></model:HMT_BLUE></gz:world>"
    )
    with libgz.World.from_file(path) as world:
        one, two = world.models
        assert type(one) is not type(two)
        assert (one.GetId(), two.GetName()) == ("HMT_RED", "HMT_BLUE")


def test_loading_twice_is_once(tmp_path):
    path = write(tmp_path, "Once")
    path.write_text(path.read_text() + "\nimport builtins\nbuiltins.counted = getattr(builtins, 'counted', 0) + 1\n")
    run(tmp_path, "Once", "Once.so").close()
    run(tmp_path, "Once", "Once.so").close()
    import builtins

    assert builtins.counted == 1


def test_a_plugin_may_import_its_neighbours(tmp_path):
    (tmp_path / "neighbour_of_a_plugin.py").write_text("VALUE = 42\n")
    write(tmp_path, "Social", load="import neighbour_of_a_plugin as n; self.value = n.VALUE")
    with run(tmp_path, "Social", "Social.so") as world:
        assert world.model("m1").value == 42


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("x = = 1", "SyntaxError"),
        ("import nothing_of_this_name", "No module named 'nothing_of_this_name'"),
        ("x = 1", "registers nothing"),
        ("def gazebo_plugin_init(): return 5", "returned 5"),
    ],
)
def test_bad_plugin_files(tmp_path, source, message):
    (tmp_path / "Bad.py").write_text(source)
    with pytest.raises(WorldFileError, match=r"w\.world:2: <model:Bad>") as caught:
        run(tmp_path, "Bad", "Bad.so")
    assert message in str(caught.value)
    assert str(tmp_path / "Bad.py") in str(caught.value)


def test_an_exception_in_load_shows_its_own_traceback(tmp_path):
    write(tmp_path, "Bad", load="self.helper()")
    with pytest.raises(WorldFileError, match="AttributeError: 'Bad' object has no attribute 'helper'") as caught:
        run(tmp_path, "Bad", "Bad.so")
    text = str(caught.value)
    assert 'Bad.py", line' in text
    assert "simulation/world.py" not in text


@pytest.mark.parametrize(
    ("method", "own", "right"),
    [
        ("Load", "self, node", "Load(self, file, node)"),
        ("Init", "self", "Init(self, file, node)"),
        ("Update", "self", "Update(self, step)"),
    ],
)
def test_a_method_with_wrong_parameters_is_shown_the_right_ones(tmp_path, caplog, method, own, right):
    source = write(tmp_path, "Wrong").read_text()
    text = re.sub(rf"def {method}\(.*\)", f"def {method}({own})", source)
    (tmp_path / "Wrong.py").write_text(text)
    try:
        with run(tmp_path, "Wrong", "Wrong.so") as world:
            world.Step()
    except libgz.GazeboError as error:
        logged = str(error)
    else:
        logged = caplog.text
    assert f"it is called as Model declares it: {right}" in logged
    assert str(tmp_path / "Wrong.py") in logged
    assert "libgz/legacy" not in logged
    assert "libgz/simulation" not in logged


def test_a_second_interface_of_an_id_is_reported_with_its_line(tmp_path, caplog):
    robot = "<model:Pioneer2AT><id>a</id></model:Pioneer2AT>\n"
    path = tmp_path / "two.world"
    path.write_text(f"<gz:world xmlns:gz='g' xmlns:model='m'>\n{robot}{robot}</gz:world>")
    with libgz.World.from_file(path):
        pass
    assert "two.world:3: <model:Pioneer2AT>: there is a second position interface with id 'a'" in caplog.text


def test_a_failing_init_ends_the_start(tmp_path):
    write(tmp_path, "Bad", init="raise ValueError('no motor')")
    with pytest.raises(PluginError, match="Init of model 'm1' failed") as caught:
        run(tmp_path, "Bad", "Bad.so")
    assert "ValueError: no motor" in str(caught.value)
    write(tmp_path, "Minus", init="return -1")
    with pytest.raises(PluginError, match="returned -1"):
        run(tmp_path, "Minus", "Minus.so")


def test_a_model_without_a_canonical_body_is_refused(tmp_path):
    path = write(tmp_path, "Bodiless")
    path.write_text(path.read_text().replace(", True)", ")"))
    with pytest.raises(WorldFileError, match=r"must call self.AddBody\(body, True\)"):
        run(tmp_path, "Bodiless", "Bodiless.so")


def test_an_exception_in_update_stops_that_model_only(tmp_path, caplog):
    path = write(tmp_path, "Flaky", update="self.turn()")
    path.write_text(
        path.read_text().replace(
            "def Update",
            """def turn(self):
        if self.world.GetSimTime() > 0.1:
            raise RuntimeError('worn out')
    def Update""",
        )
    )
    (tmp_path / "w.world").write_text(
        "<gz:world xmlns:gz='g' xmlns:model='m'><model:GroundPlane/>"
        "<model:Flaky><id>flaky</id><plugin>Flaky.so</plugin></model:Flaky>"
        "<model:Pioneer2AT><id>robot1</id><xyz>0 0 0</xyz></model:Pioneer2AT></gz:world>"
    )
    with libgz.World.from_file(tmp_path / "w.world") as world:
        world.interface("position", "robot1").command(vx=0.3)
        world.run(3.0)
        assert caplog.text.count("model 'flaky' stopped, its motors off") == 1
        assert "RuntimeError: worn out" in caplog.text
        assert world.model("robot1").GetPose().pos.x > 0.5


def test_what_a_plugin_asks_for_after_a_step_may_fail(tmp_path, caplog):
    update = "[self.world.after_step(act) for act in (lambda: 1 / 0, lambda: done.append(1))]"
    write(tmp_path, "Late", update=f"done = self.world.done; {update}")
    with run(tmp_path, "Late", "Late.py") as world:
        world.done = []
        world.step(2)
        assert world.done == [1, 1]
    assert "ZeroDivisionError" in caplog.text
    assert "in <lambda>" in caplog.text


def test_a_stopped_robot_goes_slack(caplog):
    text = """<gz:world xmlns:gz='g' xmlns:model='m'>
    <model:GroundPlane/><model:Pioneer2AT><id>r</id></model:Pioneer2AT></gz:world>"""
    with libgz.World.from_string(text) as world:
        world.interface("position", "r").command(vx=0.3)
        world.run(1.0)
        robot = world.model("r")
        robot.rate = None
        world.run(0.2)
        assert robot.failed is not None
        assert [joint.GetParam(libgz.dParamFMax) for joint in robot.joints] == [0.0] * 4


def test_a_builtin_name_is_not_taken_over(tmp_path, caplog):
    path = write(tmp_path, "Mine")
    path.write_text(path.read_text() + 'libgz.GZ_REGISTER_PLUGIN("GroundPlane", Mine)\n')
    with run(tmp_path, "GroundPlane", "Mine.so") as world:
        assert type(world.model("m1")).__module__ == "libgz.models.groundplane"
    assert "the built-in one is used" in caplog.text


def test_unknown_models_are_skipped_with_a_guess(caplog):
    text = """<gz:world xmlns:gz='g' xmlns:model='m'><model:Pioner2AT><id>a</id><model:SickLMS200/></model:Pioner2AT>
    <model:GroundPlane><id>g</id></model:GroundPlane></gz:world>"""
    with caplog.at_level(logging.WARNING), libgz.World.from_string(text) as world:
        assert [m.GetId() for m in world.models] == ["g"]
    assert (
        "<model:Pioner2AT>: unknown model class, skipped with all that is in it; did you mean 'Pioneer2AT'"
        in caplog.text
    )
    assert caplog.text.count("<string>") == 1


def test_static_registration():
    class Still(libgz.Model):
        def Load(self, file, node):
            self.AddBody(libgz.Body(self.world), True)

    libgz.GZ_REGISTER_STATIC("StillModel", Still)
    with libgz.World.from_string("<gz:world xmlns:gz='g' xmlns:model='m'><model:StillModel/></gz:world>") as world:
        assert isinstance(world.model("StillModel"), Still)


STRAY = """
from libgz import *
class Stray(Model):
    def Load(self, file, node):
        SphereGeom(Body(self.world), self.modelSpaceId, 0.1)
        if node.GetBool("fail"):
            raise RuntimeError("half made")
        self.AddBody(Body(self.world), True)
GZ_REGISTER_PLUGIN("Stray", Stray)
"""


def test_bodies_that_were_not_added_are_told_and_go_with_their_model(tmp_path, caplog):
    (tmp_path / "Stray.py").write_text(STRAY)
    with run(tmp_path, "Stray", "Stray.py") as world:
        assert "<model:Stray>: has an unnamed body that Stray.Load made and did not register" in caplog.text
        assert "call self.AddBody(body)" in caplog.text
        world.step()
        world.DeleteModel("m1")
        assert (len(world.engine.bodies), len(world.engine.geoms)) == (0, 0)
        with pytest.raises(WorldFileError, match="half made"):
            world.InsertModel(WORLD.format(model="Stray", plugin="Stray.py</plugin><fail>1</fail><plugin>"))
        assert (len(world.engine.bodies), len(world.engine.geoms)) == (0, 0)


@pytest.mark.parametrize(
    ("load", "message"),
    [
        ("pass", r"Robot.Load must make one, body = Body\(self.world\), and call self.AddBody\(body, True\)"),
        ("Body(self.world, 'base')", "Robot.Load made body 'base', but never called AddBody; it must call "),
        ("self.AddBody(Body(self.world, 'base'))", "it called AddBody without True"),
        (
            "BoxGeom(Body(self.world, 'base'), self.modelSpaceId, 1, 1, 1).SetMass(-1)",
            r"mass \[kg\] of BoxGeom 1 of body 'base' is -1; it must not be negative \(.*/Robot.py:5\)$",
        ),
        ("BoxGeom(Body(self.world), self.modelSpaceId, 1, 1, 1).SetHardness(0, 0)", "hardness kp of BoxGeom 1 of body"),
        ("Body(self.world).SetPosition((0, 0, float('nan')))", r"position \[m\] is .*nan.*Robot.py:5\)$"),
    ],
)
def test_messages_about_load_lead_to_the_fix(tmp_path, load, message):
    text = ["from libgz import *", "class Robot(Model):", "    def Load(self, file, node):", "        self.world"]
    text += [f"        {load}", "GZ_REGISTER_PLUGIN('Robot', Robot)"]
    (tmp_path / "Robot.py").write_text("\n".join(text))
    with pytest.raises(WorldFileError, match=message) as failed:
        run(tmp_path, "Robot", "Robot.py")
    assert "w.world:2: <model:Robot>: " in str(failed.value)


def test_a_message_about_init_has_the_line(tmp_path):
    write(tmp_path, "Bad", init="libgz.SphereGeom(self.GetBody(), self.modelSpaceId, -1)")
    with pytest.raises(PluginError, match=r"Init of model 'm1': .* is -1; it must be above zero \(.*/Bad.py:8\)"):
        run(tmp_path, "Bad", "Bad.py")


@pytest.mark.parametrize("name", ["libhello_world.so", "hello_world.so", "Hello_World.so"])
def test_a_folder_with_only_the_source_of_a_plugin_is_explained(tmp_path, name):
    (tmp_path / "hello_world.cc").write_text("class WorldPluginTutorial;")
    with pytest.raises(
        PluginError, match=r"hello_world.cc is C\+\+ source: build it, .* port it to Python as hello_world.py"
    ):
        find_plugin(name, str(tmp_path / "w.world"))


def test_a_misspelt_plugin_is_explained(tmp_path):
    write(tmp_path, "Robot")
    with pytest.raises(PluginError, match=r"has no Robto.py; did you mean 'Robot.py'"):
        find_plugin("Robto.so", str(tmp_path / "w.world"))


def test_what_init_and_load_fail_with_is_said_once(tmp_path):
    write(tmp_path, "Bad", init="return -1")
    with pytest.raises(PluginError, match=r"<model:Bad>: Init of model 'm1': it returned -1, which is not 0$"):
        run(tmp_path, "Bad", "Bad.py")
    (tmp_path / "Empty.py").write_text(
        "import libgz\nclass Empty(libgz.Model): pass\nlibgz.GZ_REGISTER_PLUGIN('Empty', Empty)"
    )
    with pytest.raises(WorldFileError, match=r"<model:Empty>: Empty has no Load\(file, node\)$"):
        run(tmp_path, "Empty", "Empty.py")


HINGED = """
from libgz import *
class Hinged(Model):
    def Load(self, file, node):
        base, arm = Body(self.world), Body(self.world, "arm")
        self.AddBody(base, True)
        self.AddBody(arm)
        for body, x in ((base, 0.0), (arm, 0.3)):
            BoxGeom(body, self.modelSpaceId, 0.1, 0.1, 0.1).SetMass(0.1)
            body.SetPosition((x, 0, 0))
        self.failed = False
        self.joint = HingeJoint(self.world)
        self.joint.Attach(arm, base)
        self.joint.SetAnchor((0.2, 0, 0))
        self.joint.SetAxis((0, 0, 1))
        self.joint.SetParam(dParamVel, 1.0)
        self.joint.SetParam(dParamFMax, 5.0)
GZ_REGISTER_PLUGIN("Hinged", Hinged)
"""


def test_a_nested_model_may_call_a_joint_of_its_own_joint(tmp_path):
    (tmp_path / "Hinged.py").write_text(HINGED)
    path = tmp_path / "w.world"
    inner = "<model:Hinged><id>m1</id><plugin>Hinged.py</plugin><xyz>0 0 0.7</xyz></model:Hinged>"
    path.write_text(f"<gz:world xmlns:gz='g' xmlns:model='m'><model:SimpleSolid>{inner}</model:SimpleSolid></gz:world>")
    with libgz.World.from_file(path) as world:
        model = world.model("m1")
        world.run(1.0)
        assert model.joint.GetAngle() == pytest.approx(1.0, abs=0.01)
        assert model.welded.GetJointBody(1) is world.body("SimpleSolid")
        model.Update = lambda step: 1 / 0
        world.step(2)
        assert isinstance(model.failed, ZeroDivisionError)
        world.DeleteModel("SimpleSolid")
        assert not world.engine.joints


def test_the_list_of_bodies_is_the_models(tmp_path):
    write(tmp_path, "Lister", load="self.bodies = []")
    with pytest.raises(WorldFileError, match=r"property 'bodies' of 'Lister' object has no setter"):
        run(tmp_path, "Lister", "Lister.py")


MOORED = """
from libgz import *
class Moored(Model):
    def Load(self, file, node):
        body = Body(self.world)
        self.AddBody(body, True)
        BoxGeom(body, self.modelSpaceId, 1.0, 0.1, 0.1).SetMass(1.0)
        body.SetPosition((0.1, 0.2, 0.3))
        body.SetRotation(GzQuaternFromEuler(0.1, 0.2, 0.3))
        self.joint = globals()[node.GetString("kind")](self.world)
        self.joint.Attach(*((body, None) if node.GetBool("first") else (None, body)))
        if hasattr(self.joint, "SetFixed"):
            self.joint.SetFixed()
        self.joint.SetAnchor((0.1, 0.2, 0.3))
        if hasattr(self.joint, "SetAxis1"):
            self.joint.SetAxis1((1, 0, 0))
            self.joint.SetAxis2((0, 1, 0))
        elif hasattr(self.joint, "GetPosition"):
            self.joint.SetAxis(0, 1, 0)
        elif hasattr(self.joint, "SetAxis"):
            self.joint.SetAxis((0, 1, 0))
GZ_REGISTER_PLUGIN("Moored", Moored)
"""


@pytest.mark.parametrize("first", ["true", "false"])
@pytest.mark.parametrize("kind", ["HingeJoint", "SliderJoint", "BallJoint", "UniversalJoint", "FixedJoint"])
def test_joints_to_the_world_go_where_the_worldfile_puts_their_model(tmp_path, kind, first):
    (tmp_path / "Moored.py").write_text(MOORED)
    path = tmp_path / "w.world"
    path.write_text(
        "<gz:world xmlns:gz='g' xmlns:model='m'><model:Moored><plugin>Moored.py</plugin><gravity>false</gravity>"
        f"<kind>{kind}</kind><first>{first}</first><xyz>2 1 0.5</xyz><rpy>20 30 90</rpy></model:Moored></gz:world>"
    )
    with libgz.World.from_file(path) as world:
        (model,) = world.models
        if kind in ("HingeJoint", "BallJoint", "UniversalJoint"):
            assert tuple(model.joint.GetAnchor()) == pytest.approx((2.0, 1.0, 0.5))
        world.step(50)
        pose = model.GetPose()
        assert tuple(pose.pos) == pytest.approx((2.0, 1.0, 0.5))
        turned = libgz.GzQuaternToEuler(pose.rot)
        assert tuple(turned) == pytest.approx(tuple(map(math.radians, (20, 30, 90))))


def test_a_body_is_added_once(tmp_path):
    write(tmp_path, "Twice", load="self.AddBody(self.GetBody())")
    with pytest.raises(WorldFileError, match=r"body 'm1::canonical' was added to a model already; a body belongs"):
        run(tmp_path, "Twice", "Twice.py")


@pytest.mark.parametrize("base", ["object", "libgz.Model"])
def test_classes_that_are_no_models_are_told_what_to_be(tmp_path, base):
    (tmp_path / "Plain.py").write_text(
        f"import libgz\nclass Plain({base}):\n    def __init__(self, world): self.world = world\n"
        "libgz.GZ_REGISTER_PLUGIN('Plain', Plain)"
    )
    with pytest.raises(WorldFileError, match=r"<model:Plain>: Plain must be a subclass of Model; .* super\(\)"):
        run(tmp_path, "Plain", "Plain.py")


def test_models_come_and_go_in_init(tmp_path):
    new = "<model:Pioneer2AT><id>new</id></model:Pioneer2AT>"
    write(tmp_path, "Spawner", init=f"self.world.InsertModel({new!r}); self.world.DeleteModel('old')")
    plugin = "<plugin>Spawner.py</plugin>"
    path = tmp_path / "w.world"
    path.write_text(
        "<gz:world xmlns:gz='g' xmlns:model='m'><model:Pioneer2AT><id>old</id></model:Pioneer2AT>"
        f"<model:Spawner>{plugin}</model:Spawner><model:TruthWidget><id>after</id></model:TruthWidget></gz:world>"
    )
    with libgz.World.from_file(path) as world:
        world.step()
        assert [model.GetId() for model in world.models] == ["Spawner", "after", "new"]
        assert {("truth", "after"), ("position", "new")} < set(world.gz_server.interfaces)
        assert ("position", "old") not in world.gz_server.interfaces


def test_plugins_below_an_installed_prefix_are_found(tmp_path, monkeypatch):
    """Prefixes of `libgz config --install` are searched, the latest first; /usr/local is the last place."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    monkeypatch.delenv("GAZEBOPATH", raising=False)
    older, newer = tmp_path / "older", tmp_path / "newer"
    for prefix in (older, newer, older, newer):
        note_prefix(prefix)
    for prefix, names in ((older, ("Both", "Old")), (newer, ("Both",))):
        folder = prefix / "lib" / "gazebo" / "plugins"
        folder.mkdir(parents=True)
        for name in names:
            write(folder, name)
    world = str(tmp_path / "w.world")
    assert find_plugin("Both.so", world).is_relative_to(newer)
    assert find_plugin("Old.so", world).is_relative_to(older)
    with pytest.raises(PluginError, match=r"/usr/local/lib/gazebo/plugins"):
        find_plugin("None.so", world)


def test_a_damaged_list_of_prefixes_is_no_error(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    record = tmp_path / "libgz" / "prefixes"
    record.parent.mkdir()
    record.write_bytes(b"\xff\x00relative\n/\xfe\n" + b"/x\n" * 1000)
    assert len(installed_prefixes()) < 25


@pytest.mark.parametrize("name", ["Gone.so", "Gone.py"])
def test_a_link_that_leads_nowhere_is_named(tmp_path, monkeypatch, name):
    monkeypatch.delenv("GAZEBOPATH", raising=False)
    (tmp_path / name).symlink_to("/builds/of/yesterday/Gone")
    with pytest.raises(
        PluginError, match=rf"{name} .*: this link leads to /builds/of/yesterday/Gone, where there is no"
    ):
        find_plugin(name, str(tmp_path / "w.world"))
