"""libgz check, models and schema, as users run them."""

import json
import re

import pytest
from commands import run_libgz

from libgz.base.files import installed_worlds
from libgz.reference.check import check

HEAD = '<gz:world xmlns:gz="g" xmlns:model="m" xmlns:param="p">\n'
WRONG = (
    HEAD
    + """\
<model:GroundPlane><texturFile>x.ppm</texturFile></model:GroundPlane>
<model:SimpleSolid><shape>blob</shape></model:SimpleSolid>
<model:Ball><plugin>Ball.so</plugin></model:Ball>
<model:SimpleSolid><size>1 0 1</size></model:SimpleSolid>
<model:Cup><plugin>Cup.py</plugin></model:Cup>
<model:Pioneer2AX/>
</gz:world>
"""
)


@pytest.fixture
def wrong(tmp_path):
    path = tmp_path / "wrong.world"
    path.write_text(WRONG)
    return path


def test_all_errors_at_once_in_order_of_lines(wrong):
    done = run_libgz("check", wrong)
    assert done.returncode == 1, done.stderr
    assert done.stderr == ""
    lines = [line for line in done.stdout.splitlines() if line.startswith(str(wrong))]
    assert [int(line.removeprefix(f"{wrong}:").partition(":")[0]) for line in lines] == [2, 3, 4, 5, 6, 7]
    assert lines[0].endswith(
        "<texturFile>: warning: is not used by <model:GroundPlane>; did you mean 'textureFile' or 'textureSize'?"
    )
    assert "<shape>: 'blob' is not allowed; shape must be one of box, cylinder, sphere" in lines[1]
    assert "plugin 'Ball.so' was not found; tried" in lines[2]
    assert "plugin 'Cup.py' was not found; tried" in lines[4]
    assert f"{wrong.parent}/ (the worldfile's directory): has no Ball.py" in done.stdout
    assert "unknown model class" in lines[5]
    assert "did you mean 'Pioneer2" in lines[5]


def test_json(wrong):
    done = run_libgz("check", "--json", wrong)
    diagnostics = json.loads(done.stdout)
    assert done.returncode == 1
    assert diagnostics[1] == {
        "file": str(wrong),
        "line": 3,
        "element": "shape",
        "message": "'blob' is not allowed; shape must be one of box, cylinder, sphere",
        "severity": "error",
        "included": 0,
    }


def test_warnings_are_errors_if_wanted(tmp_path):
    path = tmp_path / "unused.world"
    path.write_text(HEAD + "<model:GroundPlane><colour>1 0 0</colour></model:GroundPlane></gz:world>")
    assert run_libgz("check", path).returncode == 0
    strict = run_libgz("check", "--strict", path)
    assert strict.returncode == 1
    assert "warning: " not in strict.stdout
    assert "did you mean 'color'" in strict.stdout


def test_one_warning_covers_an_unused_element_and_its_content(tmp_path):
    path = tmp_path / "nested.world"
    path.write_text(HEAD + "<model:GroundPlane><optics><hfov>60</hfov></optics></model:GroundPlane></gz:world>")
    (error,) = check(path)
    assert error.element == "optics"


def test_ready_worlds_are_clean():
    for path in installed_worlds().glob("*.world"):
        assert check(path) == []


def test_files_that_are_no_worlds(tmp_path):
    broken = tmp_path / "broken.world"
    broken.write_text("<gz:world xmlns:gz='g'>\n<model:\n</gz:world>")
    later = tmp_path / "later.world"
    later.write_text("<?xml version='1.0'?>\n<sdf version='1.6'/>")
    absent = tmp_path / "absent.world"
    assert {error.line for error in check(broken)} & {2, 3}
    (error,) = check(later)
    assert (error.line, error.element) == (2, "sdf")
    assert error.message == "holds no world, model or light"
    (error,) = check(absent)
    assert str(error.message).startswith("cannot read worldfile")
    done = run_libgz("check", broken, later, absent)
    assert done.returncode == 1
    assert f"{later}:2: <sdf>: holds no world" in done.stdout


def test_two_models_with_the_same_interface_and_id(tmp_path):
    path = tmp_path / "twins.world"
    path.write_text(
        HEAD + "<model:Pioneer2AT><id>r</id></model:Pioneer2AT>\n<model:Pioneer2DX><id>r</id>\n"
        "<model:SickLMS200><id>r</id></model:SickLMS200></model:Pioneer2DX></gz:world>"
    )
    (error,) = check(path)
    assert (error.line, error.severity) == (3, "warning")
    assert error.message.startswith("does not serve position.r and power.r and sonar.r")
    assert "<model:Pioneer2AT>, line 2, does" in error.message


def test_invalid_ids_of_interfaces(tmp_path):
    path = tmp_path / "ids.world"
    path.write_text(
        HEAD + "<model:SimpleSolid><id>a.b</id></model:SimpleSolid>\n<model:Pioneer2AT>\n<id>a.b</id>"
        "</model:Pioneer2AT></gz:world>"
    )
    (error,) = check(path)
    assert (error.line, error.element, error.severity) == (4, "id", "error")
    assert "invalid id [a.b] (must not contain '.')" in error.message


def test_elements_that_are_almost_models_or_settings(tmp_path):
    path = tmp_path / "slips.world"
    path.write_text(
        HEAD + "<param:global><stepTime>1</stepTime></param:global>\n<SimpleSolid><id>a</id></SimpleSolid>\n"
        "<model:SimpleSolid><param:xyz>1 2 3</param:xyz><MonoCam/></model:SimpleSolid>\n"
        "<Group><model:GroundPlane/></Group></gz:world>"
    )
    settings, solid, camera, group = check(path)
    assert settings.line == 2
    assert "only <param:Global> does" in settings.message
    assert (solid.line, camera.line) == (3, 4)
    assert "a model needs the prefix: <model:SimpleSolid>" in solid.message
    assert "<model:MonoCam>" in camera.message
    assert (group.line, group.message) == (5, "is not used by <gz:world>")


def test_textures_and_skins_that_cannot_be_read(tmp_path):
    for name in ("bad.png", "bad.3ds"):
        (tmp_path / name).write_bytes(b"junk")
    path = tmp_path / "looks.world"
    path.write_text(
        HEAD + "<model:GroundPlane><textureFile>bad.png</textureFile></model:GroundPlane>\n"
        "<model:CarChassis><skinFile>bad.3ds</skinFile></model:CarChassis>\n"
        "<model:SimpleSolid><skinFile>bad.3ds</skinFile></model:SimpleSolid></gz:world>"
    )
    texture, skin = check(path)
    assert (texture.line, texture.severity, skin.line) == (2, "warning", 3)
    assert "bad.png cannot be read" in texture.message
    assert "bad.3ds cannot be read" in skin.message


def test_the_ninth_light_is_a_warning(tmp_path):
    path = tmp_path / "lights.world"
    path.write_text(HEAD + "<model:LightSource/>\n" * 9 + "</gz:world>")
    (error,) = check(path)
    assert error.line == 10
    assert "first 8 lights" in error.message


PLUGIN = """
from libgz import Body, BoxGeom, GZ_REGISTER_PLUGIN, Model
class Cup(Model):
    def Load(self, file, node):
        body = Body(self.world)
        self.AddBody(body, True)
        BoxGeom(body, self.modelSpaceId, 1, 1, 1)
        if node.GetBool("fail"):
            raise RuntimeError("it leaks")
    def Init(self, file, node):
        open("{trace}", "w").close()
GZ_REGISTER_PLUGIN("Cup", Cup)
"""


def test_plugins_are_loaded_but_not_started_and_nothing_is_left(wire, tmp_path):
    trace = tmp_path / "trace"
    (tmp_path / "CheckedCup.py").write_text(PLUGIN.format(trace=trace))
    path = tmp_path / "cup.world"
    text = HEAD + "<model:Cup><plugin>CheckedCup.py</plugin><fail>{}</fail></model:Cup></gz:world>"
    path.write_text(text.format("true"))
    (error,) = check(path)
    assert "RuntimeError: it leaks" in error.message
    path.write_text(text.format("false"))
    assert check(path) == []
    assert not trace.exists()


def test_models_are_listed_and_described(tmp_path):
    listed = run_libgz("models")
    assert listed.returncode == 0
    assert re.search(r"^SickLMS200 +SICK's scanning laser range-finder", listed.stdout, re.MULTILINE)
    described = run_libgz("models", "SickLMS200").stdout
    for text in (
        "minAngle [deg]: angle, default -90",
        "Interfaces: laser, fiducial",
        "parentBody",
        "7 kg",
        "<id>laser1",
    ):
        assert text in described
    unknown = run_libgz("models", "Sik")
    assert unknown.returncode == 1
    assert unknown.stderr.startswith("libgz: there is no model 'Sik'; there are ")
    assert "SickLMS200.md" in run_libgz("models", "--pages", tmp_path / "pages").stdout
    (tmp_path / "file").write_text("")
    assert "cannot write" in run_libgz("models", "--pages", tmp_path / "file").stderr


def test_the_grammar_is_written(tmp_path):
    path = tmp_path / "world.rng"
    assert run_libgz("schema", "--rng", "-o", path).returncode == 0
    assert path.read_text() == run_libgz("schema", "--rng").stdout
    assert "cannot write" in run_libgz("schema", "--rng", "-o", tmp_path / "no" / "world.rng").stderr


@pytest.mark.parametrize("id", ["a/b", "robot.1"])
def test_the_command_reports_invalid_ids_of_interfaces(tmp_path, id):
    path = tmp_path / "a.world"
    models = (f"<model:{name}><id>{id}</id></model:{name}>" for name in ("Pioneer2AT", "SimpleSolid"))
    path.write_text(f"{HEAD}{''.join(models)}</gz:world>")
    done = run_libgz("check", path)
    assert done.returncode == 1
    assert len(done.stdout.splitlines()) == 1
    assert f"{path}:2: <id>: invalid id [{id}] (must not contain" in done.stdout


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<a/>", "1: <a>: warning: there is no <model:...> element in this file, and its root is not like <gz:world>"),
        (
            "<robot name='a'><link name='b'/></robot>",
            "1: <link>: warning: there is no <inertial>, so link 'b' is left out",
        ),
        ("<html><body/></html>", "1: <html>: this is a web page, not a worldfile of 0.3 - 0.7"),
        ("<world><model name='m'/></world>", "1: <world>: this is an SDF world without <sdf version='1.6'> around it"),
        (
            "<model name='m'><link name='l'/></model>",
            "1: <model>: this is an SDF model without <sdf version='1.6'> around",
        ),
        ("<model><name>m</name><sdf>m.sdf</sdf></model>", "1: <model>: this is the model.config of a model's folder"),
        ("<launch><arg name='x'/></launch>", "1: <launch>: this is a launch file of ROS"),
        ("<package/>", "1: <package>: this is the description of a ROS package, not a worldfile"),
        ("<w xmlns:model='m'><model:SimpleSolid/></w>", ""),
        ("<gz:world xmlns:gz='g'/>", ""),
    ],
)
def test_files_that_are_no_worldfiles(tmp_path, text, message):
    path = tmp_path / "a.world"
    path.write_text(text)
    assert run_libgz("check", path).stdout.startswith(f"{path}:{message}" if message else "")
    assert bool(check(path)) == bool(message)
