"""Warnings at load about models that work against each other."""

import pytest

import libgz
from libgz.files import installed_worlds

WORLD = """<gz:world xmlns:gz='g' xmlns:model='m' xmlns:param='p'><param:Global><utmZone>1</utmZone></param:Global>
<model:GroundPlane/>
<model:Pioneer2AT><id>robot</id>
{}
</model:Pioneer2AT></gz:world>"""
CAMERA = "<model:SonyVID30><id>cam</id><xyz>0 0 0.3</xyz></model:SonyVID30>"
GPS = "<model:GarminGPS><id>gps</id><xyz>{} 0.3</xyz></model:GarminGPS>"


def warnings(text):
    with libgz.World.from_string(text) as world:
        return [str(warning) for warning in world.file.diagnostics.warnings]


def test_models_that_overlap_are_named_with_both_geoms_and_lines():
    found = warnings(WORLD.format(CAMERA + "\n" + GPS.format("0 0.08")))
    assert len(found) == 1
    assert found[0].startswith("<string>:5: <model:GarminGPS>: the CylinderGeom of body 'canonical' of 'gps' overlaps")
    assert "the CylinderGeom of body 'canonical' of 'cam' (line 4) by 0.014 m" in found[0]


def test_an_overlap_jams_a_camera_and_a_gap_does_not():
    for place, pan in ("0.09 -0.08", 0.0), ("-0.3 0", 0.5):
        with libgz.World.from_string(WORLD.format(CAMERA + GPS.format(place))) as world:
            assert bool(world.file.diagnostics.warnings) == (pan == 0.0)
            world.interface("ptz", "cam").command(pan=0.5)
            world.step(250)
            assert world.interface("ptz", "cam").pan == pytest.approx(pan, abs=1e-3)


def test_overlaps_of_connected_bodies_are_no_warning():
    assert not warnings(WORLD.format("<model:SickLMS200><id>l</id><xyz>0 0 0.1</xyz></model:SickLMS200>"))


def test_free_models_that_overlap_are_no_warning():
    solid = "<model:SimpleSolid><id>{}</id></model:SimpleSolid>"
    assert not warnings(f"<gz:world xmlns:gz='g' xmlns:model='m'>{solid.format('a')}{solid.format('b')}</gz:world>")


def test_inserted_models_are_checked(caplog):
    with libgz.World.from_string("<gz:world xmlns:gz='g' xmlns:model='m'/>") as world:
        lines = WORLD.format(CAMERA + GPS.format("0 0.08")).splitlines()[2:-1]
        world.InsertModel("\n".join(lines) + "</model:Pioneer2AT>")
    assert "of 'gps' overlaps the CylinderGeom of body 'canonical' of 'cam'" in caplog.text


def test_the_python_step_finds_the_same(monkeypatch):
    monkeypatch.setenv("LIBGZ_STEP", "python")
    assert "of 'gps' overlaps" in warnings(WORLD.format(CAMERA + GPS.format("0 0.08")))[0]


@pytest.mark.parametrize("path", sorted(installed_worlds().glob("*.world")), ids=lambda path: path.stem)
def test_models_of_the_installed_worlds_do_not_overlap(path):
    with libgz.World.from_file(path) as world:
        assert not [warning for warning in world.file.diagnostics.warnings if "overlaps" in warning.message]
