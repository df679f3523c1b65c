"""Warnings at load about models that work against each other."""

import math
import re

import pytest

import libgz
from libgz.base.files import installed_worlds

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


def test_a_neighbour_that_a_camera_only_pans_into_is_named_with_the_angle():
    """A CanonVCC4's head reaches 5 cm to its sides, 7.6 cm at its corners; the GPS is 6.5 cm beside its axis."""
    camera = "<model:CanonVCC4><id>cam</id><xyz>0.1 0 0.33</xyz></model:CanonVCC4>\n"
    gps = "<model:GarminGPS><id>gps</id><xyz>0.1 {} 0.35</xyz></model:GarminGPS>"
    (found,) = warnings(WORLD.format(camera + gps.format(0.105)))
    match = re.match(
        r"<string>:4: <model:CanonVCC4>: when its joint 'pan' turns by (-?\d+) degrees, the BoxGeom of body 'head' of "
        r"'cam' overlaps the CylinderGeom of body 'canonical' of 'gps' \(line 5\)",
        found,
    )
    angle = abs(math.radians(float(match[1])))
    assert not warnings(WORLD.format(camera + gps.format(0.12)))
    for place, jams in ((0.105, True), (0.12, False)):
        with libgz.World.from_string(WORLD.format(camera + gps.format(place))) as world:
            world.interface("ptz", "cam").command(pan=1.5)
            world.step(400)
            assert world.interface("ptz", "cam").pan == pytest.approx(angle if jams else 1.5, abs=0.1)


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


@pytest.mark.parametrize("path", sorted(installed_worlds().glob("*.world")), ids=lambda path: path.stem)
def test_models_of_the_installed_worlds_do_not_overlap(path):
    with libgz.World.from_file(path) as world:
        assert not [warning for warning in world.file.diagnostics.warnings if "overlaps" in warning.message]


def solids(*inside, step=0.02):
    models = "\n".join(f"<model:SimpleSolid><id>s{i}</id>{text}</model:SimpleSolid>" for i, text in enumerate(inside))
    return f"""<gz:world xmlns:gz='g' xmlns:model='m' xmlns:param='p'>
<param:Global><stepTime>{step}</stepTime></param:Global>
<model:GroundPlane/>\n{models}</gz:world>"""


CYLINDER = "<shape>cylinder</shape><size>0.5 0.4</size><xyz>0 0 0.05</xyz><rpy>{}</rpy>"


@pytest.mark.parametrize(("rpy", "step", "warned"), [("10 5 0", 0.02, True), ("10 5 0", 0.0005, False)])
def test_a_tilted_cylinder_that_would_wobble_is_named(rpy, step, warned):
    with libgz.World.from_string(solids(CYLINDER.format(rpy), step=step)) as world:
        found = [str(warning) for warning in world.file.diagnostics.warnings]
        assert any("can wobble on its rim without end at a stepTime of 0.02 s" in w for w in found) == warned
        world.run(24.0)
        rate = sum(w * w for w in world.model("s0").GetBody().GetAngularRate()) ** 0.5
        assert (rate > 0.1) == warned  # the warning is right


@pytest.mark.parametrize("rpy", ["0 0 0", "90 0 0", "0 80 0", "0 180 30"])
def test_upright_and_lying_cylinders_are_not_named(rpy):
    assert not warnings(solids(CYLINDER.format(rpy)))


def stack(count, hardness="1e6 0"):
    return solids(*(f"<surfaceHardness>{hardness}</surfaceHardness><xyz>0 0 {0.5 * i}</xyz>" for i in range(count)))


def test_a_stack_that_the_solver_does_not_hold_is_named():
    found = warnings(stack(10))
    assert len(found) == 1
    assert found[0].startswith("<string>:13: <model:SimpleSolid>: is the top of a stack of 10 solids ('s0', ")
    assert not warnings(stack(3))


@pytest.mark.parametrize(("count", "solver", "hardness"), [(3, "world", "1e6 0"), (10, "quick", "1e6 1e4")])
def test_stacks_without_a_warning_stand(count, solver, hardness):
    with libgz.World.from_string(stack(count, hardness), solver=solver) as world:
        assert not world.file.diagnostics.warnings
        world.run(10.0)
        assert world.model(f"s{count - 1}").GetPose().pos.z == pytest.approx(0.5 * (count - 1), abs=0.05)


def test_a_solid_that_its_springs_cannot_carry_is_named():
    found = warnings(solids("<mass>100</mass><surfaceHardness>1e3 0</surfaceHardness>"))
    assert "sinks about 0.25 m into the ground: contacts of kp 1000 N/m cannot carry its 100 kg" in found[0]
    assert "its kp should be above 5e+04 N/m" in found[0]
    assert not warnings(solids("<mass>100</mass><surfaceHardness>5e4 0</surfaceHardness>"))
