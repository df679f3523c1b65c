"""What goes wrong while a world of either era loads is one GazeboError with file and line."""

import re
from pathlib import Path

import pytest
from readers import problem
from sample_files import sample

from libgz import GazeboError, World
from libgz.base.errors import MOST_LISTED, UNFORESEEN

MUTANTS = Path(__file__).parent.parent / "data" / "mutants"  # found by the trials

LONG = "x" * 300
LEGACY = "<gz:world xmlns:gz='g' xmlns:model='m' xmlns:param='p'>\n{}\n</gz:world>"
SDF = "<sdf version='1.6'><world name='w'>\n{}\n</world></sdf>"
IN_LINK = "<model name='m'><link name='l'>{}</link></model>"
IN_JOINT = (
    "<model name='m'><link name='a'/><link name='b'/><joint name='j' type='revolute'><parent>a</parent><child>b</child>"
    "<axis><xyz>0 0 1</xyz></axis>{}</joint></model>"
)
COLLISION = IN_LINK.format("<collision name='c'><geometry>{}</geometry></collision>")
MAP = "<model:MapExtruder><imageFile>grid.png</imageFile>{}</model:MapExtruder>"
VISUAL = IN_LINK.format("<visual name='v'><geometry>{}</geometry></visual>")
OUTLINE = "<polyline><point>0 0</point><point>1 {}</point><point>1 1</point><height>1</height></polyline>"
RAY = (
    "<sensor name='s' type='ray'><ray><scan><horizontal><samples>10</samples><resolution>1e308</resolution>"
    "<min_angle>0</min_angle><max_angle>1</max_angle></horizontal></scan>"
    "<range><min>0</min><max>10</max></range></ray></sensor>"
)
CAMERA = "<sensor name='s' type='camera'><camera><image><width>{}</width><height>{}</height></image></camera></sensor>"
ON_LINKS = [
    "altimeter",
    "camera",
    "contact",
    "depth",
    "gps",
    "gpu_ray",
    "imu",
    "logical_camera",
    "magnetometer",
    "multicamera",
    "ray",
    "sonar",
]


def refused(tmp_path, text):
    path = tmp_path / "w.world"
    path.write_text(text)
    with pytest.raises(GazeboError) as caught, World.from_file(path) as world:
        world.step(1)
    message = str(caught.value)
    assert re.match(rf"{re.escape(str(path))}:\d+: ", message)
    assert UNFORESEEN not in message
    return message


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (LEGACY.format(f"<model:A><plugin>{LONG}.so</plugin></model:A>"), "was not found"),
        (LEGACY.format("<model:A><plugin>~nobody/x</plugin></model:A>"), "was not found"),
        (LEGACY.format("<param:Global><gravity>0 0 1e400</gravity></param:Global>"), "infinite"),
        (LEGACY.format("<param:Global><gravity>0 0 -1e20</gravity></param:Global>"), "within"),
        (
            LEGACY.format("<model:MapExtruder><imageFile>grid.png</imageFile><scale>1e308</scale></model:MapExtruder>"),
            "scale",
        ),
        (LEGACY.format("<model:ObserverCam><updateRate>1e400</updateRate></model:ObserverCam>"), "finite"),
        (LEGACY.format("<model:SimpleSolid><rpy>0 1e999 0</rpy></model:SimpleSolid>"), "infinite"),
        (SDF.format(IN_LINK.format(RAY)), "resolution"),
        (SDF.format(IN_LINK.format(CAMERA.format(1000000, 100000))), "width"),
        (SDF.format(IN_LINK.format(CAMERA.format(16000, 16000))), "px in all"),
    ],
)
def test_values_that_cannot_be_used_are_errors_with_file_and_line(tmp_path, text, words):
    assert words in refused(tmp_path, text)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        *((SDF.format(IN_JOINT.format(f"<sensor name='s' type='{kind}'/>")), "not in a <joint>") for kind in ON_LINKS),
        (SDF.format("<gravity>0 0 inf</gravity>"), "<gravity>: '0 0 inf' is read as '0 0 0'"),
        (
            SDF.format("<gravity>0 0 -1e308</gravity>"),
            "<gravity>: '0 0 -1e308' is out of range; '0.0 0.0 -1000000000.0'",
        ),
        (
            SDF.format("<physics type='ode'><max_step_size>0</max_step_size></physics>"),
            "'0' is out of range; '0.001' is",
        ),
        (SDF.format(COLLISION.format("<plane><normal>0 0 inf</normal></plane>")), "'0 0 inf' is read as '0 0 0'"),
        (SDF.format(VISUAL.format("<plane><normal>1e308 0 1e308</normal></plane>")), "is out of range"),
        (SDF.format(COLLISION.format("<sphere><radius>-1</radius></sphere>")), "sphere radius [m] is -1; "),
        (SDF.format(VISUAL.format("<box><size>1 nan 1</size></box>")), "'1 nan 1' is read as '1 0 0'"),
        (SDF.format(COLLISION.format(OUTLINE.format("1e308"))), "is out of range"),
        (SDF.format(VISUAL.format(OUTLINE.format("inf"))), "'1 inf' is read as '1 0'"),
    ],
)
def test_values_that_gazebo_ran_with_are_warnings_with_file_and_line(tmp_path, text, words, caplog):
    path = tmp_path / "w.world"
    path.write_text(text)
    with World.from_file(path) as world:
        world.step(1)
    assert words in caplog.text
    assert re.search(rf"{re.escape(str(path))}:2: <\w+>: ", caplog.text)


@pytest.mark.parametrize(
    "text",
    [
        LEGACY.format(f"<model:Terrain><terrainFile>{LONG}.gzb</terrainFile></model:Terrain>"),
        LEGACY.format(f"<model:GroundPlane><textureFile>{LONG}.png</textureFile></model:GroundPlane>"),
        LEGACY.format("<model:Terrain><terrainFile>~nobody/x.gzb</terrainFile></model:Terrain>"),
        SDF.format(f"<include><uri>model://{LONG}</uri></include>"),
        SDF.format(f"<include><uri>file://{LONG}</uri></include>"),
        SDF.format(COLLISION.format(f"<mesh><uri>file://{LONG}.dae</uri></mesh>")),
        SDF.format(COLLISION.format(f"<heightmap><uri>file://{LONG}.png</uri></heightmap>")),
        SDF.format(
            IN_LINK.format(
                "<visual name='v'><geometry><box/></geometry><material><script>"
                f"<uri>file://{LONG}</uri><name>{LONG}</name></script></material></visual>"
            )
        ),
        SDF.format(f"<plugin name='p' filename='{LONG}.so'/>"),
        SDF.format("<plugin name='p' filename='~nobody/x'/>"),
    ],
)
def test_names_of_files_that_cannot_exist_are_missing_files(tmp_path, text, caplog):
    path = tmp_path / "w.world"
    path.write_text(text)
    with World.from_file(path):
        assert LONG in caplog.text or "~nobody" in caplog.text


@pytest.mark.parametrize("raised", ["SystemExit(7)", "KeyboardInterrupt", "KeyboardInterrupt('no')"])
def test_a_plugin_that_exits_fails_like_any_other(tmp_path, raised, caplog):
    (tmp_path / "top.py").write_text(f"raise {raised}")
    name = raised.partition("(")[0]
    assert name in refused(tmp_path, LEGACY.format("<model:A><plugin>top.py</plugin></model:A>"))
    for method, build in (("Load", ""), ("Init", "def Load(self, *_): self.AddBody(Body(self.world), True)")):
        (tmp_path / f"{method}.py").write_text(
            "from libgz import GZ_REGISTER_PLUGIN, Body, Model\n"
            f"class A(Model):\n    {build}\n    def {method}(self, *_):\n        raise {raised}\n"
            "GZ_REGISTER_PLUGIN('A', A)\n"
        )
        assert name in refused(tmp_path, LEGACY.format(f"<model:A><plugin>{method}.py</plugin></model:A>"))
    (tmp_path / "update.py").write_text(
        "from libgz import GZ_REGISTER_PLUGIN, Body, Model\n"
        "class A(Model):\n    def Load(self, file, node):\n        self.AddBody(Body(self.world), True)\n"
        f"    def Update(self, step):\n        raise {raised}\nGZ_REGISTER_PLUGIN('A', A)\n"
    )
    with World.from_string(LEGACY.format(f"<model:A><plugin>{tmp_path}/update.py</plugin></model:A>")) as world:
        world.step(2)
    assert f'Update failed with\n  File "{tmp_path}/update.py"' in caplog.text
    with World.from_string(SDF.format(f"<plugin name='p' filename='{tmp_path}/top.py'/>")) as world:
        world.step(1)
    assert caplog.text.count("Failed to load plugin") == 1


def test_what_has_no_effect_is_listed_up_to_a_hundred(tmp_path, caplog):
    many = "".join(f"<unknown{i}>1</unknown{i}>\n" for i in range(300))
    solid = f"<model:SimpleSolid>{many}</model:SimpleSolid>"
    for text in (LEGACY.format(solid), LEGACY.format(many), SDF.format(many)):
        caplog.clear()
        with World.from_string(text):
            assert len(caplog.records) == MOST_LISTED + 1
            assert "this and 199 more elements have no effect" in caplog.text


def test_out_of_memory_names_the_crowd(tmp_path):
    crowd = "<model:SimpleSolid/>\n" * 200
    assert "other shapes" in refused(tmp_path, LEGACY.format(crowd))


def test_a_file_that_another_replaces_is_a_warning_with_both_paths(tmp_path, caplog):
    path = tmp_path / "w.world"
    path.write_text(LEGACY.format("<model:GroundPlane><textureFile>grass.png</textureFile></model:GroundPlane>"))
    with World.from_file(path):
        assert f"{tmp_path}/grass.png" in caplog.text
        assert "libgz/worlds/grass.png" in caplog.text or "/worlds/grass.png' is used" in caplog.text


@pytest.mark.parametrize("name", ["input", "vertices", "source", "float_array", "vcount", "triangles", "effect"])
def test_a_collada_file_without_a_part_is_damaged_or_read(tmp_path, name, caplog):
    text = sample("dae").decode()
    (tmp_path / "m.dae").write_text(re.sub(rf"<{name}\b[^>]*/>|<{name}\b.*?</{name}>", "", text, flags=re.DOTALL))
    path = tmp_path / "w.world"
    path.write_text(SDF.format(COLLISION.format("<mesh><uri>m.dae</uri></mesh>")))
    with World.from_file(path):
        assert "StopIteration" not in caplog.text


@pytest.mark.parametrize("path", sorted(MUTANTS.iterdir()), ids=lambda path: path.name)
def test_mutants_that_once_failed(path, tmp_path):
    """Files are named by their reader: legacy-1-178.world, 3ds-1-610.3ds, png-....png."""
    copy = tmp_path / path.name
    copy.write_bytes(path.read_bytes())  # the world of an asset is written beside it
    assert not problem(path.name.partition("-")[0], copy, lambda world: world.step(1))


FLAT = (
    "<COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema' version='1.4.1'><library_geometries>"
    "<geometry id='g'><mesh><source id='p'><float_array id='a' count='9'>0 0 0 1 0 0 0 1 0</float_array>"
    "<technique_common><accessor source='#a' count='3' stride='3'><param type='float'/><param type='float'/>"
    "<param type='float'/></accessor></technique_common></source><vertices id='v'>"
    "<input semantic='POSITION' source='#p'/></vertices><triangles count='1'>"
    "<input semantic='VERTEX' source='#v' offset='0'/><p>0 1 2</p></triangles></mesh></geometry></library_geometries>"
    "<library_visual_scenes><visual_scene id='s'><node><scale>0 0 0</scale><instance_geometry url='#g'/></node>"
    "</visual_scene></library_visual_scenes><scene><instance_visual_scene url='#s'/></scene></COLLADA>"
)


def test_a_mesh_without_extent_loads(tmp_path, caplog):
    (tmp_path / "flat.dae").write_text(FLAT)
    path = tmp_path / "w.world"
    path.write_text(SDF.format(COLLISION.format("<mesh><uri>flat.dae</uri></mesh>")))
    with World.from_file(path) as world:
        world.step(10)
    assert "could not look at this world" not in caplog.text


def test_a_check_that_only_warns_never_ends_a_load(tmp_path, monkeypatch, caplog):
    from libgz.sdfworld import checks

    def divide(*_arguments):
        raise ZeroDivisionError("float division by zero")

    monkeypatch.setattr(checks, "_warn_of_sinking", divide)
    path = tmp_path / "w.world"
    path.write_text(SDF.format(COLLISION.format("<box><size>1 1 1</size></box>")))
    with World.from_file(path) as world:
        world.step(10)
    assert (
        "the check warn_of_contacts could not look at this world (ZeroDivisionError: float division by" in caplog.text
    )
